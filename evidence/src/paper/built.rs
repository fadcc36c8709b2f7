//! The two parts of building a network, each timed.

use std::path::Path;
use std::time::Instant;

use dempfv::pfv::{Derivatives, Fluid, Network, Operators};
use dempfv::scene::Plan;
use dempfv::simulation::initial_packing;
use dempfv::{Aabb, InputError, Vec3};
use serde::{Deserialize, Serialize};

use super::specimens::Specimen;
use super::timing::{self, Mode};
use crate::Error;
use crate::bench::Bench;

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
        bench.step(&name, || {
            let input = Input::of(specimen, &packing)?;
            pool.install(|| build(&input))
        })
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

/// A packing and the fluid in its pores, as the network takes them.
pub struct Input {
    position: Vec<Vec3>,
    radius: Vec<f64>,
    bounds: Aabb,
    fluid: Fluid,
}

impl Input {
    /// That of a specimen's runs.
    ///
    /// # Errors
    /// When the packing is wrong.
    pub fn of(specimen: &Specimen, packing: &Path) -> Result<Input, Error> {
        let plan = Plan::from_toml(&timing::scene(packing, specimen, Mode::AllCores), None)?;
        let (position, radius, bounds) = initial_packing(&plan)?;
        let wet = plan.fluid.ok_or_else(|| InputError::new("no fluid", "add a table [fluid]"))?;
        Ok(Input { position, radius, bounds, fluid: wet.fluid })
    }

    /// Triangulation, pores, throats, and what the operators need beside them.
    ///
    /// # Errors
    /// The packing has no network.
    pub fn network(&self) -> Result<(Network, Derivatives), Error> {
        Network::new(&self.position, &self.radius, self.bounds, &self.fluid)
            .map_err(|e| dempfv::Error::from(e).into())
    }

    /// The sparse operators of a network.
    ///
    /// # Errors
    /// The derivatives are those of another network.
    pub fn operators(
        &self,
        network: &Network,
        derivatives: Derivatives,
    ) -> Result<Operators, Error> {
        Operators::new(network, derivatives, self.fluid.boundary)
            .map_err(|e| dempfv::Error::from(e).into())
    }
}

fn build(input: &Input) -> Result<Built, Error> {
    let mut best = Built { network_s: f64::INFINITY, operators_s: f64::INFINITY };
    let begin = Instant::now();
    while best.network_s == f64::INFINITY || begin.elapsed().as_secs_f64() < MEASURE_FOR {
        let start = Instant::now();
        let (network, derivatives) = input.network()?;
        let network_s = start.elapsed().as_secs_f64();
        let start = Instant::now();
        input.operators(&network, derivatives)?;
        let operators_s = start.elapsed().as_secs_f64();
        best = Built {
            network_s: best.network_s.min(network_s),
            operators_s: best.operators_s.min(operators_s),
        };
    }
    Ok(best)
}
