//! Typed reading of TOML that knows on which line every key and value stands.

use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::nearest::{nearest, suggestion};
use super::schema::Schema;
use super::syntax::number_in_quotes;
use super::wrong::Wrong;
use crate::domain::{Vec3, WallId};
use crate::excerpt::excerpt;
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

/// The text that is read.
pub(super) struct Source<'a> {
    pub text: &'a str,
    pub file: Option<&'a Path>,
    /// All tables of a scene, for suggestions across tables.
    pub schemas: &'static [&'static Schema],
}

impl Source<'_> {
    /// An error about what stands at a byte of the text.
    pub fn error(
        &self,
        at: usize,
        what: impl Into<String>,
        remedy: impl Into<String>,
    ) -> InputError {
        let before = &self.text.as_bytes()[..at.min(self.text.len())];
        let line = 1 + before.iter().filter(|&&b| b == b'\n').count();
        let error = InputError::new(what, remedy).at_line(line);
        match self.file {
            Some(file) => error.in_file(file),
            None => error,
        }
    }
}

/// A table whose keys are all known.
pub(super) struct Table<'a> {
    pub source: &'a Source<'a>,
    schema: &'static Schema,
    entries: &'a DeTable<'a>,
    /// Byte at which the table starts.
    pub at: usize,
}

/// A value with its place and how messages name it.
pub(super) struct Value<'a> {
    pub source: &'a Source<'a>,
    /// Byte at which the value starts.
    pub at: usize,
    /// Its key; of an item, that of its array.
    key: String,
    /// Name in messages, such as `` `viscosity` in [fluid] ``.
    name: String,
    node: &'a DeValue<'a>,
}

/// Which numbers are right.
#[derive(Clone, Copy)]
pub(super) enum Bound {
    /// Any finite number.
    Finite,
    /// Above 0.
    Positive,
    /// 0 or above.
    NotNegative,
    /// Above 0 and below 1.
    InsideUnit,
    /// From 0 to below 1.
    BelowOne,
    /// Above 0, up to 1.
    UpToOne,
    /// From 0 to below 90 (degrees).
    Angle,
    /// Above -1, up to 0.5.
    PoissonRatio,
    /// From 0.001 to 1.
    Restitution,
    /// From 1 to 2.
    InteractionRange,
}

impl Bound {
    pub fn holds(self, x: f64) -> bool {
        x.is_finite()
            && match self {
                Bound::Finite => true,
                Bound::Positive => x > 0.0,
                Bound::NotNegative => x >= 0.0,
                Bound::InsideUnit => x > 0.0 && x < 1.0,
                Bound::BelowOne => (0.0..1.0).contains(&x),
                Bound::UpToOne => x > 0.0 && x <= 1.0,
                Bound::Angle => (0.0..90.0).contains(&x),
                Bound::PoissonRatio => x > -1.0 && x <= 0.5,
                Bound::Restitution => (1e-3..=1.0).contains(&x),
                Bound::InteractionRange => (1.0..=2.0).contains(&x),
            }
    }

    /// "a number above 0 in Pa".
    pub fn describe(self, unit: &str) -> String {
        let range = match self {
            Bound::Finite => "a finite number",
            Bound::Positive => "a number above 0",
            Bound::NotNegative => "a number of 0 or more",
            Bound::InsideUnit => "a number above 0 and below 1",
            Bound::BelowOne => "a number from 0 to below 1",
            Bound::UpToOne => "a number above 0, up to 1",
            Bound::Angle => "a number from 0 to below 90",
            Bound::PoissonRatio => "a number above -1, up to 0.5",
            Bound::Restitution => "a number from 0.001 to 1",
            Bound::InteractionRange => "a number from 1 to 2",
        };
        if unit.is_empty() { range.to_owned() } else { format!("{range} in {unit}") }
    }
}

