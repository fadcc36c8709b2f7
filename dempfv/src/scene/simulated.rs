//! Which effects a plan simulates.

use std::borrow::Cow;

use super::accuracy::ERROR_CONTROL;
use super::bonds::Bonds;
use super::dem::Dem;
use super::fluid::Fluid;
use super::lubrication;
use super::materials;
use super::motion::GivenMotion;
use super::plan::Plan;
use super::stage::{self, StageKind};
use crate::Effect;
use crate::dem::effects::{ENERGY, PERIODIC_CELL};

impl Plan {
    /// Every effect that the program knows, and whether this plan simulates it: those of each
    /// table.
    pub fn effects(&self) -> Vec<(&'static Effect, bool)> {
        let moving: Vec<Dem> = self.stages.iter().filter_map(|s| self.mechanics(s)).collect();
        let contacts = !moving.is_empty();
        let any = |holds: fn(&StageKind) -> bool| self.stages.iter().any(|s| holds(&s.kind));
        let of_stages = |holds: fn(&StageKind) -> bool| {
            let stages = self.stages.iter().filter(move |s| holds(&s.kind));
            let fluid = self.fluid.as_ref();
            let all = stages.filter_map(|s| Some(s.kind.fluid(fluid?, 0.0))).collect::<Vec<_>>();
            // Stages differ in their pressures alone.
            let which = all.iter().position(|fluid| fluid.changes_pressures()).unwrap_or(0);
            all.into_iter().nth(which)
        };
        let coupled: Option<Cow<Fluid>> = of_stages(StageKind::is_coupled);
        let conditioned: Option<Cow<Fluid>> = of_stages(StageKind::has_conditions);
        let (coupled, conditioned) = (coupled.as_deref(), conditioned.as_deref());
        let measured = any(|k| matches!(k, StageKind::Permeability(_)));
        let flow = conditioned.or(self.fluid.as_ref().filter(|_| measured));
        let mut effects = Vec::new();
        effects.extend(self.particles.effects(contacts));
        effects.extend(materials::described(&self.other_materials, contacts));
        effects.extend(self.walls.effects(contacts && self.particles.has_friction()));
        effects.extend(self.contacts.described(contacts));
        effects.extend(Bonds::described(self.bonds.as_ref(), contacts));
        effects.extend(Dem::effects(&moving));
        effects.extend(GivenMotion::described(&self.motions, contacts));
        effects.push((&PERIODIC_CELL, contacts && self.cell.is_some()));
        effects.extend(stage::effects(&self.stages));
        effects.extend(Fluid::effects(flow, conditioned, coupled, self.cell.is_some()));
        effects.extend(lubrication::described(coupled.map(|fluid| &fluid.effects.edges)));
        effects.push((&ERROR_CONTROL, self.accuracy.is_some()));
        effects.push((&ENERGY, contacts && self.output.energy));
        effects
    }

    /// Names of the effects that are simulated.
    ///
    /// ```
    /// let scene = "
    ///     [box]
    ///     min = [0, 0, 0]
    ///     max = [1, 1, 1]
    ///     [particles]
    ///     cloud = { count = 10, radius = 0.01 }
    ///     [dem]
    ///     gravity = [0, 0, -9.81]
    ///     [[stage]]
    ///     kind = \"run\"
    ///     time = 0.5";
    /// let plan = dempfv::scene::Plan::from_toml(scene, None).unwrap();
    /// let on = plan.effects_on();
    /// assert_eq!(on, [
    ///     "contacts", "friction", "rotation", "gravity", "local damping", "energy by cause"
    /// ]);
    /// assert!(plan.effects_off().contains(&"pore flow"));
    /// ```
    pub fn effects_on(&self) -> Vec<&'static str> {
        self.effects_that_are(true)
    }

    /// Names of the effects that are known but not simulated.
    pub fn effects_off(&self) -> Vec<&'static str> {
        self.effects_that_are(false)
    }

    fn effects_that_are(&self, simulated: bool) -> Vec<&'static str> {
        let effects = self.effects();
        effects.iter().filter(|(_, on)| *on == simulated).map(|(effect, _)| effect.name).collect()
    }
}
