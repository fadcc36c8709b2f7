//! What is done to the keys of a table: they are read, checked, or written, each by the one
//! line that declares it.

use super::kind::{Kind, Number, inline};
use super::schema::Schema;
use super::table::{Table, Value};
use super::wrong::Wrong;
use crate::domain::WallId;
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

/// A passage over the keys of a table.
pub(super) enum Keys<'k, 'a> {
    /// Takes the values that the table gives.
    Read(&'k Table<'a>),
    /// Looks for a wrong value in a table that was made in code.
    Check(&'static Schema),
    /// Collects each key with its value as a scene has it.
    Write(Vec<(&'static str, String)>),
}

/// A part of a plan that is a table of a scene.
pub(super) trait Keyed: Clone {
    /// The keys of the table.
    fn schema(&self) -> &'static Schema;

    /// Passes over all keys.
    ///
    /// # Errors
    /// The first value that is wrong.
    fn keys(&mut self, keys: &mut Keys) -> Result<()>;

    /// This, with what a table says otherwise.
    ///
    /// # Errors
    /// What is wrong in the table, with its line.
    fn read(mut self, table: &Table) -> Result<Self> {
        self.keys(&mut Keys::Read(table))?;
        Ok(self)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first that is wrong.
    fn check(&self) -> Result<()> {
        self.clone().keys(&mut Keys::Check(self.schema()))
    }

    /// Each key with its value as a scene has it.
    fn write(&self) -> Vec<(&'static str, String)> {
        let mut keys = Keys::Write(Vec::new());
        match (self.clone().keys(&mut keys), keys) {
            (Ok(()), Keys::Write(entries)) => entries,
            _ => unreachable!("nothing is wrong to a passage that only writes"),
        }
    }
}

impl<'a> Keys<'_, 'a> {
    /// A key that may be absent: its value then stays as it is.
    pub fn take<T>(&mut self, key: &'static str, kind: &impl Kind<T>, value: &mut T) -> Result<()> {
        match self {
            Keys::Read(table) => {
                if let Some(found) = table.get(key) {
                    *value = kind.read(&found)?;
                }
            }
            Keys::Check(schema) => {
                if let Some(wrong) = kind.wrong(value) {
                    return Err(wrong.of(&schema.name_of(key)));
                }
            }
            Keys::Write(entries) => entries.extend(kind.write(value).map(|text| (key, text))),
        }
        Ok(())
    }

    /// A key that must be there; `what` says what it is.
    pub fn need<T>(
        &mut self,
        key: &'static str,
        what: &str,
        kind: &impl Kind<T>,
        value: &mut T,
    ) -> Result<()> {
        if let Keys::Read(table) = self {
            table.need(key, what)?;
        }
        self.take(key, kind, value)
    }

    /// A number that must be there.
    pub fn need_number(
        &mut self,
        key: &'static str,
        number: Number,
        value: &mut f64,
    ) -> Result<()> {
        self.need(key, &number.describe(), &number, value)
    }

    /// A table with a value for each wall.
    pub fn by_wall<T>(
        &mut self,
        key: &'static str,
        schema: &'static Schema,
        kind: &impl Kind<T>,
        values: &mut [T; 6],
    ) -> Result<()> {
        let mut walls = match self {
            Keys::Read(table) => match table.get(key) {
                Some(found) => {
                    return each_wall(&mut Keys::Read(&found.table(schema)?), kind, values);
                }
                None => return Ok(()),
            },
            Keys::Check(_) => Keys::Check(schema),
            Keys::Write(_) => Keys::Write(Vec::new()),
        };
        each_wall(&mut walls, kind, values)?;
        if let (Keys::Write(entries), Keys::Write(walls)) = (self, walls)
            && !walls.is_empty()
        {
            entries.push((key, inline(&walls)));
        }
        Ok(())
    }

    /// A key with its value as a scene has it, to be written.
    pub fn push(&mut self, entry: (&'static str, String)) {
        if let Keys::Write(entries) = self {
            entries.push(entry);
        }
    }

    /// A rule between the keys of the table, broken by the value of `key`.
    pub fn rule(&self, key: &str, wrong: Option<Wrong>) -> Result<()> {
        self.rule_of(key, wrong, Some)
    }

    /// The same, broken by an item of an array.
    pub fn rule_of_item(&self, key: &str, item: usize, wrong: Option<Wrong>) -> Result<()> {
        self.rule_of(key, wrong, |array| array.items("").ok()?.into_iter().nth(item))
    }

    fn rule_of(
        &self,
        key: &str,
        wrong: Option<Wrong>,
        place: impl Fn(Value<'a>) -> Option<Value<'a>>,
    ) -> Result<()> {
        let Some(wrong) = wrong else { return Ok(()) };
        match self {
            Keys::Read(table) => Err(match table.get(key).and_then(place) {
                Some(value) => value.error(&wrong.problem, wrong.remedy),
                None => {
                    let what = format!("{} {}", table.name_of(key), wrong.problem);
                    table.source.error(table.at, what, wrong.remedy)
                }
            }),
            Keys::Check(schema) => Err(wrong.of(&schema.name_of(key))),
            Keys::Write(_) => Ok(()),
        }
    }
}

fn each_wall<T>(keys: &mut Keys, kind: &impl Kind<T>, values: &mut [T; 6]) -> Result<()> {
    for (wall, value) in WallId::ALL.into_iter().zip(values) {
        keys.take(wall.name(), kind, value)?;
    }
    Ok(())
}
