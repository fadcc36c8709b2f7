//! How the pressures have gone, and where they will go next.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::operators::{SERIAL, TASK, for_each};

/// The unknown pressures of the last solves (Pa), by which the next ones are
/// predicted: on the parabola through three of them, on the line through two.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Course {
    /// The last ones, or where the next solve starts from.
    pub(super) now: Vec<f64>,
    before: [Vec<f64>; 2],
    /// How many of the three are solutions.
    known: u8,
    /// What a correction leaves of an error, at most, as it was last seen; none
    /// before the first time.
    gain: Option<f64>,
    /// Solves since then.
    age: u32,
}

/// After so many solves, what a correction leaves is looked up again.
const LOOK_AGAIN: u32 = 50;

/// What is seen of a correction times this is taken as what it leaves.
const CAUTION: f64 = 4.0;

impl Course {
    pub(super) fn at_rest(unknowns: usize) -> Course {
        let zeros = || vec![0.0; unknowns];
        Course { now: zeros(), before: [zeros(), zeros()], known: 0, gain: None, age: 0 }
    }

    /// Number of unknowns.
    pub(super) fn unknowns(&self) -> usize {
        self.now.len()
    }

    /// What stands for the last pressures is only a start from now on.
    pub(super) fn begin(&mut self) {
        self.known = 0;
    }

    /// Puts a prediction in the place of the last pressures.
    pub(super) fn predict(&mut self) {
        let [last, one_more] = &mut self.before;
        let history = (self.now.as_mut_slice(), last.as_mut_slice(), one_more.as_mut_slice());
        let known = self.known;
        in_parts(history, &|now, last, one_more| {
            let history = now.iter_mut().zip(last.iter_mut().zip(one_more));
            match known {
                0 => {}
                1 => history.for_each(|(now, (last, _))| *last = *now),
                2 => history.for_each(|(now, (last, one_more))| {
                    let next = 2.0 * *now - *last;
                    (*one_more, *last, *now) = (*last, *now, next);
                }),
                _ => history.for_each(|(now, (last, one_more))| {
                    let next = 3.0 * (*now - *last) + *one_more;
                    (*one_more, *last, *now) = (*last, *now, next);
                }),
            }
        });
    }

    /// Adds a correction to the prediction.
    pub(super) fn correct(&mut self, correction: &[f64]) {
        for_each(&mut self.now, &|u, p| *p += correction[u]);
    }

    /// The prediction has become a solution.
    pub(super) fn solved(&mut self) {
        self.known = (self.known + 1).min(3);
        self.age += 1;
    }

    /// True when a second correction should tell what the first has left.
    pub(super) fn gain_is_due(&self) -> bool {
        self.gain.is_none() || self.age >= LOOK_AGAIN
    }

    /// A second correction was of size `change`, the first of size `last`.
    pub(super) fn gained(&mut self, change: f64, last: f64) {
        if last > 0.0 {
            self.gain = Some((CAUTION * change / last).min(1.0));
            self.age = 0;
        }
    }

    /// What a correction leaves of an error.
    pub(super) fn gain(&self) -> f64 {
        self.gain.unwrap_or(1.0)
    }
}

/// Does something with parts of three vectors, on all threads if that pays.
fn in_parts(
    (a, b, c): (&mut [f64], &mut [f64], &mut [f64]),
    work: &(impl Fn(&mut [f64], &mut [f64], &mut [f64]) + Sync),
) {
    if a.len() < SERIAL {
        work(a, b, c);
    } else {
        let both = a.par_chunks_mut(TASK).zip(b.par_chunks_mut(TASK));
        both.zip(c.par_chunks_mut(TASK)).for_each(|((a, b), c)| work(a, b, c));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three points of p = 1 + 2 t + 3 t² at t = 0, 1, 2 give 34 at t = 3; the
    /// first two give the line's 11.
    #[test]
    fn a_parabola_is_predicted() {
        let mut course = Course::at_rest(1);
        let p = |t: f64| 1.0 + 2.0 * t + 3.0 * t * t;
        for (t, next) in [(0.0, p(0.0)), (1.0, 11.0), (2.0, p(3.0))] {
            course.now[0] = p(t);
            course.solved();
            course.predict();
            assert_eq!(course.now[0], next);
        }
    }
}
