//! Keeps the error of the pore pressures near a target: when networks are renewed, what solves may leave and
//! how long steps are follow from estimates.
//!
//! The error of a network is what its successor makes otherwise of the same motion. It grows with the age of
//! the network, so the strain at which it is renewed follows from it. The error of the time step is what steps
//! of half the length make otherwise of the same state, looked at ahead of the run every so often. What solves
//! leave is asked to be small beside both.

use serde::{Deserialize, Serialize};

use super::error_estimate::{ErrorEstimate, Gathered, Rates};
use crate::coupling::{Coupled, NetworkChange, Parameters, RemeshRule};
use crate::scene::{Accuracy, Plan, Stage};

/// Shares of the target that networks and time steps may have each; their squares add up.
const SHARE: f64 = 0.5;
/// The solver's tolerance over the target: a tolerance is relative to the largest pressure.
const TOLERANCE: f64 = 1e-3;
/// Remesh strain of the first network over the target, so small that its error is soon known; and the
/// bounds of any.
const FIRST_STRAIN: f64 = 0.2;
const STRAINS: [f64; 2] = [1e-4, 0.5];
/// By how much one network may change the strain of the next.
const STRAIN_CHANGE: [f64; 2] = [0.5, 4.0];
/// Bounds of the time step over the largest stable one.
const LEAST_STEP: f64 = 0.01;
/// By how much one look ahead may change the time step.
const STEP_CHANGE: f64 = 4.0;
/// Steps of one look ahead.
pub(super) const LOOK_STEPS: u32 = 32;
/// Looks from one state on until a step is short enough.
pub(super) const LOOKS: u32 = 4;
/// A time step is made longer where its error is below this share of what it may be.
const WASTEFUL: f64 = 0.5;
/// The error of a step over the difference to one of half the length: 4/3 at second order, 2 at first.
const STEP_ERROR: f64 = 1.6;
/// Steps from one look ahead to the next: of the first two, after a step that was too long, and the most. Each
/// pause is twice the one before.
const FIRST_PAUSE: u64 = 2 * LOOK_STEPS as u64;
const PAUSE_AFTER_ERROR: u64 = 8 * LOOK_STEPS as u64;
const LONGEST_PAUSE: u64 = 160 * LOOK_STEPS as u64;
/// Steps between two looks at the pressures.
const STEPS_BETWEEN_LOOKS: u64 = 8;
/// Pressures count as no smaller than this share of those of the run so far where settings are chosen.
const LEAST_PRESSURE: f64 = 0.3;
/// Mean square of the error of a network over its time, over what it is at the end: of one that was new when
/// it came into use, and of one that was half an interval old.
const NEW: f64 = 1.0 / 3.0;
const AGED: f64 = 13.0 / 12.0;

/// No stage had a choice yet.
const NO_STAGE: u64 = u64::MAX;

/// What a run has chosen, and what its errors are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorControl {
    target: f64,
    /// Number of the stage that the choices are of.
    stage: u64,
    /// Time step over the largest stable one.
    share: f64,
    /// Remesh strain.
    strain: f64,
    /// Error of a network over the strain at which it was renewed.
    error_per_strain: f64,
    /// Steps of the simulation before the next look ahead, and from it to the one after.
    next_look: u64,
    pause: u64,
    rates: Rates,
    gathered: Gathered,
    /// Model time of the last look at the pressures (s).
    looked: f64,
}

/// What half the step makes otherwise: roots of mean squares over spheres and time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Difference {
    /// Of the difference of the pressures (Pa).
    pub off: f64,
    /// Of the pressures (Pa).
    pub size: f64,
}

impl Difference {
    /// Of steps that could not be done.
    pub const UNKNOWN: Difference = Difference { off: f64::INFINITY, size: 1.0 };
}

/// The largest that a scene allows.
#[derive(Clone, Copy)]
pub(super) struct Most {
    pub share: f64,
    pub strain: f64,
}

impl Most {
    /// Of a stage of a plan.
    pub fn of(plan: &Plan, stage: &Stage) -> Most {
        let share = plan.mechanics(stage).unwrap_or_default().safety;
        let strain = plan.fluid.as_ref().and_then(|fluid| fluid.remesh.strain);
        Most { share, strain: strain.unwrap_or(STRAINS[1]).min(STRAINS[1]) }
    }
}

impl ErrorControl {
    /// Before the first step.
    pub(super) fn new(accuracy: &Accuracy) -> ErrorControl {
        ErrorControl {
            target: accuracy.target,
            stage: NO_STAGE,
            share: 0.0,
            strain: 0.0,
            error_per_strain: 0.5,
            next_look: 0,
            pause: FIRST_PAUSE,
            rates: Rates::default(),
            gathered: Gathered::default(),
            looked: 0.0,
        }
    }

    /// Takes another target into account.
    pub(super) fn aim_at(&mut self, accuracy: &Accuracy) {
        self.target = accuracy.target;
    }

    /// Begins a stage in which fluid flows between moving spheres, at a step and a time (s).
    pub(super) fn begin(&mut self, stage: usize, most: Most, (step, time): (u64, f64)) {
        if self.stage == stage as u64 {
            return;
        }
        self.stage = stage as u64;
        self.share = most.share;
        self.strain = (FIRST_STRAIN * self.target).min(most.strain);
        self.next_look = step;
        self.pause = FIRST_PAUSE;
        self.looked = time;
    }

