//! CHOLMOD from source with its GPU module, and the gate between it and CUDA.
//!
//! Needs the sources of SuiteSparse (7.7 or newer, where most faults of the GPU
//! module are mended) and CUDA's compiler and headers. `make cuda` fetches what
//! is missing. The program needs none of CUDA's libraries to link or to start:
//! the gate looks for them when a GPU is asked for.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::system;

/// Oldest SuiteSparse that is taken: main and sub version.
const OLDEST: (u32, u32) = (7, 7);

/// Oldest CUDA that is taken, as it numbers itself: before it libraries had other names.
const OLDEST_CUDA: u32 = 12_000;

/// Architectures of GPUs that code is made for, where the compiler knows them;
/// newer ones take the last one's portable code.
const ARCHITECTURES: [u32; 6] = [70, 75, 80, 86, 89, 90];

/// Compiles and links CHOLMOD; returns the directories of its headers.
pub fn cholmod() -> Result<Vec<PathBuf>, String> {
    println!("cargo::rerun-if-changed=cuda");
    let sources = sources()?;
    let cuda = Cuda::find()?;
    let out = PathBuf::from(std::env::var_os("OUT_DIR").ok_or("OUT_DIR is not set")?);
    let kernels = cuda.kernels(&sources, &out)?;
    compile_metis(&sources)?;
    compile_cholmod(&sources, &cuda)?;
    compile_gate(&sources, &cuda, &kernels)?;
    for library in ["lapack", "blas"] {
        system::require_library(library, "libopenblas-dev")?;
        println!("cargo::rustc-link-lib={library}");
    }
    println!("cargo::rustc-link-lib=gomp");
    println!("cargo::rustc-link-lib=m");
    Ok(vec![sources.join("CHOLMOD/Include"), sources.join("SuiteSparse_config")])
}

/// Where the sources of SuiteSparse lie: `SUITESPARSE_SOURCE`, or where `make
/// cuda` puts them in a checkout.
fn sources() -> Result<PathBuf, String> {
    let folder = named("SUITESPARSE_SOURCE").unwrap_or_else(|| checkout("suitesparse"));
    let header = folder.join("SuiteSparse_config/SuiteSparse_config.h");
    println!("cargo::rerun-if-changed={}", header.display());
    let text = std::fs::read_to_string(&header).map_err(|_| {
        format!(
            "the sources of SuiteSparse are not in {}; run `make cuda`, or name their folder in \
             SUITESPARSE_SOURCE",
            folder.display()
        )
    })?;
    let version =
        (defined(&text, "SUITESPARSE_MAIN_VERSION"), defined(&text, "SUITESPARSE_SUB_VERSION"));
    match version {
        (Some(main), Some(sub)) if (main, sub) >= OLDEST => Ok(folder),
        _ => Err(format!(
            "{} is older than SuiteSparse {}.{}, whose GPU module works; run `make cuda`",
            folder.display(),
            OLDEST.0,
            OLDEST.1
        )),
    }
}

/// A number that a header defines.
fn defined(header: &str, name: &str) -> Option<u32> {
    let line = header.lines().find_map(|line| line.strip_prefix("#define ")?.strip_prefix(name))?;
    line.split_whitespace().next()?.parse().ok()
}

/// The folder that an environment variable names.
fn named(variable: &str) -> Option<PathBuf> {
    println!("cargo::rerun-if-env-changed={variable}");
    std::env::var_os(variable).filter(|value| !value.is_empty()).map(PathBuf::from)
}

/// A folder of what `make cuda` fetches.
fn checkout(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../cuda").join(name)
}

/// An installation of CUDA.
struct Cuda {
    nvcc: PathBuf,
    include: PathBuf,
}

impl Cuda {
    /// That of `CUDA_PATH` or `CUDA_HOME`, else the system's, else what `make
    /// cuda` has fetched.
    fn find() -> Result<Cuda, String> {
        let chosen = named("CUDA_PATH").or_else(|| named("CUDA_HOME"));
        let usual = || vec![PathBuf::from("/usr/local/cuda"), checkout("toolkit/nvidia/cu13")];
        let folders = chosen.map_or_else(usual, |folder| vec![folder]);
        let complete = |folder: &PathBuf| {
            folder.join("bin/nvcc").is_file() && folder.join("include/cuda_runtime.h").is_file()
        };
        let folder = folders.iter().find(|folder| complete(folder)).ok_or_else(|| {
            let looked: Vec<_> = folders.iter().map(|f| f.display().to_string()).collect();
            format!(
                "CUDA's compiler was not found in {}; run `make cuda`, or name its folder in \
                 CUDA_PATH",
                looked.join(" or ")
            )
        })?;
        let header = folder.join("include/cuda_runtime_api.h");
        println!("cargo::rerun-if-changed={}", header.display());
        let text = std::fs::read_to_string(&header).unwrap_or_default();
        if defined(&text, "CUDART_VERSION").is_none_or(|version| version < OLDEST_CUDA) {
            return Err(format!(
                "{} is older than CUDA 12; run `make cuda` without it",
                folder.display()
            ));
        }
        Ok(Cuda { nvcc: folder.join("bin/nvcc"), include: folder.join("include") })
    }

