//! The part of a scene that all runs of a sweep share.

use std::time::Instant;

use dempfv::InputError;
use dempfv::scene::{ParticleSource, Plan, StageKind, TimeStep, Until};
use dempfv::simulation::{Simulation, SimulationState};
use dempfv_report::progress::Progress;

use super::knobs::reference;
use super::setting::Setting;
use crate::Result;

/// A stage that steps, from its beginning on, for a while; or a measured permeability.
pub struct Study {
    /// The scene.
    pub plan: Plan,
    /// Index and name of the stage.
    pub stage: usize,
    pub stage_name: String,
    /// Where all runs begin.
    pub state: SimulationState,
    /// Model time then (s), and how long runs go on (s).
    pub start: f64,
    pub window: f64,
    /// The whole stage is in the window.
    pub whole: bool,
    /// Largest stable time step at the start (s).
    pub limit: f64,
    /// Time step of the reference over that (1).
    pub reference_share: f64,
    pub spheres: usize,
    /// Of the state where all runs begin.
    pub state_hash: String,
    /// Nothing steps: a permeability is measured once, and takes the place of a second.
    pub is_static: bool,
}

/// How much of a stage is looked at.
#[derive(Clone, Copy, Debug)]
pub enum Extent {
    /// As much as the reference comes through in so many seconds.
    Budget(f64),
    /// So much model time (s).
    Window(f64),
}

/// Largest time step of the reference over the largest stable one (1).
const COARSEST: f64 = 0.25;
/// Largest stable steps between the window's end and that of the stage.
const MARGIN: f64 = 6.0;
/// Largest stable steps that a window has at least, however long they take.
const SHORTEST: f64 = 4.0;
/// Steps of the reference that are timed to choose the window.
const TRIAL: u32 = 6;
/// The reference takes at least so many steps, however slow they are.
const FEWEST: f64 = 40.0;

impl Study {
    /// Comes to the last stage that steps, and chooses a window through which the reference takes so
    /// many seconds, or the one that is given; in a scene where none steps, to its last permeability.
    pub fn of(plan: Plan, extent: Extent) -> Result<Study> {
        let steps =
            |kind: &StageKind| matches!(kind, StageKind::Run(_) | StageKind::Consolidate(_));
        let last =
            |holds: &dyn Fn(&StageKind) -> bool| plan.stages.iter().rposition(|s| holds(&s.kind));
        let stage = last(&|kind| steps(kind) && kind.is_coupled()).or_else(|| last(&steps));
        let measured = last(&|kind| matches!(kind, StageKind::Permeability(_)));
        let is_static = stage.is_none();
        let Some(stage) = stage.or(measured) else {
            let what = "no stage of this scene steps or measures a permeability";
            let remedy = "give a scene with a `run`, a `consolidate` or a `permeability` stage";
            return Err(InputError::new(what, remedy).into());
        };
        let mut progress = Progress::new();
        let stage_name = plan.stages[stage].name.clone();
        progress.wait(&format!("the way to stage {stage_name}"));
        let mut simulation = Simulation::new(plan.clone())?;
        while simulation.stage().is_some_and(|now| now.name != stage_name) {
            simulation.advance()?;
        }
        progress.waited();
        if is_static {
            let spheres = simulation.coupled().dem().len();
            let (state, start) = (simulation.state(), simulation.time());
            let state_hash = simulation.state_hash();
            let (window, limit, reference_share, whole) = (1.0, 1.0, 1.0, true);
            return Ok(Study {
                plan,
                stage,
                stage_name,
                state,
                start,
                window,
                whole,
                limit,
                reference_share,
                spheres,
                state_hash,
                is_static,
            });
        }
        Study::from(plan, stage, simulation.state(), extent)
    }

    /// The same from a state in the stage, or at its beginning.
    fn from(plan: Plan, stage: usize, state: SimulationState, extent: Extent) -> Result<Study> {
        let stage_name = plan.stages[stage].name.clone();
        let mut automatic = plan.clone();
        automatic.stages[stage].dt = Some(TimeStep::Auto);
        let mut look = Simulation::restart(automatic, state.clone())?;
        let (start, spheres) = (look.time(), look.coupled().dem().len());
        let state_hash = look.state_hash();
        look.advance()?;
        let limit = look.time_step_bounds().map_or(f64::NAN, |bounds| bounds.limit());
        if !(limit.is_finite() && limit > 0.0) {
            let what = format!("stage {stage_name} has no largest stable time step");
            let remedy = "accuracy needs spheres that move; see dempfv check";
            return Err(InputError::new(what, remedy).into());
        }
        // A reference is finer than what it judges.
        let mut own = Simulation::restart(plan.clone(), state.clone())?;
        own.advance()?;
        let share = COARSEST.min(0.5 * own.dt() / limit);
        // Two digits, which a reader can type.
        let digit = 10f64.powf(share.log10().floor() - 1.0);
        let reference_share = (share / digit).floor() * digit;
        let mut study = Study {
            plan,
            stage,
            stage_name,
            state,
            start,
            window: 0.0,
            whole: false,
            limit,
            reference_share,
            spheres,
            state_hash,
            is_static: false,
        };
        study.choose_window(extent)?;
        Ok(study)
    }

