//! A specimen on a machine with a GPU: the same run with the factorizations on the GPU and
//! on one core of that machine, so that ratios are of one machine.

use std::path::{Path, PathBuf};

use dempfv::InputError;
use dempfv::solver;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::factored::{self, Factored};
use super::specimens::Specimen;
use super::timing::{self, Mode, Timing};
use crate::commands::Error;
use crate::commands::bench::Bench;
use crate::commands::context::write_json;
use crate::commands::machine;

/// Folder of these measurements, one file for each device and specimen. Files from other
/// machines are put there by hand.
const FOLDER: &str = "gpu";

/// What was measured on a machine with a GPU.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct OnGpu {
    /// Name of the device.
    pub name: String,
    /// What else the driver tells of it.
    pub gpu: Value,
    /// Its machine.
    pub machine: String,
    /// Day of the measurement.
    pub day: String,
    /// The run with its factorizations on the GPU.
    pub with_gpu: Timing,
    /// The same on one core.
    pub one_core: Timing,
    /// Factorization on the CPU with the BLAS on all cores.
    pub all_cores: Factored,
    /// Number of these cores.
    pub threads: usize,
}

/// Measures a specimen on the first GPU of this machine, unless that is known. Returns why
/// there is nothing to be measured, as for a specimen too small for a GPU.
///
/// # Errors
/// There is no GPU; as a run.
pub fn measure(
    bench: &Bench,
    specimen: &Specimen,
    threads: usize,
) -> Result<Option<String>, Error> {
    let info = gpu()?;
    let path = bench.folder.join(FOLDER).join(file(&info.name, specimen));
    if path.is_file() {
        return Ok(None);
    }
    let with_gpu = timing::measure(bench, specimen, Mode::Gpu, threads)?;
    if let Some(reason) = with_gpu.without_gpu() {
        return Ok(Some(reason));
    }
    let measured = OnGpu {
        name: info.name.clone(),
        gpu: serde_json::to_value(&info).unwrap_or_default(),
        machine: machine::description(),
        day: machine::today(),
        with_gpu,
        one_core: timing::measure(bench, specimen, Mode::OneCore, 1)?,
        all_cores: factored::measure(bench, specimen, threads)?,
        threads,
    };
    let folder = bench.folder.join(FOLDER);
    std::fs::create_dir_all(&folder).map_err(|e| dempfv::Error::io(&folder, e))?;
    write_json(&path, &measured)?;
    Ok(None)
}

/// The GPU that is measured.
///
/// # Errors
/// There is none, or a stand-in for one.
fn gpu() -> Result<solver::GpuInfo, InputError> {
    let none = |why: String| InputError::new(format!("--gpu: {why}"), "see `dempfv doctor`");
    let info = solver::gpus().map_err(none)?.into_iter().next();
    let info = info.ok_or_else(|| none("there is no GPU".to_owned()))?;
    if is_standin(&info.name) {
        return Err(none(format!("{} is no GPU", info.name)));
    }
    Ok(info)
}

/// True for what our own tests put in a GPU's place: nothing measured on it is shown.
fn is_standin(name: &str) -> bool {
    name.contains("stand-in")
}

fn file(device: &str, specimen: &Specimen) -> String {
    let kept = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    format!("{}-{}.json", device.chars().map(kept).collect::<String>(), specimen.spheres)
}

/// What is known of a specimen, by device.
///
/// # Errors
/// A file is none of these measurements, or was measured on a stand-in.
pub fn known(folder: &Path, specimen: &Specimen) -> Result<Vec<OnGpu>, Error> {
    let ending = format!("-{}.json", specimen.spheres);
    let entries = std::fs::read_dir(folder.join(FOLDER)).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|e| e.path()).collect();
    paths.retain(|path| path.to_string_lossy().ends_with(&ending));
    paths.sort();
    let read = |path: PathBuf| {
        let text = std::fs::read(&path).map_err(|e| dempfv::Error::io(&path, e))?;
        let wrong = |what: String| {
            InputError::new(what, "files of `dempfv paper --gpu` belong there").in_file(&path)
        };
        let found: OnGpu = serde_json::from_slice(&text).map_err(|e| wrong(e.to_string()))?;
        match is_standin(&found.name) || found.with_gpu.without_gpu().is_some() {
            true => Err(wrong("measured without a GPU".to_owned()).into()),
            false => Ok(found),
        }
    };
    paths.into_iter().map(read).collect()
}
