//! YADE's check of injection at points, `checkDEM-PFVPressureInjection.py`, in small, the start of a flow of
//! compressible fluid, and a flow through a Darcy medium: what YADE makes of them is kept, for tests on machines without it.

use std::path::Path;

use dempfv::io::atomic;
use dempfv::scene::load_packing;
use dempfv_report::machine;
use serde::{Deserialize, Serialize};

use super::peer::Bench;
use crate::Error;

const SCRIPT: &str = include_str!("scripts/injection.py");

/// What the script is asked for: viscosity and pressure of YADE's check; pores above a third of the
/// height are held at zero, as it does.
#[derive(Serialize)]
struct Job {
    spheres: Vec<[f64; 4]>,
    #[serde(rename = "box")]
    bounds: [f64; 6],
    viscosity: f64,
    pressure: f64,
    level: f64,
    bulk_modulus: f64,
    dt: f64,
    steps: u32,
    mobility: f64,
}

/// What YADE found.
#[derive(Serialize, Deserialize)]
struct Found {
    injection: Injection,
    compression: Compression,
    darcy: [f64; 2],
}

#[derive(Serialize, Deserialize)]
struct Injection {
    cells: Vec<[u32; 4]>,
    held: Vec<u32>,
    pressure: Vec<f64>,
    entering: f64,
    leaving: f64,
    void: Vec<f64>,
}

#[derive(Serialize, Deserialize)]
struct Compression {
    pressure: Vec<f64>,
    flux: [f64; 2],
}

/// A reference file. Vertices of cells are spheres from 0 and, after them, the walls.
#[derive(Serialize)]
struct Reference<'a> {
    made: String,
    viscosity: f64,
    pressure: f64,
    bulk_modulus: f64,
    dt: f64,
    steps: u32,
    mobility: f64,
    #[serde(flatten)]
    found: &'a Found,
}

/// Writes the reference of the packing `loading-200.txt` in a folder beside it.
///
/// # Errors
/// When YADE fails, or the system refuses.
pub fn write(bench: &Bench, folder: &Path) -> Result<(), Error> {
    let (packing, bounds) = load_packing(&folder.join("loading-200.txt"), None)?;
    let spheres = packing.position.iter().zip(&packing.radius);
    let [low, high] = [bounds.min, bounds.max].map(<[f64; 3]>::from);
    let job = Job {
        spheres: spheres.map(|(x, r)| [x.x, x.y, x.z, *r]).collect(),
        bounds: [low[0], low[1], low[2], high[0], high[1], high[2]],
        viscosity: 0.1,
        pressure: 1000.0,
        level: bounds.min.y + bounds.size().y / 3.0,
        bulk_modulus: 1e6,
        dt: 1e-4,
        steps: 5,
        mobility: 2e-3,
    };
    let found = bench.yade::<Found>("injection", SCRIPT, 1, &job)?.result;
    let made = format!(
        "YADE {} by `dempfv compare yade --write-reference`, {}",
        bench.peer.version,
        machine::today()
    );
    let Job { viscosity, pressure, bulk_modulus, dt, steps, mobility, .. } = job;
    let found = &found;
    let reference =
        Reference { made, viscosity, pressure, bulk_modulus, dt, steps, mobility, found };
    let path = folder.join("injection-200.json");
    let text = serde_json::to_string(&reference).map_err(|e| dempfv::Error::io(&path, e.into()))?;
    atomic::write(&path, (text + "\n").as_bytes())?;
    Ok(())
}
