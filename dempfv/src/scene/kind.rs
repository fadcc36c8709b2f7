//! The kinds of values that keys have: how each is read, what it may be, how it is written.

use super::table::{Bound, Value};
use super::wrong::Wrong;
use crate::domain::{Axis, Vec3, WallId};
use crate::excerpt::Brief;
use crate::input::InputError;

type Result<T> = std::result::Result<T, InputError>;

/// A kind of values.
pub(super) trait Kind<T> {
    /// Reads one.
    ///
    /// # Errors
    /// What is wrong with it, with its line.
    fn read(&self, value: &Value) -> Result<T>;

    /// What is wrong with one that was made in code.
    fn wrong(&self, value: &T) -> Option<Wrong>;

    /// One as a scene has it; `None` where an absent key says it.
    fn write(&self, value: &T) -> Option<String>;
}

/// A number in a range.
#[derive(Clone, Copy)]
pub(super) struct Number {
    unit: &'static str,
    bound: Bound,
}

/// A number with a unit, in a range.
pub(super) const fn number(unit: &'static str, bound: Bound) -> Number {
    Number { unit, bound }
}

impl Number {
    /// "a number above 0 in Pa".
    pub fn describe(self) -> String {
        self.bound.describe(self.unit)
    }
}

impl Kind<f64> for Number {
    fn read(&self, value: &Value) -> Result<f64> {
        value.number(self.unit, self.bound)
    }

    fn wrong(&self, x: &f64) -> Option<Wrong> {
        let holds = self.bound.holds(*x);
        (!holds)
            .then(|| Wrong::new(format!("is {}", Brief(*x)), format!("give {}", self.describe())))
    }

    fn write(&self, x: &f64) -> Option<String> {
        Some(format!("{x:?}"))
    }
}

/// An angle: degrees in a scene, radians in a plan.
pub(super) struct Angle;

impl Kind<f64> for Angle {
    fn read(&self, value: &Value) -> Result<f64> {
        value.angle()
    }

    fn wrong(&self, radians: &f64) -> Option<Wrong> {
        let holds = (0.0..std::f64::consts::FRAC_PI_2).contains(radians);
        (!holds).then(|| Wrong::new(format!("is {radians} rad"), "give 0 to below π/2 rad"))
    }

    fn write(&self, radians: &f64) -> Option<String> {
        Some(format!("{:?}", degrees(*radians)))
    }
}

/// The degrees that are read as these radians, the shortest first; the nearest where none
/// are.
fn degrees(radians: f64) -> f64 {
    let near = radians.to_degrees();
    let short = format!("{near:.12e}").parse().unwrap_or(near);
    let bits = near.to_bits();
    let around = (bits.saturating_sub(2)..=bits.saturating_add(2)).map(f64::from_bits);
    std::iter::once(short).chain(around).find(|d| d.to_radians() == radians).unwrap_or(near)
}

/// A whole number of at least so much.
pub(super) struct Count(pub u64);

impl Kind<u64> for Count {
    fn read(&self, value: &Value) -> Result<u64> {
        value.count(self.0)
    }

    fn wrong(&self, n: &u64) -> Option<Wrong> {
        // TOML's whole numbers have a sign.
        let holds = (self.0..=i64::MAX as u64).contains(n);
        let remedy = || format!("give a whole number of {} or more, below 2⁶³", self.0);
        (!holds).then(|| Wrong::new(format!("is {n}"), remedy()))
    }

    fn write(&self, n: &u64) -> Option<String> {
        Some(n.to_string())
    }
}

impl Kind<u32> for Count {
    fn read(&self, value: &Value) -> Result<u32> {
        value.count32(self.0 as u32)
    }

    fn wrong(&self, n: &u32) -> Option<Wrong> {
        Kind::<u64>::wrong(self, &u64::from(*n))
    }

    fn write(&self, n: &u32) -> Option<String> {
        Some(n.to_string())
    }
}

/// True or false.
pub(super) struct Flag;

impl Kind<bool> for Flag {
    fn read(&self, value: &Value) -> Result<bool> {
        value.flag()
    }

    fn wrong(&self, _: &bool) -> Option<Wrong> {
        None
    }

    fn write(&self, flag: &bool) -> Option<String> {
        Some(flag.to_string())
    }
}

