//! METIS, whose ordering faer gets: its own one, minimum degree, fills these graphs more.

use std::ffi::c_int;

unsafe extern "C" {
    fn METIS_NodeND(
        vertices: *mut c_int,
        starts: *mut c_int,
        neighbours: *mut c_int,
        weights: *mut c_int,
        options: *mut c_int,
        permutation: *mut c_int,
        inverse: *mut c_int,
    ) -> c_int;
}

/// What METIS returns when all went well.
const OK: c_int = 1;

/// Nested dissection of a graph: entry k is the vertex that is eliminated as the k-th.
///
/// `starts` and `neighbours` hold the neighbours of each vertex, without itself, in both
/// directions.
pub fn order(starts: &mut [c_int], neighbours: &mut [c_int]) -> Result<Vec<usize>, String> {
    let n = starts.len() - 1;
    let mut vertices = c_int::try_from(n).map_err(|_| "too many unknowns for METIS")?;
    let complete = starts[n] as usize == neighbours.len()
        && starts.windows(2).all(|p| 0 <= p[0] && p[0] <= p[1])
        && neighbours.iter().all(|&v| (0..vertices).contains(&v));
    if !complete {
        return Err("the graph is malformed".to_owned());
    }
    let (mut permutation, mut inverse) = (vec![0; n], vec![0; n]);
    // SAFETY: Debian's METIS has 32-bit indices (idx_t); the graph was checked above; no
    // weights and no options are given as null, which its manual allows; both results have
    // one entry per vertex.
    let status = unsafe {
        METIS_NodeND(
            &raw mut vertices,
            starts.as_mut_ptr(),
            neighbours.as_mut_ptr(),
            std::ptr::null_mut(),
            std::ptr::null_mut(),
            permutation.as_mut_ptr(),
            inverse.as_mut_ptr(),
        )
    };
    if status != OK {
        return Err(format!("METIS ends with status {status}"));
    }
    Ok(permutation.into_iter().map(|v| v as usize).collect())
}
