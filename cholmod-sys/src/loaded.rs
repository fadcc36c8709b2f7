//! Functions that the process may or may not have loaded, by name.

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
pub(crate) fn symbol(name: &CStr) -> Option<*mut c_void> {
    // SAFETY: a null handle (RTLD_DEFAULT) searches what is loaded; the name
    // ends in NUL.
    let address = unsafe { dlsym(std::ptr::null_mut(), name.as_ptr()) };
    (!address.is_null()).then_some(address)
}

/// The file that provides a symbol.
pub(crate) fn file_of(name: &CStr) -> Option<String> {
    let address = symbol(name)?;
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
