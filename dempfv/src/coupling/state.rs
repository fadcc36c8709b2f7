//! A coupled system as one value that can be stored.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::coupled::Coupled;
use super::error::{CouplingError, Result};
use super::fluid_effects::FluidEffects;
use super::fluid_state::FluidState;
use super::network_builder::{NetworkBuilder, StandardBuilder};
use super::options::Acceleration;
use super::saturation::Saturation;
use super::time_step::AutoTimeStep;
use crate::Vec3;
use crate::dem::law::{ContactLaw, Linear};
use crate::dem::{ContactForces, Dem, DemOptions, DemState, Material, MaterialPair, WallMaterial};

/// What a [`CoupledState`] says it is.
const KIND: &str = "dempfv coupled state";
/// To be raised when a state would no longer mean the same.
const VERSION: u32 = 8;

/// What spheres and fluid are, and how they are computed: all that a caller
/// chooses, and may choose anew where a state is taken up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// What the spheres are made of.
    pub materials: Vec<Material>,
    /// What pairs of materials have against each other.
    pub pairs: Vec<MaterialPair>,
    /// What the walls are made of.
    pub wall_material: WallMaterial,
    /// What is simulated beside contacts.
    pub options: DemOptions,
    /// The fluid; `None` where the pores are empty.
    pub saturation: Option<Saturation>,
    /// What the fluid does beside flowing.
    pub effects: FluidEffects,
    /// How networks are renewed.
    pub acceleration: Acceleration,
    /// What a solve may leave (1); `None` for the flow's own.
    pub tolerance: Option<f64>,
    /// Points whose pore pressure is watched (m).
    pub probes: Vec<Vec3>,
}

/// Everything that spheres and fluid need to go on with the same bits. It can
/// be written with any serde format that keeps the bits of numbers, such as
/// that of [`checkpoint`](crate::io::checkpoint).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CoupledState {
    kind: String,
    version: u32,
    /// May be changed before the state is taken up.
    pub parameters: Parameters,
    dem: DemState,
    contact_forces: ContactForces,
    progress: Progress,
}

/// What a coupled system has come to, beside its mechanics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Progress {
    fluid: Option<FluidState>,
    time_step: AutoTimeStep,
    steps: u64,
    last_time_step: f64,
    time: f64,
    largest_residual: f64,
    largest_imbalance: f64,
}

impl CoupledState {
    /// Number of spheres.
    pub fn spheres(&self) -> usize {
        self.dem.particles.len()
    }

    /// Steps done when the state was taken.
    pub fn steps(&self) -> u64 {
        self.progress.steps
    }

    /// Gives the materials other densities (kg/m³): masses follow, velocities stay.
    pub(crate) fn set_densities(&mut self, densities: &[f64]) {
        let factors: Vec<f64> = self
            .parameters
            .materials
            .iter_mut()
            .zip(densities)
            .map(|(material, &density)| density / std::mem::replace(&mut material.density, density))
            .collect();
        // Lists of different lengths are refused where the state is taken up.
        let particles = &mut self.dem.particles;
        let mut by_number = vec![1.0; particles.mass.len()];
        for (i, &number) in particles.id.iter().enumerate() {
            let material = particles.material.get(i).copied().unwrap_or(0);
            if let Some(factor) = by_number.get_mut(number as usize) {
                *factor = factors.get(usize::from(material)).copied().unwrap_or(1.0);
            }
        }
        for (i, mass) in particles.mass.iter_mut().enumerate() {
            let material = particles.material.get(i).copied().unwrap_or(0);
            *mass *= factors.get(usize::from(material)).copied().unwrap_or(1.0);
        }
        self.dem.scale_clumps(|number| by_number.get(number).copied().unwrap_or(1.0));
    }

    /// Forgets the network: the next step builds one of the positions of the moment.
    pub(crate) fn forget_network(&mut self) {
        self.progress.fluid = None;
    }
}

