//! Packing by growing all radii in a fixed box or periodic cell until it carries a stress.

use serde::{Deserialize, Serialize};

use super::error::DemError;
use super::material::positive;
use super::system::Dem;
use crate::{Effect, EffectKey, Family};

/// What this effect says of itself.
pub const EFFECT: Effect = Effect {
    name: "growth of radii",
    family: Family::Bodies,
    equation: "r → r (1 + (σ_goal − σ)/σ_goal (m − 1)) every 10 steps, or the box by the inverse",
    source: "YADE's TriaxialCompressionEngine, internal compaction",
    keys: &[
        EffectKey { key: "kind = \"compact\" of a stage", unit: "", default: "none" },
        EffectKey { key: "stress in a compact stage", unit: "Pa", default: "required" },
        EffectKey { key: "keep_radii in a compact stage", unit: "", default: "false" },
    ],
    needs: "walls or a periodic cell at rest",
    test: "dempfv/tests/dem_growth.rs",
};

/// How radii grow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GrowthOptions {
    /// Mean stress of the six walls, or of the periodic cell, to be reached (Pa).
    pub stress: f64,
    /// Largest factor on the radii in one control step, until the stress has
    /// once passed the goal.
    pub fast_factor: f64,
    /// The same from then on.
    pub slow_factor: f64,
    /// Time steps from one control step to the next.
    pub interval: u64,
    /// Share of the contact time step that is used.
    pub time_step_safety: f64,
    /// At rest when the unbalanced force is less than this ...
    pub unbalanced_tolerance: f64,
    /// ... and the stress is nearer to the goal than this share of it.
    pub stress_tolerance: f64,
    /// Give up after this many steps.
    pub max_steps: u64,
    /// Radii stay; the box or the cell shrinks instead, with the places of the spheres in it
    /// ([`Dem::scale_space`]).
    pub keep_radii: bool,
}

impl GrowthOptions {
    /// The usual growth to a stress (Pa) of spheres with the modulus `young`
    /// (Pa): factors 1 + 2·10⁴/E and 1 + 2·10³/E (E in Pa) every 10 steps, to
    /// an unbalanced force of 0.001 and within 0.1 % of the stress.
    pub fn new(stress: f64, young: f64) -> GrowthOptions {
        GrowthOptions {
            stress,
            fast_factor: 1.0 + 2e4 / young,
            slow_factor: 1.0 + 2e3 / young,
            interval: 10,
            time_step_safety: 0.8,
            unbalanced_tolerance: 1e-3,
            stress_tolerance: 1e-3,
            max_steps: 200_000,
            keep_radii: false,
        }
    }

    fn check(&self) -> Result<(), DemError> {
        positive("compaction stress", self.stress)?;
        for (name, factor) in [("fast_factor", self.fast_factor), ("slow_factor", self.slow_factor)]
        {
            if !(factor > 1.0 && factor.is_finite()) {
                return Err(DemError::Parameter { name, value: factor, expected: "more than 1" });
            }
        }
        positive("growth interval", self.interval as f64)?;
        positive("time_step_safety", self.time_step_safety)?;
        positive("unbalanced_tolerance", self.unbalanced_tolerance)?;
        positive("stress_tolerance", self.stress_tolerance)
    }
}

/// Where a compaction stands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GrowthStatus {
    /// Steps done.
    pub steps: u64,
    /// Mean stress of the six walls, or of the periodic cell (Pa), at the last control step.
    pub stress: f64,
    /// Unbalanced force, at the last control step.
    pub unbalanced: f64,
    /// The packing is at rest at the stress asked for.
    pub done: bool,
}

/// A compaction by growth, advanced step by step by its caller.
///
/// Every few steps all radii are multiplied by
/// 1 + (σ_goal − σ)/σ_goal (m − 1), with σ the mean wall stress and m the
/// largest factor allowed, and all masses by its cube.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GrowthCompaction {
    options: GrowthOptions,
    status: GrowthStatus,
    /// The stress has once passed the goal.
    passed: bool,
    /// Time step in use (s); 0 where the next step has to choose one.
    dt: f64,
    /// See [`GrowthCompaction::set_time_step`].
    fixed_dt: Option<f64>,
}

