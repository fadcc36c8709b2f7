//! Carries out a plan, one step at a time.

use std::borrow::Cow;
use std::sync::Arc;

use super::clock::Clock;
use super::conditions::check_conditions;
use super::error_control::ErrorControl;
use super::estimate::UnstableStage;
use super::fingerprint::fingerprint;
use super::outcome::{Consolidation, Outcome, StageOutcome};
use super::restart::{self, Effect, Origin, Restart};
use super::setup;
use super::stages::{Active, Changes, Context, Progress};
use super::state::{SimulationState, check_stages};
use super::warning::{Warning, warn};
use crate::coupling::{
    Controls, Coupled, NetworkBuilder, Observation, Parameters, StandardBuilder, TimeStepBounds,
    UnmetTolerance,
};
use crate::dem::DemError;
use crate::dem::law::Linear;
use crate::io::checkpoint::Spheres;
use crate::pfv::RetiredNetwork;
use crate::scene::{self, Plan, Stage};
use crate::{Error, PerWall, Result};

/// A plan being carried out.
///
/// [`advance`](Simulation::advance) does one step; between two steps the
/// caller may look, save the [`SimulationState`], or stop.
pub struct Simulation {
    pub(super) plan: Plan,
    origin: Origin,
    restarted: Option<Restart>,
    pub(super) coupled: Coupled,
    pub(super) clock: Clock,
    /// Index of the current stage; the number of stages when all are done.
    pub(super) stage: usize,
    active: Option<Active>,
    stage_start: (u64, f64),
    outcomes: Vec<StageOutcome>,
    previous_remeshes: u64,
    warnings: Vec<Warning>,
    stress_extremes: PerWall<[f64; 2]>,
    pub(super) error_control: Option<ErrorControl>,
}

/// No stress was seen yet.
const NO_STRESS: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

impl Simulation {
    /// Loads or draws the packing of a plan and puts it at rest in its box.
    ///
    /// # Errors
    /// [`Error::Input`] for what [`Plan::validate`] finds or is wrong with the packing; why its
    /// spheres find no room.
    pub fn new(plan: Plan) -> Result<Simulation> {
        plan.validate()?;
        let specimen = setup::specimen(&plan)?;
        check_conditions(&plan, &specimen.position, &specimen.radius, specimen.bounds)?;
        let origin = Origin::new(&plan, &specimen.position, &specimen.radius, specimen.bounds);
        let mut coupled = setup::coupled(&plan, setup::mechanics(&plan, specimen)?)?;
        let error_control = plan.accuracy.as_ref().map(ErrorControl::new);
        coupled.compare_networks(error_control.is_some());
        Ok(Simulation {
            error_control,
            plan,
            origin,
            restarted: None,
            coupled,
            clock: Clock::new(),
            stage: 0,
            active: None,
            stage_start: (0, 0.0),
            outcomes: vec![],
            previous_remeshes: 0,
            warnings: vec![],
            stress_extremes: PerWall([NO_STRESS; 6]),
        })
    }

    /// Goes on from a state, with the same bits as if it had not stopped. What the plan says
    /// otherwise than the one that the state was made with holds from the next step on;
    /// [`Simulation::restarted`] tells what that is, and [`Simulation::warnings`] what is odd in it.
    ///
    /// # Errors
    /// [`Error::Input`] when the plan's stages are not those that the state has come through, and
    /// for what no restart can change: spheres, their box, what a measurement under way is
    /// reckoned from. Otherwise as a step.
    pub fn restart(plan: Plan, state: SimulationState) -> Result<Simulation> {
        Simulation::restart_with(plan, state, Arc::new(StandardBuilder))
    }