    /// A study of the same stage with another seed, or where its spheres are those of a file, from the
    /// end of this window on, for so much model time (s); `None` where there is nothing else to look at.
    pub fn another(&self, window: f64) -> Result<Option<Study>> {
        let extent = Extent::Window(window);
        if matches!(self.plan.particles.source, ParticleSource::Cloud(_)) {
            let seed = self.plan.seed + 1;
            return Study::of(Plan { seed, ..self.plan.clone() }, extent).map(Some);
        }
        if self.is_static || self.whole {
            return Ok(None);
        }
        let mut simulation = Simulation::restart(self.plan.clone(), self.state.clone())?;
        while simulation.time() < self.start + self.window && self.is_in_stage(&simulation) {
            simulation.advance()?;
        }
        Study::from(self.plan.clone(), self.stage, simulation.state(), extent).map(Some)
    }

    /// Whether the stage has a fluid.
    pub fn is_wet(&self) -> bool {
        let kind = &self.plan.stages[self.stage].kind;
        self.plan.fluid.is_some() && (self.is_static || kind.is_coupled())
    }

    /// Whether a run is still in the stage.
    pub fn is_in_stage(&self, simulation: &Simulation) -> bool {
        simulation.stage().is_some_and(|now| now.name == self.stage_name)
    }

    /// The settings of the reference.
    pub fn reference_settings(&self) -> Vec<Setting> {
        let mut settings = reference(self.reference_share).to_vec();
        settings.retain(|setting| !self.is_static || setting.is_of_statics());
        settings
    }

    /// The scene as the reference has it.
    pub fn reference(&self) -> Plan {
        self.with(&self.reference_settings())
    }

    /// The scene with these settings.
    pub fn with(&self, settings: &[Setting]) -> Plan {
        let mut plan = self.plan.clone();
        // What is set is not left to the run.
        if !settings.is_empty() {
            plan.accuracy = None;
        }
        settings.iter().for_each(|setting| setting.apply(&mut plan, self.stage, self.limit));
        plan
    }

    /// As much as the budget allows of what the stage lasts.
    fn choose_window(&mut self, extent: Extent) -> Result<()> {
        let affordable = match extent {
            Extent::Budget(seconds) => self.affordable(seconds)?.max(SHORTEST * self.limit),
            Extent::Window(window) => window,
        };
        // No run shall leave the stage before it has seen the last moment, and of some more steps.
        let margin = MARGIN * self.limit;
        let mut whole = Simulation::restart(self.plan.clone(), self.state.clone())?;
        while whole.time() < self.start + affordable + margin && self.is_in_stage(&whole) {
            whole.advance()?;
        }
        let lasts = whole.time() - self.start;
        (self.window, self.whole) = match self.is_in_stage(&whole) {
            true => (affordable, false),
            false => (lasts - margin, true),
        };
        // A number of steps is another time with each time step.
        if let StageKind::Run(run) = &mut self.plan.stages[self.stage].kind
            && let Until::Steps(steps) = run.until
        {
            let ends = if self.whole { lasts } else { steps as f64 * whole.dt() };
            run.until = Until::Time(ends.max(self.window + margin));
        }
        if self.window <= 2.0 * self.limit {
            let what = format!("stage {} is over after {lasts} s", self.stage_name);
            let remedy = "accuracy needs a stage of some more time steps";
            return Err(InputError::new(what, remedy).into());
        }
        Ok(())
    }

    /// Model time that the reference comes through in so many seconds (s).
    fn affordable(&self, seconds: f64) -> Result<f64> {
        let mut trial = Simulation::restart(self.reference(), self.state.clone())?;
        // The first step is not like the others.
        trial.advance()?;
        let (clock, from) = (Instant::now(), trial.time());
        for _ in 0..TRIAL {
            trial.advance()?;
        }
        let (took, went) = (clock.elapsed().as_secs_f64(), trial.time() - from);
        let steps = (seconds / (took / f64::from(TRIAL))).max(FEWEST);
        Ok(steps * went / f64::from(TRIAL))
    }
}
