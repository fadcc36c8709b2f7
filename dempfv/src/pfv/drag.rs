//! The fluid's resistance to motion: `f = -F G⁻¹ E v`.

use super::{Flow, Network, PfvError};
use crate::{Effect, EffectKey, Family};
use crate::{PerWall, Vec3, WallId};

/// What this effect says of itself.
pub const FLUID_FORCES: Effect = Effect {
    name: "fluid forces on spheres",
    family: Family::Fluid,
    equation: "f = F p, the pressure on the solid sectors of facets and the viscous share of throats",
    source: "B. Chareyre et al.: Transp. Porous Media 92 (2012)",
    keys: &[EffectKey {
        key: "fluid in a run stage",
        unit: "",
        default: "true where there is [fluid]",
    }],
    needs: "pore flow",
    test: "dempfv/tests/pfv_flow.rs, dempfv/tests/coupling_consolidation.rs",
};

/// Volume rates and pressures of a motion that is only tried out.
pub(super) struct DragScratch {
    volume_rate: Vec<f64>,
    /// Zero where the pressure is imposed.
    pressure: Vec<f64>,
}

impl DragScratch {
    pub fn new(network: &Network) -> DragScratch {
        let zeros = vec![0.0; network.pores()];
        DragScratch { volume_rate: zeros.clone(), pressure: zeros }
    }
}

impl Flow {
    /// How the fluid resists a wall's motion while the spheres stand still: what it takes off
    /// the outward force on each wall per outward velocity of this one (N·s/m). Zero where
    /// the pressure of all pores at the wall is imposed. Takes a solve.
    ///
    /// # Errors
    /// [`PfvError::Solver`] when the solve fails.
    pub fn wall_resistance(&mut self, wall: WallId) -> Result<PerWall<f64>, PfvError> {
        let mut force = vec![Vec3::zeros(); self.network().tessellation.spheres];
        self.wall_drag(wall, &mut DragScratch::new(self.network()), &mut force)
    }

    /// Share of the force that the motion of a wall puts on it that is still there a step later, all at
    /// rest (1): 0 where no pore stores fluid, 1 where none gets away. Takes two solves then.
    ///
    /// # Errors
    /// [`PfvError::Solver`] when a solve fails.
    pub fn wall_persistence(&mut self, wall: WallId) -> Result<f64, PfvError> {
        if self.time_step().is_none() {
            return Ok(0.0);
        }
        let mut scratch = DragScratch::new(self.network());
        let mut force = vec![Vec3::zeros(); self.network().tessellation.spheres];
        let first = self.wall_drag(wall, &mut scratch, &mut force)?[wall];
        let (operators, solver) = self.operators_and_solver();
        let DragScratch { volume_rate, pressure } = &mut scratch;
        for (i, (rate, p)) in volume_rate.iter_mut().zip(&*pressure).enumerate() {
            *rate = -operators.storage().map_or(0.0, |storage| storage.rate(i)) * p;
        }
        let mut wall_force = [Vec3::zeros(); 6];
        solver.respond(operators, volume_rate, pressure)?;
        operators.evaluate_forces(pressure, &mut force, &mut wall_force);
        let later = -wall_force[wall.index()][wall.axis()];
        Ok(if first > 0.0 { (later / first).clamp(0.0, 1.0) } else { 0.0 })
    }

    /// [`Flow::wall_resistance`], and the force on each sphere (N) when the
    /// wall moves at 1 m/s along its axis.
    pub(super) fn wall_drag(
        &mut self,
        wall: WallId,
        scratch: &mut DragScratch,
        force: &mut [Vec3],
    ) -> Result<PerWall<f64>, PfvError> {
        let mut speed = [0.0; 6];
        speed[wall.index()] = 1.0;
        let at_rest = vec![Vec3::zeros(); force.len()];
        let wall_force = self.drag(&at_rest, &speed, scratch, force)?;
        let resistance = PerWall::from_fn(|other| {
            -wall_force[other.index()][other.axis()] * other.inward() * wall.inward()
        });
        // Round-off must not pass for a fluid that helps.
        let resists = resistance[wall] > 0.0;
        Ok(if resists { resistance } else { PerWall::default() })
    }

    /// The fluid's force on spheres (N) and walls (returned) that move, the
    /// imposed pressures being zero: `f = -F G⁻¹ E v`. Leaves the pressures of
    /// the flow as they are. Takes a solve.
    pub(super) fn drag(
        &mut self,
        velocity: &[Vec3],
        wall_velocity: &[f64; 6],
        scratch: &mut DragScratch,
        force: &mut [Vec3],
    ) -> Result<[Vec3; 6], PfvError> {
        let (operators, solver) = self.operators_and_solver();
        let DragScratch { volume_rate, pressure } = scratch;
        let mut wall_force = [Vec3::zeros(); 6];
        operators.evaluate_volume_rate(velocity, wall_velocity, volume_rate);
        if solver.respond(operators, volume_rate, pressure)? {
            operators.evaluate_forces(pressure, force, &mut wall_force);
        } else {
            force.fill(Vec3::zeros());
        }
        Ok(wall_force)
    }
}
