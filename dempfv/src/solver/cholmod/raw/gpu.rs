//! The thin wrapper around CHOLMOD's GPU module.
//!
//! CHOLMOD keeps what belongs to the GPU in its common. Here each factor has a
//! common of its own, and the GPU's part is lent to it for one factorization:
//! two networks then share one set of pools.

use std::ffi::{c_int, c_void};
use std::ptr;

use cholmod_sys as sys;
use cholmod_sys::cuda::Pools;

use super::super::super::SymmetricCsc;
use super::{Fault, Raw, configure, sparse_view};
use crate::calls;

/// Buffers that CHOLMOD cuts its pools into, on the device and on the host.
pub(in super::super) const DEVICE_BUFFERS: usize = 6;
pub(in super::super) const HOST_BUFFERS: usize = 8;

/// CHOLMOD rounds its buffers down to multiples of this (bytes).
pub(in super::super) const BUFFER_UNIT: usize = 0x20000;

/// Columns of a supernode, and rows below them, from which on CHOLMOD gives its
/// updates to a GPU.
const LEAST_COLUMNS: usize = 32;
const LEAST_ROWS: usize = 256;

/// Calls that CHOLMOD counted in one factorization.
#[derive(Clone, Copy, Debug, Default)]
pub(in super::super) struct Calls {
    pub syrk: u64,
    pub gemm: u64,
    pub potrf: u64,
    pub trsm: u64,
}

/// The pools and what CHOLMOD makes on a device: the handle of cuBLAS, streams
/// and events.
pub(in super::super) struct Lendable {
    pools: Pools,
    buffer: usize,
    blas: *mut c_void,
    streams: [*mut c_void; HOST_BUFFERS],
    events: [*mut c_void; 3],
    complete: *mut c_void,
    free: [*mut c_void; HOST_BUFFERS],
}

// SAFETY: the pointers belong to this object alone, and CUDA's objects belong to
// the process and not to a thread.
unsafe impl Send for Lendable {}

impl Lendable {
    /// Takes memory for buffers of so many bytes, a multiple of
    /// [`BUFFER_UNIT`], on the calling thread's device.
    ///
    /// # Errors
    /// CUDA's reason.
    pub(in super::super) fn new(buffer: usize) -> Result<Lendable, String> {
        Ok(Lendable {
            pools: Pools::new(buffer * DEVICE_BUFFERS, buffer * HOST_BUFFERS)?,
            buffer,
            blas: ptr::null_mut(),
            streams: [ptr::null_mut(); HOST_BUFFERS],
            events: [ptr::null_mut(); 3],
            complete: ptr::null_mut(),
            free: [ptr::null_mut(); HOST_BUFFERS],
        })
    }

    /// Bytes of a buffer.
    pub(in super::super) fn buffer(&self) -> usize {
        self.buffer
    }

    /// Puts everything into a common.
    fn lend(&self, common: &mut sys::cholmod_common) {
        common.useGPU = 1;
        common.dev_mempool = self.pools.device();
        common.dev_mempool_size = self.buffer * DEVICE_BUFFERS;
        common.host_pinned_mempool = self.pools.host();
        common.host_pinned_mempool_size = self.buffer * HOST_BUFFERS;
        common.devBuffSize = self.buffer;
        common.cublasHandle = self.blas;
        common.gpuStream = self.streams;
        common.cublasEventPotrf = self.events;
        common.updateCKernelsComplete = self.complete;
        common.updateCBuffersFree = self.free;
    }

    /// Takes it back: the common neither uses nor frees it any more.
    fn take_back(&mut self, common: &mut sys::cholmod_common) {
        self.blas = std::mem::replace(&mut common.cublasHandle, ptr::null_mut());
        self.streams = std::mem::replace(&mut common.gpuStream, [ptr::null_mut(); HOST_BUFFERS]);
        self.events = std::mem::replace(&mut common.cublasEventPotrf, [ptr::null_mut(); 3]);
        self.complete = std::mem::replace(&mut common.updateCKernelsComplete, ptr::null_mut());
        self.free =
            std::mem::replace(&mut common.updateCBuffersFree, [ptr::null_mut(); HOST_BUFFERS]);
        common.useGPU = 0;
        common.dev_mempool = ptr::null_mut();
        common.dev_mempool_size = 0;
        common.host_pinned_mempool = ptr::null_mut();
        common.host_pinned_mempool_size = 0;
    }
}

impl Drop for Lendable {
    fn drop(&mut self) {
        // SAFETY: as in `Raw::analyze`. The common destroys what CHOLMOD made;
        // the pools are not in it, and are freed after this.
        unsafe {
            let mut common = Box::new(std::mem::zeroed::<sys::cholmod_common>());
            sys::cholmod_l_start(&mut *common);
            configure(&mut common);
            self.lend(&mut common);
            common.dev_mempool = ptr::null_mut();
            common.host_pinned_mempool = ptr::null_mut();
            sys::cholmod_l_finish(&mut *common);
        }
    }
}

