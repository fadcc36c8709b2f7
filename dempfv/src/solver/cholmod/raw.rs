//! The thin wrapper around CHOLMOD: all that is unsafe about it is here.

use std::cell::RefCell;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr;

use cholmod_sys as sys;

use super::super::SymmetricCsc;
use crate::calls;

#[cfg(feature = "cuda")]
mod gpu;
#[cfg(feature = "cuda")]
pub(super) use gpu::{BUFFER_UNIT, Calls, DEVICE_BUFFERS, HOST_BUFFERS, Lendable};

/// How a call to CHOLMOD failed.
#[derive(Debug)]
pub(super) enum Fault {
    NotPositiveDefinite,
    SmallPivot,
    OutOfMemory,
    TooLarge,
    Refused(String),
}

/// A factor, symbolic or numeric, with the common and the workspaces that are
/// its own.
pub(super) struct Raw {
    common: Box<sys::cholmod_common>,
    l: *mut sys::cholmod_factor,
    y: *mut sys::cholmod_dense,
    e: *mut sys::cholmod_dense,
}

// SAFETY: every pointer is owned by this object alone, and CHOLMOD keeps no
// state per thread: all of it is in the common.
unsafe impl Send for Raw {}

thread_local! {
    /// What CHOLMOD last complained about on this thread.
    static COMPLAINT: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Keeps what CHOLMOD would print.
///
/// SAFETY: only CHOLMOD calls it, with a message that is null or ends in NUL.
unsafe extern "C" fn keep_complaint(
    _status: c_int,
    _file: *const c_char,
    _line: c_int,
    message: *const c_char,
) {
    if !message.is_null() {
        // SAFETY: CHOLMOD passes a string that ends in NUL.
        let text = unsafe { CStr::from_ptr(message) }.to_string_lossy();
        COMPLAINT.with(|kept| kept.replace(text.into_owned()));
    }
}

impl Raw {
    /// Analyzes the pattern of a validated matrix by an ordering, entry k the number
    /// of the factor's column k, or by METIS.
    ///
    /// METIS draws from the C library's `rand` after seeding it: the caller
    /// sees to it that only one such analysis runs at a time.
    ///
    /// # Panics
    /// If the ordering has not one entry per unknown. That it is a permutation,
    /// CHOLMOD finds out.
    pub(super) fn analyze(a: &SymmetricCsc, ordering: Option<&[i64]>) -> Result<Raw, Fault> {
        calls::count(&calls::ANALYSES);
        // SAFETY: cholmod_common is plain data, and cholmod_l_start sets it up
        // before anything reads it.
        let mut common = Box::new(unsafe { std::mem::zeroed::<sys::cholmod_common>() });
        // SAFETY: the common is writable memory of the right size.
        unsafe { sys::cholmod_l_start(&mut *common) };
        configure(&mut common);
        let mut raw = Raw { common, l: ptr::null_mut(), y: ptr::null_mut(), e: ptr::null_mut() };
        let mut view = sparse_view(a);
        if ordering.is_some() {
            raw.common.method[0].ordering = sys::CHOLMOD_GIVEN as c_int;
        }
        let permutation = ordering.map_or(ptr::null(), |order| {
            assert_eq!(order.len(), a.n, "the ordering must have one entry per unknown");
            order.as_ptr()
        });
        // SAFETY: the view borrows arrays that outlive the call, and the permutation,
        // if there is one, has an entry per unknown. CHOLMOD only reads them.
        raw.l = unsafe {
            sys::cholmod_l_analyze_p(
                &mut view,
                permutation.cast_mut(),
                ptr::null_mut(),
                0,
                &mut *raw.common,
            )
        };
        raw.outcome()?;
        // SAFETY: no fault, so the analysis returned a factor.
        let found = unsafe { (*raw.l).ordering };
        // Without memory for METIS, CHOLMOD takes AMD and says nothing: more
        // fill, and other bits than with memory.
        if found == raw.common.method[0].ordering { Ok(raw) } else { Err(Fault::OutOfMemory) }
    }

    /// Factors a matrix of the pattern that was analyzed.
    pub(super) fn factorize(&mut self, a: &SymmetricCsc) -> Result<(), Fault> {
        calls::count(&calls::FACTORIZATIONS);
        let mut view = sparse_view(a);
        // SAFETY: as in `analyze`; `l` is a factor of this common.
        sys::openmp::serially(|| unsafe {
            sys::cholmod_l_factorize(&mut view, self.l, &mut *self.common)
        });
        self.outcome()
    }

    /// Solves with a numeric factor. `b` and `x` have one entry per unknown.
    pub(super) fn solve(&mut self, b: &[f64], x: &mut [f64]) -> Result<(), Fault> {
        let mut b_view = dense_view(b.as_ptr().cast_mut(), b.len());
        let mut x_view = dense_view(x.as_mut_ptr(), x.len());
        let mut x_handle: *mut sys::cholmod_dense = &mut x_view;
        // SAFETY: `b` is only read. The view of `x` has the size, type and
        // leading dimension of the result, so CHOLMOD writes into it and
        // neither frees nor replaces it. The workspaces are null or this
        // common's.
        unsafe {
            sys::cholmod_l_solve2(
                sys::CHOLMOD_A as c_int,
                self.l,
                &mut b_view,
                ptr::null_mut(),
                &mut x_handle,
                ptr::null_mut(),
                &mut self.y,
                &mut self.e,
                &mut *self.common,
            )
        };
        self.outcome()
    }

    /// Entries of the factor and operations of the factorization, without what
    /// supernodes add in explicit zeros.
    pub(super) fn counts(&self) -> (f64, f64) {
        (self.common.lnz, self.common.fl)
    }

    /// Bytes that CHOLMOD holds for this object.
    pub(super) fn memory(&self) -> usize {
        self.common.memory_inuse
    }

    /// The ordering: entry k is the caller's number of the factor's column k.
    pub(super) fn permutation(&self) -> &[i64] {
        // SAFETY: after an analysis `Perm` holds n 64-bit integers.
        unsafe { slice((*self.l).Perm, (*self.l).n) }
    }

    /// The factor's column at which a factorization stopped (n if it did not).
    pub(super) fn stopped_at(&self) -> usize {
        // SAFETY: `l` is a valid factor since `analyze`.
        unsafe { (*self.l).minor }
    }

    /// Calls `f(k, L_kk)` for every column k of a numeric factor.
    pub(super) fn for_each_pivot(&self, mut f: impl FnMut(usize, f64)) {
        // SAFETY: `l` is a valid factor, with the arrays that the manual
        // describes for its kind: `super` has nsuper + 1 entries, `pi` and
        // `px` as many, `p` has n + 1; `x` holds the entries they point to.
        unsafe {
            let l = &*self.l;
            let x = l.x as *const f64;
            if l.is_super == 0 {
                let start: &[i64] = slice(l.p, l.n);
                start.iter().enumerate().for_each(|(k, &p)| f(k, *x.add(p as usize)));
                return;
            }
            let first: &[i64] = slice(l.super_, l.nsuper + 1);
            let rows: &[i64] = slice(l.pi, l.nsuper + 1);
            let start: &[i64] = slice(l.px, l.nsuper);
            for s in 0..l.nsuper {
                let height = (rows[s + 1] - rows[s]) as usize;
                for (i, k) in (first[s] as usize..first[s + 1] as usize).enumerate() {
                    f(k, *x.add(start[s] as usize + i * (height + 1)));
                }
            }
        }
    }

    /// The status of the last call as a result.
    fn outcome(&self) -> Result<(), Fault> {
        // The headers give the constants several types.
        const OK: c_int = sys::CHOLMOD_OK as c_int;
        const NOT_POSDEF: c_int = sys::CHOLMOD_NOT_POSDEF as c_int;
        const DSMALL: c_int = sys::CHOLMOD_DSMALL as c_int;
        const OUT_OF_MEMORY: c_int = sys::CHOLMOD_OUT_OF_MEMORY as c_int;
        const TOO_LARGE: c_int = sys::CHOLMOD_TOO_LARGE as c_int;
        Err(match self.common.status {
            OK => return Ok(()),
            NOT_POSDEF => Fault::NotPositiveDefinite,
            DSMALL => Fault::SmallPivot,
            OUT_OF_MEMORY => Fault::OutOfMemory,
            TOO_LARGE => Fault::TooLarge,
            status => {
                let text = COMPLAINT.with(RefCell::take);
                Fault::Refused(if text.is_empty() { format!("status {status}") } else { text })
            }
        })
    }
}

impl Drop for Raw {
    fn drop(&mut self) {
        // SAFETY: each was allocated with this common or is null, which
        // CHOLMOD ignores; the common is finished last and once.
        unsafe {
            sys::cholmod_l_free_dense(&mut self.y, &mut *self.common);
            sys::cholmod_l_free_dense(&mut self.e, &mut *self.common);
            sys::cholmod_l_free_factor(&mut self.l, &mut *self.common);
            sys::cholmod_l_finish(&mut *self.common);
        }
    }
}

/// CHOLMOD factors by supernodes where the operations per entry of the factor
/// exceed this; below, the calls of the BLAS cost more than they save.
const SUPERNODAL_SWITCH: f64 = 150.0;

/// LLᵀ with METIS, silent, stopping at the first bad pivot.
fn configure(common: &mut sys::cholmod_common) {
    common.print = 0;
    common.error_handler = Some(keep_complaint);
    common.nmethods = 1;
    common.method[0].ordering = sys::CHOLMOD_METIS as c_int;
    common.postorder = 1;
    common.supernodal = sys::CHOLMOD_AUTO as c_int;
    common.supernodal_switch = SUPERNODAL_SWITCH;
    common.final_ll = 1;
    common.quick_return_if_not_posdef = 1;
    // Else an environment variable may switch the GPU on.
    common.useGPU = 0;
    // METIS does not survive a lack of memory everywhere; CHOLMOD tries
    // beforehand whether there is twice as much as METIS commonly needs.
    common.metis_memory = 2.0;
    sys::set_openmp_threads(common, 1);
}

/// A borrowed view of a matrix. CHOLMOD takes it as mutable but only reads.
fn sparse_view(a: &SymmetricCsc) -> sys::cholmod_sparse {
    sys::cholmod_sparse {
        nrow: a.n,
        ncol: a.n,
        nzmax: a.nnz(),
        p: a.col_ptr.as_ptr() as *mut c_void,
        i: a.row_idx.as_ptr() as *mut c_void,
        nz: ptr::null_mut(),
        x: a.values.as_ptr() as *mut c_void,
        z: ptr::null_mut(),
        stype: -1,
        itype: sys::CHOLMOD_LONG as c_int,
        xtype: sys::CHOLMOD_REAL as c_int,
        dtype: sys::CHOLMOD_DOUBLE as c_int,
        sorted: 1,
        packed: 1,
    }
}

/// A view of a vector.
fn dense_view(x: *mut f64, n: usize) -> sys::cholmod_dense {
    sys::cholmod_dense {
        nrow: n,
        ncol: 1,
        nzmax: n,
        d: n,
        x: x.cast(),
        z: ptr::null_mut(),
        xtype: sys::CHOLMOD_REAL as c_int,
        dtype: sys::CHOLMOD_DOUBLE as c_int,
    }
}

/// An array of CHOLMOD's as a slice.
///
/// # Safety
/// `data` points to `len` integers that live and stay unchanged for `'a`.
unsafe fn slice<'a>(data: *mut c_void, len: usize) -> &'a [i64] {
    // SAFETY: the caller's promise.
    unsafe { std::slice::from_raw_parts(data as *const i64, len) }
}
