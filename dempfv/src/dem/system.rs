//! The whole mechanics: state, neighbour list, forces, and the time step.

use serde::{Deserialize, Serialize};

use super::body_force::BodyForces;
use super::cell::PeriodicCell;
use super::cell_pass::{CellPass, CellSum};
use super::compiled::CompiledLaw;
use super::damping::LocalDamping;
use super::error::{DemError, require_length};
use super::external::ExternalLoads;
use super::held::Held;
use super::integrate::{FluidLoads, Loads, Step, advance};
use super::law::Needs;
use super::ledger::{Ledger, MotionWork};
use super::material::{Material, MaterialPair, WallMaterial, finite, positive};
use super::neighbours::Neighbours;
use super::particles::Particles;
use super::pass::Forces;
use super::pass_input::Input;
use super::servo::WallResistance;
use super::state::DemState;
use super::stiffness_pass::StiffnessScratch;
use super::wall_pairs::WallSum;
use super::walls::{Wall, WallControl, box_of};
use crate::calls;
use crate::{Aabb, PerWall, Vec3, WallId};

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
///
/// Spheres are named by the user's numbers, their places in the list that the
/// `Dem` was made of, except where a name says `storage`.
pub struct Dem {
    pub(super) particles: Particles,
    /// Place of each of the user's numbers in storage.
    pub(super) place: Vec<u32>,
    pub(super) walls: PerWall<Wall>,
    /// The periodic cell; `None` between walls.
    pub(super) cell: Option<PeriodicCell>,
    /// Share of the cell's edges that each sphere is at least away from where it may not stray. It
    /// spares looking at them.
    pub(super) room_to_stray: f64,
    pub(super) options: DemOptions,
    pub(super) law: Box<dyn CompiledLaw>,
    pub(super) materials: Vec<Material>,
    pub(super) pairs: Vec<MaterialPair>,
    pub(super) wall_material: WallMaterial,
    /// See [`DemState::pending_dt`].
    pub(super) pending_dt: f64,
    /// See [`DemState::bonds`].
    pub(super) bonds: u64,
    pub(super) list: Neighbours,
    pub(super) forces: Forces,
    /// Centre and radius of each sphere, as the contact pass reads them.
    pub(super) centre: Vec<[f64; 4]>,
    pub(super) wall_sums: PerWall<WallSum>,
    pub(super) cell_sum: CellSum,
    /// See [`Dem::set_wall_resistance`].
    pub(super) wall_resistance: WallResistance,
    /// Smallest radius (m) and softest material of the spheres, since the list was built.
    pub(super) smallest_radius: f64,
    pub(super) softest: Material,
    pub(super) external: ExternalLoads,
    pub(super) body_forces: BodyForces,
    /// Clumps and prescribed motions.
    pub(super) held: Held,
    /// See [`Dem::track_energy`].
    pub(super) ledger: Option<Ledger>,
    /// See [`Dem::track_turning`].
    pub(super) tracks_turning: bool,
    /// What forces did in the step, per sphere; empty where that is not tracked.
    pub(super) motion_work: Vec<MotionWork>,
    /// Scratch of [`Dem::contact_time_step`].
    pub(super) stiffness: StiffnessScratch,
    /// See [`Dem::storage_order`].
    pub(super) order: u64,
}

impl Dem {
    /// What a checkpoint holds.
    pub fn state(&self) -> DemState {
        DemState {
            law: self.law.name().to_owned(),
            particles: self.particles.clone(),
            walls: self.walls,
            cell: self.cell.clone(),
            sphere_history: self.list.sphere_history(),
            wall_history: self.list.wall_history(),
            pending_dt: self.pending_dt,
            bonds: self.bonds,
            clumps: self.clumps().cloned().collect(),
            motions: self.held.motions.kept(),
            ledger: self.ledger,
        }
    }

    /// Puts the spheres in spatial order again, after they have moved far
    /// from where they were. Changes the order of all arrays in storage, and
    /// no number of the user's. Forces and torques that were added are
    /// forgotten.
    ///
    /// # Errors
    /// As [`Dem::compute_contacts`].
    pub fn sort_spatially(&mut self) -> Result<(), DemError> {
        let mut state = self.state();
        let law = self.law.clone_box();
        state.sort_spatially(law.history_length(), |history| law.reverse(history));
        let materials = std::mem::take(&mut self.materials);
        let pairs = std::mem::take(&mut self.pairs);
        let body_forces = std::mem::take(&mut self.body_forces);
        let sorted = Dem::assemble(law, state, materials, self.wall_material, self.options)?;
        let before = std::mem::replace(self, sorted);
        (self.pairs, self.body_forces) = (pairs, body_forces);
        self.tracks_turning = before.tracks_turning;
        self.order = before.order + 1;
        self.particles.move_into(before.particles);
        self.forces.move_into(before.forces);
        Ok(())
    }