    /// Tells the engine what is chosen.
    pub(super) fn apply(&self, coupled: &mut Coupled) -> crate::Result<()> {
        coupled.set_remesh_rule(self.remesh_rule());
        Ok(coupled.set_tolerance(self.tolerance())?)
    }

    /// Puts what was chosen in the place of what a plan says.
    pub(super) fn resume(&self, parameters: &mut Parameters) {
        if let Some(saturation) = &mut parameters.saturation {
            saturation.remesh = self.remesh_rule();
        }
        parameters.tolerance = Some(self.tolerance());
    }

    /// When networks are renewed.
    pub(super) fn remesh_rule(&self) -> RemeshRule {
        RemeshRule { interval: None, strain: Some(self.strain) }
    }

    /// What a solve may leave (1).
    pub fn tolerance(&self) -> f64 {
        TOLERANCE * self.target
    }

    /// Time step over the largest stable one (1).
    pub fn share(&self) -> f64 {
        self.share
    }

    /// Strain at which networks are renewed (1).
    pub fn strain(&self) -> f64 {
        self.strain
    }

    /// Error that was asked for (1).
    pub fn target(&self) -> f64 {
        self.target
    }

    /// Whether anything was chosen yet.
    pub fn has_begun(&self) -> bool {
        self.stage != NO_STAGE
    }

    /// Whether steps are to be looked at ahead of this one.
    pub(super) fn look_is_due(&self, step: u64) -> bool {
        step >= self.next_look
    }

    /// Pressures below this one are of little weight (Pa).
    pub(super) fn least_pressure(&self) -> f64 {
        LEAST_PRESSURE * self.gathered.mean_pressure()
    }

    /// Takes the difference that half the step makes into account: whether the step is short enough.
    pub(super) fn looked_ahead(
        &mut self,
        Difference { off, size }: Difference,
        most: Most,
    ) -> bool {
        let relative = |size: f64| if size > 0.0 { STEP_ERROR * off / size } else { 0.0 };
        self.rates.time_step = relative(size);
        let (error, allowed) = (relative(size.max(self.least_pressure())), SHARE * self.target);
        let before = self.share;
        // Between first and second order.
        let change = (allowed / error).powf(2.0 / 3.0).clamp(1.0 / STEP_CHANGE, STEP_CHANGE.sqrt());
        if error > allowed {
            self.share = (before * change).max(LEAST_STEP.min(most.share));
            return self.share == before;
        }
        if error < WASTEFUL * allowed && before < most.share {
            self.share = (before * change).min(most.share);
            self.rates.time_step *= (self.share / before).powf(1.5);
        }
        true
    }

    /// No look ahead before some steps have been done from this one on; sooner where steps had to be
    /// `shortened`.
    pub(super) fn pause_looks(&mut self, step: u64, shortened: bool) {
        if shortened {
            self.pause = self.pause.min(PAUSE_AFTER_ERROR);
        }
        self.next_look = step + self.pause;
        self.pause = (2 * self.pause).min(LONGEST_PAUSE);
    }

    /// Books a step, which ended at a time (s).
    pub(super) fn stepped(&mut self, coupled: &mut Coupled, most: Most, (step, time): (u64, f64)) {
        let change = coupled.take_network_change();
        if change.is_none() && !step.is_multiple_of(STEPS_BETWEEN_LOOKS) {
            return;
        }
        let pressure = coupled.determined_pressures();
        let squares = pressure.iter().map(|p| p * p).sum::<f64>() / pressure.len().max(1) as f64;
        let largest = pressure.iter().fold(0.0f64, |m, p| m.max(p.abs()));
        if squares > 0.0 {
            self.rates.solver = self.tolerance() * largest / squares.sqrt();
        }
        self.gathered.add(time - self.looked, squares, &self.rates);
        self.looked = time;
        if let Some(change) = change {
            self.replaced(change, coupled.networks_begin_aged(), most);
            coupled.set_remesh_rule(self.remesh_rule());
        }
    }

    /// A network was replaced.
    fn replaced(
        &mut self,
        NetworkChange { difference, pressure }: NetworkChange,
        aged: bool,
        most: Most,
    ) {
        let shape = if aged { AGED } else { NEW };
        if pressure > 0.0 {
            self.rates.network = difference / pressure;
        }
        self.gathered.replaced(self.rates.network, shape);
        let size = pressure.max(self.least_pressure());
        if size > 0.0 {
            let error = shape.sqrt() * difference / size;
            self.error_per_strain = error / self.strain;
            let change = (SHARE * self.target / error).clamp(STRAIN_CHANGE[0], STRAIN_CHANGE[1]);
            self.strain = (self.strain * change).clamp(STRAINS[0].min(most.strain), most.strain);
        }
    }

    /// The estimate; `strain` is how far the network in use has come towards the limit.
    pub(super) fn estimate(&self, strain: f64) -> Option<ErrorEstimate> {
        let open = self.error_per_strain * self.strain * strain;
        self.gathered.estimate(open * open)
    }
}
