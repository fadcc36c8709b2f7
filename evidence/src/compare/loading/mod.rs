//! One wall of a packing is loaded by the servo, in both programs.

mod course;
mod packing;

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

pub use self::course::{Apart, Course, Gap};
pub use self::packing::{Packing, settled};
use super::peer::Bench;
use crate::Error;

/// Sets up the box and the engines of a [`Job`]; what is done with them comes after it.
pub const LOADED: &str = include_str!("../scripts/loaded.py");
const LOADING: &str = include_str!("../scripts/loading.py");

/// Friction angle between spheres (degrees); walls are smooth.
const FRICTION: f64 = 30.0;

/// What the spheres are made of: the material of the YADE oedometer.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Material {
    /// Contact modulus (Pa), of the walls as well.
    pub young: f64,
    /// k_s / k_n.
    pub stiffness_ratio: f64,
    /// Friction angle (rad).
    pub friction_angle: f64,
    /// Density (kg/m³).
    pub density: f64,
    /// Local damping.
    pub damping: f64,
}

impl Default for Material {
    fn default() -> Material {
        Material {
            young: 1e6,
            stiffness_ratio: 0.5,
            friction_angle: FRICTION * PI / 180.0,
            density: 2600.0,
            damping: 0.2,
        }
    }
}

/// A fluid that drains at the loaded wall.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Wet {
    /// Viscosity (Pa·s).
    pub viscosity: f64,
    /// Steps from one remesh to the next.
    pub remesh_interval: u64,
    /// Whether conductances are clamped in YADE's way.
    pub clamp: bool,
}

/// The servo wall y_max goes to a stress while the others stand still.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Loading {
    /// What the spheres are made of.
    #[serde(flatten)]
    pub material: Material,
    /// Time step (s).
    pub dt: f64,
    /// Stress that the servo goes to (Pa).
    pub stress: f64,
    /// Cut of the servo's speed (m/s).
    pub max_velocity: f64,
    /// The fluid, if any.
    pub wet: Option<Wet>,
    /// Points whose pore pressure is of interest (m).
    pub probes: Vec<[f64; 3]>,
    /// Steps in all.
    pub steps: u64,
    /// Steps after which one looks; none of them a remesh, after which YADE shows the
    /// pressures of a network that it has not solved yet.
    pub samples: Vec<u64>,
}

/// What is changed in YADE, to see what it does.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Change {
    /// By how much each sphere is shifted along x, every other one backwards (m).
    pub perturbation: f64,
    /// The slip of a contact is that of the two bodies' surfaces where they touch, without
    /// YADE's factor (r₁ + r₂) / (distance of the centres) on the translation.
    pub plain_slip: bool,
    /// The pores in the box's corners push their spheres, which YADE leaves out.
    pub corner_push: bool,
}

impl Change {
    /// What makes YADE follow the equations that ours follows.
    pub const ALIGNED: Change = Change { perturbation: 0.0, plain_slip: true, corner_push: true };
}

/// What a script is told.
#[derive(Serialize)]
pub struct Job<'a> {
    spheres: &'a [[f64; 4]],
    bounds: [f64; 6],
    #[serde(flatten)]
    loading: &'a Loading,
    #[serde(flatten)]
    change: Change,
}

impl<'a> Job<'a> {
    /// A loading of a packing.
    pub fn new(packing: &'a Packing, loading: &'a Loading, change: Change) -> Job<'a> {
        Job { spheres: &packing.spheres, bounds: packing.bounds, loading, change }
    }
}

/// Steps `first`, `first + every`, ... up to `steps`.
pub fn samples(first: u64, every: u64, steps: u64) -> Vec<u64> {
    (first..=steps).step_by(every as usize).collect()
}

impl Loading {
    /// The same loading with a shorter time step, seen at the same times.
    pub fn refined(&self, times: u64) -> Loading {
        let mut refined = self.clone();
        refined.dt /= times as f64;
        refined.steps *= times;
        refined.samples.iter_mut().for_each(|s| *s *= times);
        refined.wet.iter_mut().for_each(|wet| wet.remesh_interval *= times);
        refined
    }

    /// The beginning of the same loading.
    pub fn until(&self, step: u64) -> Loading {
        let mut part = self.clone();
        part.steps = part.steps.min(step);
        part.samples.retain(|s| *s <= step);
        part
    }

    /// YADE's course of the loading.
    ///
    /// # Errors
    /// As [`Bench::yade`].
    pub fn yade(
        &self,
        bench: &Bench,
        step: &str,
        packing: &Packing,
        change: Change,
    ) -> Result<Course, Error> {
        let (job, script) = (Job::new(packing, self, change), format!("{LOADED}\n{LOADING}"));
        Ok(bench.yade::<Course>(&format!("{step}-yade"), &script, 1, &job)?.result)
    }

    /// Our course of the loading.
    ///
    /// # Errors
    /// As [`Bench::ours`].
    pub fn ours(&self, bench: &Bench, step: &str, packing: &Packing) -> Result<Course, Error> {
        let run = bench.ours(step, &self.scene(packing), 1)?;
        Course::of_run(&run, &self.samples, self.probes.len()).ok_or_else(|| Error::Peer {
            step: step.to_owned(),
            what: "dempfv's history has not the columns or rows that were asked for".to_owned(),
            log: None,
        })
    }

    /// The loading as a scene of ours.
    pub fn scene(&self, packing: &Packing) -> String {
        let Material { young, stiffness_ratio, density, damping, .. } = self.material;
        let mut text = format!(
            "[particles]\npacking = {:?}\nyoung = {young:?}\nstiffness_ratio = {stiffness_ratio:?}\n\
             friction_angle = {FRICTION:?}\ndensity = {density:?}\n\
             [walls]\nfriction_angle = 0.0\n[dem]\ndt = {:?}\ndamping = {damping:?}\n",
            packing.path, self.dt
        );
        if let Some(Wet { viscosity, remesh_interval, clamp }) = self.wet {
            let clamp = if clamp { "yade" } else { "unlimited" };
            text += &format!(
                "[fluid]\nviscosity = {viscosity:?}\nremesh_interval = {remesh_interval}\n\
                 slip_walls = true\nclamp = \"{clamp}\"\npressure = {{ y_max = 0.0 }}\n"
            );
        }
        text += &format!(
            "[[stage]]\nkind = \"run\"\nsteps = {}\n\
             walls = {{ y_max = {{ stress = {:?}, max_velocity = {:?} }} }}\n\
             [output]\npictures = false\nhistory_every = {}\n",
            self.steps,
            self.stress,
            self.max_velocity,
            self.history_every()
        );
        if !self.probes.is_empty() {
            text += &format!("probes = {:?}\n", self.probes);
        }
        text
    }

    /// The largest interval of rows that has a row at each sample.
    fn history_every(&self) -> u64 {
        fn common(a: u64, b: u64) -> u64 {
            if b == 0 { a } else { common(b, a % b) }
        }
        self.samples.iter().fold(0, |a, &b| common(a, b)).max(1)
    }
}
