//! The pressures of the last solves, and the prediction of the next.

use serde::{Deserialize, Serialize};

use crate::parallel::max_norm;
use crate::parallel::with_pores;

/// The unknown pressures of the last solves (Pa), by which the next ones are
/// predicted: on the parabola through three of them, on the line through two.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Extrapolation {
    /// The pressure that they are measured from (Pa).
    reference: f64,
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

/// What a prediction has taken the place of.
#[derive(Clone, Debug, Default)]
pub(super) struct Replaced {
    oldest: Vec<f64>,
    gain: Option<f64>,
    age: u32,
}

/// After so many solves, what a correction leaves is looked up again.
const SOLVES_PER_GAIN: u32 = 50;

/// What is seen of a correction times this is taken as what it leaves.
const GAIN_SAFETY_FACTOR: f64 = 4.0;

impl Extrapolation {
    pub(super) fn at_rest(unknowns: usize, reference: f64) -> Extrapolation {
        let zeros = || vec![0.0; unknowns];
        let before = [zeros(), zeros()];
        Extrapolation { reference, now: zeros(), before, known: 0, gain: None, age: 0 }
    }

    /// Measures the pressures from another one (Pa).
    pub(super) fn measure_from(&mut self, reference: f64) {
        let shift = self.reference - reference;
        if shift != 0.0 {
            let [last, one_more] = &mut self.before;
            self.now.iter_mut().chain(last).chain(one_more).for_each(|p| *p += shift);
            self.reference = reference;
        }
    }

    /// Number of unknowns.
    pub(super) fn unknowns(&self) -> usize {
        self.now.len()
    }

    /// Forgets the history: what stands for the last pressures is only a start from now on.
    pub(super) fn restart(&mut self) {
        self.known = 0;
    }

    /// Puts a prediction in the place of the last pressures, and of those of their pores. What it
    /// takes the place of is in `replaced` until the prediction is a solution.
    pub(super) fn predict(
        &mut self,
        replaced: &mut Replaced,
        pore_of: &[u32],
        pressure: &mut [f64],
    ) {
        let Extrapolation { now, before: [last, one_more], .. } = self;
        let known = self.known;
        replaced.oldest.resize(now.len(), 0.0);
        let part =
            |[now, last, one_more, next]: [&mut [f64]; 4], pores: &[u32], out: &mut [f64]| {
                let history = now.iter().zip(last.iter().zip(&*one_more));
                let predicted = next.iter_mut().zip(history);
                match known {
                    0 | 1 => predicted.for_each(|(next, (now, _))| *next = *now),
                    2 => predicted.for_each(|(next, (now, (last, _)))| *next = 2.0 * *now - *last),
                    _ => predicted.for_each(|(next, (now, (last, one_more)))| {
                        *next = 3.0 * (*now - *last) + *one_more;
                    }),
                }
                spread(next, pores, out);
            };
        let all = [&mut now[..], last, one_more, &mut replaced.oldest];
        with_pores(pore_of, all, pressure, &part, &|(), ()| ());
        std::mem::swap(one_more, &mut replaced.oldest);
        std::mem::swap(last, one_more);
        std::mem::swap(now, last);
        (replaced.gain, replaced.age) = (self.gain, self.age);
    }

    /// Takes a prediction back that has not become a solution.
    pub(super) fn take_back(
        &mut self,
        replaced: &mut Replaced,
        pore_of: &[u32],
        pressure: &mut [f64],
    ) {
        let Extrapolation { now, before: [last, one_more], .. } = self;
        std::mem::swap(now, last);
        std::mem::swap(last, one_more);
        std::mem::swap(one_more, &mut replaced.oldest);
        (self.gain, self.age) = (replaced.gain, replaced.age);
        for (p, &pore) in self.now.iter().zip(pore_of) {
            pressure[pore as usize] = *p;
        }
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
        let (mut extrapolation, mut pressure) = (Extrapolation::at_rest(1, 0.0), [0.0]);
        let mut replaced = Replaced::default();
        let p = |t: f64| 1.0 + 2.0 * t + 3.0 * t * t;
        for (t, next) in [(0.0, p(0.0)), (1.0, 11.0), (2.0, p(3.0))] {
            extrapolation.now[0] = p(t);
            extrapolation.solved();
            extrapolation.predict(&mut replaced, &[0], &mut pressure);
            assert_eq!((extrapolation.now[0], pressure[0]), (next, next));
        }
    }

    /// After any number of solves: a prediction that is corrected and taken back leaves what was
    /// there, to the bit.
    #[test]
    fn a_failed_solve_is_taken_back() {
        let (mut extrapolation, mut pressure) = (Extrapolation::at_rest(2, 0.0), [0.0; 2]);
        let mut replaced = Replaced::default();
        for solve in 0..6 {
            let (before, pressures) = (extrapolation.clone(), pressure);
            extrapolation.predict(&mut replaced, &[0, 1], &mut pressure);
            extrapolation.correct(&mut [1.0, -3.0], &[0, 1], &mut pressure);
            extrapolation.observe_gain(0.1, 1.0);
            extrapolation.take_back(&mut replaced, &[0, 1], &mut pressure);
            assert_eq!((&extrapolation, pressure), (&before, pressures), "solve {solve}");
            extrapolation.predict(&mut replaced, &[0, 1], &mut pressure);
            let correction = f64::from(solve * solve) + 0.1;
            extrapolation.correct(&mut [correction; 2], &[0, 1], &mut pressure);
            extrapolation.solved();
        }
    }

    /// Every seventh pore has an imposed pressure and keeps it, the others get that of their
    /// unknown, on one thread or many; and the sizes told are those of a loop.
    #[test]
    fn pressures_go_to_their_pores() {
        for unknowns in [0, 1, 6, 100, 4_097, 50_000] {
            let pore_of: Vec<u32> = (0..).filter(|k| k % 7 != 0).take(unknowns).collect();
            let mut pressure = vec![-1.0; pore_of.last().map_or(1, |&k| k as usize + 3)];
            let mut extrapolation = Extrapolation::at_rest(unknowns, 0.0);
            let mut correction: Vec<f64> =
                (0..unknowns).map(|u| ((u * 7919) % 1009) as f64 - 504.0).collect();
            let start = |u: usize| (u % 10) as f64;
            extrapolation.now.iter_mut().enumerate().for_each(|(u, p)| *p = start(u));
            extrapolation.predict(&mut Replaced::default(), &pore_of, &mut pressure);
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
            let mut extrapolation = Extrapolation::at_rest(pore_of.len(), 0.0);
            let mut correction = vec![1.0; pore_of.len()];
            correction[at] = f64::NAN;
            let mut pressure = vec![0.0; pore_of.len()];
            let sizes = extrapolation.correct(&mut correction, &pore_of, &mut pressure);
            assert!(sizes.change.is_nan() && sizes.pressure.is_nan(), "{at} {sizes:?}");
        }
    }
}
