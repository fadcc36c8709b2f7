//! Which spheres a table means: a list, a ball, a box or a range of radii.

use serde::Serialize;

use super::keys::Keys;
use super::kind::{Array, Count, Maybe, Vector, number};
use super::table::Bound;
use super::wrong::Wrong;
use crate::domain::Vec3;
use crate::input::InputError;

/// A choice of spheres: those with these numbers, or all whose centres lie in a ball or in a box, or
/// whose radii are in a range. One of the four is given.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SphereChoice {
    /// Numbers of spheres, from 0 on.
    pub numbers: Option<Vec<u32>>,
    /// Middle of a ball (m).
    pub center: Option<Vec3>,
    /// Radius of the ball (m).
    pub radius: Option<f64>,
    /// Lower corner of a box (m).
    pub min: Option<Vec3>,
    /// Upper corner of the box (m).
    pub max: Option<Vec3>,
    /// The smallest and the largest radius (m).
    pub radii: Option<Vec<f64>>,
}

const NUMBERS: Array<Count> = Array { items: Count(0), form: "numbers of spheres, as in [0, 1]" };

impl SphereChoice {
    /// Passes over its keys.
    pub(super) fn keys(&mut self, keys: &mut Keys) -> Result<(), InputError> {
        let radii =
            Array { items: number("m", Bound::NotNegative), form: "two radii, as in [1e-3, 2e-3]" };
        keys.take("numbers", &Maybe(NUMBERS), &mut self.numbers)?;
        keys.take("center", &Maybe(Vector("m")), &mut self.center)?;
        keys.take("radius", &Maybe(number("m", Bound::Positive)), &mut self.radius)?;
        keys.take("min", &Maybe(Vector("m")), &mut self.min)?;
        keys.take("max", &Maybe(Vector("m")), &mut self.max)?;
        keys.take("radii", &Maybe(radii), &mut self.radii)?;
        keys.rule("numbers", self.wrong())?;
        let range = self.radii.as_ref().filter(|r| !(r.len() == 2 && r[0] <= r[1]));
        let remedy = "give the smallest and the largest, as in [1e-3, 2e-3]";
        keys.rule("radii", range.map(|_| Wrong::new("is no range of radii", remedy)))
    }

    fn wrong(&self) -> Option<Wrong> {
        let of_two = |a: bool, b: bool| (a || b, a && b);
        let given = [
            (self.numbers.is_some(), true),
            of_two(self.center.is_some(), self.radius.is_some()),
            of_two(self.min.is_some(), self.max.is_some()),
            (self.radii.is_some(), true),
        ];
        let chosen = given.iter().filter(|(some, _)| *some).count();
        if chosen == 1 && given.iter().all(|(some, whole)| !some || *whole) {
            return None;
        }
        let problem = "is not the one choice of spheres: a list, a ball, a box or a range of radii";
        let remedy = "give `numbers`, or `center` and `radius`, or `min` and `max`, or `radii`, and one of these";
        Some(Wrong::new(problem, remedy))
    }

    /// The numbers of its spheres, of which these are the centres and radii (m).
    pub(crate) fn chosen(&self, position: &[Vec3], radius: &[f64]) -> Vec<u32> {
        let all = |holds: &dyn Fn(&Vec3, f64) -> bool| {
            let inside = (0u32..).zip(position.iter().zip(radius));
            inside.filter(|(_, (x, r))| holds(x, **r)).map(|(number, _)| number).collect()
        };
        match (&self.numbers, self.center.zip(self.radius), self.min.zip(self.max), &self.radii) {
            (Some(numbers), ..) => numbers.clone(),
            (_, Some((center, radius)), ..) => all(&|x, _| (x - center).norm() <= radius),
            (.., Some((min, max)), _) => {
                all(&|x, _| (0..3).all(|k| (min[k]..=max[k]).contains(&x[k])))
            }
            (.., Some(range)) => all(&|_, r| range[0] <= r && r <= range[1]),
            _ => vec![],
        }
    }
}