impl Raw {
    /// Bytes of a buffer in which every supernode has room; `None` where none is
    /// large enough for CHOLMOD to give its updates to a GPU.
    pub(in super::super) fn buffer_need(&self) -> Option<usize> {
        // SAFETY: `l` is a valid factor, with the arrays that the manual
        // describes: `super` and `pi` have nsuper + 1 entries.
        unsafe {
            let l = &*self.l;
            if l.is_super == 0 {
                return None;
            }
            let first: &[i64] = super::slice(l.super_, l.nsuper + 1);
            let rows: &[i64] = super::slice(l.pi, l.nsuper + 1);
            let sizes = || {
                (0..l.nsuper).map(|s| {
                    let width = (first[s + 1] - first[s]) as usize;
                    (width, (rows[s + 1] - rows[s]) as usize)
                })
            };
            let fits = |(width, height): (usize, usize)| {
                width >= LEAST_COLUMNS && height - width >= LEAST_ROWS
            };
            if !sizes().any(fits) {
                return None;
            }
            // Blocks have up to 31 rows of padding.
            let largest = sizes().map(|(width, height)| width * (height + 64)).max().unwrap_or(0);
            // What gpu_init asks for, and where it sorts descendants.
            let maps = (l.ssize + 2 * l.n + 4) * size_of::<i64>();
            let scores = l.nsuper * 2 * size_of::<f64>();
            Some((largest * size_of::<f64>()).max(maps).max(scores))
        }
    }

    /// Bytes of a buffer without which CHOLMOD refuses the factor, however its
    /// supernodes are cut.
    pub(in super::super) fn least_buffer(&self) -> usize {
        // SAFETY: `l` is a valid factor since `analyze`.
        let l = unsafe { &*self.l };
        // Supernodes that are cut smaller have more rows in all.
        2 * (l.ssize + 2 * l.n + 4) * size_of::<i64>()
    }

    /// Allows a GPU whose buffers every supernode fits into.
    pub(in super::super) fn allow_gpu(&mut self) {
        // SAFETY: `l` is a valid factor since `analyze`.
        unsafe { (*self.l).useGPU = 1 };
    }

    /// Analyzes anew, by the ordering that is known, with supernodes that are
    /// cut to the size of the buffers.
    pub(in super::super) fn cut_supernodes(
        &mut self,
        a: &SymmetricCsc,
        gpu: &mut Lendable,
    ) -> Result<(), Fault> {
        let mut permutation = self.permutation().to_vec();
        let mut view = sparse_view(a);
        let before = self.common.method[0].ordering;
        self.common.method[0].ordering = sys::CHOLMOD_GIVEN as c_int;
        gpu.lend(&mut self.common);
        // SAFETY: the view borrows arrays that outlive the call, and the
        // permutation has one entry per unknown.
        let l = unsafe {
            sys::cholmod_l_analyze_p(
                &mut view,
                permutation.as_mut_ptr(),
                ptr::null_mut(),
                0,
                &mut *self.common,
            )
        };
        gpu.take_back(&mut self.common);
        self.common.method[0].ordering = before;
        self.outcome()?;
        // SAFETY: no fault, so the analysis returned a factor; the old one is
        // this common's.
        unsafe { sys::cholmod_l_free_factor(&mut self.l, &mut *self.common) };
        self.l = l;
        Ok(())
    }

    /// Factors with the help of the calling thread's device. What CUDA reports
    /// is in the ledger of `cholmod_sys::cuda`, not in the result: CHOLMOD goes
    /// on after some of its errors.
    pub(in super::super) fn factorize_on(
        &mut self,
        a: &SymmetricCsc,
        gpu: &mut Lendable,
        threads: usize,
    ) -> (Result<(), Fault>, Calls) {
        calls::count(&calls::FACTORIZATIONS);
        let mut view = sparse_view(a);
        sys::set_openmp_threads(&mut self.common, i32::try_from(threads).unwrap_or(i32::MAX));
        gpu.lend(&mut self.common);
        // SAFETY: as in `factorize`.
        unsafe { sys::cholmod_l_factorize(&mut view, self.l, &mut *self.common) };
        gpu.take_back(&mut self.common);
        sys::set_openmp_threads(&mut self.common, 1);
        let calls = Calls {
            syrk: self.common.cholmod_gpu_syrk_calls as u64,
            gemm: self.common.cholmod_gpu_gemm_calls as u64,
            potrf: self.common.cholmod_gpu_potrf_calls as u64,
            trsm: self.common.cholmod_gpu_trsm_calls as u64,
        };
        (self.outcome(), calls)
    }
}
