//! The settings that a sweep tries.

use dempfv::coupling::{RemeshMode, Update};
use dempfv::pfv::Clamp;
use dempfv::solver::SolverKind;

use super::setting::{Omitted, Setting};
use super::study::Study;

/// Settings of the runs that errors are measured from: a network at each step, solved to round-off, at
/// this share of the largest stable step.
pub fn reference(time_step: f64) -> [Setting; 6] {
    [
        Setting::Interval(1),
        Setting::Mode(RemeshMode::AtOnce),
        Setting::Update(Update::Remesh),
        Setting::Tolerance(1e-12),
        Setting::Clamp(Clamp::None),
        Setting::TimeStep(time_step),
    ]
}

/// Remesh intervals (steps), the finest first; those of Caulk et al. (2020), fig. 2, and finer ones.
const INTERVALS: [u64; 10] = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
/// Strains (1) of their eq. 14.
const STRAINS: [f64; 4] = [0.001, 0.01, 0.05, 0.3];
/// Quick sweeps try every second setting of knobs that have more than these.
const FEW: usize = 4;
/// Errors that runs keep to by themselves.
const TARGETS: [f64; 4] = [0.003, 0.01, 0.03, 0.1];
const TOLERANCES: [f64; 6] = [1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2];
/// Time steps as shares of the largest stable one.
const TIME_STEPS: [f64; 6] = [0.0625, 0.125, 0.25, 0.5, 0.8, 0.95];

/// All knobs that a study has, each with its settings; the first of each is the finest. Of `quick`
/// sweeps fewer, and no intervals longer than the window.
pub fn knobs(study: &Study, quick: bool) -> Vec<Vec<Setting>> {
    let finest = &study.reference_share;
    let steps = study.window / study.limit;
    let mut all: Vec<Vec<Setting>> = vec![];
    if study.is_wet() {
        let intervals = INTERVALS.into_iter().filter(|&n| n as f64 <= steps.max(1.0));
        all.push(intervals.map(Setting::Interval).collect());
        all.push(STRAINS.map(Setting::Strain).to_vec());
        all.push(RemeshMode::ALL.map(Setting::Mode).to_vec());
        all.push([Update::EveryStep, Update::Remesh].map(Setting::Update).to_vec());
        all.push([SolverKind::Cholmod, SolverKind::Frontal].map(Setting::Solver).to_vec());
        all.push(TOLERANCES.map(Setting::Tolerance).to_vec());
        all.push(TOLERANCES.map(Setting::IteratedTolerance).to_vec());
        let clamps = [Clamp::None, Clamp::Relative, Clamp::Unlimited, Clamp::Yade];
        all.push(clamps.map(Setting::Clamp).to_vec());
    }
    let coarser = TIME_STEPS.into_iter().filter(|&share| share > 1.2 * finest);
    all.push(std::iter::once(*finest).chain(coarser).map(Setting::TimeStep).collect());
    let kept = Setting::Target(TARGETS[0]);
    if !study.is_static && study.with(&[kept]).validate().is_ok() {
        all.push(TARGETS.map(Setting::Target).to_vec());
    }
    all.push(omissions(study).into_iter().map(Setting::Without).collect());
    if quick {
        for settings in all.iter_mut().filter(|settings| settings.len() > FEW) {
            let finest = settings.first().copied();
            let mut nth = 0..;
            settings.retain(|s| finest == Some(*s) || nth.next().is_some_and(|n| n % 2 == 1));
        }
    }
    for settings in &mut all {
        settings.retain(|setting| !study.is_static || setting.is_of_statics());
    }
    all.retain(|settings| !settings.is_empty());
    all
}

/// Effects that are on and can be left out.
fn omissions(study: &Study) -> Vec<Omitted> {
    let plan = &study.plan;
    let mut all = vec![];
    let clumps = plan.particles.clump.is_some();
    if plan.dem.is_some_and(|dem| dem.options.rotation) && !clumps {
        all.push(Omitted::Rotation);
    }
    let Some(fluid) = plan.fluid.as_ref().filter(|_| study.is_wet()) else { return all };
    let effects = &fluid.effects;
    if fluid.fluid.slip_walls && plan.cell.is_none() {
        all.push(Omitted::WallSlip);
    }
    if effects.bulk_modulus.is_some() {
        all.push(Omitted::Compressibility);
    }
    if effects.edges.any() {
        all.push(Omitted::FilmsBetweenNeighbours);
    }
    if effects.density.is_some() {
        all.push(Omitted::FluidWeight);
    }
    if !effects.one_way {
        all.push(Omitted::MotionOnFluid);
    }
    all
}