impl Coupled {
    /// What must be stored to go on with the same bits.
    ///
    /// ```
    /// use dempfv::coupling::{Coupled, CoupledState};
    /// use dempfv::dem::{Dem, DemOptions, Material, Particles, WallMaterial};
    /// use dempfv::io::checkpoint;
    /// use dempfv::{Aabb, Vec3};
    ///
    /// let material =
    ///     Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };
    /// let sphere = Particles::new(vec![Vec3::repeat(0.39)], vec![0.4], material.density);
    /// let bounds = Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) };
    /// let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
    /// let dem = Dem::new(sphere, bounds, material, walls, DemOptions::default())?;
    /// let mut coupled = Coupled::new(dem);
    /// coupled.step(1e-4)?;
    ///
    /// let path = std::env::temp_dir().join("dempfv-doc-state.checkpoint");
    /// checkpoint::save(&path, &coupled.state())?;
    /// let state: CoupledState = checkpoint::load(&path)?;
    /// let again = Coupled::from_state(state)?;
    /// assert_eq!(again.observe(), coupled.observe());
    /// # std::fs::remove_file(&path).unwrap();
    /// # Ok::<(), dempfv::Error>(())
    /// ```
    pub fn state(&self) -> CoupledState {
        CoupledState {
            kind: KIND.to_owned(),
            version: VERSION,
            parameters: Parameters {
                materials: self.dem.materials().to_vec(),
                pairs: self.dem.material_pairs().to_vec(),
                wall_material: *self.dem.wall_material(),
                options: *self.dem.options(),
                saturation: self.saturation,
                effects: self.effects.clone(),
                acceleration: *self.acceleration(),
                tolerance: self.remesher.tolerance(),
                probes: self.probes.clone(),
            },
            dem: self.dem.state(),
            contact_forces: self.dem.contact_forces(),
            progress: Progress {
                fluid: self.remesher.state(),
                time_step: self.auto_time_step,
                steps: self.steps,
                last_time_step: self.last_time_step,
                time: self.time,
                largest_residual: self.largest_residual,
                largest_imbalance: self.largest_imbalance,
            },
        }
    }

    /// Goes on from a state, with the same bits as if it had not stopped; what
    /// can be observed is what could be when the state was taken. The network in use
    /// is built again, and with [`RemeshMode::Background`](super::RemeshMode)
    /// the one that was on its way.
    ///
    /// # Errors
    /// [`CouplingError::ForeignState`] for a state of another kind or version;
    /// as [`Dem::from_state`]; as a remesh.
    pub fn from_state(state: CoupledState) -> Result<Coupled> {
        Coupled::from_state_with(state, Arc::new(StandardBuilder))
    }

    /// As [`Coupled::from_state`], with networks built by `builder`.
    ///
    /// # Errors
    /// As [`Coupled::from_state`].
    pub fn from_state_with(
        state: CoupledState,
        builder: Arc<dyn NetworkBuilder>,
    ) -> Result<Coupled> {
        Coupled::from_state_with_law(state, Linear, builder)
    }

    /// As [`Coupled::from_state`], for spheres in contact by `law`, with networks built by
    /// `builder`. What parameters the law has beside the materials is the caller's to know.
    ///
    /// # Errors
    /// As [`Coupled::from_state`]; a state of another law is refused.
    pub fn from_state_with_law(
        state: CoupledState,
        law: impl ContactLaw,
        builder: Arc<dyn NetworkBuilder>,
    ) -> Result<Coupled> {
        let (mut coupled, progress) = Coupled::mechanics_of(state, law)?;
        coupled.build_with(builder);
        coupled.take_up(progress)?;
        Ok(coupled)
    }

    /// First half of [`Coupled::from_state`]: the mechanics, which the caller
    /// may still change, with the pores empty.
    pub(crate) fn mechanics_of(
        state: CoupledState,
        law: impl ContactLaw,
    ) -> Result<(Coupled, Progress)> {
        let CoupledState { kind, version, parameters, dem, contact_forces, progress } = state;
        if (kind.as_str(), version) != (KIND, VERSION) {
            let (expected_kind, expected_version) = (KIND, VERSION);
            return Err(CouplingError::ForeignState {
                kind,
                version,
                expected_kind,
                expected_version,
            });
        }
        let Parameters { materials, wall_material, options, .. } = &parameters;
        let mut dem = Dem::with_law_from_state(law, dem, materials, *wall_material, *options)?;
        if !parameters.pairs.is_empty() {
            dem.set_materials(materials, &parameters.pairs)?;
        }
        dem.set_contact_forces(contact_forces)?;
        let mut coupled = Coupled::new(dem);
        coupled.accelerate(parameters.acceleration);
        if let Some(tolerance) = parameters.tolerance {
            coupled.set_tolerance(tolerance)?;
        }
        coupled.watch(parameters.probes);
        coupled.saturation = parameters.saturation;
        coupled.effects = parameters.effects;
        Ok((coupled, progress))
    }

    /// Second half of [`Coupled::from_state`]: the network, and how far it all
    /// has come.
    pub(crate) fn take_up(&mut self, progress: Progress) -> Result<()> {
        let Progress { fluid, time_step, steps, last_time_step, time, .. } = progress;
        let Progress { largest_residual, largest_imbalance, .. } = progress;
        self.steps = steps;
        self.last_time_step = last_time_step;
        self.time = time;
        self.largest_residual = largest_residual;
        self.largest_imbalance = largest_imbalance;
        self.auto_time_step = time_step;
        if let (Some(saturation), Some(fluid)) = (self.saturation, fluid) {
            self.restore_network(&saturation, fluid)?;
        }
        Ok(())
    }
}
