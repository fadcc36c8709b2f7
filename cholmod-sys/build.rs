//! Finds CHOLMOD and METIS and generates their bindings.
//!
//! What is missing is said in one line that names the Debian package.

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
const CHOLMOD_MIN: &str = "3.0";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=wrapper.h");
    if let Err(message) = build() {
        // A plain error line: a panic would bury it in a trace.
        println!("cargo::error={message}");
    }
}

fn build() -> Result<(), String> {
    let includes = [
        find("CHOLMOD", CHOLMOD_MIN, "cholmod", "cholmod.h", "libsuitesparse-dev")?,
        find("metis", "5", "metis", "metis.h", "libmetis-dev")?,
    ];
    // Holds SuiteSparse's version function; part of every CHOLMOD.
    println!("cargo::rustc-link-lib=suitesparseconfig");
    clang_sys::load().map_err(|_| {
        "libclang was not found, which generates the bindings; install libclang-dev".to_owned()
    })?;
    let bindings = generate(&includes)?;
    // CHOLMOD 5 can be told its OpenMP threads.
    println!("cargo::rustc-check-cfg=cfg(openmp_threads)");
    if bindings.contains("nthreads_max") {
        println!("cargo::rustc-cfg=openmp_threads");
    }
    let out = PathBuf::from(std::env::var_os("OUT_DIR").ok_or("OUT_DIR is not set")?);
    std::fs::write(out.join("bindings.rs"), &bindings)
        .map_err(|e| format!("{}: {e}", out.display()))?;
    publish(&bindings)
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
fn require_library(lib: &str, package: &str) -> Result<(), String> {
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

fn generate(includes: &[Vec<PathBuf>]) -> Result<String, String> {
    let mut builder = bindgen::Builder::default()
        .header("wrapper.h")
        .allowlist_function("cholmod_l_.*|METIS_NodeND|METIS_SetDefaultOptions|SuiteSparse_version")
        .allowlist_type("cholmod_.*|idx_t|real_t|rstatus_et|moptions_et")
        .allowlist_var("CHOLMOD_.*|SUITESPARSE_.*VERSION|METIS_.*|IDXTYPEWIDTH")
        .prepend_enum_name(false)
        .layout_tests(false)
        .merge_extern_blocks(true)
        .formatter(bindgen::Formatter::None);
    for dir in includes.iter().flatten() {
        builder = builder.clang_arg(format!("-I{}", dir.display()));
    }
    let bindings = builder.generate().map_err(|e| {
        let first = e.to_string();
        let first = first.lines().next().unwrap_or_default().to_owned();
        format!("the headers of CHOLMOD and METIS cannot be read ({first}); install libclang-dev and libsuitesparse-dev anew")
    })?;
    Ok(bindings.to_string())
}

/// Hands the versions in the headers to the build scripts of crates above.
fn publish(bindings: &str) -> Result<(), String> {
    for (key, prefix, parts) in [
        ("suitesparse", "SUITESPARSE_", ["MAIN_VERSION", "SUB_VERSION", "SUBSUB_VERSION"]),
        ("cholmod", "CHOLMOD_", ["MAIN_VERSION", "SUB_VERSION", "SUBSUB_VERSION"]),
        ("metis", "METIS_", ["VER_MAJOR", "VER_MINOR", "VER_SUBMINOR"]),
    ] {
        let numbers: Option<Vec<String>> =
            parts.iter().map(|part| constant(bindings, &format!("{prefix}{part}"))).collect();
        let numbers =
            numbers.ok_or_else(|| format!("the headers do not tell the version of {key}"))?;
        println!("cargo::metadata={key}_version={}", numbers.join("."));
    }
    Ok(())
}

/// Value of an integer constant in the generated bindings.
fn constant(bindings: &str, name: &str) -> Option<String> {
    let rest = &bindings[bindings
        .find(&format!("pub const {name} :"))
        .or_else(|| bindings.find(&format!("pub const {name}:")))?..];
    let value = &rest[rest.find('=')? + 1..rest.find(';')?];
    Some(value.trim().to_owned())
}
