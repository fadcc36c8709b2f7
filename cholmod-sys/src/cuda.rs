//! CUDA's libraries and devices, behind the gate that CHOLMOD's GPU module goes
//! through (`cuda/gate.h`).
//!
//! The libraries are looked for when they are first asked for. A program that
//! never asks needs none of them.

use std::env;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Names a folder where CUDA's libraries are looked for before any other.
pub const FOLDER_VARIABLE: &str = "DEMPFV_CUDA_LIBRARIES";

/// What went to a device and came from it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Ledger {
    /// Bytes copied to the device.
    pub bytes_to_device: u64,
    /// Bytes copied from the device.
    pub bytes_from_device: u64,
    /// Calls of cuBLAS.
    pub blas_calls: u64,
    /// Floating point operations of those calls.
    pub blas_flops: f64,
    error: c_int,
    what: [c_char; 160],
}

impl Ledger {
    /// The first error since the ledger was opened: which function, and why.
    pub fn error(&self) -> Option<String> {
        (self.error != 0).then(|| text(&self.what))
    }
}

#[repr(C)]
struct RawDevice {
    name: [c_char; 256],
    memory: u64,
    memory_free: u64,
    compute_major: c_int,
    compute_minor: c_int,
    multiprocessors: c_int,
    clock_khz: c_int,
}

unsafe extern "C" {
    fn gate_cuda_major() -> c_int;
    fn gate_load(library: c_int, path: *const c_char) -> *const c_char;
    fn gate_runtime_version() -> c_int;
    fn gate_driver_version() -> c_int;
    fn gate_blas_version() -> c_int;
    fn gate_reset();
    fn gate_read(ledger: *mut Ledger);
    fn gate_devices() -> c_int;
    fn gate_use_device(device: c_int, description: *mut RawDevice) -> c_int;
    fn gate_error_text(error: c_int) -> *const c_char;
    fn gate_allocate(
        device: *mut *mut c_void,
        device_bytes: usize,
        host: *mut *mut c_void,
        host_bytes: usize,
    ) -> c_int;
    fn gate_release(device: *mut c_void, host: *mut c_void);
}

/// A device as CUDA describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Device {
    /// Its number.
    pub number: u32,
    /// Its name.
    pub name: String,
    /// Its memory (bytes).
    pub memory: u64,
    /// What is free of it (bytes).
    pub memory_free: u64,
    /// Compute capability: major and minor.
    pub compute: (i32, i32),
    /// Number of multiprocessors.
    pub multiprocessors: i32,
    /// Highest clock of the multiprocessors (kHz), if the driver tells.
    pub clock_khz: Option<i32>,
}

/// CUDA's libraries, loaded.
#[derive(Clone, Debug, PartialEq)]
pub struct Libraries {
    /// Version of CUDA's runtime, major and minor.
    pub runtime: (i32, i32),
    /// Version of CUDA that the driver is made for, major and minor.
    pub driver: (i32, i32),
    /// Version of cuBLAS: major, minor, patch.
    pub blas: (i32, i32, i32),
}

/// Loads CUDA's libraries, once for the process.
///
/// # Errors
/// Which one is not there or of no use, and where it was looked for.
pub fn libraries() -> Result<&'static Libraries, &'static str> {
    static LOADED: OnceLock<Result<Libraries, String>> = OnceLock::new();
    LOADED.get_or_init(load).as_ref().map_err(String::as_str)
}

/// The driver's library.
const DRIVER: &str = "libcuda.so.1";

fn load() -> Result<Libraries, String> {
    // SAFETY: the function has no arguments and no effect.
    let major = unsafe { gate_cuda_major() };
    load_library(0, DRIVER, "there is no NVIDIA driver")?;
    load_library(1, &format!("libcudart.so.{major}"), &format!("CUDA {major} is not installed"))?;
    load_library(2, &format!("libcublas.so.{major}"), &format!("cuBLAS {major} is not installed"))?;
    // SAFETY: the functions have no arguments; the libraries are loaded.
    let (runtime, driver, blas) =
        unsafe { (gate_runtime_version(), gate_driver_version(), gate_blas_version()) };
    let parts = |version: c_int| (version / 1000, version % 1000 / 10);
    let blas = (blas / 10000, blas / 100 % 100, blas % 100);
    Ok(Libraries { runtime: parts(runtime), driver: parts(driver), blas })
}

/// Loads a library from the first place that has it.
fn load_library(library: c_int, name: &str, missing: &str) -> Result<(), String> {
    let mut why = String::new();
    for path in candidates(name) {
        let Ok(c_path) = CString::new(path.to_string_lossy().as_bytes()) else { continue };
        // SAFETY: the path ends in NUL. One thread at a time is here: the
        // caller initializes a OnceLock.
        let complaint = unsafe { gate_load(library, c_path.as_ptr()) };
        if complaint.is_null() {
            return Ok(());
        }
        // A file that is there and useless says more than one that is not.
        if why.is_empty() || path.is_file() {
            // SAFETY: a complaint ends in NUL and lives until the next call.
            why = unsafe { CStr::from_ptr(complaint) }.to_string_lossy().into_owned();
        }
    }
    Err(format!("{missing} ({why})"))
}

