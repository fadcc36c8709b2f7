//! The whole mechanics: state, neighbour list, forces, and the time step.

use serde::{Deserialize, Serialize};

use super::error::DemError;
use super::integrate::{Motion, advance};
use super::material::{Law, Material, WallMaterial, check_friction, positive};
use super::neighbours::Neighbours;
use super::particles::Particles;
use super::pass::{Forces, Input, WallSum, contact_forces};
use super::state::DemState;
use super::walls::{Wall, WallControl, WallLoad, box_of, check_box, walls_of};
use crate::{Aabb, Vec3, WallId};

/// What is simulated beside contacts, and how.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DemOptions {
    /// Local damping λ, 0 to less than 1.
    pub damping: f64,
    /// Acceleration of gravity (m/s²), if any.
    pub gravity: Option<Vec3>,
    /// Whether spheres rotate.
    pub rotation: bool,
    /// Skin of the neighbour list, as a share of the mean radius. Results do
    /// not depend on it, only the time they take.
    pub skin: f64,
}

impl Default for DemOptions {
    /// No damping, no gravity, rotation, and a skin of a tenth of the radius.
    fn default() -> Self {
        DemOptions { damping: 0.0, gravity: None, rotation: true, skin: 0.1 }
    }
}

/// Spheres in a box of six walls.
pub struct Dem {
    pub(super) particles: Particles,
    pub(super) walls: [Wall; 6],
    pub(super) options: DemOptions,
    pub(super) law: Law,
    material: Material,
    wall_material: WallMaterial,
    /// See [`DemState::pending_dt`].
    pending_dt: f64,
    pub(super) list: Neighbours,
    pub(super) forces: Forces,
    /// Centre and radius of each sphere, as the contact pass reads them.
    pub(super) centre: Vec<[f64; 4]>,
    pub(super) wall_sums: [WallSum; 6],
    /// See [`Dem::set_wall_resistance`].
    wall_resistance: [f64; 6],
    /// Scratch of [`Dem::contact_time_step`]: stiffness of each sphere's
    /// contacts, and rotational stiffness over r².
    pub(super) stiffness: Vec<[Vec3; 2]>,
}

impl Dem {
    /// Spheres at the positions given, between fixed walls around `box_`. The
    /// spheres are put in spatial order; [`Particles::id`] tells the user's.
    ///
    /// # Errors
    /// Parameters that make no sense, a centre beyond a wall, two spheres
    /// with one centre, numbers that are not finite: see [`DemError`].
    pub fn new(
        particles: Particles,
        box_: Aabb,
        material: Material,
        wall_material: WallMaterial,
        options: DemOptions,
    ) -> Result<Dem, DemError> {
        check_box(&box_)?;
        particles.check()?;
        let mut state = DemState {
            particles,
            walls: walls_of(&box_),
            sphere_history: Vec::new(),
            wall_history: Vec::new(),
            pending_dt: 0.0,
        };
        state.sort_spatially();
        Dem::from_state(state, material, wall_material, options)
    }

    /// Goes on from a state that [`Dem::state`] gave, with the same bits as
    /// if it had not stopped.
    ///
    /// # Errors
    /// As [`Dem::new`].
    pub fn from_state(
        state: DemState,
        material: Material,
        wall_material: WallMaterial,
        options: DemOptions,
    ) -> Result<Dem, DemError> {
        material.check()?;
        wall_material.check()?;
        options.check()?;
        state.particles.check()?;
        check_box(&box_of(&state.walls))?;
        let mut list = Neighbours::default();
        list.load(&state)?;
        let DemState { particles, walls, pending_dt, .. } = state;
        let centre = particles
            .position
            .iter()
            .zip(&particles.radius)
            .map(|(x, &r)| [x.x, x.y, x.z, r])
            .collect();
        let mut dem = Dem {
            law: material.law(&wall_material),
            forces: Forces::default(),
            wall_sums: [WallSum::ZERO; 6],
            wall_resistance: [0.0; 6],
            stiffness: vec![],
            particles,
            walls,
            options,
            material,
            wall_material,
            pending_dt,
            list,
            centre,
        };
        dem.forces.force.resize(dem.particles.len(), Vec3::zeros());
        dem.forces.torque.resize(dem.particles.len(), Vec3::zeros());
        dem.rebuild()?;
        Ok(dem)
    }

    /// What a checkpoint holds.
    pub fn state(&self) -> DemState {
        DemState {
            particles: self.particles.clone(),
            walls: self.walls,
            sphere_history: self.list.sphere_history(),
            wall_history: self.list.wall_history(),
            pending_dt: self.pending_dt,
        }
    }

