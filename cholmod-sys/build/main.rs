//! Finds CHOLMOD and METIS, or with the feature `cuda` compiles CHOLMOD with its
//! GPU module, and generates the bindings.
//!
//! Where docs.rs builds the documentation there is neither, and nothing is linked: the
//! bindings are then those of one version, kept in `documented.rs`.
//!
//! What is missing is said in one line that names the Debian package or the
//! command that fetches it.

#[cfg(feature = "cuda")]
mod cuda;
mod system;

use std::path::PathBuf;

/// The bindings that this script has generated for SuiteSparse 5.12 and METIS 5.1.
const DOCUMENTED: &str = include_str!("documented.rs");

fn main() {
    println!("cargo::rerun-if-changed=build");
    println!("cargo::rerun-if-changed=wrapper.h");
    println!("cargo::rerun-if-env-changed=DOCS_RS");
    if let Err(message) = build() {
        // A plain error line: a panic would bury it in a trace.
        println!("cargo::error={message}");
    }
}

fn build() -> Result<(), String> {
    let bindings = match std::env::var_os("DOCS_RS") {
        Some(_) => DOCUMENTED.to_owned(),
        None => bindings()?,
    };
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

/// Links the libraries and reads their headers.
fn bindings() -> Result<String, String> {
    #[cfg(feature = "cuda")]
    let cholmod = cuda::cholmod()?;
    #[cfg(not(feature = "cuda"))]
    let cholmod = system::cholmod()?;
    let includes = [cholmod, system::metis()?];
    clang_sys::load().map_err(|_| {
        "libclang was not found, which generates the bindings; install libclang-dev".to_owned()
    })?;
    generate(&includes)
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
