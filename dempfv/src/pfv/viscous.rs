//! How fast viscosity stops the spheres: the bound that it sets to explicit
//! time steps.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::drag::DragScratch;
use super::krylov::largest;
use super::packing_check::{require_finite, require_length};
use super::{Flow, PfvError};
use crate::{PerWall, Vec3, WallId};

/// The mode of the spheres that the fluid stops fastest: the largest
/// eigenvalue of V M⁻¹, V = F G⁻¹ E (eq. A.9 of Caulk 2020), and its vector.
///
/// Fluid forces that are evaluated at the velocity before the step make a
/// mode of rate λ overshoot by 1 − λ Δt: it grows when Δt > 2/λ.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ViscousMode {
    /// Rate λ at which it decays (1/s).
    pub rate: f64,
    /// What the rate may miss (1/s): twice the length of the residual. Where
    /// many modes decay nearly as fast, once the residual was seen to be less
    /// than what was missing; never twice.
    pub margin: f64,
    /// Solves that it took.
    pub solves: u32,
    /// √m v of each sphere, together of length 1: the squares are the shares
    /// of the kinetic energy.
    pub shape: Vec<Vec3>,
}

impl ViscousMode {
    /// Upper bound of the rate (1/s).
    pub fn upper_rate(&self) -> f64 {
        self.rate + self.margin
    }

    /// The `count` spheres that carry most of the kinetic energy, with their
    /// shares of it; fewer where half of it comes together before.
    pub fn carriers(&self, count: usize) -> Vec<(usize, f64)> {
        let mut shares: Vec<(usize, f64)> =
            self.shape.iter().map(|s| s.norm_squared()).enumerate().collect();
        shares.sort_by(|(i, a), (j, b)| b.total_cmp(a).then(i.cmp(j)));
        let mut sum = 0.0;
        let enough = shares.iter().take(count).position(|(_, share)| {
            sum += share;
            sum >= 0.5
        });
        shares.truncate(enough.map_or(count, |last| last + 1));
        shares
    }

    /// The number of spheres that would share the energy evenly (1):
    /// 1 / Σ share².
    pub fn participation(&self) -> f64 {
        1.0 / self.shape.iter().map(|s| s.norm_squared().powi(2)).sum::<f64>()
    }
}

/// A wall that the fluid pushes around.
struct FreeWall {
    wall: WallId,
    /// See [`Flow::wall_resistance`] (N·s/m).
    resistance: PerWall<f64>,
    /// Force against the motion of each sphere when it moves alone (N·s/m).
    field: Vec<Vec3>,
}

