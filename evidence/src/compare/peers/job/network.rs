//! Networks from positions to operators.

use std::path::PathBuf;
use std::time::Instant;

use dempfv::WallId;
use dempfv::pfv::{Boundary, Clamp, Fluid, Network, Operators};
use dempfv::scene::load_packing;
use serde::{Deserialize, Serialize};

use crate::Error;

/// The packing, and how often its network is built.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Build {
    pub packing: PathBuf,
    pub repeats: usize,
    pub run: usize,
}

/// How long it took.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Built {
    pub pores: f64,
    pub throats: f64,
    /// Triangulation, pores and throats (s).
    pub network_s: Vec<f64>,
    /// The same with the operators G, E and F (s).
    pub all_s: Vec<f64>,
}

/// Water, drained at the top.
pub fn fluid() -> Fluid {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMax] = Some(0.0);
    Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary }
}

impl Build {
    /// Builds it.
    ///
    /// # Errors
    /// What is wrong in the packing.
    pub fn measure(&self) -> Result<Built, Error> {
        let (packing, bounds) = load_packing(&self.packing, None).map_err(dempfv::Error::from)?;
        let mut built = Built { pores: 0.0, throats: 0.0, network_s: vec![], all_s: vec![] };
        for _ in 0..self.repeats {
            let fluid = fluid();
            let start = Instant::now();
            let (network, derivatives) =
                Network::new(&packing.position, &packing.radius, bounds, &fluid)
                    .map_err(dempfv::Error::from)?;
            built.network_s.push(start.elapsed().as_secs_f64());
            let operators = Operators::new(&network, derivatives, fluid.boundary)
                .map_err(dempfv::Error::from)?;
            built.all_s.push(start.elapsed().as_secs_f64());
            drop(operators);
            built.pores = network.pores() as f64;
            built.throats = network.throats.pores.len() as f64;
        }
        Ok(built)
    }
}
