//! What YADE makes of injection, of the start of a compressible flow and of a Darcy medium on a small
//! packing is kept, for tests on machines without it.

use std::path::Path;

use dempfv::io::atomic;
use dempfv_report::machine;
use serde::Serialize;

use super::conditions::{Case, Injection, Job, Look};
use super::loading::Packing;
use super::peer::Bench;
use crate::Error;

/// Steps of the compressible flow.
const STEPS: u32 = 5;

/// A reference file.
#[derive(Serialize)]
struct Reference<'a> {
    made: String,
    viscosity: f64,
    pressure: f64,
    bulk_modulus: f64,
    dt: f64,
    steps: u32,
    mobility: f64,
    injection: &'a Option<Injection>,
    compression: Option<&'a Look>,
    darcy: Option<[f64; 2]>,
}

/// Writes the reference of the packing `loading-200.txt` in a folder beside it.
///
/// # Errors
/// When YADE fails, or the system refuses.
pub fn write(bench: &Bench, folder: &Path) -> Result<(), Error> {
    let packing = Packing::load(&folder.join("loading-200.txt"))?;
    let cases = [Case::Injection, Case::Compression, Case::Darcy];
    let mut job = Job::new(&packing, &cases);
    job.looks = vec![STEPS];
    let found = job.ask(bench, "injection")?;
    let made = format!(
        "YADE {} by `dempfv compare yade --write-reference`, {}",
        bench.peer.version,
        machine::today()
    );
    let Job { viscosity, pressure, bulk_modulus, dt, mobility, .. } = job;
    let reference = Reference {
        made,
        viscosity,
        pressure,
        bulk_modulus,
        dt,
        steps: STEPS,
        mobility,
        injection: &found.injection,
        compression: found.compression.as_ref().and_then(|c| c.looks.last()),
        darcy: found.darcy,
    };
    let path = folder.join("injection-200.json");
    let text = serde_json::to_string(&reference).map_err(|e| dempfv::Error::io(&path, e.into()))?;
    atomic::write(&path, (text + "\n").as_bytes())?;
    Ok(())
}