impl Flow {
    /// The mode that the fluid stops fastest, for spheres of these masses
    /// (kg); `None` where no pressure is unknown. One solve for each
    /// application of V, six to twenty-four of them, and one for each wall in
    /// `servo`. `start`, the [`ViscousMode::shape`] of an earlier network,
    /// saves some; a rate that turns out to be less than `negligible` (1/s)
    /// remains rough, on the safe side.
    ///
    /// Walls in `servo` yield to the fluid: together they move by the fluid's forces on
    /// them over their resistances R, a matrix, which keeps their own motion stable
    /// for any time step but adds to that of the spheres. Where the mode
    /// alternates from step to step such walls move at R⁻¹ V_ws v, so the
    /// spheres feel V + V_sw R⁻¹ V_ws.
    ///
    /// # Errors
    /// When a solve fails; [`PfvError::InvalidInput`] for masses that are not one per sphere or
    /// not positive, a start that is not one finite vector per sphere, and a `negligible` rate
    /// that is below zero.
    pub fn viscous_mode(
        &mut self,
        mass: &[f64],
        servo: [bool; 6],
        start: Option<&[Vec3]>,
        negligible: f64,
    ) -> Result<Option<ViscousMode>, PfvError> {
        let spheres = self.network().tessellation.spheres;
        require_length("mass", mass.len(), spheres, "spheres")?;
        if let Some(index) = mass.iter().position(|m| !(*m > 0.0 && m.is_finite())) {
            let problem = format!("{} is not a positive mass", mass[index]);
            return Err(PfvError::invalid("mass", index, problem));
        }
        if let Some(start) = start {
            require_length("start", start.len(), spheres, "spheres")?;
            require_finite("start", start)?;
        }
        if negligible.is_nan() || negligible < 0.0 {
            let problem = format!("{negligible} is no rate; it must be 0 or more");
            return Err(PfvError::InvalidInput { argument: "negligible", index: None, problem });
        }
        if self.operators().unknowns() == 0 {
            return Ok(None);
        }
        let mut scratch = DragScratch::new(self.network());
        let mut walls = vec![];
        for wall in WallId::ALL.into_iter().filter(|w| servo[w.index()]) {
            walls.extend(self.free_wall(wall, &mut scratch)?);
        }
        let yielding = YieldingWalls::new(&walls);
        let weight: Vec<f64> = mass.iter().map(|m| 1.0 / m.sqrt()).collect();
        let mut velocity = vec![Vec3::zeros(); mass.len()];
        let found = largest(mass.len(), start, negligible, |shape, out| {
            for ((v, s), w) in velocity.iter_mut().zip(shape).zip(&weight) {
                *v = *w * s;
            }
            let wall_force = self.drag(&velocity, &[0.0; 6], &mut scratch, out)?;
            let speeds = yielding.speeds(&wall_force);
            for (FreeWall { field, .. }, speed) in walls.iter().zip(speeds) {
                out.iter_mut().zip(field).for_each(|(f, per_speed)| *f -= speed * per_speed);
            }
            out.iter_mut().zip(&weight).for_each(|(f, w)| *f *= -w);
            Ok(())
        })?;
        Ok(Some(ViscousMode {
            // A rate below zero, which no fluid has, must not pass for none.
            rate: found.value.abs(),
            margin: 2.0 * found.residual,
            solves: found.applications + walls.len() as u32,
            shape: found.vector,
        }))
    }

    /// What the fluid does when a wall moves alone; `None` where it does not
    /// resist, because every pore at the wall has an imposed pressure.
    fn free_wall(
        &mut self,
        wall: WallId,
        scratch: &mut DragScratch,
    ) -> Result<Option<FreeWall>, PfvError> {
        let spheres = self.network().tessellation.spheres;
        let mut field = vec![Vec3::zeros(); spheres];
        let resistance = self.wall_drag(wall, scratch, &mut field)?;
        field.iter_mut().for_each(|f| *f = -*f);
        Ok((resistance[wall] > 0.0).then_some(FreeWall { wall, resistance, field }))
    }
}

/// Walls that the fluid pushes around, together.
struct YieldingWalls {
    walls: Vec<WallId>,
    inverse: DMatrix<f64>,
}

impl YieldingWalls {
    fn new(walls: &[FreeWall]) -> YieldingWalls {
        let entry = |i: usize, j: usize| {
            let (a, b) = (walls[i].wall, walls[j].wall);
            // Along the axes.
            walls[j].resistance[a] * a.inward() * b.inward()
        };
        let matrix = DMatrix::from_fn(walls.len(), walls.len(), entry);
        // Walls that cannot be told apart yield each by itself.
        let alone = || DMatrix::from_diagonal(&matrix.diagonal().map(|r| 1.0 / r));
        let inverse = matrix.clone().try_inverse().unwrap_or_else(alone);
        YieldingWalls { walls: walls.iter().map(|w| w.wall).collect(), inverse }
    }

    /// Speeds along their axes (m/s) that spheres whose motion puts these forces on the walls
    /// (N) make of the walls in the next step.
    fn speeds(&self, wall_force: &[Vec3; 6]) -> Vec<f64> {
        let along = |w: &WallId| -wall_force[w.index()][w.axis()];
        let force = DVector::from_iterator(self.walls.len(), self.walls.iter().map(along));
        (&self.inverse * force).iter().copied().collect()
    }
}
