//! Steps of dry spheres between walls that stand still.

use std::path::PathBuf;
use std::time::Instant;

use dempfv::dem::{self, Dem, DemOptions, Particles, WallMaterial};
use dempfv::scene::load_packing;
use serde::{Deserialize, Serialize};

use crate::Error;

/// What the spheres are made of, as in the paper's specimen, and the step: half of what is
/// stable.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Material {
    /// Pa, 1, rad, kg/m³.
    pub young: f64,
    pub stiffness_ratio: f64,
    pub friction_angle: f64,
    pub density: f64,
    pub damping: f64,
    /// s.
    pub dt: f64,
}

impl Default for Material {
    fn default() -> Material {
        Material {
            young: 1e6,
            stiffness_ratio: 0.5,
            friction_angle: 30_f64.to_radians(),
            density: 2600.0,
            damping: 0.2,
            dt: 2e-5,
        }
    }
}

/// Which steps are timed; the script for YADE reads the same keys.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Dry {
    pub packing: PathBuf,
    #[serde(rename = "box")]
    pub bounds: [[f64; 3]; 2],
    #[serde(flatten)]
    pub material: Material,
    /// Steps before the clock starts: lists of neighbours are made in them.
    pub before: u64,
    /// Steps that are timed.
    pub steps: u64,
    /// Number of the run.
    pub run: usize,
}

/// How long a step took.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Stepped {
    /// s.
    pub step_s: f64,
    /// Between spheres, at the end.
    pub contacts: f64,
}

impl Dry {
    /// Does the steps in ours.
    ///
    /// # Errors
    /// What is wrong in the packing.
    pub fn measure(&self) -> Result<Stepped, Error> {
        let (packing, bounds) = load_packing(&self.packing, None).map_err(dempfv::Error::from)?;
        let Material { young, stiffness_ratio, friction_angle, density, damping, dt } =
            self.material;
        let particles = Particles::new(packing.position, packing.radius, density);
        let material = dem::Material { young, stiffness_ratio, friction_angle, density };
        let walls = WallMaterial { young, friction_angle: 0.0 };
        let options = DemOptions { damping, ..DemOptions::default() };
        let wrong = dempfv::Error::from;
        let mut dem = Dem::new(particles, bounds, material, walls, options).map_err(wrong)?;
        for _ in 0..self.before {
            dem.step(dt).map_err(wrong)?;
        }
        let start = Instant::now();
        for _ in 0..self.steps {
            dem.step(dt).map_err(wrong)?;
        }
        let step_s = start.elapsed().as_secs_f64() / self.steps as f64;
        Ok(Stepped { step_s, contacts: dem.sphere_contact_count() as f64 })
    }
}
