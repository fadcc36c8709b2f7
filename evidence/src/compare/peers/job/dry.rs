//! Steps of dry spheres between walls that stand still.

use std::path::PathBuf;
use std::time::Instant;

use dempfv::dem::law::{GranularEffects, Hertz, Resistance};
use dempfv::dem::{self, Dem, DemError, DemOptions, Particles, WallMaterial};
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

/// What contacts have beside springs and friction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Contacts {
    /// Hertz's and Mindlin's contact in the place of linear springs, with this Poisson's ratio.
    pub poisson_ratio: Option<f64>,
    pub rolling: Option<Turning>,
    pub twisting: Option<Turning>,
}

/// A resistance against turning: see [`Resistance`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Turning {
    pub friction: f64,
    pub stiffness_ratio: f64,
    pub damping_ratio: f64,
}

impl Contacts {
    fn effects(&self) -> GranularEffects {
        let resistance = |turning: Turning| Resistance {
            friction: turning.friction,
            stiffness_ratio: turning.stiffness_ratio,
            damping_ratio: turning.damping_ratio,
        };
        let hertz = |ratio| Hertz { poisson_ratio: ratio, wall_poisson_ratio: ratio };
        GranularEffects {
            hertz: self.poisson_ratio.map(hertz),
            rolling: self.rolling.map(resistance),
            twisting: self.twisting.map(resistance),
            ..GranularEffects::default()
        }
    }

    /// The same with the limits of what resists turning multiplied.
    #[must_use]
    pub fn with_limits(self, factor: f64) -> Contacts {
        let more = |t: Turning| Turning { friction: factor * t.friction, ..t };
        Contacts { rolling: self.rolling.map(more), twisting: self.twisting.map(more), ..self }
    }

    /// Spheres with such contacts between walls without friction.
    ///
    /// # Errors
    /// What is wrong in them.
    pub fn between(
        &self,
        material: &Material,
        particles: Particles,
        bounds: dempfv::Aabb,
    ) -> Result<Dem, DemError> {
        let Material { young, stiffness_ratio, friction_angle, density, damping, .. } = *material;
        let material = dem::Material { young, stiffness_ratio, friction_angle, density };
        let walls = WallMaterial { young, friction_angle: 0.0 };
        let options = DemOptions { damping, ..DemOptions::default() };
        // The linear law is compiled apart from the granular one.
        match *self == Contacts::default() {
            true => Dem::new(particles, bounds, material, walls, options),
            false => {
                let effects = self.effects();
                Dem::with_effects(effects, particles, bounds, &[material], walls, options)
            }
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
    pub contacts: Contacts,
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
        let Material { density, dt, .. } = self.material;
        let particles = Particles::new(packing.position, packing.radius, density);
        let wrong = dempfv::Error::from;
        let mut dem = self.contacts.between(&self.material, particles, bounds).map_err(wrong)?;
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
