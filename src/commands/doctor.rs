//! `dempfv doctor`: what this program was built from and what this machine offers.

use std::collections::BTreeMap;
use std::fmt;
use std::thread::available_parallelism;

use dempfv::Error;
use dempfv::solver::{self, GpuInfo, SolverKind, blas};
use dempfv_report::format::bytes;
use dempfv_report::versions;
use serde::Serialize;

/// What `doctor` takes: nothing of its own.
#[derive(clap::Args)]
pub struct Args {}

/// What was found.
#[derive(Debug, Serialize)]
pub struct Report {
    versions: BTreeMap<&'static str, String>,
    /// The file that provides the BLAS.
    blas_library: Option<String>,
    solvers: Vec<&'static str>,
    cores: Option<usize>,
    /// Memory of the machine, and what is free of it (bytes).
    memory_bytes: Option<u64>,
    memory_available_bytes: Option<u64>,
    gpus: Vec<GpuInfo>,
    /// Why there is none.
    no_gpu: Option<String>,
    advice: Vec<String>,
}

/// Looks around.
///
/// # Errors
/// None at present.
pub fn run(_: &Args) -> Result<Report, Error> {
    let memory = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let gpus = solver::gpus();
    let built = SolverKind::ALL.iter().filter(|kind| kind.is_built());
    Ok(Report {
        versions: versions::all(),
        blas_library: versions::blas_library(),
        solvers: built.map(|kind| kind.name()).collect(),
        cores: available_parallelism().ok().map(Into::into),
        memory_bytes: meminfo(&memory, "MemTotal:"),
        memory_available_bytes: meminfo(&memory, "MemAvailable:"),
        gpus: gpus.clone().unwrap_or_default(),
        no_gpu: gpus.err(),
        advice: advice(),
    })
}

/// What a GPU is, in a line.
fn gpu_line(gpu: &GpuInfo) -> String {
    format!(
        "{}: {}, {} ({} free), compute capability {}, {} multiprocessors{}; driver {} for CUDA {}, \
         runtime {}, cuBLAS {}",
        gpu.device,
        gpu.name,
        bytes(gpu.memory_bytes as f64),
        bytes(gpu.memory_free_bytes as f64),
        gpu.compute,
        gpu.multiprocessors,
        gpu.clock_mhz.map_or(String::new(), |mhz| format!(" up to {mhz} MHz")),
        gpu.driver.as_deref().unwrap_or("of unknown version"),
        gpu.driver_cuda,
        gpu.runtime_cuda,
        gpu.cublas
    )
}

/// A line of /proc/meminfo, in bytes.
fn meminfo(text: &str, key: &str) -> Option<u64> {
    let rest = text.lines().find_map(|line| line.strip_prefix(key))?;
    Some(rest.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}

/// What would make the program faster or its results safer here.
fn advice() -> Vec<String> {
    let mut advice = Vec::new();
    if blas::threads().is_none() {
        advice.push(
            "the BLAS is not OpenBLAS, so CHOLMOD is slower or its threads unknown (the frontal \
             solver uses no BLAS); install libopenblas0-pthread"
                .to_owned(),
        );
    }
    advice.extend(blas::old_kernels().map(|kernels| kernels.to_string()));
    advice.extend(versions::cholmod_advice());
    advice
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, version) in &self.versions {
            writeln!(f, "{name:<12} {version}")?;
        }
        let or_unknown = |text: Option<String>| text.unwrap_or_else(|| "unknown".to_owned());
        writeln!(f, "{:<12} {}", "", or_unknown(self.blas_library.clone()))?;
        writeln!(f, "{:<12} {}", "solvers", self.solvers.join(", "))?;
        writeln!(f, "{:<12} {}", "cores", or_unknown(self.cores.map(|n| n.to_string())))?;
        let size = |size: Option<u64>| or_unknown(size.map(|size| bytes(size as f64)));
        let (all, free) = (size(self.memory_bytes), size(self.memory_available_bytes));
        writeln!(f, "{:<12} {all}, {free} available", "memory")?;
        for gpu in &self.gpus {
            writeln!(f, "{:<12} {}", "GPU", gpu_line(gpu))?;
        }
        if let Some(reason) = &self.no_gpu {
            writeln!(f, "{:<12} none: {reason}", "GPU")?;
        }
        match self.advice.as_slice() {
            [] => writeln!(f, "\nnothing is missing"),
            advice => advice.iter().try_for_each(|line| writeln!(f, "\n{line}")),
        }
    }
}
