//! Where a factorization was computed.

use serde::Serialize;

/// What a solver that works on a GPU takes for itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, serde::Deserialize)]
pub struct GpuOptions {
    /// Number of the device, as CUDA counts them from 0.
    pub device: u32,
    /// Most memory that is taken on the device (bytes); `None`: 40 % of what is
    /// free when the first matrix is factored.
    pub memory: Option<u64>,
}

/// Where a factorization was computed.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(tag = "device", rename_all = "lowercase")]
pub enum Placement {
    /// On the CPU, which is all that the solver uses.
    #[default]
    Cpu,
    /// In part on a GPU: the solver's own counters say so.
    Gpu(GpuWork),
    /// On the CPU, although a GPU was asked for.
    Fallback {
        /// Why, in one line.
        reason: String,
    },
}

/// What a GPU did for one factorization.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct GpuWork {
    /// Name of the device.
    pub name: String,
    /// Updates by rank k that CHOLMOD gave to the GPU.
    pub syrk_calls: u64,
    /// Products that CHOLMOD gave to the GPU.
    pub gemm_calls: u64,
    /// Dense factorizations that CHOLMOD gave to the GPU.
    pub potrf_calls: u64,
    /// Triangular solves that CHOLMOD gave to the GPU.
    pub trsm_calls: u64,
    /// Floating point operations of all calls of cuBLAS.
    pub flops: f64,
    /// The same over those of the whole factorization (1); may exceed 1 by the
    /// zeros that supernodes hold.
    pub share: f64,
    /// Calls of cuBLAS that went through; CHOLMOD counts some that it then skips.
    pub blas_calls: u64,
    /// Bytes copied to the device.
    pub bytes_to_device: u64,
    /// Bytes copied from the device.
    pub bytes_from_device: u64,
    /// Memory that is held on the device (bytes).
    pub memory: u64,
}

impl GpuWork {
    /// All calls that CHOLMOD gave to the GPU.
    pub fn calls(&self) -> u64 {
        self.syrk_calls + self.gemm_calls + self.potrf_calls + self.trsm_calls
    }
}
