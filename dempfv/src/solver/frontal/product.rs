//! C = C - A Bᵀ for blocks of tiles.

use pulp::{Simd, WithSimd};

use super::block::Block;
use super::register_tile::{ByColumns, RowsOfB, Strip, for_each_strip};

/// What is subtracted from C, which has the rows of A and as many columns as B has rows.
pub struct Product<'a> {
    pub a: Block<'a>,
    pub b: Block<'a>,
    /// Columns of A and B; no more than a tile has.
    pub depth: usize,
    /// Of C only the lower triangle is read later: what is above may be left as it is.
    pub lower: bool,
    /// C is zero before: it is written and not read.
    pub fresh: bool,
}

impl Product<'_> {
    pub fn subtract_from(self, c: &mut [f32], stride: usize) {
        let Product { a, b, depth, .. } = self;
        if a.rows == 0 || b.rows == 0 || depth == 0 {
            return;
        }
        pulp::Arch::new().dispatch(Subtract { c, stride, product: self });
    }
}

struct Subtract<'a> {
    c: &'a mut [f32],
    stride: usize,
    product: Product<'a>,
}

impl WithSimd for Subtract<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let columns = self.product.b.rows;
        for_each_strip(simd, columns, &mut self);
    }
}

impl ByColumns for Subtract<'_> {
    #[inline(always)]
    fn columns<S: Simd, const N: usize>(&mut self, simd: S, copy: &mut RowsOfB, from: usize) {
        let Product { a, b, depth, lower, fresh } = self.product;
        let b = copy.copy::<N>(b.below(from), depth);
        let c = &mut self.c[from * self.stride..];
        let strip = Strip { c, stride: self.stride, a, b, fresh, triangle: None };
        strip.run(simd, if lower { from } else { 0 });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers between 0.5 and 1.5 that do not repeat within a tile.
    fn numbers(count: usize, seed: usize) -> Vec<f32> {
        (0..count).map(|k| 0.5 + ((k + 1) * (7919 + seed) % 65_521) as f32 / 65_521.0).collect()
    }

    /// A block of so many rows, `stride` apart, that starts at an address of its own.
    fn block(data: &[f32], from: usize, rows: usize, stride: usize) -> Block<'_> {
        Block { data: &data[from..], rows, stride }
    }

    /// Against sums in double precision. A sum of positive products is right to half a unit in
    /// the last place for each addition (Higham 2002), and C is subtracted from once. Sizes are
    /// one and one more than what vectors, registers and tiles hold.
    #[test]
    fn products_are_right_to_round_off() {
        for (m, n, depth) in
            [(1, 1, 1), (7, 5, 3), (17, 6, 2), (65, 13, 32), (128, 64, 33), (255, 256, 256)]
        {
            let (stride, a, b) = (m + 3, numbers(m * depth, 1), numbers(n * depth, 2));
            let c = numbers(stride * n, 3);
            for (lower, fresh) in [(false, false), (true, false), (false, true), (true, true)] {
                // What is not read may be anything.
                let mut out = if fresh { vec![f32::NAN; c.len()] } else { c.clone() };
                let (a, b) = (block(&a, 0, m, m), block(&b, 0, n, n));
                Product { a, b, depth, lower, fresh }.subtract_from(&mut out, stride);
                for (i, j) in
                    (0..n).flat_map(|j| (if lower { j } else { 0 }..m).map(move |i| (i, j)))
                {
                    let product =
                        |k: usize| f64::from(a.data[k * m + i]) * f64::from(b.data[k * n + j]);
                    let sum: f64 = (0..depth).map(product).sum();
                    let before = if fresh { 0.0 } else { f64::from(c[j * stride + i]) };
                    let error = (f64::from(out[j * stride + i]) - (before - sum)).abs();
                    let bound = (depth + 1) as f64 * f64::from(f32::EPSILON) / 2.0 * (sum + before);
                    assert!(error <= bound, "{m} {n} {depth}: ({i}, {j}) is off by {error:e}");
                }
                let between = |(at, (x, c)): (usize, (&f32, &f32))| {
                    at % stride < m || x == c || (fresh && x.is_nan())
                };
                assert!(out.iter().zip(&c).enumerate().all(between), "{m} {n} {depth}");
            }
        }
    }

    /// A factor must not depend on where the allocator has put a tile, nor on how it is cut.
    #[test]
    fn bits_of_an_entry_depend_on_its_products_alone() {
        let (m, n, depth) = (77, 29, 65);
        let (a, b, c) = (numbers(m * depth, 1), numbers(n * depth, 2), numbers(m * n, 3));
        let mut whole = c.clone();
        let part = |i: usize, j: usize, rows: usize, columns: usize| {
            (block(&a, i, rows, m), block(&b, j, columns, n))
        };
        let (all_a, all_b) = part(0, 0, m, n);
        let product = Product { a: all_a, b: all_b, depth, lower: false, fresh: false };
        product.subtract_from(&mut whole, m);
        for shift in 0..17 {
            let shifted: Vec<f32> = vec![0.0; shift].into_iter().chain(a.iter().copied()).collect();
            let mut out = [vec![0.0; shift], c.clone()].concat();
            let a = block(&shifted, shift, m, m);
            let product = Product { a, b: all_b, depth, lower: false, fresh: false };
            product.subtract_from(&mut out[shift..], m);
            assert!(out[shift..] == whole, "at an address {shift} entries later");
        }
        let mut single = c;
        for (i, j) in (0..n).flat_map(|j| (0..m).map(move |i| (i, j))) {
            let (a, b) = part(i, j, 1, 1);
            let product = Product { a, b, depth, lower: false, fresh: false };
            product.subtract_from(&mut single[j * m + i..], m);
        }
        assert!(single == whole);
    }

    /// AVX2 has other vectors and half as many registers as AVX-512, but multiplies and adds with one
    /// rounding too.
    #[cfg(target_arch = "x86_64")]
    #[test]
    fn avx2_gives_the_bits_of_the_widest_vectors() {
        let Some(avx2) = pulp::x86::V3::try_new() else { return };
        for (m, n, depth) in [(1, 1, 1), (40, 7, 9), (77, 29, 65), (256, 33, 256)] {
            let (a, b, c) = (numbers(m * depth, 1), numbers(n * depth, 2), numbers(m * n, 3));
            let product = || {
                let (a, b) = (block(&a, 0, m, m), block(&b, 0, n, n));
                Product { a, b, depth, lower: false, fresh: false }
            };
            let (mut widest, mut narrow) = (c.clone(), c);
            product().subtract_from(&mut widest, m);
            pulp::Simd::vectorize(avx2, Subtract { c: &mut narrow, stride: m, product: product() });
            assert!(widest == narrow, "{m} {n} {depth}");
        }
    }
}
