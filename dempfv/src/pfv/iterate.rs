//! Pressures of a network that has moved on from its factor: conjugate
//! gradients, preconditioned by that factor.

use rayon::prelude::*;

use super::geometry_update::Weakened;
use super::{Boundary, Flow, Operators};
use crate::Result;
use crate::parallel::{SERIAL, TASK, for_each};

/// Most applications of the factor in a solve.
const MOST: u32 = 48;
/// Largest ratio of two corrections that tells of convergence: beyond, the
/// error is taken for twenty times the correction.
const SLOWEST: f64 = 0.95;
/// The error is taken for so many times the last correction at least: where
/// single pores are far from their factor, corrections are smaller than what
/// they miss.
const LEAST: f64 = 4.0;
/// Round-off of pressures, relative to the largest imposed one.
const ROUND_OFF: f64 = 1e-13;

/// How an iterated solve went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Iterations {
    /// Applications of the aged factor.
    pub applications: u32,
    /// Estimated error of the pressures (1): root of the sum of squares,
    /// relative to their distance from the mean imposed pressure.
    pub error: f64,
}

/// What the iteration keeps from solve to solve.
#[derive(Default)]
pub(super) struct Gradients {
    direction: Vec<f64>,
    /// The direction over all pores, 0 where the pressure is imposed.
    spread: Vec<f64>,
    product: Vec<f64>,
    /// Partial sums.
    parts: Vec<f64>,
}

impl Flow {
    /// As [`Flow::update_pressure`] where the network has moved on from its
    /// factor ([`Flow::follow`]): conjugate gradients preconditioned by the
    /// factor, from what the last pressures predict, until the estimated error
    /// is at most `tolerance`. [`Iterations::error`] is larger where they come
    /// to no end.
    ///
    /// The residual tells little of the pressures where conductances span
    /// many decades, the corrections do: they are residuals divided by nearly
    /// the right matrix. With ρ the ratio of the last two, what is missing
    /// still is about ρ/(1 − ρ) times the last one. It is taken for four times
    /// the last one at least, so that one small correction ends nothing by
    /// chance.
    ///
    /// # Errors
    /// When an application fails, or a pressure is not finite.
    pub fn iterate(&mut self, tolerance: f64) -> Result<Iterations> {
        let went = self.improve(tolerance)?;
        self.extrapolation.solved();
        self.operators.pressures(&self.extrapolation.now, &mut self.pressure);
        self.imbalance = self.operators.imbalance(&self.pressure, &self.volume_rate);
        self.check_pressure()?;
        Ok(went)
    }

    fn improve(&mut self, tolerance: f64) -> Result<Iterations> {
        let Flow { operators, extrapolation, correction, pressure, rhs, .. } = self;
        let mut went = Iterations::default();
        let Some(factor) = &mut self.factor else { return Ok(went) };
        let weakened = self.follower.as_ref().map_or(&[][..], |f| f.weakened());
        let gradients = &mut *self.gradients;
        extrapolation.predict(&operators.pore_of, pressure);
        let solution = &mut extrapolation.now;
        gradients.fit(solution.len(), pressure.len());
        operators.residual(pressure, &self.volume_rate, rhs);
        let (level, round_off) = datum(&operators.boundary, solution.len());
        let (mut last, mut alpha, mut fall) = (0.0, 0.0, 0.0);
        loop {
            factor.correct(rhs, correction)?;
            strengthen(weakened, rhs, correction);
            went.applications += 1;
            let beta = match went.applications {
                1 => 0.0,
                // The preconditioner need not be the same to the last bit.
                _ => -alpha * gradients.dot_product(correction) / fall,
            };
            fall = gradients.dot(rhs, correction);
            let curvature = gradients.turn(operators, correction, beta);
            // Nothing is left, or nothing can be told apart from round-off.
            if curvature <= 0.0 {
                break;
            }
            alpha = fall / curvature;
            gradients.go(alpha, solution, rhs);
            let step = gradients.dot(correction, correction).sqrt();
            let ratio =
                if went.applications == 1 { SLOWEST } else { f64::min(step / last, SLOWEST) };
            let missing = step * f64::max(LEAST, ratio / (1.0 - ratio));
            went.error = missing / gradients.distance(solution, level);
            last = step;
            if went.error <= tolerance || step <= round_off || went.applications == MOST {
                break;
            }
        }
        Ok(went)
    }
}

