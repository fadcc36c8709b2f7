//! Which effects a plan simulates, by name.

use super::plan::*;
use crate::coupling::{RemeshMode, Update};
use crate::pfv::Clamp;

impl Plan {
    /// Every effect the program knows, and whether this plan simulates it.
    fn effects(&self) -> [(&'static str, bool); 16] {
        let any = |holds: fn(&StageKind) -> bool| self.stages.iter().any(|s| holds(&s.kind));
        let contacts = self.dem.is_some() && any(StageKind::moves);
        let coupled = self.fluid.is_some() && any(StageKind::is_coupled);
        let flow =
            coupled || self.fluid.is_some() && any(|k| matches!(k, StageKind::Permeability(_)));
        let dem = |holds: fn(&Dem) -> bool| contacts && self.dem.as_ref().is_some_and(holds);
        let fluid = |holds: fn(&Fluid) -> bool| flow && self.fluid.as_ref().is_some_and(holds);
        [
            ("contacts", contacts),
            ("friction", contacts && self.has_friction()),
            ("wall friction", contacts && self.walls.friction_angle > 0.0 && self.has_friction()),
            ("rotation", dem(|d| d.rotation)),
            ("gravity", dem(|d| d.gravity.is_some())),
            ("local damping", dem(|d| d.damping > 0.0)),
            ("growth of radii", any(|k| matches!(k, StageKind::Compact(_)))),
            ("moving walls", any(StageKind::has_moving_wall)),
            ("servo walls", any(StageKind::has_servo)),
            ("pore flow", flow),
            ("fluid forces on spheres", coupled),
            ("wall slip", fluid(|f| f.slip_walls)),
            ("conductance clamp", fluid(|f| f.clamp != Clamp::None)),
            (
                "background remesh",
                coupled && fluid(|f| f.acceleration.remesh == RemeshMode::Background),
            ),
            (
                "network at every step",
                coupled && fluid(|f| f.acceleration.update == Update::EveryStep),
            ),
            ("parallel tasks", coupled && fluid(|f| f.acceleration.parallel_tasks)),
        ]
    }

    /// Shear stiffness and friction between spheres: without either, contacts are smooth.
    fn has_friction(&self) -> bool {
        self.particles.friction_angle > 0.0 && self.particles.stiffness_ratio > 0.0
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
    /// assert_eq!(on, ["contacts", "friction", "rotation", "gravity", "local damping"]);
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
        effects.iter().filter(|(_, on)| *on == simulated).map(|(name, _)| *name).collect()
    }
}
