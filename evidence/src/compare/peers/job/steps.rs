//! Steps of a scene, with the pressures held against the direct solution in double
//! precision.

use std::time::{Duration, Instant};

use dempfv::coupling::Phase;
use dempfv::pfv::Flow;
use dempfv::scene::Plan;
use dempfv::simulation::Simulation;
use dempfv::solver::{SolverKind, SymmetricCsc};
use serde::{Deserialize, Serialize};

use super::solver_failed;
use crate::Error;
use crate::bench::sample::worst;

/// The reference is refined so often: a correction then changes nothing any more.
const REFINEMENTS: usize = 3;

/// A scene, its number of steps, and after which of them its pressures are checked.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Run {
    pub scene: String,
    pub steps: usize,
    pub checks: Vec<usize>,
    pub run: usize,
}

/// What was measured.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Steps {
    pub pores: f64,
    pub unknowns: f64,
    pub nnz_l: f64,
    /// Time of each step (s), and of its solve.
    pub step_s: Vec<f64>,
    pub solve_s: Vec<f64>,
    /// Largest error of a pressure over the largest pressure, at each check.
    pub pressure_errors: Vec<f64>,
    /// |b − A p|₂ / |b|₂ there, summed up throat by throat.
    pub residuals: Vec<f64>,
    pub remeshes: u64,
}

impl Run {
    /// Does the steps.
    ///
    /// # Errors
    /// What is wrong in the scene, or why it does not go on.
    pub fn measure(&self) -> Result<Steps, Error> {
        let plan = Plan::from_toml(&self.scene, None).map_err(dempfv::Error::from)?;
        let mut simulation = Simulation::new(plan)?;
        let mut done = Steps {
            pores: 0.0,
            unknowns: 0.0,
            nnz_l: 0.0,
            step_s: vec![],
            solve_s: vec![],
            pressure_errors: vec![],
            residuals: vec![],
            remeshes: 0,
        };
        for step in 1..=self.steps {
            let spent = |s: &Simulation| s.coupled().phases().spent(Phase::Solve);
            let (start, before) = (Instant::now(), spent(&simulation));
            simulation.advance()?;
            done.step_s.push(start.elapsed().as_secs_f64());
            let solve: Duration = spent(&simulation) - before;
            done.solve_s.push(solve.as_secs_f64());
            if let Some(flow) =
                simulation.coupled().storage_flow().filter(|_| self.checks.contains(&step))
            {
                let (error, residual) = check(flow)?;
                done.pressure_errors.push(error);
                done.residuals.push(residual);
            }
        }
        if let Some(flow) = simulation.coupled().storage_flow() {
            done.pores = flow.network().pores() as f64;
            done.unknowns = flow.operators().unknowns() as f64;
            done.nnz_l = flow.nnz_l() as f64;
        }
        done.remeshes = simulation.remeshes();
        Ok(done)
    }
}

/// Error and residual of a flow's pressures, by CHOLMOD on the same network and the same
/// motion, refined.
fn check(flow: &Flow) -> Result<(f64, f64), Error> {
    let failed = |e| solver_failed("cholmod", &e);
    let (network, operators) = (flow.network(), flow.operators());
    let a: &SymmetricCsc = &operators.matrix;
    let backend = SolverKind::Cholmod.backend();
    let symbolic = backend.analyze(a, None).map_err(failed)?;
    let mut factor = symbolic.factor(a).map_err(failed)?;
    let (mut x, mut rhs, mut change) = (vec![0.0; a.n], vec![0.0; a.n], vec![0.0; a.n]);
    let mut pressure = vec![0.0; network.pores()];
    operators.pressures(&x, &mut pressure).map_err(dempfv::Error::from)?;
    operators.residual(&pressure, flow.volume_rate(), &mut rhs).map_err(dempfv::Error::from)?;
    let norm = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
    let whole = norm(&rhs);
    for _ in 0..=REFINEMENTS {
        factor.solve(&rhs, &mut change).map_err(failed)?;
        x.iter_mut().zip(&change).for_each(|(x, c)| *x += c);
        operators.pressures(&x, &mut pressure).map_err(dempfv::Error::from)?;
        operators.residual(&pressure, flow.volume_rate(), &mut rhs).map_err(dempfv::Error::from)?;
    }
    operators
        .residual(flow.pressure(), flow.volume_rate(), &mut rhs)
        .map_err(dempfv::Error::from)?;
    let residual = share(norm(&rhs), whole);
    let error = worst(pressure.iter().zip(flow.pressure()).map(|(a, b)| a - b));
    Ok((share(error, worst(pressure.iter().copied())), residual))
}

/// A part of a whole; nothing of nothing is no error: all spheres are at rest at the start.
fn share(part: f64, whole: f64) -> f64 {
    if part == 0.0 { 0.0 } else { part / whole }
}
