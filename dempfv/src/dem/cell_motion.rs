//! Spheres in a periodic cell, and how both move in a step.

use super::cell::{CellControls, PeriodicCell};
use super::cell_neighbours::STRAY;
use super::cell_pass::CellPass;
use super::error::DemError;
use super::law::ContactLaw;
use super::material::{Material, WallMaterial};
use super::particles::Particles;
use super::system::{Dem, DemOptions};
use super::walls::walls_of;
use crate::parallel::for_each;
use crate::{Cell, PerWall, Tensor, Vec3};

impl Dem {
    /// Spheres in a periodic cell, with a contact law and materials as [`Dem::with_law`] takes
    /// them. Their velocities, here and everywhere, are relative to the mean field L x of the
    /// cell; spins are not. Any copy of a sphere may be given.
    ///
    /// ```
    /// use dempfv::dem::law::Linear;
    /// use dempfv::dem::{Dem, DemOptions, Material, Particles};
    /// use dempfv::{Cell, Vec3};
    ///
    /// let material =
    ///     Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };
    /// let across = vec![Vec3::new(0.05, 0.5, 0.5), Vec3::new(0.86, 0.5, 0.5)];
    /// let spheres = Particles::new(across, vec![0.1, 0.1], material.density);
    /// let cell = Cell::of_size(Vec3::repeat(1.0))?;
    /// let mut dem = Dem::in_cell(Linear, spheres, cell, &[material], DemOptions::default())?;
    /// dem.compute_contacts()?;
    /// assert!((dem.force(0).x - 1e6 * 0.1 * 0.01).abs() < 1e-9);
    /// # Ok::<(), dempfv::dem::DemError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Dem::with_law`]; [`DemError::CellTooSmall`]; [`DemError::InCell`] with gravity, which
    /// nothing there holds up.
    pub fn in_cell(
        law: impl ContactLaw,
        particles: Particles,
        cell: Cell,
        materials: &[Material],
        options: DemOptions,
    ) -> Result<Dem, DemError> {
        let cell = PeriodicCell::new(cell);
        let young = materials.first().map_or(1.0, |m| m.young);
        // Of walls that nothing touches.
        let walls = WallMaterial { young, friction_angle: 0.0 };
        let around = (cell.cell().bounds(), Some(cell));
        Dem::at_rest(law, particles, around, materials, walls, options)
    }

    /// The periodic cell; `None` between walls.
    pub fn cell(&self) -> Option<&PeriodicCell> {
        self.cell.as_ref()
    }

    /// Tells what moves the cell from now on.
    ///
    /// # Errors
    /// [`DemError::NoCell`] between walls; [`DemError::Parameter`] for a number that is not finite;
    /// [`DemError::StressTwice`] for a shear stress that is given for both its components.
    pub fn set_cell_controls(&mut self, controls: CellControls) -> Result<(), DemError> {
        self.cell.as_mut().ok_or(DemError::NoCell)?.set_controls(controls)
    }

    /// Centres of all spheres (m), by the user's numbers, of those copies that are in the cell.
    /// ([`Dem::positions`] has them as far outside as they have come.)
    pub fn wrapped_positions(&self) -> Vec<Vec3> {
        let mut positions = self.positions();
        if let Some(cell) = &self.cell {
            positions.iter_mut().for_each(|x| *x = cell.cell().wrap(x).0);
        }
        positions
    }

    /// Takes the cell through a step of length `dt` (s): places go with it, velocities against.
    ///
    /// # Errors
    /// [`DemError::Cell`] where the step leaves no cell.
    pub(super) fn move_cell(
        &mut self,
        dt: f64,
        fluid: Option<&PerWall<Vec3>>,
    ) -> Result<(), DemError> {
        let Some(mut cell) = self.cell.take() else { return self.move_walls(dt, fluid) };
        let (gradient, drift) = self.cell_gradient(&cell, dt);
        let before = self.ledger.map(|_| CellPass::new(&cell).gradient());
        cell.drift = drift;
        let moved = cell.advance(gradient, dt);
        self.cell = Some(cell);
        moved?;
        if let Some(before) = before {
            self.book_cell(dt, [&before, &gradient]);
        }
        if gradient == Tensor::zeros() {
            return Ok(());
        }
        let go = dt * gradient;
        // The cell that the step has left is one: so it can be gone back.
        let back = (Tensor::identity() + go).try_inverse().unwrap_or_default();
        for_each(&mut self.centre, &|_, [x, y, z, _]: &mut [f64; 4]| {
            let way = go * Vec3::new(*x, *y, *z);
            (*x, *y, *z) = (*x + way.x, *y + way.y, *z + way.z);
        });
        let motion = self.ledger.map(|_| self.translational_energy());
        for_each(&mut self.particles.velocity, &|_, c: &mut Vec3| *c = back * *c);
        if let Some(motion) = motion {
            self.book_cell_motion(motion);
        }
        self.list.strained(&go);
        self.follow_cell();
        Ok(())
    }

    /// Lets the planes of the box go with the cell.
    fn follow_cell(&mut self) {
        let Some(cell) = &self.cell else { return };
        let planes = walls_of(&cell.cell().bounds());
        for (wall, plane) in self.walls.iter_mut() {
            plane.position = planes[wall].position;
        }
    }

    /// Puts all spheres back into the cell where one has strayed too far, or where the cell has
    /// got other edges; no sphere has gone farther than `way` (m) since this was done last. Which
    /// step does it depends on the spheres alone, not on when a list was built.
    pub(super) fn keep_in_cell(&mut self, way: f64) {
        let Some(cell) = &mut self.cell else { return };
        let reduced = cell.reduce();
        let cell = *cell.cell();
        let height = cell.heights().into_iter().fold(f64::INFINITY, f64::min);
        self.room_to_stray -= way / height;
        // Less than all, for round-off.
        if self.room_to_stray > 1e-6 && !reduced {
            return;
        }
        let room = self.centre.iter().map(|&[x, y, z, _]| {
            let f = cell.fractions(&Vec3::new(x, y, z));
            f.iter().fold(1.0, |room: f64, f| room.min(1.0 + STRAY - f).min(f + STRAY))
        });
        self.room_to_stray = room.fold(1.0, f64::min);
        if reduced || self.room_to_stray < 0.0 {
            for (c, x) in self.centre.iter_mut().zip(&mut self.particles.position) {
                *x = cell.wrap(&Vec3::new(c[0], c[1], c[2])).0;
                (c[0], c[1], c[2]) = (x.x, x.y, x.z);
            }
            self.room_to_stray = STRAY;
            self.list.outdate();
            self.follow_cell();
        }
    }
}
