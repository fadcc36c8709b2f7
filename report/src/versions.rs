//! Versions of all that a result depends on.

use std::collections::BTreeMap;

use dempfv::solver::blas;

/// The revision of the sources; `unknown` where they are no git checkout.
pub const GIT: &str = env!("DEMPFV_GIT_VERSION");

/// The headers of CHOLMOD that the program was built against.
const CHOLMOD: &str = env!("DEMPFV_CHOLMOD_VERSION");

/// All versions, by name.
pub fn all() -> BTreeMap<&'static str, String> {
    BTreeMap::from([
        ("dempfv", env!("CARGO_PKG_VERSION").to_owned()),
        ("git", GIT.to_owned()),
        ("rustc", env!("DEMPFV_RUSTC_VERSION").to_owned()),
        ("suitesparse", env!("DEMPFV_SUITESPARSE_VERSION").to_owned()),
        ("cholmod", CHOLMOD.to_owned()),
        ("metis", env!("DEMPFV_METIS_VERSION").to_owned()),
        ("cgal", env!("DEMPFV_CGAL_VERSION").to_owned()),
        // The BLAS is the machine's choice, known only now.
        ("blas", blas::description()),
    ])
}

/// The BLAS by name and version, with the processor that its kernels are made for where it
/// tells: "OpenBLAS 0.3.21, SkylakeX kernels".
pub fn blas_with_kernels() -> String {
    with_kernels(&blas::description())
}

/// OpenBLAS describes itself as name, version, options, kernels and its most threads.
fn with_kernels(description: &str) -> String {
    let words: Vec<&str> = description.split_whitespace().collect();
    match words[..] {
        ["OpenBLAS", version, .., kernels, most] if most.starts_with("MAX_THREADS") => {
            format!("OpenBLAS {version}, {kernels} kernels")
        }
        _ => description.to_owned(),
    }
}

/// The file that provides the BLAS, where the system tells.
pub fn blas_library() -> Option<String> {
    cholmod_sys::blas::library_path()
}

/// What is to be done where the CHOLMOD that is loaded is not the one that the program was
/// built against.
pub fn cholmod_advice() -> Option<String> {
    let loaded = cholmod_sys::cholmod_version().map(|number| number.to_string()).join(".");
    (loaded != CHOLMOD).then(|| {
        format!(
            "the program was built against CHOLMOD {CHOLMOD} but has loaded {loaded}; build it anew"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_are_told_where_the_blas_tells() {
        let debian = "OpenBLAS 0.3.21 NO_LAPACKE DYNAMIC_ARCH NO_AFFINITY Prescott MAX_THREADS=64";
        assert_eq!(with_kernels(debian), "OpenBLAS 0.3.21, Prescott kernels");
        assert_eq!(with_kernels("reference BLAS"), "reference BLAS");
    }
}