/// Where a library may lie, the likeliest places first.
fn candidates(name: &str) -> Vec<PathBuf> {
    if let Some(folder) = env::var_os(FOLDER_VARIABLE).filter(|folder| !folder.is_empty()) {
        let there = Path::new(&folder).join(name);
        // The driver's library is never where CUDA's are.
        return if name == DRIVER { vec![there, name.into()] } else { vec![there] };
    }
    // The bare name: where the system's loader looks.
    let mut paths = vec![PathBuf::from(name)];
    if let Some(folder) = env::current_exe().ok().as_deref().and_then(Path::parent) {
        paths.push(folder.join("lib").join(name));
    }
    let installed = ["CUDA_PATH", "CUDA_HOME"].into_iter().filter_map(env::var_os);
    for folder in installed.map(PathBuf::from).chain([PathBuf::from("/usr/local/cuda")]) {
        paths.push(folder.join("lib64").join(name));
        paths.push(folder.join("lib").join(name));
    }
    paths.push(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(FETCHED).join(name));
    paths
}

/// Where `make cuda` puts what it fetches, seen from this crate.
const FETCHED: &str = "../cuda/toolkit/nvidia/cu13/lib";

/// Number of devices.
///
/// # Errors
/// As [`libraries`]; and CUDA's reason why there is none, such as a driver that
/// is too old.
pub fn devices() -> Result<u32, String> {
    libraries()?;
    // SAFETY: the libraries are loaded.
    let count = unsafe { gate_devices() };
    u32::try_from(count).map_err(|_| format!("CUDA finds no GPU: {}", error_text(-count)))
}

/// Makes a device the calling thread's, and describes it.
///
/// # Errors
/// As [`devices`]; there is no device of this number, or it does not answer.
pub fn use_device(number: u32) -> Result<Device, String> {
    let count = devices()?;
    if number >= count {
        return Err(format!("there is no GPU {number}; CUDA finds {count}, numbered from 0"));
    }
    // SAFETY: the struct is plain data; zero is a value of each of its fields.
    let mut raw: RawDevice = unsafe { std::mem::zeroed() };
    // SAFETY: `raw` has the layout that the gate writes, and the libraries are
    // loaded. The number is below the count, which is an int.
    let error = unsafe { gate_use_device(number as c_int, &mut raw) };
    if error != 0 {
        return Err(format!("GPU {number} does not answer: {}", error_text(error)));
    }
    Ok(Device {
        number,
        name: text(&raw.name),
        memory: raw.memory,
        memory_free: raw.memory_free,
        compute: (raw.compute_major, raw.compute_minor),
        multiprocessors: raw.multiprocessors,
        clock_khz: (raw.clock_khz > 0).then_some(raw.clock_khz),
    })
}

/// Opens an empty ledger for the calling thread.
pub fn open_ledger() {
    // SAFETY: the function touches the thread's own ledger alone.
    unsafe { gate_reset() };
}

/// What the calling thread has sent through the gate since
/// [`open_ledger`]; waits until the device is done with it.
pub fn read_ledger() -> Ledger {
    // SAFETY: zero is a value of each of the struct's fields.
    let mut ledger: Ledger = unsafe { std::mem::zeroed() };
    // SAFETY: `ledger` has the layout that the gate writes.
    unsafe { gate_read(&mut ledger) };
    ledger
}

/// Memory on a device and memory of the host that the device can reach; given
/// back when dropped.
#[derive(Debug)]
pub struct Pools {
    device: *mut c_void,
    host: *mut c_void,
}

// SAFETY: the memory belongs to this object alone, and CUDA's allocations
// belong to the process and not to a thread.
unsafe impl Send for Pools {}

impl Pools {
    /// Allocates both, in bytes, on the calling thread's device.
    ///
    /// # Errors
    /// CUDA's reason, memory that is short for one.
    pub fn new(device_bytes: usize, host_bytes: usize) -> Result<Pools, String> {
        libraries()?;
        let mut pools = Pools { device: std::ptr::null_mut(), host: std::ptr::null_mut() };
        // SAFETY: the pointers are written, and freed by `drop` alone.
        let error =
            unsafe { gate_allocate(&mut pools.device, device_bytes, &mut pools.host, host_bytes) };
        if error == 0 { Ok(pools) } else { Err(error_text(error)) }
    }

    /// The memory on the device.
    pub fn device(&self) -> *mut c_void {
        self.device
    }

    /// The memory of the host.
    pub fn host(&self) -> *mut c_void {
        self.host
    }
}

impl Drop for Pools {
    fn drop(&mut self) {
        // SAFETY: both were allocated by the gate or are null.
        unsafe { gate_release(self.device, self.host) };
    }
}

fn error_text(error: c_int) -> String {
    // SAFETY: the function returns a static string for any number.
    unsafe { CStr::from_ptr(gate_error_text(error)) }.to_string_lossy().into_owned()
}

/// The text in an array that a NUL ends.
fn text(chars: &[c_char]) -> String {
    let bytes: Vec<u8> = chars.iter().take_while(|&&c| c != 0).map(|&c| c as u8).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}
