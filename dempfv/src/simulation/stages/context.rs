//! What a stage works on.

use crate::coupling::Coupled;
use crate::dem::{Contact, Partner};
use crate::scene::{Dem, GivenMotion, Plan, Stage, TimeStep};
use crate::simulation::clock::Clock;
use crate::simulation::estimate::UnstableStage;
use crate::simulation::outcome::{Outcome, StageOutcome};
use crate::simulation::warning::{BondsUnderLoad, Warning, warn};
use crate::{InputError, Result};

/// Steps of a stage between two looks at whether its fixed time step is stable.
const STEPS_BETWEEN_LOOKS: u64 = 1_000;
/// The viscous limit of packings of up to so many spheres is found from the network itself,
/// which takes some solves; of larger ones it is the paper's estimate.
const MEASURED: usize = 20_000;

/// What a stage works on.
pub(in crate::simulation) struct Context<'a> {
    pub plan: &'a Plan,
    /// The stage that is carried out.
    pub stage: &'a Stage,
    pub coupled: &'a mut Coupled,
    pub clock: &'a mut Clock,
    /// Steps that the stage has done.
    pub stage_steps: u64,
    pub warnings: &'a mut Vec<Warning>,
    pub outcomes: &'a [StageOutcome],
    /// Time step over the largest stable one, where an error is kept to.
    pub share: Option<f64>,
}

/// Whether a stage goes on.
pub(in crate::simulation) enum Progress {
    Running,
    Finished(Box<Outcome>),
}

impl Progress {
    /// The stage is over.
    pub fn finished(outcome: Outcome) -> Progress {
        Progress::Finished(Box::new(outcome))
    }
}

impl Context<'_> {
    /// The mechanics of the stage: those of the scene, with what the stage says
    /// otherwise; the defaults where nothing moves.
    pub fn mechanics(&self) -> Dem {
        self.plan.mechanics(self.stage).unwrap_or_default()
    }

    /// One step with the time step of the stage, and with the scene's fluid if
    /// the pores are filled.
    pub fn step(&mut self) -> Result<()> {
        let dt = self.next_dt()?;
        self.step_by(dt)
    }

    /// The length of the next step (s).
    pub fn next_dt(&mut self) -> Result<f64> {
        let Dem { dt, safety, .. } = self.mechanics();
        if matches!(dt, TimeStep::Fixed(_)) && self.stage_steps.is_multiple_of(STEPS_BETWEEN_LOOKS)
        {
            self.watch_fixed_step()?;
        }
        let Some(share) = self.share else { return self.clock.next_dt(dt, safety, self.coupled) };
        let mut next = self.clock.next_dt(TimeStep::Auto, share, self.coupled)?;
        if let TimeStep::Fixed(longest) = dt {
            next = next.min(longest);
            self.clock.dt = next;
        }
        Ok(next)
    }

    /// One step of this length (s), which [`Context::next_dt`] told.
    pub fn step_by(&mut self, dt: f64) -> Result<()> {
        self.coupled.set_time(self.clock.time);
        self.coupled.step(dt)?;
        self.clock.advance();
        Ok(())
    }

    /// One step of this length (s) of the fluid alone.
    pub fn step_fluid(&mut self, dt: f64) -> Result<()> {
        self.clock.dt = dt;
        self.clock.bounds = None;
        self.coupled.set_time(self.clock.time);
        self.coupled.step_fluid(dt)?;
        self.clock.advance();
        Ok(())
    }

    /// Warns of a fixed time step above its limit.
    fn watch_fixed_step(&mut self) -> Result<()> {
        if self.coupled.dem().len() <= MEASURED {
            self.coupled.update_viscous_mode(true)?;
        }
        let bounds = self.coupled.time_step_bounds();
        if let Some(unstable) = UnstableStage::of(self.plan, self.stage, bounds) {
            warn(self.warnings, Warning::UnstableTimeStep(unstable));
        }
        Ok(())
    }

    /// Bonds the spheres, and says where that took a load off contacts.
    pub fn bond(&mut self) -> Result<()> {
        self.coupled.compute_contacts()?;
        let between_spheres = |c: &Contact| matches!(c.partner, Partner::Sphere(_));
        let contacts = self.coupled.dem().contacts().filter(between_spheres);
        let loaded = contacts.filter(|contact| contact.normal_force > 0.0).count() as u64;
        let made = self.coupled.controls().bond()?;
        if loaded > 0 {
            let stage = self.stage.name.clone();
            warn(self.warnings, Warning::BondsUnderLoad(BondsUnderLoad { stage, loaded, made }));
        }
        Ok(())
    }

    /// Gives the motions that begin with the stage.
    pub fn give_motions(&mut self, is_first: bool) -> Result<()> {
        let begins = |m: &&GivenMotion| m.begin_with(&self.stage.name, is_first);
        for (place, given) in self.plan.motions.iter().enumerate().filter(|(_, m)| begins(m)) {
            let dem = self.coupled.dem();
            let numbers = given.which.chosen(&dem.positions(), &dem.radii());
            if numbers.is_empty() {
                let what = format!(
                    "[[motion]] {} has no sphere when stage \"{}\" begins",
                    place + 1,
                    self.stage.name
                );
                let remedy = "give a region with the centre of a sphere in it";
                return Err(InputError::new(what, remedy).into());
            }
            let time = self.clock.time;
            self.coupled.controls().prescribe(&numbers, given.motion.clone(), time)?;
        }
        Ok(())
    }

    /// Fills the pores with the scene's fluid, under the stage's pressures.
    pub fn saturate(&mut self) -> Result<()> {
        let fluid = self.plan.fluid.as_ref().ok_or_else(|| {
            InputError::new(
                "a coupled stage in a scene without fluid",
                "add a table [fluid] with its viscosity",
            )
        })?;
        let fluid = self.stage.kind.fluid(fluid, self.clock.time);
        self.coupled.saturate(fluid.saturation());
        self.coupled.set_fluid_effects(fluid.effects.clone());
        Ok(())
    }
}
