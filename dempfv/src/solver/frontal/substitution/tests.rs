use super::super::kernels::mixed::MixedColumns;
use super::super::packed::{self, FactorSlices, OVERREAD_WORDS};
use super::super::pivot;
use super::*;

/// A front as a network's are, in double precision: columns that give away up to nine
/// tenths of what they have, in parts that differ by nine decades, five decades less where
/// that is far, and nothing to the last row of a wider border; and its entries.
struct Made {
    shape: Shape,
    dense: Vec<f64>,
    words: Vec<u32>,
    triangles: Vec<f32>,
    factors: Vec<f32>,
}

/// Of each four blocks of the border the second, and the fourth for two columns of three.
fn is_far(row: usize, column: usize) -> bool {
    match row / BLOCK_ROWS % 4 {
        1 => true,
        3 => !column.is_multiple_of(3),
        _ => false,
    }
}

fn number(k: usize) -> f64 {
    ((k * 7919 + 13) % 101) as f64 / 101.0
}

impl Made {
    fn new(width: usize, border: usize, parallel: bool) -> Made {
        let shape = Shape { width, border };
        let height = shape.height();
        let mut dense = vec![0.0; width * height];
        let mut l = vec![0.0f32; shape.len()];
        for j in 0..width {
            let column = &mut dense[j * height..(j + 1) * height];
            let raw = |i: usize| match border > 1 && i + 1 == height {
                true => 0.0,
                false => {
                    let far = i >= width && is_far(i - width, j);
                    let most = if far { 1e-5 } else { 1.0 };
                    most * 10f64.powf(-9.0 * number(i * 31 + j * 17).powi(3))
                }
            };
            let sum: f64 = (j + 1..height).map(raw).sum();
            let size = 0.5 + number(j);
            for (i, x) in column.iter_mut().enumerate().skip(j) {
                let part = if i == j { 1.0 } else { -0.9 * raw(i) / sum };
                let at = &mut l[shape.index(i, j)];
                *at = (size * part) as f32;
                *x = f64::from(*at);
            }
        }
        for panel in 0..shape.panels() {
            let (start, w) = (shape.panel_start(panel), shape.panel_width(panel));
            pivot::invert_pivot_blocks(&mut l[start..start + w * w], w);
        }
        let words: usize = panels(shape).map(Panel::words).sum();
        let triangles: usize = panels(shape).map(Panel::triangles).sum();
        let mut made = Made {
            shape,
            dense,
            // What comes after the parts must not matter.
            words: vec![0x7fff_7fff; words + OVERREAD_WORDS],
            triangles: vec![1e30; triangles + OVERREAD_WORDS],
            factors: vec![0.0; width],
        };
        let part = FactorSlices {
            words: &mut made.words[..words],
            triangles: &mut made.triangles[..triangles],
            factors: &mut made.factors,
            inverse: &mut vec![0.0; width],
        };
        packed::pack(shape, &l, true, part, parallel);
        made
    }

    fn front(&self) -> Front<'_> {
        let Made { shape, words, triangles, factors, .. } = self;
        Front { shape: *shape, words, triangles, factors }
    }

    /// L₁⁻¹ x, and what is left to the border.
    fn down(&self, x: &[f64]) -> Vec<f64> {
        let height = self.shape.height();
        let mut x = x.to_vec();
        for j in 0..self.shape.width {
            x[j] /= self.dense[j * height + j];
            for i in j + 1..height {
                x[i] -= self.dense[j * height + i] * x[j];
            }
        }
        x
    }

    /// L₁⁻ᵀ x with the border as it is.
    fn up(&self, x: &[f64]) -> Vec<f64> {
        let height = self.shape.height();
        let mut x = x.to_vec();
        for j in (0..self.shape.width).rev() {
            for i in j + 1..height {
                x[j] -= self.dense[j * height + i] * x[i];
            }
            x[j] /= self.dense[j * height + j];
        }
        x
    }
}

