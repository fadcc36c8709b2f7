//! What a GPU did for a simulation.

use serde::Serialize;

use crate::solver::{GpuWork, Placement};

/// What became of the factorizations for which a GPU was asked, since the
/// simulation began or was restarted.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct GpuUse {
    /// Factorizations in which the GPU did a part.
    pub factorizations: u64,
    /// Factorizations that the CPU had to do.
    pub fallbacks: u64,
    /// Why it had to, the last time.
    pub reason: Option<String>,
    /// The GPU's work in all, with its share of the last factorization.
    #[serde(flatten)]
    pub work: Option<GpuWork>,
}

impl GpuUse {
    /// Books a factorization.
    pub(super) fn book(&mut self, placement: &Placement) {
        match placement {
            Placement::Cpu => {}
            Placement::Fallback { reason } => {
                self.fallbacks += 1;
                self.reason = Some(reason.clone());
            }
            Placement::Gpu(new) => {
                self.factorizations += 1;
                let old = self.work.take().unwrap_or_default();
                self.work = Some(GpuWork {
                    syrk_calls: old.syrk_calls + new.syrk_calls,
                    gemm_calls: old.gemm_calls + new.gemm_calls,
                    potrf_calls: old.potrf_calls + new.potrf_calls,
                    trsm_calls: old.trsm_calls + new.trsm_calls,
                    flops: old.flops + new.flops,
                    blas_calls: old.blas_calls + new.blas_calls,
                    bytes_to_device: old.bytes_to_device + new.bytes_to_device,
                    bytes_from_device: old.bytes_from_device + new.bytes_from_device,
                    ..new.clone()
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Work adds up, the share is the last one's, and a fallback keeps its reason.
    #[test]
    fn factorizations_add_up() {
        let work = |syrk_calls, share| GpuWork { syrk_calls, share, ..GpuWork::default() };
        let mut found = GpuUse::default();
        found.book(&Placement::Gpu(work(3, 0.5)));
        found.book(&Placement::Fallback { reason: "memory".to_owned() });
        found.book(&Placement::Gpu(work(4, 0.25)));
        found.book(&Placement::Cpu);
        assert_eq!((found.factorizations, found.fallbacks), (2, 1));
        assert_eq!(found.reason.as_deref(), Some("memory"));
        assert_eq!(found.work, Some(work(7, 0.25)));
    }
}
