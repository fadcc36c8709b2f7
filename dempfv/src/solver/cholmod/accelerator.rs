//! A GPU that a factor may use; without the feature `cuda` there is none.

use super::super::{GpuOptions, Placement, SymmetricCsc};
use super::raw::{Fault, Raw};

#[cfg(feature = "cuda")]
use super::gpu;

/// The GPU that a factor's user asked for.
pub(super) struct Accelerator {
    #[cfg(feature = "cuda")]
    options: GpuOptions,
    #[cfg(feature = "cuda")]
    session: std::sync::Arc<std::sync::Mutex<gpu::Session>>,
}

#[cfg(feature = "cuda")]
impl Accelerator {
    pub(super) fn new(options: GpuOptions) -> Accelerator {
        Accelerator { options, session: gpu::session(options) }
    }

    /// Factors a matrix, there if that goes well and else on the CPU.
    pub(super) fn factorize(
        &self,
        raw: &mut Raw,
        a: &SymmetricCsc,
    ) -> (Result<(), Fault>, Placement) {
        gpu::factorize(raw, a, self.options, &self.session)
    }
}

#[cfg(not(feature = "cuda"))]
impl Accelerator {
    pub(super) fn new(_: GpuOptions) -> Accelerator {
        Accelerator {}
    }

    /// Factors a matrix on the CPU.
    pub(super) fn factorize(
        &self,
        raw: &mut Raw,
        a: &SymmetricCsc,
    ) -> (Result<(), Fault>, Placement) {
        let reason = "this program was built without GPU support (feature `cuda`)".to_owned();
        (raw.factorize(a), Placement::Fallback { reason })
    }
}