/// Both ways through a narrow front, with vectors of any kind.
struct Narrow<'a> {
    front: Front<'a>,
    down: &'a mut [f32],
    above: &'a [f32],
}

impl pulp::WithSimd for Narrow<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Narrow { front, down, above } = self;
        let (x, border) = down.split_at_mut(front.shape.width);
        forward_narrow(simd, front, x, |rows, v| v.add_to(&mut border[rows]));
        let take = |rows: Range<usize>| Halves::of(&above[rows]);
        backward_narrow(simd, front, &mut TransposedProduct::new(), x, take);
    }
}

/// What a front gives to its border and what its columns get, against double precision:
/// nothing is negative, so that the errors of entries are the most. Half a unit of its
/// root is 2.3e-5 s^(2/3) of a multiplier s, and with 8 bits up to 1.4e-4 s^(2/3) of those of
/// 1e-5 at most; what is given comes from many. And what is given in all is right to single precision,
/// however it is shared out.
#[test]
fn entries_are_right_and_nothing_is_lost() {
    let shapes = [(1, 0), (1, 1), (3, 13), (7, 33), (10, 54), (32, 64), (5, 300), (32, 600)];
    let wide = [(33, 0), (40, 1), (100, 777), (256, 513), (300, 70), (700, 1100)];
    for (width, border) in shapes.into_iter().chain(wide) {
        let made = Made::new(width, border, width > 256);
        let start: Vec<f64> =
            (0..width + border).map(|k| if k < width { number(k * k + 1) } else { 0.0 }).collect();
        let above: Vec<f32> = (0..border).map(|k| number(3 * k + 2) as f32).collect();
        let down = made.down(&start);
        let back: Vec<f64> =
            down[..width].iter().copied().chain(above.iter().map(|&v| v.into())).collect();
        let up = made.up(&back);

        let single: Vec<f32> = start.iter().map(|&v| v as f32).collect();
        let mut found = vec![];
        if width <= PIVOT_BLOCK {
            let mut with = |run: &dyn Fn(Narrow<'_>)| {
                let mut x = single.clone();
                run(Narrow { front: made.front(), down: &mut x, above: &above });
                found.push(x);
            };
            // This processor's vectors, shorter ones, none.
            with(&|work| pulp::Arch::new().dispatch(work));
            with(&|work| pulp::WithSimd::with_simd(work, pulp::Scalar256b));
            with(&|work| pulp::WithSimd::with_simd(work, pulp::Scalar));
        }
        for parallel in [false, true] {
            let mut all = single.clone();
            let (x, border) = all.split_at_mut(width);
            forward(made.front(), x, border, parallel);
            backward(made.front(), x, &above, parallel);
            found.push(all);
        }
        let [.., alone, contiguous] = &found[..] else { unreachable!() };
        assert_eq!(alone, contiguous, "{width} {border}");
        for found in &found {
            for (k, (found, expected)) in
                found.iter().zip(up[..width].iter().chain(&down[width..])).enumerate()
            {
                let error = (f64::from(*found) - expected).abs();
                let is_eight_bit = width > PIVOT_BLOCK && k >= width && is_far(k - width, 0);
                let digits = if is_eight_bit { 3e-4 } else { 1e-4 };
                let bound = digits * expected.powf(2.0 / 3.0) + 1e-13;
                assert!(error < bound, "{width} {border} {k}: {found} {expected}");
            }
            let scaled: f64 = found[width..].iter().map(|&v| f64::from(v)).sum();
            let expected: f64 = down[width..].iter().sum();
            assert!((scaled - expected).abs() <= 3e-6 * expected, "{width} {border} {scaled}");
        }
    }
}

/// Both ways through a full block with a header.
struct Packed<'a> {
    words: &'a [u32],
    width: usize,
    x: &'a [f32; PIVOT_BLOCK],
    y: &'a [f32],
}

