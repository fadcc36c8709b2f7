//! The OpenMP threads under CHOLMOD.
//!
//! CHOLMOD before 5 (SuiteSparse 7) asks for the number of threads that it was
//! compiled with (Debian: 4) in every supernode, whatever `OMP_NUM_THREADS`
//! says. On two cores that doubles the time of a factorization.

use std::ffi::c_int;

use crate::loaded::symbol;

/// Calls `work` with OpenMP on the calling thread alone, where OpenMP is
/// loaded. Other threads of the process keep their setting.
pub fn serially<R>(work: impl FnOnce() -> R) -> R {
    let _restore = set_max_active_levels(0).map(Restore);
    work()
}

/// Sets the former number of levels when dropped, also by a panic.
struct Restore(c_int);

impl Drop for Restore {
    fn drop(&mut self) {
        set_max_active_levels(self.0);
    }
}

/// Sets how deep parallel regions of this thread may nest (0: not at all) and
/// returns the former number.
fn set_max_active_levels(levels: c_int) -> Option<c_int> {
    let former = max_active_levels()?;
    let address = symbol(c"omp_set_max_active_levels")?;
    // SAFETY: OpenMP declares `void omp_set_max_active_levels(int)`.
    let set: extern "C" fn(c_int) = unsafe { std::mem::transmute(address) };
    set(levels);
    Some(former)
}

fn max_active_levels() -> Option<c_int> {
    let address = symbol(c"omp_get_max_active_levels")?;
    // SAFETY: OpenMP declares `int omp_get_max_active_levels(void)`.
    let get: extern "C" fn() -> c_int = unsafe { std::mem::transmute(address) };
    Some(get())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nothing may nest inside, all is as before outside, after a panic too.
    #[test]
    fn openmp_is_off_inside_and_as_before_outside() {
        // Keeps CHOLMOD, and so its OpenMP, linked into this test.
        assert!(crate::cholmod_version()[0] >= 3);
        let before = max_active_levels();
        if before.is_some() {
            assert_eq!(serially(max_active_levels), Some(0));
        }
        assert_eq!(max_active_levels(), before);
        std::panic::catch_unwind(|| serially(|| panic!("on purpose"))).unwrap_err();
        assert_eq!(max_active_levels(), before);
    }
}
