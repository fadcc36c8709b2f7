//! Raw bindings to CHOLMOD (64-bit indices, `cholmod_l_*`) and METIS, generated
//! at build time against the installed headers, and the little that one must
//! know about the BLAS under CHOLMOD.
//!
//! Struct layouts differ between versions of SuiteSparse; never assume one.

#[allow(non_camel_case_types, non_snake_case, non_upper_case_globals, missing_docs, clippy::all)]
mod bindings {
    include!(concat!(env!("OUT_DIR"), "/bindings.rs"));
}

pub mod blas;
#[cfg(feature = "cuda")]
pub mod cuda;
mod loaded;
pub mod openmp;

pub use bindings::*;

/// Version of the SuiteSparse headers that the crate was built against.
pub const SUITESPARSE_HEADER_VERSION: [u32; 3] =
    [SUITESPARSE_MAIN_VERSION, SUITESPARSE_SUB_VERSION, SUITESPARSE_SUBSUB_VERSION];

/// Version of the METIS headers that the crate was built against.
pub const METIS_HEADER_VERSION: [u32; 3] = [METIS_VER_MAJOR, METIS_VER_MINOR, METIS_VER_SUBMINOR];

/// Version of the CHOLMOD that the process has loaded: main, sub, subsub.
pub fn cholmod_version() -> [i32; 3] {
    let mut version = [0; 3];
    // SAFETY: the function writes three ints and has no other effect.
    unsafe { cholmod_l_version(version.as_mut_ptr()) };
    version
}

/// Version of the SuiteSparse that the process has loaded: main, sub, subsub.
pub fn suitesparse_version() -> [i32; 3] {
    let mut version = [0; 3];
    // SAFETY: the function writes three ints and has no other effect.
    unsafe { SuiteSparse_version(version.as_mut_ptr()) };
    version
}

/// Limits the OpenMP threads of calls with this common. CHOLMOD before 5
/// (SuiteSparse 7) cannot be told; see [`openmp`].
#[cfg_attr(not(openmp_threads), expect(unused_variables))]
pub fn set_openmp_threads(common: &mut cholmod_common, threads: i32) {
    #[cfg(openmp_threads)]
    {
        common.nthreads_max = threads;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A minor or major version that differs means that the bindings describe
    /// other structs than the library uses.
    #[test]
    fn loaded_library_is_the_one_of_the_headers() {
        let header = [CHOLMOD_MAIN_VERSION as i32, CHOLMOD_SUB_VERSION as i32];
        assert_eq!(cholmod_version()[..2], header);
        let header = [SUITESPARSE_MAIN_VERSION as i32, SUITESPARSE_SUB_VERSION as i32];
        assert_eq!(suitesparse_version()[..2], header);
    }

    /// The library writes into `cholmod_common` what the bindings read.
    #[test]
    fn start_sets_the_defaults_of_the_manual() {
        // SAFETY: the common is started before it is read, and finished once.
        unsafe {
            let mut common = Box::<cholmod_common>::new(std::mem::zeroed());
            assert_eq!(cholmod_l_start(&mut *common), 1);
            assert_eq!(common.supernodal, CHOLMOD_AUTO as i32);
            assert_eq!(common.supernodal_switch, 40.0);
            assert_eq!(common.postorder, 1);
            assert_eq!(common.status, CHOLMOD_OK as i32);
            assert_eq!(common.itype, CHOLMOD_LONG as i32);
            assert_eq!(cholmod_l_finish(&mut *common), 1);
        }
    }

    /// Nested dissection of a 3 x 3 grid gives a permutation and its inverse.
    #[test]
    fn metis_orders_a_grid() {
        let mut start: Vec<idx_t> = vec![0];
        let mut neighbor: Vec<idx_t> = Vec::new();
        for (x, y) in (0..3i32).flat_map(|y| (0..3i32).map(move |x| (x, y))) {
            for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1)] {
                let (u, v) = (x + dx, y + dy);
                if (0..3).contains(&u) && (0..3).contains(&v) {
                    neighbor.push((u + 3 * v) as idx_t);
                }
            }
            start.push(neighbor.len() as idx_t);
        }
        let (mut n, mut perm, mut inverse) = (9 as idx_t, [0 as idx_t; 9], [0 as idx_t; 9]);
        // SAFETY: the arrays have the sizes that METIS asks for; null weights
        // and options are allowed.
        let status = unsafe {
            METIS_NodeND(
                &mut n,
                start.as_mut_ptr(),
                neighbor.as_mut_ptr(),
                std::ptr::null_mut(),
                std::ptr::null_mut(),
                perm.as_mut_ptr(),
                inverse.as_mut_ptr(),
            )
        };
        assert_eq!(status, METIS_OK);
        for i in 0..9 {
            assert_eq!(inverse[perm[i] as usize] as usize, i);
        }
    }
}
