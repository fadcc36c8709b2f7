//! Numbers from the halves of words.

use pulp::Simd;

use super::super::low_rank::CODE_OF_ZERO;
use super::super::packed::{CODE_BASE, ROOT_OFFSET, ROOT_SCALE};

/// Makes numbers of the halves of words.
pub trait Decode<S: Simd>: Copy {
    fn new(simd: S) -> Self;
    fn low(self, simd: S, words: S::u32s) -> S::f32s;
    fn high(self, simd: S, words: S::u32s) -> S::f32s;
}

/// Multipliers of their cube roots.
#[derive(Clone, Copy)]
pub struct CubeRoots<S: Simd> {
    half: S::u32s,
    mask: S::u32s,
    ones: S::u32s,
    scale: S::f32s,
    offset: S::f32s,
}

impl<S: Simd> Decode<S> for CubeRoots<S> {
    #[inline(always)]
    fn new(simd: S) -> CubeRoots<S> {
        CubeRoots {
            half: simd.splat_u32s(16),
            mask: simd.splat_u32s(0xffff),
            ones: simd.splat_u32s(CODE_BASE.to_bits()),
            scale: simd.splat_f32s(ROOT_SCALE),
            offset: simd.splat_f32s(ROOT_OFFSET),
        }
    }

    #[inline(always)]
    fn low(self, simd: S, words: S::u32s) -> S::f32s {
        self.multiplier(simd, simd.and_u32s(words, self.mask))
    }

    #[inline(always)]
    fn high(self, simd: S, words: S::u32s) -> S::f32s {
        self.multiplier(simd, simd.wrapping_dyn_shr_u32s(words, self.half))
    }
}

impl<S: Simd> CubeRoots<S> {
    /// The cube of a byte.
    #[inline(always)]
    pub(super) fn byte(self, simd: S, words: S::u32s, byte: usize) -> S::f32s {
        let words = simd.wrapping_dyn_shr_u32s(words, simd.splat_u32s(8 * byte as u32));
        let bits = simd.or_u32s(simd.and_u32s(words, simd.splat_u32s(0xff)), self.ones);
        let root = simd.sub_f32s(simd.transmute_f32s_u32s(bits), simd.splat_f32s(CODE_BASE));
        simd.mul_f32s(simd.mul_f32s(root, root), root)
    }

    #[inline(always)]
    fn multiplier(self, simd: S, half: S::u32s) -> S::f32s {
        let number = simd.transmute_f32s_u32s(simd.or_u32s(half, self.ones));
        let root = simd.mul_add_e_f32s(number, self.scale, self.offset);
        simd.mul_f32s(simd.mul_f32s(root, root), root)
    }
}

/// Whole numbers with a sign.
#[derive(Clone, Copy)]
pub struct Integers<S: Simd> {
    half: S::u32s,
    mask: S::u32s,
    ones: S::u32s,
    zero: S::f32s,
}

impl<S: Simd> Decode<S> for Integers<S> {
    #[inline(always)]
    fn new(simd: S) -> Integers<S> {
        Integers {
            half: simd.splat_u32s(16),
            mask: simd.splat_u32s(0xffff),
            ones: simd.splat_u32s(CODE_BASE.to_bits()),
            zero: simd.splat_f32s(f32::from_bits(CODE_BASE.to_bits() | CODE_OF_ZERO)),
        }
    }

    #[inline(always)]
    fn low(self, simd: S, words: S::u32s) -> S::f32s {
        self.number(simd, simd.and_u32s(words, self.mask))
    }

    #[inline(always)]
    fn high(self, simd: S, words: S::u32s) -> S::f32s {
        self.number(simd, simd.wrapping_dyn_shr_u32s(words, self.half))
    }
}

impl<S: Simd> Integers<S> {
    #[inline(always)]
    fn number(self, simd: S, half: S::u32s) -> S::f32s {
        let bits = simd.or_u32s(half, self.ones);
        simd.sub_f32s(simd.transmute_f32s_u32s(bits), self.zero)
    }
}
