//! Pressures of a network that has moved on from its factor: conjugate
//! gradients, preconditioned by that factor.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::operators::{SERIAL, TASK, for_each};
use super::{Flow, NONE, Network, Operators, PfvError};
use crate::Result;

/// Most applications of the factor in a solve.
const MOST: u32 = 50;

/// How an iterative solve went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Iterations {
    /// Applications of the aged factor.
    pub applications: u32,
    /// Estimated error of the pressures, relative to them (1).
    pub error: f64,
}

/// What the next iterative solve needs to know of the last ones, beside their
/// pressures.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Course {
    /// The unknown pressures before the last ones (Pa); empty after a remesh.
    pub(super) before: Vec<f64>,
    /// Solves since the network was built.
    pub(super) solves: u64,
    /// Share of the error that one application of the factor leaves (1), as
    /// last measured.
    pub(super) left: f64,
}

/// Scratch of the iteration.
#[derive(Default)]
pub(super) struct Iterator {
    direction: Vec<f64>,
    /// The direction over all pores, 0 where the pressure is imposed.
    spread: Vec<f64>,
    product: Vec<f64>,
    parts: Vec<f64>,
    pub course: Course,
}

impl Flow {
    pub fn iterate(&mut self, tolerance: f64) -> Result<Iterations> {
        let Flow { network, operators, solution, correction, pressure, volume_rate, rhs, .. } =
            self;
        let Some(factor) = &mut self.factor else { return Ok(Iterations::default()) };
        let Iterator { direction, spread, product, parts, course } = &mut *self.iterator;
        direction.resize(solution.len(), 0.0);
        product.resize(solution.len(), 0.0);
        spread.resize(pressure.len(), 0.0);
        parts.resize(solution.len().div_ceil(TASK), 0.0);
        predict(solution, &mut course.before);
        operators.pressures(solution, pressure);
        operators.surplus(network, pressure, volume_rate, rhs);
        let trace = std::env::var("TRACE").is_ok();
        let mut seen = vec![];
        let mut went = Iterations::default();
        let mut size_before = 0.0;
        let (mut rz, mut alpha) = (0.0, 0.0);
        loop {
            factor.solve(rhs, correction)?;
            went.applications += 1;
            let step = dot(correction, correction, parts).sqrt();
            let size = dot(solution, solution, parts).sqrt();
            if size == 0.0 && step == 0.0 {
                break;
            }
            seen.push(step / size);
            let new = dot(rhs, correction, parts);
            let beta = if went.applications == 1 {
                0.0
            } else {
                -alpha * dot(correction, product, parts) / rz
            };
            rz = new;
            for_each(direction, &|u, d| *d = correction[u] + beta * *d);
            for (d, &pore) in direction.iter().zip(&operators.pore_of) {
                spread[pore as usize] = *d;
            }
            conduct(network, operators, spread, product);
            let curvature = dot(direction, product, parts);
            alpha = rz / curvature;
            if !(curvature > 0.0) {
                break;
            }
            for_each(solution, &|u, x| *x += alpha * direction[u]);
            for_each(rhs, &|u, r| *r -= alpha * product[u]);
            let left = if went.applications == 1 { 1.0 } else { step / size_before };
            size_before = step;
            went.error = step / size * left.min(1.0);
            if went.error <= tolerance || went.applications == MOST {
                break;
            }
        }
        if trace {
            let text: Vec<String> = seen.iter().map(|s| format!("{s:.1e}")).collect();
            eprintln!("ITER {} {:.1e} [{}]", course.solves, went.error, text.join(" "));
        }
        course.solves += 1;
        operators.pressures(solution, pressure);
        self.imbalance = self.operators.imbalance(&self.pressure, &self.volume_rate);
        match self.pressure.iter().position(|p| !p.is_finite()) {
            None => Ok(went),
            Some(pore) => Err(PfvError::PressureNotFinite { pore: pore as u32 }.into()),
        }
    }
}

/// Extrapolates.
fn predict(solution: &mut [f64], before: &mut Vec<f64>) {
    let w: f64 = std::env::var("PREDICT").ok().and_then(|v| v.parse().ok()).unwrap_or(1.0);
    if before.len() == solution.len() {
        for (p, q) in solution.iter_mut().zip(before) {
            let last = *p;
            *p += w * (last - *q);
            *q = last;
        }
    } else {
        before.clear();
        before.extend_from_slice(solution);
    }
}

/// `G d` throat by throat, for `d` spread over all pores.
fn conduct(network: &Network, operators: &Operators, spread: &[f64], out: &mut [f64]) {
    for_each(out, &|u, product| {
        let i = operators.pore_of[u] as usize;
        let around = network.tessellation.neighbors[i].into_iter();
        *product = around
            .zip(network.conductances_of(i))
            .filter(|(j, _)| *j != NONE)
            .map(|(j, g)| g * (spread[i] - spread[j as usize]))
            .fold(0.0, |sum, flow| sum + flow);
    });
}

/// The scalar product in chunks of fixed size, so that its bits do not depend
/// on the number of threads.
fn dot(a: &[f64], b: &[f64], parts: &mut [f64]) -> f64 {
    let part = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let chunks = |a: &'_ [f64]| a.len();
    let _ = chunks;
    if a.len() < SERIAL {
        parts
            .iter_mut()
            .zip(a.chunks(TASK).zip(b.chunks(TASK)))
            .for_each(|(p, (a, b))| *p = part(a, b));
    } else {
        parts
            .par_iter_mut()
            .zip(a.par_chunks(TASK).zip(b.par_chunks(TASK)))
            .for_each(|(p, (a, b))| *p = part(a, b));
    }
    parts.iter().sum()
}
