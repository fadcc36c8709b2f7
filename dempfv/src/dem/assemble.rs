//! Spheres, walls and a contact law, put together.

use super::body_force::BodyForces;
use super::cell::PeriodicCell;
use super::cell_pass::CellSum;
use super::compiled::{CompiledLaw, compile};
use super::error::DemError;
use super::external::ExternalLoads;
use super::held::Held;
use super::law::{ContactLaw, Linear, Losses};
use super::ledger::MotionWork;
use super::material::{Material, WallMaterial};
use super::motion::Motions;
use super::neighbours::{Neighbours, check_inside};
use super::particles::Particles;
use super::pass::Forces;
use super::state::{ContactHistory, DemState};
use super::stiffness_pass::StiffnessScratch;
use super::system::{Dem, DemOptions};
use super::walls::{check_box, walls_of};
use crate::parallel::block_count;
use crate::{Aabb, PerWall, Vec3};

impl Dem {
    /// Spheres at the positions given, between fixed walls around `box_`, with
    /// the [`Linear`] contact law.
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
        Dem::with_law(Linear, particles, box_, &[material], wall_material, options)
    }

    /// The same with a contact law of the caller's choice, compiled for it, and
    /// spheres of one material or several: see [`Particles::material`].
    ///
    /// # Errors
    /// As [`Dem::new`]; [`DemError::NoSuchMaterial`],
    /// [`DemError::NumberOfMaterials`].
    pub fn with_law(
        law: impl ContactLaw,
        particles: Particles,
        box_: Aabb,
        materials: &[Material],
        wall_material: WallMaterial,
        options: DemOptions,
    ) -> Result<Dem, DemError> {
        Dem::at_rest(law, particles, (box_, None), materials, wall_material, options)
    }

    /// Spheres that have no contacts yet.
    pub(super) fn at_rest(
        law: impl ContactLaw,
        particles: Particles,
        (box_, cell): (Aabb, Option<PeriodicCell>),
        materials: &[Material],
        wall_material: WallMaterial,
        options: DemOptions,
    ) -> Result<Dem, DemError> {
        let state = Dem::state_at_rest(law.name(), particles, (box_, cell))?;
        Dem::with_law_from_state(law, state, materials, wall_material, options)
    }

    /// As [`Dem::new`], for spheres that stand still: they are listed with their neighbours when
    /// their contacts are looked at for the first time, and no sooner. That two of them have one
    /// place is found then.
    ///
    /// # Errors
    /// As [`Dem::new`], but for [`DemError::Coincident`].
    pub fn standing(
        particles: Particles,
        box_: Aabb,
        materials: &[Material],
        wall_material: WallMaterial,
        options: DemOptions,
    ) -> Result<Dem, DemError> {
        let state = Dem::state_at_rest(Linear.name(), particles, (box_, None))?;
        check_materials(materials, &wall_material)?;
        let law = compile(Linear, materials, &wall_material);
        let dem = Dem::unlisted(law, state, materials.to_vec(), wall_material, options)?;
        check_inside(&dem.particles, &dem.walls)?;
        Ok(dem)
    }

    fn state_at_rest(
        law: &str,
        particles: Particles,
        (box_, cell): (Aabb, Option<PeriodicCell>),
    ) -> Result<DemState, DemError> {
        check_box(&box_)?;
        particles.check()?;
        let mut state = DemState {
            law: law.to_owned(),
            particles,
            walls: walls_of(&box_),
            cell,
            sphere_history: ContactHistory::default(),
            wall_history: ContactHistory::default(),
            pending_dt: 0.0,
            bonds: 0,
            clumps: vec![],
            motions: Motions::default(),
            ledger: None,
        };
        // Nothing to reverse: there are no contacts yet.
        state.sort_spatially(0, |_| ());
        Ok(state)
    }

    /// Goes on from a state that [`Dem::state`] gave, with the same bits as
    /// if it had not stopped.
    ///
    /// # Errors
    /// As [`Dem::new`]; [`DemError::Law`] for the state of another law than
    /// [`Linear`].
    pub fn from_state(
        state: DemState,
        material: Material,
        wall_material: WallMaterial,
        options: DemOptions,
    ) -> Result<Dem, DemError> {
        Dem::with_law_from_state(Linear, state, &[material], wall_material, options)
    }

    /// The same with the contact law and the number of materials that the
    /// state was made with.
    ///
    /// # Errors
    /// As [`Dem::from_state`] and [`Dem::with_law`].
    pub fn with_law_from_state(
        law: impl ContactLaw,
        state: DemState,
        materials: &[Material],
        wall_material: WallMaterial,
        options: DemOptions,
    ) -> Result<Dem, DemError> {
        if state.law != law.name() {
            return Err(DemError::Law { found: state.law, expected: law.name() });
        }
        check_materials(materials, &wall_material)?;
        let law = compile(law, materials, &wall_material);
        Dem::assemble(law, state, materials.to_vec(), wall_material, options)
    }

    pub(super) fn assemble(
        law: Box<dyn CompiledLaw>,
        state: DemState,
        materials: Vec<Material>,
        wall_material: WallMaterial,
        options: DemOptions,
    ) -> Result<Dem, DemError> {
        let mut dem = Dem::unlisted(law, state, materials, wall_material, options)?;
        dem.rebuild()?;
        Ok(dem)
    }

    /// All but the neighbour list.
    fn unlisted(
        law: Box<dyn CompiledLaw>,
        state: DemState,
        materials: Vec<Material>,
        wall_material: WallMaterial,
        options: DemOptions,
    ) -> Result<Dem, DemError> {
        options.check()?;
        state.check()?;
        state.particles.check_materials(materials.len())?;
        if state.cell.is_some() && options.gravity.is_some_and(|g| g != Vec3::zeros()) {
            let remedy = "nothing holds the spheres up; leave it out";
            return Err(DemError::InCell { what: "gravity", remedy });
        }
        let mut list = Neighbours::new(law.history_length());
        list.load(&state)?;
        let DemState { particles, walls, cell, pending_dt, bonds, clumps, motions, ledger, .. } =
            state;
        let centre = particles
            .position
            .iter()
            .zip(&particles.radius)
            .map(|(x, &r)| [x.x, x.y, x.z, r])
            .collect();
        let mut place = vec![0; particles.len()];
        for (k, &number) in (0u32..).zip(&particles.id) {
            place[number as usize] = k;
        }
        let mut dem = Dem {
            law,
            held: Held::new(motions, clumps, &place),
            place,
            forces: Forces::default(),
            wall_sums: PerWall::default(),
            cell_sum: CellSum::default(),
            wall_resistance: PerWall::default(),
            smallest_radius: 0.0,
            softest: materials[0],
            external: ExternalLoads::default(),
            body_forces: BodyForces::default(),
            ledger,
            tracks_turning: true,
            motion_work: vec![],
            stiffness: StiffnessScratch::default(),
            order: 0,
            particles,
            walls,
            cell,
            room_to_stray: 0.0,
            options,
            materials,
            pairs: vec![],
            wall_material,
            pending_dt,
            bonds,
            list,
            centre,
        };
        dem.forces.force.resize(dem.particles.len(), Vec3::zeros());
        dem.forces.torque.resize(dem.particles.len(), Vec3::zeros());
        if ledger.is_some() {
            dem.forces.losses = vec![Losses::default(); block_count(dem.particles.len())];
            dem.motion_work = vec![MotionWork::default(); dem.particles.len()];
        }
        dem.keep_in_cell(0.0);
        Ok(dem)
    }
}

/// Refuses no material, too many, and what none can be.
fn check_materials(materials: &[Material], walls: &WallMaterial) -> Result<(), DemError> {
    if materials.is_empty() || materials.len() > usize::from(u16::MAX) {
        return Err(DemError::NumberOfMaterials { found: materials.len() });
    }
    materials.iter().try_for_each(Material::check)?;
    walls.check()
}
