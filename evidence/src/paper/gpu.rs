//! A specimen on a machine with a GPU: the same run with CHOLMOD's factorizations on the GPU
//! and on one core of that machine, so that ratios are of one machine and one solver.

use std::path::{Path, PathBuf};

use dempfv::InputError;
use dempfv::solver::{self, GpuOptions, SolverKind};
use dempfv_report::json;
use dempfv_report::machine;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::built::Input;
use super::factored::{self, Factored};
use super::specimens::Specimen;
use super::timing::{self, Mode, Timing};
use crate::Error;
use crate::bench::Bench;

/// Folder of these measurements, one file for each device and specimen. Files from other
/// machines are put there by hand.
const FOLDER: &str = "gpu";

/// Factorizations in one process, of which the fastest counts.
const WARM: usize = 4;

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
    /// The run with its factorizations on the GPU, of which the first, and here only, one is
    /// a cold start.
    pub with_gpu: Timing,
    /// Factorization on the GPU, the fastest of four in one process.
    pub warm: Factored,
    /// The same with CHOLMOD on one core.
    pub one_core: Timing,
    /// CHOLMOD's factorization on the CPU with the BLAS on all cores.
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
    // Kept one by one: a call that is cut off goes on from there.
    let one_core = timing::measure(bench, specimen, Mode::Cholmod, 1)?;
    let all_cores = factored::measure(bench, specimen, threads)?;
    // What another device has done must not stand for this one.
    let with_gpu = timing::run(bench, specimen, Mode::Gpu, threads)?;
    if let Some(reason) = with_gpu.without_gpu() {
        return Ok(Some(reason));
    }
    if with_gpu.gpu_name() != info.name {
        return Ok(Some(format!("the run used {}, not {}", with_gpu.gpu_name(), info.name)));
    }
    let input = Input::of(specimen, &specimen.packing(bench)?)?;
    let solver = SolverKind::CholmodGpu(GpuOptions::default());
    let measured = OnGpu {
        name: info.name.clone(),
        gpu: serde_json::to_value(&info).unwrap_or_default(),
        machine: machine::description(),
        day: machine::today(),
        with_gpu,
        warm: factored::factor(&input, solver, 1, WARM)?,
        one_core,
        all_cores,
        threads,
    };
    let folder = bench.folder.join(FOLDER);
    std::fs::create_dir_all(&folder).map_err(|e| dempfv::Error::io(&folder, e))?;
    json::write(&path, &measured)?;
    Ok(None)
}

/// Makes what was measured on this machine's GPU unknown.
///
/// # Errors
/// When the system refuses.
pub fn forget(bench: &Bench, specimen: &Specimen) -> Result<(), Error> {
    let path = bench.folder.join(FOLDER).join(file(&gpu()?.name, specimen));
    match std::fs::remove_file(&path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
            Err(dempfv::Error::io(&path, e).into())
        }
        _ => Ok(()),
    }
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
            false => Ok(OnGpu {
                with_gpu: found
                    .with_gpu
                    .clone()
                    .with_factorization(found.warm.analyze_s, found.warm.factor_s),
                ..found
            }),
        }
    };
    paths.into_iter().map(read).collect()
}
