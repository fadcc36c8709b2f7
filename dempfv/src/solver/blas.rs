//! The BLAS, which CHOLMOD computes with: its threads, which are the whole process's, and its kernels.
//!
//! OpenBLAS cuts its work by the number of its threads and so rounds
//! differently with each. The library promises results that do not depend on
//! the number of threads, so the BLAS runs on one unless [`set_threads`] says
//! otherwise.

use std::fmt;
use std::sync::Once;

static CHOSEN: Once = Once::new();

/// Lets the BLAS use this many threads, for the whole process, and gives up
/// the promise that results are the same bits for any number of threads.
/// Returns false for no thread at all, and where the loaded BLAS is not OpenBLAS: nothing was set
/// then.
///
/// Not to be called while another thread factors or solves.
pub fn set_threads(threads: usize) -> bool {
    if threads == 0 {
        return false;
    }
    CHOSEN.call_once(|| {});
    cholmod_sys::blas::set_num_threads(threads)
}

/// Number of threads that the BLAS uses; `None` where it is not OpenBLAS.
pub fn threads() -> Option<usize> {
    cholmod_sys::blas::num_threads()
}

/// Which BLAS is loaded: OpenBLAS's own words, else the library's file.
pub fn description() -> String {
    cholmod_sys::blas::description()
}

/// OpenBLAS computes with kernels for an older processor than this one: it does not know it, or was
/// told to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OldKernels {
    /// The processor that the kernels are for, by OpenBLAS's name.
    pub used: String,
    /// The name of one whose kernels use this processor's vectors.
    pub better: &'static str,
}

impl fmt::Display for OldKernels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "OpenBLAS uses its kernels for {}, an older processor than this one, so CHOLMOD takes \
             longer than need be; set OPENBLAS_CORETYPE={} in the environment",
            self.used, self.better
        )
    }
}

/// Kernels of the BLAS that leave the widest vectors of this processor unused; `None` where they
/// use them, and where nothing is known of them.
pub fn old_kernels() -> Option<OldKernels> {
    let used = cholmod_sys::blas::kernels()?;
    let better = better_than(&used, VectorUnits::detect())?;
    Some(OldKernels { used, better })
}

/// What OpenBLAS's newer kernels need.
#[derive(Clone, Copy)]
struct VectorUnits {
    avx2: bool,
    avx512: bool,
}

impl VectorUnits {
    #[cfg(target_arch = "x86_64")]
    fn detect() -> VectorUnits {
        let avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
        // Those of Skylake's servers.
        let avx512 = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl");
        VectorUnits { avx2, avx512 }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn detect() -> VectorUnits {
        VectorUnits { avx2: false, avx512: false }
    }
}

/// Processors without AVX2 that OpenBLAS has kernels for (its list `DYNAMIC_CORE` for x86-64).
const WITHOUT_AVX2: [&str; 18] = [
    "Katmai",
    "Coppermine",
    "Northwood",
    "Prescott",
    "Banias",
    "Core2",
    "Penryn",
    "Dunnington",
    "Nehalem",
    "Atom",
    "Nano",
    "Athlon",
    "Opteron",
    "Opteron_SSE3",
    "Barcelona",
    "Bobcat",
    "Bulldozer",
    "Sandybridge",
];

fn better_than(used: &str, units: VectorUnits) -> Option<&'static str> {
    if !WITHOUT_AVX2.iter().any(|old| old.eq_ignore_ascii_case(used)) {
        return None;
    }
    match units {
        VectorUnits { avx512: true, .. } => Some("SkylakeX"),
        VectorUnits { avx2: true, .. } => Some("Haswell"),
        _ => None,
    }
}

/// Sets one thread, once, unless the user has chosen.
pub(super) fn choose_default() {
    CHOSEN.call_once(|| {
        cholmod_sys::blas::set_num_threads(1);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// OpenBLAS 0.3.21 takes a Xeon of 2023 for a Prescott of 2004. Newer kernels, and those that
    /// are not known here, are left in peace, and so is a processor that has no more.
    #[test]
    fn old_kernels_are_found_by_name() {
        let units = |avx2, avx512| VectorUnits { avx2, avx512 };
        assert_eq!(better_than("Prescott", units(true, true)), Some("SkylakeX"));
        assert_eq!(better_than("Nehalem", units(true, false)), Some("Haswell"));
        assert_eq!(better_than("Sandybridge", units(false, false)), None);
        for newer in ["SkylakeX", "Haswell", "Zen", "Cooperlake", "SapphireRapids", "neoversen1"] {
            assert_eq!(better_than(newer, units(true, true)), None, "{newer}");
        }
    }
}
