//! The pressures of the last solves, and the prediction of the next.

use serde::{Deserialize, Serialize};

use crate::parallel::max_norm;
use crate::parallel::with_pores;

/// The unknown pressures of the last solves (Pa), by which the next ones are
/// predicted: on the parabola through three of them, on the line through two.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Extrapolation {
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
const SOLVES_PER_GAIN: u32 = 50;

/// What is seen of a correction times this is taken as what it leaves.
const GAIN_SAFETY_FACTOR: f64 = 4.0;

impl Extrapolation {
    pub(super) fn at_rest(unknowns: usize) -> Extrapolation {
        let zeros = || vec![0.0; unknowns];
        Extrapolation { now: zeros(), before: [zeros(), zeros()], known: 0, gain: None, age: 0 }
    }

    /// Number of unknowns.
    pub(super) fn unknowns(&self) -> usize {
        self.now.len()
    }

    /// Forgets the history: what stands for the last pressures is only a start from now on.
    pub(super) fn restart(&mut self) {
        self.known = 0;
    }

    /// Puts a prediction in the place of the last pressures, and of those of their pores.
    pub(super) fn predict(&mut self, pore_of: &[u32], pressure: &mut [f64]) {
        let [last, one_more] = &mut self.before;
        let known = self.known;
        let part = |[now, last, one_more]: [&mut [f64]; 3], pores: &[u32], out: &mut [f64]| {
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
            spread(now, pores, out);
        };
        with_pores(pore_of, [&mut self.now, last, one_more], pressure, &part, &|(), ()| ());
    }

    /// Adds a correction to the prediction, and to the pressures of the pores.
    pub(super) fn correct(
        &mut self,
        correction: &mut [f64],
        pore_of: &[u32],
        pressure: &mut [f64],
    ) -> Sizes {
        let part = |[now, correction]: [&mut [f64]; 2], pores: &[u32], out: &mut [f64]| {
            now.iter_mut().zip(&*correction).for_each(|(now, correction)| *now += correction);
            spread(now, pores, out);
            Sizes { change: max_norm(correction), pressure: max_norm(now) }
        };
        with_pores(pore_of, [&mut self.now, correction], pressure, &part, &Sizes::and)
    }

    /// True when the last pressures are those of a solve.
    pub(super) fn is_solution(&self) -> bool {
        self.known > 0
    }

    /// The prediction has become a solution.
    pub(super) fn solved(&mut self) {
        self.known = (self.known + 1).min(3);
        self.age += 1;
    }

    /// Forgets what a correction leaves: another solver corrects from now on.
    pub(super) fn forget_gain(&mut self) {
        self.gain = None;
    }

    /// True when a second correction should tell what the first has left.
    pub(super) fn gain_is_due(&self) -> bool {
        self.gain.is_none() || self.age >= SOLVES_PER_GAIN
    }

    /// A second correction was of size `change`, the first of size `last`.
    pub(super) fn observe_gain(&mut self, change: f64, last: f64) {
        if last > 0.0 {
            self.gain = Some((GAIN_SAFETY_FACTOR * change / last).min(1.0));
            self.age = 0;
        }
    }

    /// What a correction leaves of an error.
    pub(super) fn gain(&self) -> f64 {
        self.gain.unwrap_or(1.0)
    }
}

/// The largest change of a pressure and the largest pressure (Pa); not a number if one of
/// them is not finite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sizes {
    pub change: f64,
    pub pressure: f64,
}

impl Sizes {
    fn and(self, other: Sizes) -> Sizes {
        Sizes {
            change: max_norm(&[self.change, other.change]),
            pressure: max_norm(&[self.pressure, other.pressure]),
        }
    }
}

/// Writes the pressures of unknowns to those of their pores, the first of which is the
/// first unknown's.
fn spread(now: &[f64], pores: &[u32], out: &mut [f64]) {
    let Some(&first) = pores.first() else { return };
    for (p, &pore) in now.iter().zip(pores) {
        out[(pore - first) as usize] = *p;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three points of p = 1 + 2 t + 3 t² at t = 0, 1, 2 give 34 at t = 3; the
    /// first two give the line's 11.
    #[test]
    fn a_parabola_is_predicted() {
        let (mut extrapolation, mut pressure) = (Extrapolation::at_rest(1), [0.0]);
        let p = |t: f64| 1.0 + 2.0 * t + 3.0 * t * t;
        for (t, next) in [(0.0, p(0.0)), (1.0, 11.0), (2.0, p(3.0))] {
            extrapolation.now[0] = p(t);
            extrapolation.solved();
            extrapolation.predict(&[0], &mut pressure);
            assert_eq!((extrapolation.now[0], pressure[0]), (next, next));
        }
    }

    /// Every seventh pore has an imposed pressure and keeps it, the others get that of their
    /// unknown, on one thread or many; and the sizes told are those of a loop.
    #[test]
    fn pressures_go_to_their_pores() {
        for unknowns in [0, 1, 6, 100, 4_097, 50_000] {
            let pore_of: Vec<u32> = (0..).filter(|k| k % 7 != 0).take(unknowns).collect();
            let mut pressure = vec![-1.0; pore_of.last().map_or(1, |&k| k as usize + 3)];
            let mut extrapolation = Extrapolation::at_rest(unknowns);
            let mut correction: Vec<f64> =
                (0..unknowns).map(|u| ((u * 7919) % 1009) as f64 - 504.0).collect();
            let start = |u: usize| (u % 10) as f64;
            extrapolation.now.iter_mut().enumerate().for_each(|(u, p)| *p = start(u));
            extrapolation.predict(&pore_of, &mut pressure);
            for (u, &pore) in pore_of.iter().enumerate() {
                assert_eq!(pressure[pore as usize], start(u));
            }
            let sizes = extrapolation.correct(&mut correction, &pore_of, &mut pressure);
            let mut expected = Sizes::default();
            for (u, &pore) in pore_of.iter().enumerate() {
                let p = start(u) + correction[u];
                assert_eq!(pressure[pore as usize], p, "{unknowns} {u}");
                expected.change = expected.change.max(correction[u].abs());
                expected.pressure = expected.pressure.max(p.abs());
            }
            assert_eq!(sizes, expected);
            let imposed = pressure.iter().enumerate().filter(|(k, _)| k % 7 == 0);
            assert!(imposed.into_iter().all(|(_, &p)| p == -1.0));
        }
    }

    /// One pressure that is none shows in what is told of all, wherever it is.
    #[test]
    fn what_is_no_number_is_told() {
        let pore_of: Vec<u32> = (0..20_000).collect();
        for at in [0, 777, 19_999] {
            let mut extrapolation = Extrapolation::at_rest(pore_of.len());
            let mut correction = vec![1.0; pore_of.len()];
            correction[at] = f64::NAN;
            let mut pressure = vec![0.0; pore_of.len()];
            let sizes = extrapolation.correct(&mut correction, &pore_of, &mut pressure);
            assert!(sizes.change.is_nan() && sizes.pressure.is_nan(), "{at} {sizes:?}");
        }
    }
}