impl<'a> Table<'a> {
    /// Takes a table after looking for unknown keys in it.
    pub fn new(
        source: &'a Source<'a>,
        schema: &'static Schema,
        entries: &'a DeTable<'a>,
        at: usize,
    ) -> Result<Table<'a>> {
        let unknown = entries
            .keys()
            .filter(|key| !schema.keys.contains(&key.get_ref().as_ref()))
            .min_by_key(|key| key.span().start);
        match unknown {
            None => Ok(Table { source, schema, entries, at }),
            Some(key) => Err(source.error(
                key.span().start,
                format!("unknown {} `{}` in {}", schema.noun, excerpt(key.get_ref()), schema.name),
                remedy_for_key(key.get_ref(), schema, source.schemas),
            )),
        }
    }

    /// The value of a key, if the key is there.
    pub fn get(&self, key: &str) -> Option<Value<'a>> {
        debug_assert!(self.schema.keys.contains(&key), "{key} is not in the schema");
        let value = self.entries.get(key)?;
        Some(Value {
            source: self.source,
            at: value.span().start,
            key: key.to_owned(),
            name: self.name_of(key),
            node: value.get_ref(),
        })
    }

    /// Name of a key in messages.
    pub fn name_of(&self, key: &str) -> String {
        self.schema.name_of(key)
    }

    /// The value of a key that must be there; `what` says what it is.
    pub fn need(&self, key: &str, what: &str) -> Result<Value<'a>> {
        self.get(key).ok_or_else(|| {
            let (missing, remedy) = match self.schema.is_root() {
                true => (self.name_of(key), format!("add {what}")),
                false => (format!("`{key}`"), format!("add `{key} = ...`: {what}")),
            };
            self.source.error(self.at, format!("{} has no {missing}", self.schema.name), remedy)
        })
    }
}

/// What would be right instead of an unknown key: a near key of the table, else the table
/// that has it, else the keys of the table.
fn remedy_for_key(key: &str, schema: &Schema, all: &[&Schema]) -> String {
    let elsewhere = all.iter().find(|s| s.noun == "key" && s.keys.contains(&key));
    match (nearest(key, schema.keys), elsewhere) {
        (None, Some(other)) => format!("it belongs in {}", other.name),
        _ => suggestion(key, schema.keys),
    }
}

impl<'a> Value<'a> {
    /// The value's key.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// An error about this value.
    pub fn error(&self, problem: &str, remedy: impl Into<String>) -> InputError {
        self.source.error(self.at, format!("{} {problem}", self.name), remedy)
    }

    fn wrong_type(&self, wanted: &str) -> InputError {
        self.error(&format!("is {}", self.found()), format!("give {wanted}"))
    }

    /// As [`Value::wrong_type`], where a number is wanted.
    fn wrong_number(&self, wanted: &str) -> InputError {
        match self.node.as_str().and_then(number_in_quotes) {
            Some(spelling) => self.wrong_type(&format!("{wanted}, {spelling}")),
            None => self.wrong_type(wanted),
        }
    }

    /// What stands there, in words.
    fn found(&self) -> String {
        match self.node {
            DeValue::String(s) => format!("a text (\"{}\")", excerpt(s)),
            DeValue::Integer(i) => i.to_string(),
            DeValue::Float(f) => f.as_str().to_owned(),
            DeValue::Boolean(b) => b.to_string(),
            DeValue::Datetime(d) => format!("a date ({d})"),
            DeValue::Array(_) => "an array".to_owned(),
            DeValue::Table(_) => "a table".to_owned(),
        }
    }

    pub fn number(&self, unit: &str, bound: Bound) -> Result<f64> {
        let wanted = bound.describe(unit);
        let x = match self.node {
            DeValue::Integer(i) => {
                i64::from_str_radix(i.as_str(), i.radix()).ok().map(|i| i as f64)
            }
            DeValue::Float(f) => f.as_str().parse().ok(),
            _ => None,
        };
        x.filter(|&x| bound.holds(x)).ok_or_else(|| self.wrong_number(&wanted))
    }

    /// An angle in degrees, returned in radians.
    pub fn angle(&self) -> Result<f64> {
        Ok(self.number("degrees", Bound::Angle)?.to_radians())
    }

    /// A whole number of at least `least`.
    pub fn count(&self, least: u64) -> Result<u64> {
        let n = match self.node {
            DeValue::Integer(i) => u64::from_str_radix(i.as_str(), i.radix()).ok(),
            _ => self.whole(),
        };
        n.filter(|&n| n >= least && n <= i64::MAX as u64)
            .ok_or_else(|| self.wrong_number(&format!("a whole number of {least} or more")))
    }

