//! What a restart changes, as those ask who take it up.

use crate::WallId;
use crate::scene::Difference;

/// Keys of a scene that a restart has changed.
pub(in crate::simulation) struct Changes<'a> {
    differences: &'a [Difference],
    /// Name of the stage under way.
    stage: Option<&'a str>,
}

impl<'a> Changes<'a> {
    pub fn new(differences: &'a [Difference], stage: Option<&'a str>) -> Changes<'a> {
        Changes { differences, stage }
    }

    /// Whether there are any.
    pub fn any(&self) -> bool {
        !self.differences.is_empty()
    }

    fn has(&self, keys: &[&str]) -> bool {
        self.differences.iter().any(|difference| difference.is_in(keys))
    }

    /// Whether the stage under way has another value of a key.
    pub fn in_stage(&self, key: &str) -> bool {
        self.stage.is_some_and(|stage| self.has(&["stage", stage, key]))
    }

    /// Whether a wall is told something else in the stage under way.
    pub fn of_wall(&self, wall: WallId) -> bool {
        self.stage.is_some_and(|stage| self.has(&["stage", stage, "walls", wall.name()]))
    }

    /// Whether the pressures, resistances and viscous modes of the network in use are those of
    /// something else.
    pub fn outdate_network(&self) -> bool {
        let fluid = [
            "viscosity",
            "density",
            "bulk_modulus",
            "slip_walls",
            "clamp",
            "pressure",
            "sealed_pores",
            "imposed",
            "sources",
            "coupling",
            "darcy_permeability",
            "conductance_factor",
            "conductance_regions",
            "blocked",
            "pressure_gradient",
        ];
        self.has(&["particles", "density"])
            || self.in_stage("pressure")
            || fluid.iter().any(|key| self.has(&["fluid", key]))
    }

    /// Whether the bounds of an automatic time step are those of something else.
    pub fn bear_on_time_step(&self) -> bool {
        let stage = [
            "walls",
            "velocity_gradient",
            "cell_stress",
            "friction_angle",
            "damping",
            "fluid",
            "max_velocity",
            "from",
            "to",
        ];
        let mechanics = ["damping", "gravity", "rotation"];
        self.outdate_network()
            || self.has(&["particles"])
            || self.has(&["walls"])
            || self.has(&["contacts"])
            || mechanics.iter().any(|key| self.has(&["dem", key]))
            || stage.iter().any(|key| self.in_stage(key))
    }
}