impl GrowthCompaction {
    /// A compaction that has not begun.
    ///
    /// # Errors
    /// [`DemError::Parameter`] for options that make no sense.
    pub fn new(options: GrowthOptions) -> Result<GrowthCompaction, DemError> {
        options.check()?;
        let status = GrowthStatus { steps: 0, stress: 0.0, unbalanced: 0.0, done: false };
        Ok(GrowthCompaction { options, status, passed: false, dt: 0.0, fixed_dt: None })
    }

    /// Changes how it goes on; [`GrowthOptions::max_steps`] counts from the beginning.
    ///
    /// # Errors
    /// As [`GrowthCompaction::new`].
    pub fn set_options(&mut self, options: GrowthOptions) -> Result<(), DemError> {
        options.check()?;
        self.options = options;
        Ok(())
    }

    /// Fixes the time step (s); `None`: the largest that is safe, chosen anew
    /// at each control step. The next control step refuses one that is not
    /// positive.
    pub fn set_time_step(&mut self, dt: Option<f64>) {
        self.fixed_dt = dt;
    }

    /// Makes the next step choose its time step, after something has changed that bears on it.
    pub fn refresh_time_step(&mut self) {
        self.dt = 0.0;
    }

    /// Where the compaction stands.
    pub fn status(&self) -> GrowthStatus {
        self.status
    }

    /// The time step in use (s); 0 before the first step.
    pub fn time_step(&self) -> f64 {
        self.dt
    }

    /// One time step, unless the packing is at rest already.
    ///
    /// # Errors
    /// [`DemError::NotSettled`] when the steps are used up,
    /// [`DemError::TimeStepTooLarge`] when a fixed time step is not stable (at
    /// each control step: the bound changes with the radii); and as
    /// [`Dem::step`].
    pub fn step(&mut self, dem: &mut Dem) -> Result<GrowthStatus, DemError> {
        if self.status.done {
            return Ok(self.status);
        }
        dem.compute_contacts()?;
        if self.status.steps.is_multiple_of(self.options.interval) {
            self.control(dem)?;
            if self.status.done {
                return Ok(self.status);
            }
        }
        self.check_steps()?;
        if self.dt == 0.0 {
            self.choose_time_step(dem)?;
        }
        dem.integrate(self.dt, None, None)?;
        self.status.steps += 1;
        Ok(self.status)
    }

    /// All steps, until the packing is at rest.
    ///
    /// # Errors
    /// As [`GrowthCompaction::step`].
    pub fn run(&mut self, dem: &mut Dem) -> Result<GrowthStatus, DemError> {
        while !self.step(dem)?.done {}
        Ok(self.status)
    }

    /// Measures, grows, and sets the time step.
    fn control(&mut self, dem: &mut Dem) -> Result<(), DemError> {
        let goal = self.options.stress;
        let stress = dem.mean_stress();
        let unbalanced = dem.force_ratio(None);
        let missing = (goal - stress) / goal;
        self.status.stress = stress;
        self.status.unbalanced = unbalanced;
        self.status.done = unbalanced < self.options.unbalanced_tolerance
            && missing.abs() < self.options.stress_tolerance;
        if self.status.done {
            return Ok(());
        }
        // Before anything grows: with more steps allowed, it goes on from here.
        self.check_steps()?;
        self.passed |= stress > goal;
        let largest = if self.passed { self.options.slow_factor } else { self.options.fast_factor };
        // An early burst of stress must not shrink the spheres to nothing.
        let factor = (1.0 + missing * (largest - 1.0)).max(0.9);
        match self.options.keep_radii {
            true => dem.scale_space(1.0 / factor)?,
            false => dem.scale_radii(factor)?,
        }
        self.choose_time_step(dem)
    }

    fn choose_time_step(&mut self, dem: &mut Dem) -> Result<(), DemError> {
        self.dt = match self.fixed_dt {
            None => dem.safe_time_step(self.options.time_step_safety),
            Some(dt) => stable(dt, dem.safe_time_step(1.0))?,
        };
        Ok(())
    }

    fn check_steps(&self) -> Result<(), DemError> {
        let GrowthStatus { steps, stress, unbalanced, .. } = self.status;
        if steps < self.options.max_steps {
            return Ok(());
        }
        Err(DemError::NotSettled { steps, stress, goal: self.options.stress, unbalanced })
    }
}

/// A time step (s) that is not above its limit.
fn stable(dt: f64, limit: f64) -> Result<f64, DemError> {
    match dt <= limit {
        true => Ok(dt),
        false => Err(DemError::TimeStepTooLarge { dt, limit }),
    }
}
