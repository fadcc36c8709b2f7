//! The GPUs of this machine.

/// A GPU, and what drives it.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct GpuInfo {
    /// Its number, from 0.
    pub device: u32,
    /// Its name.
    pub name: String,
    /// Its memory (bytes).
    pub memory_bytes: u64,
    /// What is free of it (bytes).
    pub memory_free_bytes: u64,
    /// Compute capability.
    pub compute: String,
    /// Number of multiprocessors.
    pub multiprocessors: i32,
    /// Highest clock of the multiprocessors (MHz), if the driver tells.
    pub clock_mhz: Option<i32>,
    /// The driver's own version, if the system tells.
    pub driver: Option<String>,
    /// Version of CUDA that the driver is made for.
    pub driver_cuda: String,
    /// Version of CUDA's runtime.
    pub runtime_cuda: String,
    /// Version of cuBLAS.
    pub cublas: String,
}

/// The GPUs that [`CholmodGpu`](super::CholmodGpu) could use.
///
/// # Errors
/// Why there is none: no driver, one that is too old, no libraries, or a build
/// without the feature `cuda`.
#[cfg(feature = "cuda")]
pub fn gpus() -> Result<Vec<GpuInfo>, String> {
    use cholmod_sys::cuda;

    let count = cuda::devices()?;
    let libraries = cuda::libraries()?;
    let version = |(major, minor): (i32, i32)| format!("{major}.{minor}");
    let driver = driver();
    let (major, minor, patch) = libraries.blas;
    let mut why = "CUDA finds no GPU".to_owned();
    let found: Vec<GpuInfo> = (0..count)
        .filter_map(|number| {
            // One that another program keeps to itself hides no other.
            let device = cuda::use_device(number).map_err(|reason| why = reason).ok()?;
            Some(GpuInfo {
                device: number,
                name: device.name,
                memory_bytes: device.memory,
                memory_free_bytes: device.memory_free,
                compute: version(device.compute),
                multiprocessors: device.multiprocessors,
                clock_mhz: device.clock_khz.map(|khz| khz / 1000),
                driver: driver.clone(),
                driver_cuda: version(libraries.driver),
                runtime_cuda: version(libraries.runtime),
                cublas: format!("{major}.{minor}.{patch}"),
            })
        })
        .collect();
    if found.is_empty() { Err(why) } else { Ok(found) }
}

/// The GPUs that [`CholmodGpu`](super::CholmodGpu) could use.
///
/// # Errors
/// Always: this build lacks the feature `cuda`.
#[cfg(not(feature = "cuda"))]
pub fn gpus() -> Result<Vec<GpuInfo>, String> {
    Err("this program was built without GPU support (feature `cuda`)".to_owned())
}

/// The version in what the driver's kernel module says of itself.
#[cfg(feature = "cuda")]
fn driver() -> Option<String> {
    let text = std::fs::read_to_string("/proc/driver/nvidia/version").ok()?;
    let is_version =
        |word: &&str| word.contains('.') && word.chars().all(|c| c.is_ascii_digit() || c == '.');
    text.lines().next()?.split_whitespace().find(is_version).map(str::to_owned)
}