    /// As [`Simulation::restart`], with networks built by `builder`.
    ///
    /// # Errors
    /// As [`Simulation::restart`].
    pub fn restart_with(
        plan: Plan,
        state: SimulationState,
        builder: Arc<dyn NetworkBuilder>,
    ) -> Result<Simulation> {
        plan.validate()?;
        let stage = state.stage as usize;
        let names = scene::stage_names(&state.origin.scene)?;
        check_stages(&plan, &state, &names)?;
        let differences = scene::differences(&state.origin.scene, &plan.to_toml())?;
        let step = state.clock.step;
        // The box first: a cloud's radii follow from it.
        let origin = state.origin.with(&plan)?;
        let changed = restart::judge(&plan, &differences, &state.under_way(&names))?;
        let mut warnings = state.warnings;
        for change in changed.iter().filter(|change| change.effect == Effect::Odd) {
            warn(&mut warnings, Warning::Restarted { step, change: change.clone() });
        }

        let going = state.active.as_ref().and(plan.stages.get(stage));
        let changes = Changes::new(&differences, going.map(|stage| stage.name.as_str()));
        let mut saved = state.coupled;
        let was_wet = saved.parameters.saturation.is_some();
        let is_wet = going.map_or(was_wet, |stage| stage.kind.has_conditions());
        let materials = plan.materials();
        saved.set_densities(&materials.iter().map(|m| m.density).collect::<Vec<_>>());
        saved.parameters = parameters(&plan, is_wet, going.map(|s| (s, state.stage_start.1)));
        let error_control = match (&plan.accuracy, state.error_control) {
            (Some(accuracy), Some(mut control)) => {
                control.aim_at(accuracy);
                control.resume(&mut saved.parameters);
                Some(control)
            }
            (accuracy, _) => accuracy.as_ref().map(ErrorControl::new),
        };
        if changes.outdate_network() {
            saved.forget_network();
        }
        let (mut coupled, progress) = match plan.granular_law()? {
            Some(law) => Coupled::mechanics_of(saved, law)?,
            None => Coupled::mechanics_of(saved, Linear)?,
        };
        coupled.build_with(builder);
        let mut active = state.active;
        if let (Some(active), Some(going)) = (&mut active, going) {
            let start = state.stage_start;
            active.restore(&mut coupled, &plan, going, &changes, (start, &state.clock))?;
        }
        coupled.controls().track_turning(plan.output.energy_turning);
        coupled.compare_networks(error_control.is_some());
        coupled.take_up(progress)?;
        if changes.bear_on_time_step() {
            coupled.refresh_time_step();
        }
        Ok(Simulation {
            plan,
            origin,
            restarted: Some(Restart { step, changed }),
            coupled,
            clock: state.clock,
            stage,
            active,
            stage_start: state.stage_start,
            outcomes: state.outcomes,
            previous_remeshes: state.remeshes,
            warnings,
            stress_extremes: state.stress_extremes,
            error_control,
        })
    }

    /// Changes who builds networks, from the next one on.
    pub fn build_with(&mut self, builder: Arc<dyn NetworkBuilder>) {
        self.coupled.build_with(builder);
    }

    /// Does one step, or the whole of a stage that has no steps. Returns
    /// whether there is more to do.
    ///
    /// # Errors
    /// [`Error::AtStep`] says at which step what went wrong.
    pub fn advance(&mut self) -> Result<bool> {
        let step = self.clock.step;
        let advanced = self.try_advance();
        // A step may be complete, and its stage the failure; one that failed has no stress.
        if advanced.is_ok() || self.clock.step > step {
            for (wall, [low, high]) in self.stress_extremes.iter_mut() {
                let stress = self.coupled.wall_stress(wall);
                (*low, *high) = (low.min(stress), high.max(stress));
            }
        }
        advanced.map_err(|source| match source {
            Error::Input(input) => Error::Input(input),
            source => Error::AtStep { step, source: Box::new(self.with_cause(source)) },
        })
    }

    /// Lowest and highest stress on each wall (Pa), by contacts and fluid together, of any step
    /// since the simulation began or [`Simulation::reset_stress_extremes`] was called last.
    pub fn stress_extremes(&self) -> &PerWall<[f64; 2]> {
        &self.stress_extremes
    }

    /// Begins to look for the extremes of stress anew.
    pub fn reset_stress_extremes(&mut self) {
        self.stress_extremes = PerWall([NO_STRESS; 6]);
    }

    /// A failure of a step, with a fixed time step as its cause where that is above the limit.
    fn with_cause(&mut self, source: Error) -> Error {
        if !self.plan.moves() {
            return source;
        }
        let bounds = self.coupled.time_step_bounds();
        // That one says it itself.
        let known = matches!(source, Error::Dem(DemError::TimeStepTooLarge { .. }));
        let looked_for = source.spoils_state() && !known;
        let unstable = self.plan.stages.get(self.stage).filter(|_| looked_for);
        match unstable.and_then(|stage| UnstableStage::of(&self.plan, stage, bounds)) {
            Some(UnstableStage { dt, limit, rule, .. }) => {
                Error::Unstable { source: Box::new(source.without_cause()), dt, limit, rule }
            }
            None => source,
        }
    }