impl Gradients {
    /// Takes memory in the first solve.
    fn fit(&mut self, unknowns: usize, pores: usize) {
        self.direction.resize(unknowns, 0.0);
        self.product.resize(unknowns, 0.0);
        self.spread.resize(pores, 0.0);
        self.parts.resize(unknowns.div_ceil(TASK), 0.0);
    }

    /// Turns the direction `d` by β and returns `d · G d`.
    fn turn(&mut self, operators: &Operators, correction: &[f64], beta: f64) -> f64 {
        for_each(&mut self.direction, &|u, d| *d = correction[u] + beta * *d);
        for (d, &pore) in self.direction.iter().zip(&operators.pore_of) {
            self.spread[pore as usize] = *d;
        }
        operators.conduct(&self.spread, &mut self.product);
        dot(&self.direction, &self.product, &mut self.parts)
    }

    /// Goes α along the direction.
    fn go(&self, alpha: f64, solution: &mut [f64], residual: &mut [f64]) {
        for_each(solution, &|u, x| *x += alpha * self.direction[u]);
        for_each(residual, &|u, r| *r -= alpha * self.product[u]);
    }

    fn dot(&mut self, a: &[f64], b: &[f64]) -> f64 {
        dot(a, b, &mut self.parts)
    }

    fn dot_product(&mut self, a: &[f64]) -> f64 {
        dot(a, &self.product, &mut self.parts)
    }

    /// Distance of the pressures from a level.
    fn distance(&mut self, solution: &[f64], level: f64) -> f64 {
        let part = |x: &[f64]| x.iter().map(|x| (x - level) * (x - level)).sum();
        sum_of_parts(&mut self.parts, &|k| part(chunk(solution, k))).sqrt()
    }
}

/// The mean imposed pressure (Pa), and what is round-off in the distance of so
/// many pressures.
fn datum(boundary: &Boundary, unknowns: usize) -> (f64, f64) {
    let imposed = || boundary.pressure.iter().flatten();
    let level = imposed().sum::<f64>() / imposed().count().max(1) as f64;
    let largest = imposed().fold(0.0f64, |m, p| m.max(p.abs()));
    (level, ROUND_OFF * largest * (unknowns as f64).sqrt())
}

/// Adds what the aged factor does too little of: where a throat was much wider
/// when it was factored, the difference of its two pores hardly counts. Each
/// such difference is solved for by itself (additive Schwarz).
fn strengthen(weakened: &[Weakened], residual: &[f64], correction: &mut [f64]) {
    for &Weakened { unknowns, inverse } in weakened {
        let [u, v] = unknowns.map(|u| u as usize);
        let at = |u: usize| residual.get(u).copied().unwrap_or(0.0);
        let step = inverse * (at(u) - at(v));
        if let Some(c) = correction.get_mut(u) {
            *c += step;
        }
        if let Some(c) = correction.get_mut(v) {
            *c -= step;
        }
    }
}

fn dot(a: &[f64], b: &[f64], parts: &mut [f64]) -> f64 {
    let part = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum();
    sum_of_parts(parts, &|k| part(chunk(a, k), chunk(b, k)))
}

/// The numbers that a partial sum takes.
fn chunk(x: &[f64], k: usize) -> &[f64] {
    &x[k * TASK..x.len().min((k + 1) * TASK)]
}

/// Adds partial sums up in one order, so that the bits do not depend on the
/// number of threads.
fn sum_of_parts(parts: &mut [f64], part: &(impl Fn(usize) -> f64 + Sync)) -> f64 {
    if parts.len() * TASK < SERIAL {
        parts.iter_mut().enumerate().for_each(|(k, sum)| *sum = part(k));
    } else {
        parts.par_iter_mut().enumerate().for_each(|(k, sum)| *sum = part(k));
    }
    parts.iter().sum()
}