    /// Puts the spheres in spatial order again, after they have moved far
    /// from where they were. Changes the order of all arrays.
    ///
    /// # Errors
    /// As [`Dem::compute_contacts`].
    pub fn sort_spatially(&mut self) -> Result<(), DemError> {
        let mut state = self.state();
        state.sort_spatially();
        *self = Dem::from_state(state, self.material, self.wall_material, self.options)?;
        Ok(())
    }

    fn rebuild(&mut self) -> Result<(), DemError> {
        self.list.build(&self.particles, &self.walls, self.options.skin)?;
        let end = self.list.bounds.last().copied().unwrap_or_default();
        self.forces.sent.clear();
        self.forces.sent.resize(end.sent, [0.0; 6]);
        self.forces.wall_sums.resize(self.list.bounds.len() - 1, [WallSum::ZERO; 6]);
        Ok(())
    }

    /// Computes the contact forces at the current positions, after building
    /// the neighbour list anew if something may have used up its skin. The
    /// shear forces follow the motion of the last step, once.
    ///
    /// # Errors
    /// [`DemError::OutsideBox`] or [`DemError::Coincident`], found when the
    /// list is built.
    pub fn compute_contacts(&mut self) -> Result<(), DemError> {
        if self.list.outdated(&self.centre, &self.walls) {
            self.rebuild()?;
        }
        let input = Input {
            centre: &self.centre,
            velocity: &self.particles.velocity,
            spin: &self.particles.spin,
            walls: &self.walls,
            law: self.law,
            dt: self.pending_dt,
            rotation: self.options.rotation,
        };
        contact_forces(&mut self.list, &mut self.forces, input);
        self.pending_dt = 0.0;
        self.wall_sums = [WallSum::ZERO; 6];
        for block in &self.forces.wall_sums {
            for (total, part) in self.wall_sums.iter_mut().zip(block) {
                total.force += part.force;
                total.stiffness += part.stiffness;
            }
        }
        Ok(())
    }

    /// Moves walls and spheres by one time step `dt` (s) under the contact
    /// forces of the last [`Dem::compute_contacts`] and, where given, the
    /// fluid's force on each sphere and each wall (N).
    ///
    /// # Errors
    /// [`DemError::NotFinite`] names a particle whose force or motion is not
    /// finite; the state is then spoilt. [`DemError::WallsMet`],
    /// [`DemError::Parameter`] for a time step that is not positive,
    /// [`DemError::Length`] for a fluid force of another length.
    pub fn integrate(
        &mut self,
        dt: f64,
        fluid_force: Option<&[Vec3]>,
        fluid_wall_force: Option<&[Vec3; 6]>,
    ) -> Result<(), DemError> {
        positive("time step", dt)?;
        let expected = self.particles.len();
        if let Some(found) = fluid_force.map(<[Vec3]>::len).filter(|&n| n != expected) {
            return Err(DemError::Length { what: "fluid force", found, expected });
        }
        self.move_walls(dt, fluid_wall_force)?;
        let motion = Motion {
            dt,
            damping: self.options.damping,
            gravity: self.options.gravity.unwrap_or_default(),
            // Without friction nothing turns a sphere.
            rotation: self.options.rotation && self.law.has_friction(),
        };
        let farthest = advance(
            &mut self.particles,
            &mut self.centre,
            [&self.forces.force, &self.forces.torque],
            fluid_force,
            motion,
        )?;
        self.list.moved(farthest);
        self.pending_dt = dt;
        Ok(())
    }

    fn move_walls(&mut self, dt: f64, fluid: Option<&[Vec3; 6]>) -> Result<(), DemError> {
        let box_ = self.box_();
        let size = box_.size();
        for wall in WallId::ALL {
            let (k, axis) = (wall.index(), wall.axis());
            let force = self.wall_sums[k].force[axis] + fluid.map_or(0.0, |f| f[k][axis]);
            let load = WallLoad {
                outward: -wall.inward() * force,
                stiffness: self.wall_sums[k].stiffness,
                resistance: self.wall_resistance[k],
                area: box_.wall_area(wall),
                axis_share: 3.0 * size[axis] / size.sum(),
            };
            self.walls[k].advance(wall, dt, load);
        }
        check_box(&self.box_())
    }

