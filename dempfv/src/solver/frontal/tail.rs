//! The thin wrapper around pulp's masked loads and stores.

use pulp::{MemMask, Simd};

/// The first lanes of a vector, where fewer entries than lanes are left.
#[derive(Clone, Copy)]
pub struct Tail<S: Simd> {
    mask: MemMask<S::m32s>,
    len: usize,
}

impl<S: Simd> Tail<S> {
    #[inline(always)]
    pub fn new(simd: S, len: usize) -> Tail<S> {
        // Without the mask's own functions, which are called and not inlined.
        Tail { mask: MemMask::new(simd.mask_between_m32s(0, len as u32).mask()), len }
    }

    /// The entries, and zeros.
    #[inline(always)]
    pub fn load(self, simd: S, x: &[f32]) -> S::f32s {
        let x = &x[..self.len];
        // SAFETY: the mask enables the lanes of these entries only.
        unsafe { simd.mask_load_ptr_f32s(self.mask, x.as_ptr()) }
    }

    /// Takes the entries over from a vector.
    #[inline(always)]
    pub fn store(self, simd: S, x: &mut [f32], values: S::f32s) {
        let x = &mut x[..self.len];
        // SAFETY: the mask enables the lanes of these entries only.
        unsafe { simd.mask_store_ptr_f32s(self.mask, x.as_mut_ptr(), values) }
    }
}