/// One of a few names.
pub(super) struct OneOf<'t, T>(pub &'t [(&'static str, T)]);

impl<T: Copy + PartialEq> Kind<T> for OneOf<'_, T> {
    fn read(&self, value: &Value) -> Result<T> {
        value.choice(self.0)
    }

    fn wrong(&self, _: &T) -> Option<Wrong> {
        None
    }

    fn write(&self, value: &T) -> Option<String> {
        self.0.iter().find(|(_, v)| v == value).map(|(name, _)| quoted(name))
    }
}

/// The wall that a stage moves.
pub(super) const A_WALL: &str = "the wall that moves, as in \"y_max\"";

/// The six walls.
pub(super) const WALL: OneOf<'static, WallId> = OneOf(&[
    (WallId::XMin.name(), WallId::XMin),
    (WallId::XMax.name(), WallId::XMax),
    (WallId::YMin.name(), WallId::YMin),
    (WallId::YMax.name(), WallId::YMax),
    (WallId::ZMin.name(), WallId::ZMin),
    (WallId::ZMax.name(), WallId::ZMax),
]);

/// An axis.
pub(super) const AN_AXIS: &str = "\"x\", \"y\" or \"z\"";

/// The three axes.
pub(super) const AXIS: OneOf<'static, Axis> =
    OneOf(&[(Axis::X.name(), Axis::X), (Axis::Y.name(), Axis::Y), (Axis::Z.name(), Axis::Z)]);

/// Three finite numbers in a unit.
pub(super) struct Vector(pub &'static str);

impl Kind<Vec3> for Vector {
    fn read(&self, value: &Value) -> Result<Vec3> {
        value.vector(self.0)
    }

    fn wrong(&self, v: &Vec3) -> Option<Wrong> {
        let holds = v.iter().all(|x| x.is_finite());
        let remedy = || format!("give three finite numbers in {}", self.0);
        (!holds).then(|| Wrong::new(format!("is [{}, {}, {}]", v.x, v.y, v.z), remedy()))
    }

    fn write(&self, v: &Vec3) -> Option<String> {
        Some(format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z))
    }
}

/// A value that need not be there.
pub(super) struct Maybe<K>(pub K);

impl<T, K: Kind<T>> Kind<Option<T>> for Maybe<K> {
    fn read(&self, value: &Value) -> Result<Option<T>> {
        self.0.read(value).map(Some)
    }

    fn wrong(&self, value: &Option<T>) -> Option<Wrong> {
        value.as_ref().and_then(|v| self.0.wrong(v))
    }

    fn write(&self, value: &Option<T>) -> Option<String> {
        value.as_ref().and_then(|v| self.0.write(v))
    }
}

/// An array of values; `form` says what it should hold.
pub(super) struct Array<K> {
    /// The kind of its items.
    pub items: K,
    /// "an array of T_v, as in [0.1, 0.5]".
    pub form: &'static str,
}

impl<T, K: Kind<T>> Kind<Vec<T>> for Array<K> {
    fn read(&self, value: &Value) -> Result<Vec<T>> {
        value.items(self.form)?.iter().map(|item| self.items.read(item)).collect()
    }

    fn wrong(&self, values: &Vec<T>) -> Option<Wrong> {
        let wrong = values.iter().enumerate().find_map(|(i, v)| Some((i, self.items.wrong(v)?)));
        let (i, Wrong { problem, remedy }) = wrong?;
        Some(Wrong::new(format!("has an item {} that {problem}", i + 1), remedy))
    }

    fn write(&self, values: &Vec<T>) -> Option<String> {
        let items: Vec<String> = values.iter().filter_map(|v| self.items.write(v)).collect();
        (!items.is_empty()).then(|| format!("[{}]", items.join(", ")))
    }
}

/// A text as TOML has it.
pub(super) fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => quoted += &format!("\\u{:04X}", u32::from(c)),
            c => quoted.push(c),
        }
    }
    quoted + "\""
}

/// A table on one line.
pub(super) fn inline(entries: &[(&'static str, String)]) -> String {
    let entries: Vec<String> = entries.iter().map(|(k, v)| format!("{k} = {v}")).collect();
    format!("{{ {} }}", entries.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Degrees that were read are written so that they are read again as the same bits.
    #[test]
    fn degrees_survive_a_round_trip() {
        for k in 0..9000 {
            let radians = (f64::from(k) * 0.01).to_radians();
            let again: f64 = Angle.write(&radians).unwrap().parse().unwrap();
            assert_eq!(again.to_radians().to_bits(), radians.to_bits(), "{k}");
        }
        assert_eq!(Angle.write(&30f64.to_radians()).unwrap(), "30.0");
        assert_eq!(Angle.write(&0.1f64.to_radians()).unwrap(), "0.1");
    }

    #[test]
    fn texts_are_quoted_as_toml_wants_them() {
        assert_eq!(quoted("a \"b\" \\ µ\n\u{7f}"), "\"a \\\"b\\\" \\\\ µ\\u000A\\u007F\"");
    }
}