    fn try_advance(&mut self) -> Result<bool> {
        if self.stage >= self.plan.stages.len() {
            return Ok(false);
        }
        if self.active.is_none() {
            self.active = Some(self.begin_stage()?);
        }
        self.control_error()?;
        let Some(mut active) = self.active.take() else { return Ok(false) };
        let (stage, step) = (self.stage, self.clock.step);
        let advanced = active.advance(&mut self.context(stage));
        if advanced.is_ok() && self.clock.step > step {
            self.book_error(stage);
        }
        match advanced {
            Ok(Progress::Finished(outcome)) => {
                let name = self.plan.stages[stage].name.clone();
                self.finish_stage(name, *outcome);
            }
            Ok(Progress::Running) => self.active = Some(active),
            Err(error) => {
                // A checkpoint of the failure knows how far the stage came.
                self.active = Some(active);
                return Err(error);
            }
        }
        Ok(self.stage < self.plan.stages.len())
    }

    /// What a stage works on.
    fn context(&mut self, stage: usize) -> Context<'_> {
        let controlled = self.error_control.as_ref().filter(|_| self.is_coupled(stage));
        Context {
            share: controlled.map(ErrorControl::share),
            stage_steps: self.clock.step - self.stage_start.0,
            warnings: &mut self.warnings,
            plan: &self.plan,
            stage: &self.plan.stages[stage],
            coupled: &mut self.coupled,
            clock: &mut self.clock,
            outcomes: &self.outcomes,
        }
    }

    /// Whether fluid flows between moving spheres in a stage.
    pub(super) fn is_coupled(&self, stage: usize) -> bool {
        self.plan.stages.get(stage).is_some_and(|stage| stage.kind.is_coupled())
    }

    fn begin_stage(&mut self) -> Result<Active> {
        let (number, is_first) = (self.stage, self.stage == 0);
        let mut context = self.context(number);
        let bonds = context.plan.bonds.as_ref();
        if bonds.is_some_and(|b| b.begin_with(&context.stage.name, is_first)) {
            context.bond()?;
        }
        let begun = Active::start(&mut context)?;
        context.give_motions(is_first)?;
        Ok(begun)
    }

    fn finish_stage(&mut self, name: String, outcome: Outcome) {
        let (step, time) = self.stage_start;
        let steps = self.clock.step - step;
        self.outcomes.push(StageOutcome {
            name,
            steps,
            model_time_s: self.clock.time - time,
            outcome,
        });
        self.stage += 1;
        self.stage_start = (self.clock.step, self.clock.time);
        self.coupled.refresh_time_step();
        // Steps of growth are the mechanics' alone.
        self.coupled.count_from(self.clock.step);
    }

    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// How the simulation was taken up again, and what the plan has changed there; `None` for
    /// one that began with its plan.
    pub fn restarted(&self) -> Option<&Restart> {
        self.restarted.as_ref()
    }

    /// The stage that the next step belongs to; `None` when all are done.
    pub fn stage(&self) -> Option<&Stage> {
        self.plan.stages.get(self.stage)
    }

    /// Name of the stage that did the last step; of the first stage before it.
    pub fn last_stage(&self) -> &str {
        let done = self.outcomes.iter().rev().find(|o| o.steps > 0);
        match (self.stage(), done) {
            (Some(stage), _) if self.stage_steps() > 0 => &stage.name,
            (_, Some(outcome)) => &outcome.name,
            (stage, None) => stage.map_or("", |s| &s.name),
        }
    }

    /// How much of the current stage is done, 0 to 1; `None` where that cannot
    /// be known.
    pub fn stage_progress(&self) -> Option<f64> {
        self.active.as_ref()?.progress(&self.clock)
    }

    /// Steps done in the current stage.
    pub fn stage_steps(&self) -> u64 {
        self.clock.step - self.stage_start.0
    }

    /// Steps done in all stages.
    pub fn step(&self) -> u64 {
        self.clock.step
    }

    /// Model time (s).
    pub fn time(&self) -> f64 {
        self.clock.time
    }

    /// The last time step (s).
    pub fn dt(&self) -> f64 {
        self.clock.dt
    }

    /// The spheres and the fluid.
    pub fn coupled(&self) -> &Coupled {
        &self.coupled
    }

    /// Changes the mechanics between two steps: what drives the walls, friction,
    /// damping, velocities. Stages set the walls and the friction anew when they
    /// begin.
    pub fn controls(&mut self) -> Controls<'_> {
        self.coupled.controls()
    }

    /// See [`Coupled::keep_network_arrays`].
    pub fn keep_network_arrays(&mut self, keep: bool) {
        self.coupled.keep_network_arrays(keep);
    }

    /// See [`Coupled::take_retired_network`].
    pub fn take_retired_network(&mut self) -> Option<RetiredNetwork> {
        self.coupled.take_retired_network()
    }

    /// Networks built so far, before a restart included.
    pub fn remeshes(&self) -> u64 {
        self.previous_remeshes + self.coupled.remeshes()
    }

    /// What a user should know of the run so far, a sentence each: of its stages, then of the
    /// networks of this session.
    pub fn warnings(&self) -> Vec<String> {
        let UnmetTolerance { steps, first, worst } = self.coupled.unmet_tolerance();
        let unmet = (steps > 0).then(|| {
            format!(
                "{steps} solves left more than the tolerance asks for, up to {worst:.1e}, the first at step {first}: \
                 ask for less, or take another solver"
            )
        });
        let networks = self.coupled.remesh_counts().remarks.warnings();
        let missed = self.missed_target();
        self.warnings
            .iter()
            .map(Warning::to_string)
            .chain(missed)
            .chain(unmet)
            .chain(networks)
            .collect()
    }

    /// What the finished stages found out.
    pub fn outcomes(&self) -> &[StageOutcome] {
        &self.outcomes
    }

    /// The consolidation that is going on, as far as it has come.
    pub fn consolidation(&self) -> Option<&Consolidation> {
        self.active.as_ref()?.consolidation()
    }

    /// Scalars of the current state.
    pub fn observe(&self) -> Observation {
        self.coupled.observe()
    }

    /// The bounds that the automatic time step was last chosen by; `None` with
    /// a fixed one.
    pub fn time_step_bounds(&self) -> Option<TimeStepBounds> {
        self.clock.bounds
    }

    /// What a checkpoint must hold.
    pub fn state(&self) -> SimulationState {
        SimulationState {
            spheres: self.spheres(),
            origin: self.origin.clone(),
            clock: self.clock,
            stage: self.stage as u64,
            active: self.active.clone(),
            stage_start: self.stage_start,
            outcomes: self.outcomes.clone(),
            remeshes: self.remeshes(),
            warnings: self.warnings.clone(),
            stress_extremes: self.stress_extremes,
            error_control: self.error_control.clone(),
            coupled: self.coupled.state(),
        }
    }

    fn spheres(&self) -> Spheres {
        let dem = self.coupled.dem();
        let radius = dem.radii();
        match dem.cell() {
            Some(cell) => Spheres::new(dem.wrapped_positions(), radius, None, Some(*cell.cell())),
            None => Spheres::new(dem.positions(), radius, Some(dem.box_()), None),
        }
    }

    /// A hash of positions, velocities and pressures, of their very bits: the
    /// same run gives the same hash for any number of threads. Spheres count
    /// in the order of the user's numbers.
    pub fn state_hash(&self) -> String {
        let particles = self.coupled.dem().storage();
        let mut order: Vec<usize> = (0..particles.len()).collect();
        order.sort_unstable_by_key(|&i| particles.id[i]);
        let vectors = order.iter().flat_map(|&i| [particles.position[i], particles.velocity[i]]);
        let pressures = self.coupled.storage_flow().map_or(&[][..], |f| f.pressure());
        let numbers = vectors.flat_map(|v| [v.x, v.y, v.z]).chain(pressures.iter().copied());
        format!("{:016x}", fingerprint(numbers))
    }
}

/// What a plan says of spheres and fluid, the latter where the pores are filled; in a stage that began
/// at a time (s).
fn parameters(plan: &Plan, is_wet: bool, going: Option<(&Stage, f64)>) -> Parameters {
    let fluid = plan.fluid.as_ref().map(|fluid| match going {
        Some((stage, start)) => stage.kind.fluid(fluid, start),
        None => Cow::Borrowed(fluid),
    });
    let fluid = fluid.as_deref();
    Parameters {
        materials: plan.materials(),
        pairs: plan.material_pairs(),
        wall_material: plan.walls.material,
        options: setup::options(plan),
        saturation: fluid.filter(|_| is_wet).map(|f| f.saturation()),
        effects: fluid.map(|f| f.effects.clone()).unwrap_or_default(),
        acceleration: fluid.map(|f| f.acceleration).unwrap_or_default(),
        tolerance: fluid.map(|f| f.tolerance),
        probes: plan.output.probes.clone(),
    }
}