    /// The whole number that a number with a point or an exponent is, as in 1e3.
    fn whole(&self) -> Option<u64> {
        let DeValue::Float(f) = self.node else { return None };
        let x: f64 = f.as_str().parse().ok()?;
        // Above 2⁵³ a float does not say which whole number is meant.
        (x.fract() == 0.0 && (0.0..=9e15).contains(&x)).then_some(x as u64)
    }

    /// As [`Value::count`], for numbers of 32 bits.
    pub fn count32(&self, least: u32) -> Result<u32> {
        let wanted = || self.wrong_type(&format!("a whole number from {least} to {}", u32::MAX));
        self.count(u64::from(least))?.try_into().map_err(|_| wanted())
    }

    pub fn flag(&self) -> Result<bool> {
        self.node.as_bool().ok_or_else(|| self.wrong_type("true or false"))
    }

    /// A text; `what` says what it should tell.
    pub fn text(&self, what: &str) -> Result<&'a str> {
        self.node.as_str().ok_or_else(|| self.wrong_type(&format!("a text in quotes: {what}")))
    }

    /// True when a text stands here that is not a number in quotes.
    pub fn is_name(&self) -> bool {
        self.node.as_str().is_some_and(|text| number_in_quotes(text).is_none())
    }

    /// An error about this value.
    pub fn wrong(&self, wrong: Wrong) -> InputError {
        self.error(&wrong.problem, wrong.remedy)
    }

    /// True when a table stands here.
    pub fn is_table(&self) -> bool {
        self.node.is_table()
    }

    /// One of a few names.
    pub fn choice<T: Copy>(&self, options: &[(&str, T)]) -> Result<T> {
        let names: Vec<&str> = options.iter().map(|(name, _)| *name).collect();
        let given = self.text(&format!("one of {}", names.join(", ")))?;
        options.iter().find(|(name, _)| *name == given).map(|(_, value)| *value).ok_or_else(|| {
            let problem = format!("is \"{}\"", excerpt(given));
            self.error(&problem, suggestion(given, &names))
        })
    }

    pub fn wall(&self) -> Result<WallId> {
        self.choice(&WallId::ALL.map(|w| (w.name(), w)))
    }

    /// The items of an array; `what` says what the array should hold.
    pub fn items(&self, what: &str) -> Result<Vec<Value<'a>>> {
        let array = self.node.as_array().ok_or_else(|| self.wrong_type(what))?;
        let item = |v: &'a Spanned<DeValue<'a>>| Value {
            source: self.source,
            at: v.span().start,
            key: self.key.clone(),
            name: self.name.clone(),
            node: v.get_ref(),
        };
        Ok(array.iter().map(item).collect())
    }

    /// Three numbers.
    pub fn vector(&self, unit: &str) -> Result<Vec3> {
        let wanted = format!("three numbers in {unit}, as in [0.0, 0.0, 1.0]");
        let items = self.items(&wanted)?;
        let [x, y, z] = items.as_slice() else {
            return Err(
                self.error(&format!("has {} numbers", items.len()), format!("give {wanted}"))
            );
        };
        let read = |v: &Value| v.number(unit, Bound::Finite);
        Ok(Vec3::new(read(x)?, read(y)?, read(z)?))
    }

    /// A table with the keys of `schema`.
    pub fn table(&self, schema: &'static Schema) -> Result<Table<'a>> {
        let entries = self.node.as_table().ok_or_else(|| {
            self.wrong_type(&format!("a table with the keys {}", schema.keys.join(", ")))
        })?;
        Table::new(self.source, schema, entries, self.at)
    }

    /// The value of one key of this table, before the table's schema is known.
    pub fn peek(&self, key: &str) -> Option<Value<'a>> {
        let value = self.node.as_table()?.get(key)?;
        Some(Value {
            source: self.source,
            at: value.span().start,
            key: key.to_owned(),
            name: format!("`{key}`"),
            node: value.get_ref(),
        })
    }
}
