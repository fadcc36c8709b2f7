//! One run through the window, and what is seen of it.

use std::time::Instant;

use dempfv::InputError;
use dempfv::scene::Plan;
use dempfv::simulation::{Outcome, Simulation};
use dempfv_report::format::three_digits;
use serde::{Deserialize, Serialize};

use super::study::Study;
use crate::Result;

/// How often a run is looked at, evenly in model time.
pub const LOOKS: u32 = 32;
/// At most so many spheres are looked at, evenly by number.
const SPHERES: usize = 1_000;

/// A quantity at each look; empty where there is no such thing.
pub type Seen = Vec<Vec<f64>>;

/// A run.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Course {
    /// Pressure at spheres (Pa).
    pub pressure: Seen,
    /// Displacement of each wall since the window began (m).
    pub displacement: Seen,
    /// What has left through the walls since then (m³).
    pub drained: Seen,
    /// Stress on each wall, contacts and fluid together (Pa); in a periodic cell that of contacts.
    pub stress: Seen,
    /// Permeability (m²).
    pub permeability: Seen,
    pub steps: u64,
    /// Networks that came into use.
    pub networks: u64,
    /// Seconds of each turn.
    pub seconds: Vec<f64>,
    /// Largest distance of the degree of consolidation from Terzaghi's theory (1), in a consolidation.
    pub theory: Option<f64>,
    /// The error that the run estimated of itself (1).
    pub estimate: Option<f64>,
    /// What the balance of energy misses, over all that was moved (1).
    pub energy: Option<f64>,
}

/// Runs a plan through the window of a study; `turns` says how often, from the seconds that it takes.
pub fn run(study: &Study, plan: &Plan, turns: impl Fn(f64) -> usize) -> Result<Course> {
    let mut course = once(study, plan)?;
    for _ in 1..turns(course.seconds[0]) {
        course.seconds.extend(once(study, plan)?.seconds);
    }
    Ok(course)
}

/// What is seen of one quantity, between steps at the moments of the looks.
struct Track {
    /// How long before the end of its step a value holds, in steps.
    lag: f64,
    before: Option<(f64, Vec<f64>)>,
    seen: Seen,
}

impl Track {
    fn new(lag: f64) -> Track {
        Track { lag, before: None, seen: vec![] }
    }

    fn is_complete(&self) -> bool {
        self.seen.len() == LOOKS as usize
    }

    /// Looks after a step of `dt` that ended at `now` (s), if one of the moments is near.
    fn look(&mut self, study: &Study, (now, dt): (f64, f64), value: impl FnOnce() -> Vec<f64>) {
        let due = |k: usize| study.start + study.window * (k + 1) as f64 / f64::from(LOOKS);
        let at = now - self.lag * dt;
        // The step after this one may be the first beyond the moment.
        if self.is_complete() || at + 1.5 * dt < due(self.seen.len()) {
            self.before = None;
            return;
        }
        let here = value();
        while !self.is_complete() && at >= due(self.seen.len()) {
            let then = due(self.seen.len());
            self.seen.push(match &self.before {
                Some((start, there)) => between(there, &here, (then - start) / (at - start)),
                None => here.clone(),
            });
        }
        self.before = Some((at, here));
    }
}

/// What lies at a share of the way from one to another.
fn between(from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
    // The first step of a wet stage may have no pressures before it.
    if from.len() != to.len() {
        return to.to_vec();
    }
    from.iter().zip(to).map(|(a, b)| a + share * (b - a)).collect()
}

/// The permeability of a packing at rest.
fn measured(mut simulation: Simulation) -> Result<Course> {
    let clock = Instant::now();
    simulation.advance()?;
    let seconds = clock.elapsed().as_secs_f64();
    let found = match simulation.outcomes().last().map(|stage| &stage.outcome) {
        Some(Outcome::Permeability(test)) => vec![test.permeability_m2],
        _ => vec![],
    };
    Ok(Course {
        permeability: vec![found],
        networks: 1,
        seconds: vec![seconds],
        ..Course::default()
    })
}

fn once(study: &Study, plan: &Plan) -> Result<Course> {
    let mut simulation = Simulation::restart(plan.clone(), study.state.clone())?;
    if study.is_static {
        return measured(simulation);
    }
    let first = simulation.step();
    let began = displacement(&simulation);
    // A step n takes contacts from its positions, pressures from the velocities half a step before
    // these, and then moves: what holds when is right to second order only so.
    let [mut pressure, mut drained, mut stress] = [1.5, 1.0, 1.0].map(Track::new);
    let mut moved = Track::new(0.0);
    let (mut seconds, mut left) = (0.0, 0.0);
    let is_wet = study.is_wet();
    loop {
        let complete = moved.is_complete() && stress.is_complete();
        let wet_complete = !is_wet || (pressure.is_complete() && drained.is_complete());
        if complete && wet_complete {
            break;
        }
        if !study.is_in_stage(&simulation) {
            let [after, window] = [simulation.time() - study.start, study.window].map(three_digits);
            let what = format!("the stage is over after {after} s of a window of {window} s");
            let remedy = "give --seconds less, or the stage another end";
            return Err(InputError::new(what, remedy).into());
        }
        let (clock, time) = (Instant::now(), simulation.time());
        simulation.advance()?;
        seconds += clock.elapsed().as_secs_f64();
        let step = (simulation.time(), simulation.time() - time);
        if let Some(flow) = simulation.coupled().storage_flow().filter(|_| is_wet) {
            left -= step.1 * flow.flux().iter().sum::<f64>();
            pressure.look(study, step, || pressures(&simulation));
            drained.look(study, step, || vec![left]);
        }
        stress.look(study, step, || stresses(&simulation));
        moved.look(study, step, || {
            displacement(&simulation).iter().zip(&began).map(|(u, before)| u - before).collect()
        });
    }
    let energy = simulation.coupled().dem().energy_balance();
    Ok(Course {
        pressure: pressure.seen,
        displacement: moved.seen,
        drained: drained.seen,
        stress: stress.seen,
        permeability: vec![],
        steps: simulation.step() - first,
        networks: simulation.coupled().remeshes(),
        seconds: vec![seconds],
        theory: simulation.consolidation().map(|c| c.largest_error(0.0, f64::INFINITY)),
        estimate: simulation.error_estimate().map(|estimate| estimate.total),
        energy: energy.map(|e| (e.residual / e.moved()).abs()),
    })
}

/// At spheres (Pa); less their mean in a periodic cell, where an incompressible fluid leaves a constant open.
fn pressures(simulation: &Simulation) -> Vec<f64> {
    let mut all = simulation.coupled().pressure_at_spheres();
    let stores = simulation.coupled().fluid_effects().bulk_modulus.is_some();
    if simulation.coupled().dem().cell().is_some() && !stores {
        let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
        all.iter_mut().for_each(|p| *p -= mean);
    }
    let apart = all.len().div_ceil(SPHERES).max(1);
    all.into_iter().step_by(apart).collect()
}

fn stresses(simulation: &Simulation) -> Vec<f64> {
    let seen = simulation.coupled().observe();
    match seen.cell {
        Some(cell) => cell.stress.iter().copied().collect(),
        None => seen.contact_stress.iter().zip(seen.fluid_stress).map(|(a, b)| a + b).collect(),
    }
}

/// Of walls (m), or in a periodic cell the strain of the cell (1).
fn displacement(simulation: &Simulation) -> Vec<f64> {
    let seen = simulation.coupled().observe();
    match seen.cell {
        Some(cell) => cell.strain.iter().copied().collect(),
        None => seen.wall_displacement.to_vec(),
    }
}