impl pulp::WithSimd for Packed<'_> {
    type Output = (Vec<f32>, Vec<f32>);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Packed { words, width, x, y } = self;
        let mut scaled = vec![0.0; BLOCK_ROWS];
        multiply_mixed(simd, words, x, width).0.add_to(&mut scaled);
        let mut sums_so_far = TransposedProduct::new();
        sums_so_far.begin::<S>(width);
        sums_so_far.add_mixed(simd, width, words, &Halves::of(y));
        let mut sums = vec![0.0; width];
        sums_so_far.total(simd, &mut sums);
        (scaled, sums)
    }
}

/// In wide fronts the columns are 8-bit where they are far, and nowhere else; what these
/// give and get is right (half a step is 1.4e-4 s^(2/3) of a multiplier s of 1e-5 at most, and
/// of 64 of them together four times as much); and vectors of all lengths read the same,
/// but for the order of sums.
#[test]
fn far_columns_have_eight_bits() {
    for (width, border) in [(33, 256), (100, 777), (700, 1100)] {
        let made = Made::new(width, border, false);
        let before: usize =
            panels(made.shape).take(made.shape.panels() - 1).map(Panel::words).sum();
        let panel = Panel::new(made.shape, made.shape.panels() - 1);
        let mut words = &made.words[before + panel.chunk(0).1..];
        let height = made.shape.height();
        let near = |found: f32, expected: f64| {
            let bound = 6e-4 * expected.powf(2.0 / 3.0);
            assert!((f64::from(found) - expected).abs() <= bound, "{found} {expected}");
        };
        let y: Vec<f32> = (0..BLOCK_ROWS).map(|k| number(5 * k + 1) as f32).collect();
        for row in (0..border.min(CHUNK_ROWS) / BLOCK_ROWS * BLOCK_ROWS).step_by(BLOCK_ROWS) {
            // Numbers as these are no sum of few rank-one terms.
            assert_eq!(rank_of(words[0]), None, "{width} {border} {row}");
            words = &words[1..];
            for pivot_block in panel.pivot_blocks() {
                let columns = MixedColumns::of(words, pivot_block.width);
                let first = panel.first + pivot_block.first;
                let far = |k: &usize| is_far(row, first + k);
                let expected =
                    (0..pivot_block.width).filter(far).fold(0u32, |mask, k| mask | 1 << k);
                assert_eq!(columns.eight_bit, expected, "{width} {border} {row}");
                // Only far columns give something, if there are any.
                let gives = |k: usize| expected == 0 || expected >> k & 1 == 1;
                let x = std::array::from_fn(|k| match k < pivot_block.width && gives(k) {
                    true => number(k + 3) as f32 * made.factors[first + k],
                    false => 0.0,
                });
                let entry =
                    |i: usize, k: usize| -made.dense[(first + k) * height + width + row + i];
                let mixed = || Packed { words, width: pivot_block.width, x: &x, y: &y };
                let (scaled, sums) = pulp::Arch::new().dispatch(mixed());
                for (i, &scaled) in scaled.iter().enumerate() {
                    let parts = (0..pivot_block.width).filter(|&k| gives(k));
                    near(scaled, parts.map(|k| entry(i, k) * number(k + 3)).sum());
                }
                for (k, &sum) in sums.iter().enumerate() {
                    let parts = (0..BLOCK_ROWS).map(|i| entry(i, k) * f64::from(y[i]));
                    near(sum * made.factors[first + k], parts.sum());
                }
                for (also_given, also_sums) in [
                    pulp::WithSimd::with_simd(mixed(), pulp::Scalar512b),
                    pulp::WithSimd::with_simd(mixed(), pulp::Scalar256b),
                    pulp::WithSimd::with_simd(mixed(), pulp::Scalar128b),
                    pulp::WithSimd::with_simd(mixed(), pulp::Scalar),
                ] {
                    let pairs = scaled.iter().zip(also_given).chain(sums.iter().zip(also_sums));
                    for (a, b) in pairs {
                        assert!((a - b).abs() <= 1e-5 * a, "{width} {border} {row}: {a} {b}");
                    }
                }
                words = &words[columns.len()..];
            }
        }
    }
}