    /// Compiles CHOLMOD's kernels to device code; returns a C file that holds it.
    fn kernels(&self, sources: &Path, out: &Path) -> Result<PathBuf, String> {
        let known = self.run(&["--list-gpu-code".as_ref()])?;
        let known: Vec<u32> = known
            .split_whitespace()
            .filter_map(|name| name.strip_prefix("sm_")?.parse().ok())
            .collect();
        let chosen: Vec<u32> = ARCHITECTURES.into_iter().filter(|a| known.contains(a)).collect();
        let newest = chosen.last().ok_or_else(|| {
            format!("{} makes code for none of sm_70 to sm_90", self.nvcc.display())
        })?;
        let image = out.join("kernels.fatbin");
        let mut command = Command::new(&self.nvcc);
        command.args(["-O3", "--fatbin", "-DCHOLMOD_HAS_CUDA"]);
        for arch in &chosen {
            command.arg(format!("-gencode=arch=compute_{arch},code=sm_{arch}"));
        }
        command.arg(format!("-gencode=arch=compute_{newest},code=compute_{newest}"));
        command.arg("-I").arg(sources.join("SuiteSparse_config"));
        command.arg(sources.join("CHOLMOD/GPU/cholmod_gpu_kernels.cu")).arg("-o").arg(&image);
        output(&mut command)?;
        let bytes = std::fs::read(&image).map_err(|e| format!("{}: {e}", image.display()))?;
        let mut text =
            "const unsigned char gate_kernels [] __attribute__ ((aligned (16))) = {".to_owned();
        for byte in bytes {
            // Writing to a string cannot fail.
            let _ = write!(text, "{byte},");
        }
        text += "} ;\n";
        let file = out.join("kernels.c");
        std::fs::write(&file, text).map_err(|e| format!("{}: {e}", file.display()))?;
        Ok(file)
    }

    fn run(&self, args: &[&std::ffi::OsStr]) -> Result<String, String> {
        output(Command::new(&self.nvcc).args(args))
    }
}

/// What a command prints.
fn output(command: &mut Command) -> Result<String, String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let done = command.output().map_err(|e| format!("{name} cannot be run: {e}"))?;
    if done.status.success() {
        return Ok(String::from_utf8_lossy(&done.stdout).into_owned());
    }
    let errors = String::from_utf8_lossy(&done.stderr);
    let telling = errors.lines().find(|line| line.contains("error")).or(errors.lines().next());
    Err(format!("{name} fails: {}", telling.unwrap_or("without a word")))
}

/// A compilation of C as all of them are: optimized whatever the profile, for
/// an unoptimized BLAS driver is of use to nobody, and silent about code that
/// is not ours.
fn compilation() -> cc::Build {
    let mut build = cc::Build::new();
    build.opt_level(3).debug(false).warnings(false).pic(true).define("NDEBUG", None);
    build
}

/// METIS as CHOLMOD has it, under names of its own.
fn compile_metis(sources: &Path) -> Result<(), String> {
    let metis = sources.join("CHOLMOD/SuiteSparse_metis");
    compilation()
        .file(sources.join("CHOLMOD/Partition/cholmod_metis_wrapper.c"))
        .include(sources.join("SuiteSparse_config"))
        .include(sources.join("CHOLMOD"))
        .include(sources.join("CHOLMOD/Include"))
        .include(metis.join("include"))
        .include(metis.join("GKlib"))
        .include(metis.join("libmetis"))
        .try_compile("dempfv_cholmod_metis")
        .map_err(|e| e.to_string())
}

/// CHOLMOD with 64-bit indices, what it needs of SuiteSparse, and its GPU
/// module.
fn compile_cholmod(sources: &Path, cuda: &Cuda) -> Result<(), String> {
    let mut build = compilation();
    for package in ["AMD", "CAMD", "COLAMD", "CCOLAMD"] {
        build.include(sources.join(package).join("Include"));
        build.files(c_files(&sources.join(package).join("Source"), |_| true)?);
    }
    build.include(sources.join("SuiteSparse_config"));
    build.file(sources.join("SuiteSparse_config/SuiteSparse_config.c"));
    for module in ["Utility", "Check", "Cholesky", "Partition", "Supernodal", "GPU"] {
        let folder = sources.join("CHOLMOD").join(module);
        // Functions without `_l_` are for 32-bit indices, but for a few that both share.
        let shared = ["cholmod_mult_uint64_t.c", "cholmod_memdebug.c"];
        let wanted = |name: &str| name.starts_with("cholmod_l_") || shared.contains(&name);
        build.files(c_files(&folder, wanted)?);
    }
    build.include(sources.join("CHOLMOD/Include")).include(sources.join("CHOLMOD"));
    let metis = sources.join("CHOLMOD/SuiteSparse_metis");
    build.include(metis.join("include"));
    with_gate(&mut build, sources, cuda);
    let gate = Path::new(env!("CARGO_MANIFEST_DIR")).join("cuda/gate.h");
    build.flag("-include").flag(gate.as_os_str());
    // The counters of calls to the GPU are behind BLAS_TIMER.
    build.flag("-fopenmp").define("CHOLMOD_HAS_CUDA", None).define("BLAS_TIMER", None);
    build.try_compile("dempfv_cholmod").map_err(|e| e.to_string())
}

fn compile_gate(sources: &Path, cuda: &Cuda, kernels: &Path) -> Result<(), String> {
    let mut build = compilation();
    build.file("cuda/gate.c").file(kernels);
    build.include(sources.join("SuiteSparse_config"));
    with_gate(&mut build, sources, cuda);
    build.try_compile("dempfv_gate").map_err(|e| e.to_string())
}

/// The headers of the gate, of the GPU module, and of CUDA.
fn with_gate(build: &mut cc::Build, sources: &Path, cuda: &Cuda) {
    build.include("cuda/include").include("cuda");
    build.include(sources.join("CHOLMOD/GPU")).include(&cuda.include);
}

/// The C files of a folder whose names are wanted, in the order of their names.
fn c_files(folder: &Path, wanted: impl Fn(&str) -> bool) -> Result<Vec<PathBuf>, String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|e| e == "c"))
        .filter(|path| path.file_name().and_then(|n| n.to_str()).is_some_and(&wanted))
        .collect();
    files.sort();
    Ok(files)
}
