//! The two parts of building a network, each timed.

use std::path::Path;
use std::time::Instant;

use dempfv::coupling::initial_packing;
use dempfv::pfv::{Boundary, Fluid, Network, Operators};
use dempfv::scene::Plan;
use serde::{Deserialize, Serialize};

use super::specimens::Specimen;
use super::timing::{self, Mode};
use crate::commands::Error;
use crate::commands::bench::Bench;

/// Small networks are built again and again for about so long (s), and the fastest counts.
const MEASURE_FOR: f64 = 1.0;

/// How long the parts of a network take (s).
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Built {
    /// Triangulation, pores, throats.
    pub network_s: f64,
    /// The sparse operators: G, E and F.
    pub operators_s: f64,
}

/// Builds the network of a specimen, or returns what an earlier call measured.
///
/// # Errors
/// The packing has no network, or the result cannot be kept.
pub fn measure(bench: &Bench, specimen: &Specimen, threads: usize) -> Result<Built, Error> {
    let packing = specimen.packing(bench)?;
    let name = name(specimen, threads);
    bench.remembered(&name, &specimen.origin(), || {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|e| dempfv::Error::io("threads", std::io::Error::other(e)))?;
        bench.step(&name, || pool.install(|| build(&packing, specimen)))
    })
}

/// What an earlier call measured.
///
/// # Errors
/// None that a user could cause.
pub fn known(bench: &Bench, specimen: &Specimen, threads: usize) -> Result<Option<Built>, Error> {
    bench.known(&name(specimen, threads), &specimen.origin())
}

/// Name of a measurement.
pub fn name(specimen: &Specimen, threads: usize) -> String {
    format!("build-{}-on-{threads}", specimen.spheres)
}

fn build(packing: &Path, specimen: &Specimen) -> Result<Built, Error> {
    let plan = Plan::from_toml(&timing::scene(packing, specimen, Mode::AllCores), None)?;
    let (position, radius, bounds) = initial_packing(&plan)?;
    let pressure = plan.fluid.as_ref().map_or([None; 6], |f| f.pressure);
    let fluid = Fluid {
        viscosity: plan.fluid.as_ref().map_or(1e-3, |f| f.viscosity),
        slip_walls: true,
        clamp: dempfv::pfv::Clamp::None,
        boundary: Boundary { pressure },
    };
    let mut best = Built { network_s: f64::INFINITY, operators_s: f64::INFINITY };
    let begin = Instant::now();
    while best.network_s == f64::INFINITY || begin.elapsed().as_secs_f64() < MEASURE_FOR {
        let start = Instant::now();
        let network =
            Network::new(&position, &radius, bounds, &fluid).map_err(dempfv::Error::from)?;
        let network_s = start.elapsed().as_secs_f64();
        let start = Instant::now();
        Operators::new(&network, fluid.boundary).map_err(dempfv::Error::from)?;
        let operators_s = start.elapsed().as_secs_f64();
        best = Built {
            network_s: best.network_s.min(network_s),
            operators_s: best.operators_s.min(operators_s),
        };
    }
    Ok(best)
}
