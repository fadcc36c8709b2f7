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
