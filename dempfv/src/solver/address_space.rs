//! Room for the BLAS where the address space of the process is limited.
//!
//! OpenBLAS takes a buffer for each thread that calls it, and where the system refuses it asks again
//! without end. So the room is looked for before.

use std::hint::black_box;
use std::sync::atomic::{AtomicBool, Ordering};

use super::SolverError;

/// A buffer of OpenBLAS 0.3.21 on x86-64 in whole pages, as the system is asked for it.
const BUFFER_BYTES: u64 = (128 << 20) + 2 * 4096;

/// Rows of matrices whose product OpenBLAS needs its buffer for: it multiplies smaller ones without.
const ROWS: usize = 128;

/// Whether the BLAS has its buffer, which it keeps.
static HAS_BUFFER: AtomicBool = AtomicBool::new(false);

/// The most address space that the system gives this process (`ulimit -v`), in bytes; `None` where it
/// sets no limit, or does not tell.
pub fn address_space_limit() -> Option<u64> {
    limit_in(&std::fs::read_to_string("/proc/self/limits").ok()?)
}

fn limit_in(limits: &str) -> Option<u64> {
    let values = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    values.split_whitespace().next()?.parse().ok()
}

/// Address space in use (bytes).
fn used() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let size = status.lines().find_map(|line| line.strip_prefix("VmSize:"))?;
    Some(size.split_whitespace().next()?.parse::<u64>().ok()? * 1024)
}

/// Lets the BLAS take its buffer for this solver while there is room for it.
///
/// # Errors
/// There is not.
pub(super) fn reserve_buffer(solver: &'static str) -> Result<(), SolverError> {
    if HAS_BUFFER.load(Ordering::Relaxed) || cholmod_sys::blas::num_threads().is_none() {
        return Ok(());
    }
    if let (Some(limit), Some(used)) = (address_space_limit(), used()) {
        let left = limit.saturating_sub(used);
        if left < BUFFER_BYTES {
            return Err(SolverError::AddressSpace { solver, needed: BUFFER_BYTES, left });
        }
    }
    let (a, b, mut c) = (vec![0.0; ROWS * ROWS], vec![0.0; ROWS * ROWS], vec![0.0; ROWS * ROWS]);
    black_box(cholmod_sys::blas::multiply::<f64>(ROWS, &a, &b, &mut c));
    HAS_BUFFER.store(true, Ordering::Relaxed);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines as Linux writes them.
    #[test]
    fn limit_is_read_where_there_is_one() {
        let lines = |value| {
            format!(
                "Limit                     Soft Limit           Hard Limit           Units     \n\
                 Max locked memory         8388608              8388608              bytes     \n\
                 Max address space         {value}            unlimited            bytes     \n"
            )
        };
        assert_eq!(limit_in(&lines("307200000")), Some(307_200_000));
        assert_eq!(limit_in(&lines("unlimited")), None);
        assert_eq!(limit_in(""), None);
    }
}