    pub(super) fn rebuild(&mut self) -> Result<(), DemError> {
        self.law.fit_cut_off(self.particles.radius.iter().copied().fold(0.0, f64::max));
        let (cut_off, skin) = (self.law.cut_off(), self.options.skin);
        let cell = self.cell.as_ref().map(PeriodicCell::cell);
        let clumps = self.held.clumps.indices();
        calls::count(&calls::NEIGHBOUR_LISTS);
        self.list.build(&self.particles, (&self.walls, cell), (cut_off, skin), clumps)?;
        self.look_at_sizes();
        let end = self.list.bounds.last().copied().unwrap_or_default();
        self.forces.sent.clear();
        self.forces.sent.resize(end.sent, [0.0; 6]);
        self.forces.wall_sums.resize(self.list.bounds.len() - 1, PerWall::default());
        let in_cell = if self.cell.is_some() { self.forces.wall_sums.len() } else { 0 };
        self.forces.cell_sums.resize(in_cell, CellSum::default());
        Ok(())
    }

    /// Computes the contact forces at the current positions, after building
    /// the neighbour list anew if something may have used up its skin. The
    /// histories follow the motion of the last step, once.
    ///
    /// # Errors
    /// [`DemError::LeftBox`] or [`DemError::Coincident`], found when the list
    /// is built.
    pub fn compute_contacts(&mut self) -> Result<(), DemError> {
        let outdated = match self.cell {
            _ if !self.list.is_built() => true,
            None => self.list.outdated(&self.centre, &self.walls),
            Some(_) => self.list.outdated_in_cell(&self.centre),
        };
        if outdated {
            self.rebuild().map_err(|error| self.explained(error))?;
        }
        let cell = self.cell.as_ref().map(CellPass::new);
        let input = Input {
            centre: &self.centre,
            velocity: &self.particles.velocity,
            spin: &self.particles.spin,
            material: &self.particles.material,
            walls: &self.walls,
            cell: cell.as_ref(),
            dt: self.pending_dt,
            rotation: self.options.rotation,
            tracks_energy: self.ledger.is_some(),
            tracks_turning: self.ledger.is_some() && self.tracks_turning,
        };
        self.law.contact_forces(&mut self.list, &mut self.forces, input);
        self.pending_dt = 0.0;
        self.book_losses();
        self.wall_sums = PerWall::default();
        for block in &self.forces.wall_sums {
            for ((_, total), part) in self.wall_sums.iter_mut().zip(block.values()) {
                total.force += part.force;
                total.stiffness += part.stiffness;
                total.dashpot += part.dashpot;
            }
        }
        self.cell_sum = CellSum::default();
        self.forces.cell_sums.iter().for_each(|block| self.cell_sum.add(block));
        Ok(())
    }

    /// Moves walls and spheres by one time step `dt` (s) under the contact
    /// forces of the last [`Dem::compute_contacts`], gravity, body forces, what
    /// [`Dem::add_force`] and [`Dem::add_torque`] have added since the last
    /// step, and, where given, the fluid's force on each sphere, in storage
    /// order, and each wall (N).
    ///
    /// # Errors
    /// [`DemError::NotFinite`] names a particle whose force or motion is not
    /// finite; the state is then spoilt. [`DemError::BodyForce`], before anything
    /// moves: what was added for the step is forgotten. [`DemError::WallsMet`],
    /// [`DemError::Parameter`] for a time step that is not positive or a fluid
    /// force on a wall that is not finite, [`DemError::Length`] for a fluid
    /// force of another length.
    pub fn integrate(
        &mut self,
        dt: f64,
        fluid_force: Option<&[Vec3]>,
        fluid_wall_force: Option<&PerWall<Vec3>>,
    ) -> Result<(), DemError> {
        let torque = None;
        self.integrate_under(
            dt,
            FluidLoads { force: fluid_force, torque, on_walls: fluid_wall_force },
        )
    }

    /// [`Dem::integrate`] with a fluid that turns the spheres, too.
    pub(crate) fn integrate_under(&mut self, dt: f64, fluid: FluidLoads) -> Result<(), DemError> {
        positive("time step", dt)?;
        for (name, load) in [("fluid force", fluid.force), ("fluid torque", fluid.torque)] {
            if let Some(load) = load {
                require_length(name, load.len(), self.particles.len())?;
            }
        }
        let on_walls = fluid.on_walls.iter().flat_map(|f| f.values()).flat_map(Vec3::iter);
        on_walls.copied().try_for_each(|f| finite("fluid wall force", f))?;
        let wall_velocity = self.walls.map(|wall| wall.velocity);
        self.act_body_forces()?;
        self.move_cell(dt, fluid.on_walls)?;
        let turned =
            self.law.needs() == Needs::Torques || self.external.turns() || fluid.torque.is_some();
        let step = Step {
            dt,
            last_dt: self.last_dt(dt),
            damping: LocalDamping::new(self.options.damping)?,
            gravity: self.options.gravity.unwrap_or_default(),
            rotation: self.options.rotation && turned,
        };
        let loads = Loads {
            force: &self.forces.force,
            torque: &self.forces.torque,
            fluid: fluid.force,
            fluid_torque: fluid.torque,
            external: self.external.get(),
            held: self.held.mask(),
        };
        let (particles, centre, work) =
            (&mut self.particles, &mut self.centre, &mut self.motion_work);
        let mut farthest = advance(particles, centre, loads, step, work)?;
        if !loads.held.is_empty() {
            farthest = farthest.max(self.move_held(step, fluid)?);
        }
        self.book_work(dt, &wall_velocity);
        self.count_time(dt);
        self.external.clear();
        self.list.moved(farthest);
        self.keep_in_cell(farthest);
        self.pending_dt = dt;
        Ok(())
    }

