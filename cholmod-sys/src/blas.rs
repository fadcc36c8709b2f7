//! The BLAS under CHOLMOD.
//!
//! Debian's BLAS is an alternative: the library behind `libblas.so.3` is only
//! known at run time, so what OpenBLAS offers beyond the standard is looked up
//! by name.

use std::ffi::{CStr, c_char, c_int};

use crate::loaded::{file_of, symbol};

/// Sets the number of BLAS threads, for the whole process.
///
/// Returns false where the loaded BLAS is not OpenBLAS: nothing was set then
/// (the reference BLAS and BLIS run on one thread by themselves). Not to be
/// called while another thread is inside the BLAS.
pub fn set_num_threads(threads: usize) -> bool {
    let Some(address) = symbol(c"openblas_set_num_threads") else { return false };
    // SAFETY: OpenBLAS declares `void openblas_set_num_threads(int)`.
    let set: extern "C" fn(c_int) = unsafe { std::mem::transmute(address) };
    set(c_int::try_from(threads.max(1)).unwrap_or(c_int::MAX));
    true
}

/// Number of threads that the BLAS uses; `None` where it is not OpenBLAS.
pub fn num_threads() -> Option<usize> {
    let address = symbol(c"openblas_get_num_threads")?;
    // SAFETY: OpenBLAS declares `int openblas_get_num_threads(void)`.
    let get: extern "C" fn() -> c_int = unsafe { std::mem::transmute(address) };
    usize::try_from(get()).ok()
}

/// Which BLAS is loaded: what OpenBLAS says of itself (version, options,
/// processor), else the file that provides `dgemm`.
pub fn description() -> String {
    if let Some(address) = symbol(c"openblas_get_config") {
        // SAFETY: OpenBLAS declares `char *openblas_get_config(void)`; the
        // string is static and ends in NUL.
        let text = unsafe {
            let get: extern "C" fn() -> *const c_char = std::mem::transmute(address);
            CStr::from_ptr(get())
        };
        return text.to_string_lossy().trim().to_owned();
    }
    library_path().unwrap_or_else(|| "unknown BLAS".to_owned())
}

/// The processor that the kernels in use are made for, by OpenBLAS's name for it; `None` where the
/// BLAS is not OpenBLAS.
pub fn kernels() -> Option<String> {
    let address = symbol(c"openblas_get_corename")?;
    // SAFETY: OpenBLAS declares `char *openblas_get_corename(void)`; the string is static and ends
    // in NUL.
    let name = unsafe {
        let get: extern "C" fn() -> *const c_char = std::mem::transmute(address);
        CStr::from_ptr(get())
    };
    Some(name.to_string_lossy().into_owned())
}

/// The file that provides `dgemm`.
pub fn library_path() -> Option<String> {
    file_of(c"dgemm_")
}

/// A type that the BLAS multiplies matrices of.
pub trait Real: Copy + Default {
    #[doc(hidden)]
    const GEMM: &'static CStr;
    #[doc(hidden)]
    const ONE: Self;
}

impl Real for f64 {
    const GEMM: &'static CStr = c"dgemm_";
    const ONE: f64 = 1.0;
}

impl Real for f32 {
    const GEMM: &'static CStr = c"sgemm_";
    const ONE: f32 = 1.0;
}

/// C = A B of square matrices by columns: how fast this goes is what a machine can be held
/// against. Returns false where no BLAS is loaded, or the three are not n x n.
pub fn multiply<T: Real>(n: usize, a: &[T], b: &[T], c: &mut [T]) -> bool {
    type Gemm<T> = unsafe extern "C" fn(
        *const c_char,
        *const c_char,
        *const c_int,
        *const c_int,
        *const c_int,
        *const T,
        *const T,
        *const c_int,
        *const T,
        *const c_int,
        *const T,
        *mut T,
        *const c_int,
    );
    let (Some(address), Ok(size)) = (symbol(T::GEMM), c_int::try_from(n)) else { return false };
    if [a.len(), b.len(), c.len()] != [n * n; 3] {
        return false;
    }
    let (plain, one, zero) = (b'N' as c_char, T::ONE, T::default());
    // SAFETY: the BLAS declares `xgemm_` so, for the type that GEMM is named after; each
    // matrix has n columns of n entries, as was checked.
    unsafe {
        let gemm: Gemm<T> = std::mem::transmute(address);
        let (a, b, c, size) = (a.as_ptr(), b.as_ptr(), c.as_mut_ptr(), &raw const size);
        let (t, one, zero) = (&raw const plain, &raw const one, &raw const zero);
        gemm(t, t, size, size, size, one, a, size, b, size, zero, c, size);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: (1 3; 2 4)(5 7; 6 8) by columns.
    #[test]
    fn matrices_are_multiplied() {
        std::hint::black_box(crate::cholmod_l_factorize as *const ());
        let mut c = [0.0; 4];
        assert!(multiply(2, &[1.0, 2.0, 3.0, 4.0], &[5.0, 6.0, 7.0, 8.0], &mut c));
        assert_eq!(c, [23.0, 34.0, 31.0, 46.0]);
        let mut c = [0.0_f32; 1];
        assert!(multiply(1, &[3.0], &[2.0], &mut c) && c == [6.0]);
        assert!(!multiply(2, &[1.0_f32], &[2.0], &mut c));
    }

    /// CHOLMOD needs a BLAS, so there is one to describe; where it is OpenBLAS
    /// the number of threads that was set is the one that is told.
    #[test]
    fn blas_is_named_and_takes_threads() {
        // Keeps the factorization, and so the BLAS, linked into this test.
        std::hint::black_box(crate::cholmod_l_factorize as *const ());
        assert!(library_path().is_some_and(|path| path.contains("blas")));
        assert!(!description().is_empty());
        if set_num_threads(1) {
            assert_eq!(num_threads(), Some(1));
            assert!(kernels().is_some_and(|name| description().contains(&name)));
        } else {
            assert_eq!((num_threads(), kernels()), (None, None));
        }
    }
}