    /// One dry step: [`Dem::compute_contacts`], then [`Dem::integrate`].
    ///
    /// # Errors
    /// As these two.
    pub fn step(&mut self, dt: f64) -> Result<(), DemError> {
        self.compute_contacts()?;
        self.integrate(dt, None, None)
    }

    /// The spheres, in the order of all arrays per sphere.
    pub fn particles(&self) -> &Particles {
        &self.particles
    }

    /// Velocities and spins, to be changed: (m/s), (rad/s).
    pub fn velocities_mut(&mut self) -> (&mut [Vec3], &mut [Vec3]) {
        (&mut self.particles.velocity, &mut self.particles.spin)
    }

    /// The walls, by [`WallId::index`].
    pub fn walls(&self) -> &[Wall; 6] {
        &self.walls
    }

    /// The box between the walls.
    pub fn box_(&self) -> Aabb {
        box_of(&self.walls)
    }

    /// What the spheres are made of.
    pub fn material(&self) -> &Material {
        &self.material
    }

    /// What the walls are made of.
    pub fn wall_material(&self) -> &WallMaterial {
        &self.wall_material
    }

    /// The options in force.
    pub fn options(&self) -> &DemOptions {
        &self.options
    }

    /// Force of the contacts on each sphere (N), from the last
    /// [`Dem::compute_contacts`].
    pub fn forces(&self) -> &[Vec3] {
        &self.forces.force
    }

    /// Torque of the contacts on each sphere (N m), likewise.
    pub fn torques(&self) -> &[Vec3] {
        &self.forces.torque
    }

    /// Force of the contacts on each wall (N), likewise.
    pub fn wall_force(&self) -> [Vec3; 6] {
        self.wall_sums.map(|sum| sum.force)
    }

    /// Tells a wall what moves it from now on.
    ///
    /// # Errors
    /// [`DemError::Parameter`] for a velocity or stress that is not finite or
    /// a largest speed that is not positive.
    pub fn set_control(&mut self, wall: WallId, control: WallControl) -> Result<(), DemError> {
        control.check()?;
        self.walls[wall.index()].set_control(control);
        Ok(())
    }

    /// Tells how much the force of the fluid on each wall changes with the
    /// wall's velocity, against it (N·s/m); 0 for a dry wall. A servo counts on
    /// it in the next steps; it is no part of the state.
    pub fn set_wall_resistance(&mut self, resistance: [f64; 6]) {
        self.wall_resistance = resistance;
    }

    /// Changes the friction angle between spheres (rad).
    ///
    /// # Errors
    /// [`DemError::Parameter`] for an angle that is not from 0 to less than π/2.
    pub fn set_friction(&mut self, angle: f64) -> Result<(), DemError> {
        check_friction(angle)?;
        self.material.friction_angle = angle;
        self.law = self.material.law(&self.wall_material);
        // Without friction the pass does not look at the history.
        if self.law.friction == 0.0 {
            self.list.shear.fill(Vec3::zeros());
        }
        if self.law.wall_friction == 0.0 {
            self.list.wall_shear.fill(Vec3::zeros());
        }
        Ok(())
    }

    /// Changes the local damping λ.
    ///
    /// # Errors
    /// [`DemError::Parameter`] for a value that is not from 0 to less than 1.
    pub fn set_damping(&mut self, damping: f64) -> Result<(), DemError> {
        let options = DemOptions { damping, ..self.options };
        options.check()?;
        self.options = options;
        Ok(())
    }

    /// Multiplies all radii by `factor` and all masses by its cube.
    ///
    /// # Errors
    /// [`DemError::Parameter`] for a factor that is not positive.
    pub fn scale_radii(&mut self, factor: f64) -> Result<(), DemError> {
        positive("radius factor", factor)?;
        let mass_factor = factor.powi(3);
        let p = &mut self.particles;
        for ((r, m), c) in p.radius.iter_mut().zip(&mut p.mass).zip(&mut self.centre) {
            *r *= factor;
            *m *= mass_factor;
            c[3] = *r;
        }
        self.list.resized();
        Ok(())
    }
}

impl DemOptions {
    fn check(&self) -> Result<(), DemError> {
        if !(0.0..1.0).contains(&self.damping) {
            return Err(DemError::Parameter {
                name: "damping",
                value: self.damping,
                expected: "from 0 to less than 1",
            });
        }
        if let Some(bad) = self.gravity.iter().flat_map(|g| g.iter()).find(|c| !c.is_finite()) {
            return Err(DemError::Parameter { name: "gravity", value: *bad, expected: "finite" });
        }
        positive("skin", self.skin)
    }
}
