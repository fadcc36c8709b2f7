//! The BLAS under CHOLMOD.
//!
//! Debian's BLAS is an alternative: the library behind `libblas.so.3` is only
//! known at run time, so what OpenBLAS offers beyond the standard is looked up
//! by name.

use std::ffi::{CStr, c_char, c_int, c_void};

#[repr(C)]
struct DlInfo {
    file: *const c_char,
    base: *mut c_void,
    symbol: *const c_char,
    address: *mut c_void,
}

unsafe extern "C" {
    fn dlsym(handle: *mut c_void, name: *const c_char) -> *mut c_void;
    fn dladdr(address: *const c_void, info: *mut DlInfo) -> c_int;
}

/// Address of a symbol in the libraries that the process has loaded.
fn symbol(name: &CStr) -> Option<*mut c_void> {
    // SAFETY: a null handle (RTLD_DEFAULT) searches what is loaded; the name
    // ends in NUL.
    let address = unsafe { dlsym(std::ptr::null_mut(), name.as_ptr()) };
    (!address.is_null()).then_some(address)
}

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

/// The file that provides `dgemm`.
pub fn library_path() -> Option<String> {
    let address = symbol(c"dgemm_")?;
    let mut info = DlInfo {
        file: std::ptr::null(),
        base: std::ptr::null_mut(),
        symbol: std::ptr::null(),
        address: std::ptr::null_mut(),
    };
    // SAFETY: the address is a symbol's and `info` has the layout of Dl_info.
    let found = unsafe { dladdr(address, &mut info) };
    if found == 0 || info.file.is_null() {
        return None;
    }
    // SAFETY: dladdr filled in a string that lives as long as the library,
    // which is never unloaded.
    Some(unsafe { CStr::from_ptr(info.file) }.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CHOLMOD needs a BLAS, so there is one to describe; where it is OpenBLAS
    /// the number of threads that was set is the one that is told.
    #[test]
    fn blas_is_named_and_takes_threads() {
        // Keeps the library, and so the BLAS, linked into this test.
        assert!(crate::cholmod_version()[0] >= 3);
        assert!(library_path().is_some_and(|path| path.contains("blas")));
        assert!(!description().is_empty());
        if set_num_threads(1) {
            assert_eq!(num_threads(), Some(1));
        } else {
            assert_eq!(num_threads(), None);
        }
    }
}
