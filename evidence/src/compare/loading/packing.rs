//! The packings that are loaded.

use std::path::{Path, PathBuf};

use dempfv::dem::{self, Dem, DemOptions, Particles, WallMaterial};
use dempfv::io::packing;
use dempfv::scene::{Plan, load_packing};
use dempfv::simulation::Simulation;
use dempfv::{Aabb, Vec3};

use super::{Bench, Error, Material};

/// A packing, as both programs get it.
pub struct Packing {
    /// Its file.
    pub path: PathBuf,
    /// x, y, z, r of each sphere (m).
    pub spheres: Vec<[f64; 4]>,
    /// Smallest x, y, z of the box, then the largest (m).
    pub bounds: [f64; 6],
}

impl Packing {
    /// Reads a packing file.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn load(path: &Path) -> Result<Packing, Error> {
        let (packing, Aabb { min, max }) = load_packing(path, None)?;
        let spheres = packing.position.iter().zip(&packing.radius);
        Ok(Packing {
            path: path.to_owned(),
            spheres: spheres.map(|(x, &r)| [x.x, x.y, x.z, r]).collect(),
            bounds: [min.x, min.y, min.z, max.x, max.y, max.z],
        })
    }

    /// Mean stress on the six walls as it is (Pa), and the time step that its contacts are
    /// stable with (s).
    ///
    /// # Errors
    /// When it is no packing for our mechanics.
    pub fn rest(&self, material: Material) -> Result<(f64, f64), Error> {
        let Material { young, stiffness_ratio, friction_angle, density, .. } = material;
        let (position, radius): (Vec<Vec3>, Vec<f64>) =
            self.spheres.iter().map(|&[x, y, z, r]| (Vec3::new(x, y, z), r)).unzip();
        let [a, b, c, d, e, f] = self.bounds;
        let bounds = Aabb { min: Vec3::new(a, b, c), max: Vec3::new(d, e, f) };
        let particles = Particles::new(position, radius, density);
        let spheres = dem::Material { young, stiffness_ratio, friction_angle, density };
        let walls = WallMaterial { young, friction_angle: 0.0 };
        let mut dem = Dem::new(particles, bounds, spheres, walls, DemOptions::default())
            .map_err(dempfv::Error::from)?;
        dem.compute_contacts().map_err(dempfv::Error::from)?;
        Ok((dem.mean_wall_stress(), dem.safe_time_step(0.8)))
    }

    /// Name in steps, figures and tables.
    pub fn name(&self) -> String {
        self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Edge lengths of the box (m).
    pub fn size(&self) -> Vec3 {
        let [a, b, c, d, e, f] = self.bounds;
        Vec3::new(d - a, e - b, f - c)
    }

    /// Points on the vertical through the middle of the box, at these shares of its height.
    pub fn vertical<const N: usize>(&self, heights: [f64; N]) -> Vec<[f64; 3]> {
        let size = self.size();
        let at = |axis: usize, share: f64| self.bounds[axis] + share * size[axis];
        heights.iter().map(|&h| [at(0, 0.5), at(1, h), at(2, 0.5)]).collect()
    }
}

/// A packing of spheres within a third of the mean radius in a cube of 1 m, settled at
/// 10 kPa without friction: a packing file has no room for shear forces, so this one is at
/// rest in any program that loads it.
///
/// # Errors
/// When it does not settle or cannot be written.
pub fn settled(bench: &Bench, count: usize) -> Result<Packing, Error> {
    let scene = format!(
        "[box]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n\
         [particles]\ncloud = {{ count = {count}, spread = 0.3333, porosity = 0.95 }}\n[dem]\n\
         [[stage]]\nkind = \"compact\"\nstress = 1.0e4\nfriction_angle = 0.0\nunbalanced = 1.0e-5\n\
         tolerance = 1.0e-4\n"
    );
    let mut simulation = Simulation::new(Plan::from_toml(&scene, None)?)?;
    let name = format!("settled-{count}");
    bench.step(&name, || {
        while simulation.advance()? {}
        Ok::<(), Error>(())
    })?;
    let dem = simulation.coupled().dem();
    let particles = dem.particles();
    // Ten digits are what a packing file of YADE's has.
    let round = |x: f64| format!("{x:.10}").parse().unwrap_or(x);
    let position: Vec<Vec3> = particles.position.iter().map(|x| x.map(round)).collect();
    let radius: Vec<f64> = particles.radius.iter().copied().map(round).collect();
    let path = bench.folder.join("scenes").join(format!("{name}.txt"));
    let comment = "settled at 10 kPa by growth, without friction; metres";
    packing::write(&path, &position, &radius, Some(&dem.box_()), comment)?;
    Packing::load(&std::path::absolute(&path).map_err(|e| dempfv::Error::io(&path, e))?)
}