    /// One dry step: [`Dem::compute_contacts`], then [`Dem::integrate`].
    ///
    /// # Errors
    /// As these two.
    pub fn step(&mut self, dt: f64) -> Result<(), DemError> {
        self.compute_contacts()?;
        self.integrate(dt, None, None)
    }

    /// The spheres in storage order, an order in space of the `Dem`'s own:
    /// [`Particles::id`] tells the user's number of each. For loops over all
    /// spheres that shall not copy them. Its arrays, and those of [`Dem::storage_forces`] and
    /// [`Dem::storage_torques`], stay where they are in memory as long as there is the `Dem`.
    pub fn storage(&self) -> &Particles {
        &self.particles
    }

    /// How often the storage order has changed ([`Dem::sort_spatially`]).
    pub fn storage_order(&self) -> u64 {
        self.order
    }

    /// Velocities (m/s) and spins (rad/s) in storage order, to be changed.
    pub fn storage_velocities_mut(&mut self) -> (&mut [Vec3], &mut [Vec3]) {
        (&mut self.particles.velocity, &mut self.particles.spin)
    }

    /// Force of the contacts on each sphere (N) in storage order, from the
    /// last [`Dem::compute_contacts`].
    pub fn storage_forces(&self) -> &[Vec3] {
        &self.forces.force
    }

    /// Torque of the contacts on each sphere (N m) in storage order, likewise.
    pub fn storage_torques(&self) -> &[Vec3] {
        &self.forces.torque
    }

    /// The walls.
    pub fn walls(&self) -> &PerWall<Wall> {
        &self.walls
    }

    /// The box between the walls.
    pub fn box_(&self) -> Aabb {
        box_of(&self.walls)
    }

    /// What the spheres are made of; the first of their materials.
    pub fn material(&self) -> &Material {
        &self.materials[0]
    }

    /// The materials of the spheres; [`Particles::material`] tells which is
    /// whose.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// What pairs of materials have against each other: see [`Dem::set_materials`].
    pub fn material_pairs(&self) -> &[MaterialPair] {
        &self.pairs
    }

    /// What the walls are made of.
    pub fn wall_material(&self) -> &WallMaterial {
        &self.wall_material
    }

    /// The options in force.
    pub fn options(&self) -> &DemOptions {
        &self.options
    }

    /// Name of the contact law.
    pub fn law(&self) -> &'static str {
        self.law.name()
    }

    /// Force of the contacts on each wall (N), from the last
    /// [`Dem::compute_contacts`].
    pub fn wall_force(&self) -> PerWall<Vec3> {
        self.wall_sums.map(|sum| sum.force)
    }

    /// Tells a wall what moves it from now on.
    ///
    /// # Errors
    /// [`DemError::Parameter`] for a velocity or stress that is not finite or
    /// a largest speed that is not positive.
    pub fn set_control(&mut self, wall: WallId, control: WallControl) -> Result<(), DemError> {
        control.check()?;
        if self.cell.is_some() && control != WallControl::Fixed {
            let remedy = "there are no walls; move the cell";
            return Err(DemError::InCell { what: "a moving wall", remedy });
        }
        self.walls[wall].set_control(control);
        Ok(())
    }

    /// Tells what the fluid takes off the outward force on each wall per outward velocity of
    /// each other (N·s/m): `resistance[a][b]` is that on wall `a` when `b` moves; 0 between dry
    /// walls. Servo walls count on it in the next steps, jointly; it is no part of the state.
    ///
    /// # Errors
    /// [`DemError::Parameter`] for a resistance that is not finite.
    pub fn set_wall_resistance(&mut self, resistance: WallResistance) -> Result<(), DemError> {
        let each = resistance.values().flat_map(PerWall::values).copied();
        each.into_iter().try_for_each(|r| finite("wall resistance", r))?;
        self.wall_resistance = resistance;
        Ok(())
    }
}

impl DemOptions {
    pub(super) fn check(&self) -> Result<(), DemError> {
        LocalDamping::new(self.damping)?;
        let gravity = self.gravity.iter().flat_map(|g| g.iter()).copied();
        gravity.into_iter().try_for_each(|g| finite("gravity", g))?;
        positive("skin", self.skin)
    }
}

impl std::fmt::Debug for Dem {
    /// Without the arrays.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Dem")
            .field("spheres", &self.particles.len())
            .field("box_", &self.box_())
            .field("law", &self.law)
            .field("materials", &self.materials)
            .field("wall_material", &self.wall_material)
            .field("options", &self.options)
            .finish_non_exhaustive()
    }
}
