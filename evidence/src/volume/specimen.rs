//! One specimen: packed, loaded in cycles, and flowed through.

use std::time::Instant;

use dempfv::InputError;
use dempfv::scene::Plan;
use dempfv::simulation::{Outcome, PermeabilityTest, Simulation};
use serde::{Deserialize, Serialize};

use crate::Result;

/// Steps of a specimen of [`FEWEST`] spheres, and the power of the number of spheres with which they grow:
/// about, for the time left.
const STEPS: f64 = 3_400.0;
const GROWTH: f64 = 0.25;
/// Smallest number of spheres that is a specimen: below it walls touch most of them.
pub const FEWEST: u32 = 100;

/// What was measured on a specimen.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Specimen {
    pub spheres: u32,
    pub seed: u64,
    pub porosity: f64,
    pub sauter_diameter_m: f64,
    /// Permeability by axis, x to z (m²).
    pub permeability_m2: [f64; 3],
    /// The same of the part that is a Sauter diameter away from all walls, where it has one.
    pub core_permeability_m2: [Option<f64>; 3],
    /// Secant modulus of the second loading (Pa).
    pub modulus_pa: f64,
    pub steps: u64,
    pub seconds: f64,
}

/// The oedometer of `scenes/oedometer.toml` up to its load, with a permeability along each axis.
pub fn scene(spheres: u32, seed: u64) -> String {
    let flows = ["x", "y", "z"].map(|axis| {
        format!("[[stage]]\nkind = \"permeability\"\nname = \"flow {axis}\"\naxis = \"{axis}\"\n")
    });
    format!(
        "title = \"Oedometer: {spheres} spheres in a box of 1 m\"\nseed = {seed}\n\
         [box]\nmin = [0.0, 0.0, 0.0]\nmax = [1.0, 1.0, 1.0]\n\
         [particles]\ncloud = {{ count = {spheres}, spread = 0.3333, porosity = 0.95 }}\n\
         density = 2600.0\nyoung = 1.0e6\nstiffness_ratio = 0.5\nfriction_angle = 30.0\n\
         [walls]\nfriction_angle = 0.0\n[dem]\ndt = 1.0e-4\ndamping = 0.2\n\
         [fluid]\nviscosity = 10.0\nremesh_interval = 500\npressure = {{ y_max = 0.0 }}\n\
         [[stage]]\nkind = \"compact\"\nstress = 1.0e4\nfriction_angle = 3.0\ndt = \"auto\"\n\
         [[stage]]\nkind = \"cycle\"\nwall = \"y_max\"\nfrom = 1.0e4\nto = 1.1e4\ncycles = 2\n\
         max_velocity = 0.05\nunbalanced = 1.0e-4\ndt = \"auto\"\n\
         {}[output]\npictures = false\nenergy = false\n",
        flows.concat()
    )
}

/// Steps that a specimen is expected to take.
pub fn expected_steps(spheres: u32) -> f64 {
    STEPS * (f64::from(spheres) / f64::from(FEWEST)).powf(GROWTH)
}

impl Specimen {
    /// Packs, loads and flows through a specimen; `stepped` hears of each step.
    pub fn measure(spheres: u32, seed: u64, mut stepped: impl FnMut(u64)) -> Result<Specimen> {
        let clock = Instant::now();
        let mut simulation = Simulation::new(Plan::from_toml(&scene(spheres, seed), None)?)?;
        while simulation.advance()? {
            stepped(simulation.step());
        }
        let outcomes = || simulation.outcomes().iter().map(|stage| &stage.outcome);
        let modulus = outcomes().find_map(|outcome| match outcome {
            Outcome::Cycle(cycles) => Some(cycles.modulus_pa),
            _ => None,
        });
        let flows: Vec<&PermeabilityTest> = outcomes()
            .filter_map(|outcome| match outcome {
                Outcome::Permeability(test) => Some(test),
                _ => None,
            })
            .collect();
        let (Some(modulus_pa), [x, y, z]) = (modulus, &flows[..]) else {
            let what = format!("{spheres} spheres, seed {seed}: the run left no modulus");
            return Err(InputError::new(what, "give another number of spheres").into());
        };
        Ok(Specimen {
            spheres,
            seed,
            porosity: y.porosity,
            sauter_diameter_m: y.sauter_diameter_m,
            permeability_m2: [x, y, z].map(|test| test.permeability_m2),
            core_permeability_m2: [x, y, z].map(|test| test.core_permeability_m2),
            modulus_pa,
            steps: simulation.step(),
            seconds: clock.elapsed().as_secs_f64(),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// The same box, spheres, walls, time step and stages as the shipped scene has.
    #[test]
    fn the_scene_is_the_shipped_oedometer() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/oedometer.toml");
        let shipped = Plan::load(&path).unwrap();
        let ours = Plan::from_toml(&scene(1000, 1), None).unwrap();
        assert_eq!((ours.bounds, &ours.particles), (shipped.bounds, &shipped.particles));
        assert_eq!((ours.walls, ours.dem, ours.seed), (shipped.walls, shipped.dem, shipped.seed));
        assert_eq!(ours.fluid, shipped.fluid);
        assert_eq!(ours.stages[..2], shipped.stages[..2]);
        assert_eq!(ours.stages[3].kind, shipped.stages[2].kind);
    }
}
