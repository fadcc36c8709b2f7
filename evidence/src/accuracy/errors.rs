//! How far one run is from another.

use serde::{Deserialize, Serialize};

use super::course::{Course, Seen};

/// Errors of a run (1), each relative: the root of the sum of squares, over all looks and all that is
/// seen in each, of the difference to another run, over that of the other run itself. `None` where
/// nothing is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Of the pressures at the spheres.
    pub pressure: Option<f64>,
    /// Of the displacements of the walls since the window began.
    pub displacement: Option<f64>,
    /// Of what has left through the walls.
    pub drained: Option<f64>,
    /// Of the stresses on the walls.
    pub stress: Option<f64>,
    /// Of the permeability.
    pub permeability: Option<f64>,
}

/// The quantities, by name.
pub const QUANTITIES: [&str; 5] = ["pressure", "displacement", "drained", "stress", "permeability"];

/// From this difference between two references on, a quantity has no relative error.
const MEANINGLESS: f64 = 0.1;

impl Errors {
    /// How far a run is from another.
    pub fn between(run: &Course, other: &Course) -> Errors {
        Errors {
            pressure: relative(&run.pressure, &other.pressure),
            displacement: relative(&run.displacement, &other.displacement),
            drained: relative(&run.drained, &other.drained),
            stress: relative(&run.stress, &other.stress),
            permeability: relative(&run.permeability, &other.permeability),
        }
    }

    /// Without the quantities that another solver already makes another: they are next to nothing in this
    /// scene, and an error relative to them says nothing.
    pub fn beside_floor(self, floor: &Errors) -> Errors {
        let known = |error: Option<f64>, floor: Option<f64>| {
            error.filter(|_| floor.is_none_or(|floor| floor < MEANINGLESS))
        };
        Errors {
            pressure: known(self.pressure, floor.pressure),
            displacement: known(self.displacement, floor.displacement),
            drained: known(self.drained, floor.drained),
            stress: known(self.stress, floor.stress),
            permeability: known(self.permeability, floor.permeability),
        }
    }

    /// In the order of [`QUANTITIES`].
    pub fn all(&self) -> [Option<f64>; 5] {
        [self.pressure, self.displacement, self.drained, self.stress, self.permeability]
    }

    /// The error that is meant where one number is asked for: of pressures; without fluid the larger of
    /// those of displacements, which may be prescribed, and stresses; where nothing steps of the
    /// permeability. Not a number where nothing is known.
    pub fn main(&self) -> f64 {
        let dry = || match (self.displacement, self.stress) {
            (Some(a), Some(b)) => Some(if a.is_nan() { a } else { b.max(a) }),
            (a, b) => a.or(b),
        };
        self.pressure.or_else(dry).or(self.permeability).unwrap_or(f64::NAN)
    }
}

fn relative(run: &Seen, other: &Seen) -> Option<f64> {
    let (mut off, mut size) = (0.0, 0.0);
    for (look, reference) in run.iter().zip(other) {
        for (a, b) in look.iter().zip(reference) {
            off += (a - b).powi(2);
            size += b * b;
        }
    }
    (size > 0.0).then(|| (off / size).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn course(values: &[f64]) -> Course {
        let pressure = values.iter().map(|v| vec![*v, 2.0 * v]).collect();
        Course { pressure, ..Course::default() }
    }

    /// By hand: differences of 0.1 and 0.2 beside values of 1 and 2 are 10 %.
    #[test]
    fn errors_are_relative() {
        let errors = Errors::between(&course(&[1.1]), &course(&[1.0]));
        assert!((errors.main() - 0.1).abs() < 1e-12, "{errors:?}");
        assert_eq!(errors.all()[1..], [None; 4]);
        let floor = Errors { pressure: Some(1.0), ..Errors::default() };
        assert_eq!(errors.beside_floor(&floor), Errors::default());
        assert_eq!(errors.beside_floor(&Errors::default()), errors);
        let dry = Errors { displacement: Some(0.0), stress: Some(0.5), ..Errors::default() };
        assert_eq!(dry.main(), 0.5);
        assert!(Errors::default().main().is_nan());
    }
}
