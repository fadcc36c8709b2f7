//! CHOLMOD and METIS as the system has installed them.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Where headers live if pkg-config does not know.
const INCLUDE_DIRS: [&str; 5] = [
    "/usr/include/suitesparse",
    "/usr/include",
    "/usr/local/include/suitesparse",
    "/usr/local/include",
    "/opt/homebrew/include/suitesparse",
];

/// Oldest CHOLMOD whose functions and statuses are those used here
/// (SuiteSparse 5.0).
#[cfg(not(feature = "cuda"))]
const CHOLMOD_MIN: &str = "3.0";

/// Links CHOLMOD and returns the directories of its headers.
#[cfg(not(feature = "cuda"))]
pub fn cholmod() -> Result<Vec<PathBuf>, String> {
    let dirs = find("CHOLMOD", CHOLMOD_MIN, "cholmod", "cholmod.h", "libsuitesparse-dev")?;
    // Holds SuiteSparse's version function; part of every CHOLMOD.
    println!("cargo::rustc-link-lib=suitesparseconfig");
    Ok(dirs)
}

/// Links METIS and returns the directories of its headers.
pub fn metis() -> Result<Vec<PathBuf>, String> {
    find("metis", "5", "metis", "metis.h", "libmetis-dev")
}

/// Links a library and returns the directories of its headers: what pkg-config
/// says where it knows the library, else the usual places.
fn find(
    pc: &str,
    version: &str,
    lib: &str,
    header: &str,
    package: &str,
) -> Result<Vec<PathBuf>, String> {
    let known = pkg_config::Config::new().atleast_version(version).cargo_metadata(false).probe(pc);
    match known {
        Ok(found) => {
            for dir in &found.link_paths {
                println!("cargo::rustc-link-search=native={}", dir.display());
            }
            let dirs =
                if found.include_paths.is_empty() { usual_dirs() } else { found.include_paths };
            require_header(&dirs, header, package)?;
            println!("cargo::rustc-link-lib={lib}");
            Ok(dirs)
        }
        Err(pkg_config::Error::ProbeFailure { .. }) if is_too_old(pc) => {
            Err(format!("{pc} is older than version {version}; install a newer {package}"))
        }
        Err(_) => {
            let dirs = usual_dirs();
            require_header(&dirs, header, package)?;
            require_library(lib, package)?;
            println!("cargo::rustc-link-lib={lib}");
            Ok(dirs)
        }
    }
}

/// True where pkg-config knows the library but refused its version.
fn is_too_old(pc: &str) -> bool {
    pkg_config::Config::new().cargo_metadata(false).env_metadata(false).probe(pc).is_ok()
}

fn usual_dirs() -> Vec<PathBuf> {
    INCLUDE_DIRS.iter().map(PathBuf::from).filter(|dir| dir.is_dir()).collect()
}

fn require_header(dirs: &[PathBuf], header: &str, package: &str) -> Result<(), String> {
    let found = dirs.iter().map(|dir| dir.join(header)).find(|path| path.is_file());
    let path =
        found.ok_or_else(|| format!("the header {header} was not found; install {package}"))?;
    println!("cargo::rerun-if-changed={}", path.display());
    Ok(())
}

/// Asks the C compiler, which rustc links with, where it would find a library.
pub fn require_library(lib: &str, package: &str) -> Result<(), String> {
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let names = [format!("lib{lib}.so"), format!("lib{lib}.dylib"), format!("lib{lib}.a")];
    for name in &names {
        let answer = Command::new(&compiler)
            .arg(format!("-print-file-name={name}"))
            .output()
            .map_err(|e| format!("the C compiler {compiler} cannot be run ({e}); install gcc"))?;
        // A compiler that does not find the file echoes the bare name.
        if Path::new(String::from_utf8_lossy(&answer.stdout).trim()).is_absolute() {
            return Ok(());
        }
    }
    Err(format!("the library {} was not found; install {package}", names[0]))
}
