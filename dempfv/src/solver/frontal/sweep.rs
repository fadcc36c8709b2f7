//! Ways through fronts: with the shares of their columns forward, and back.

use std::ops::Range;

use pulp::Simd;
use rayon::prelude::*;

use super::block::{
    AHEAD, Collected, Halves, Roots, collect_products, spread, spread_packed, spread_products, turn,
};
use super::lanes::Tail;
use super::pivot::STRIP;
use super::products::rank_of;
use super::shape::{Shape, TILE};
use super::shares::{BLOCK, CHUNK, Panel, Strip, panels, words as words_of};

/// The factor of one front; words and entries of triangles may go on after it.
#[derive(Clone, Copy)]
pub struct Front<'a> {
    pub shape: Shape,
    pub words: &'a [u32],
    pub triangles: &'a [f32],
    pub factors: &'a [f32],
}

/// What the columns of a strip have for the rows below: values times factors, and zeros
/// after them.
#[inline(always)]
fn given<S: Simd>(simd: S, x: &[f32], factors: &[f32], out: &mut [f32; STRIP]) {
    let (out, _) = S::as_mut_simd_f32s(out);
    let mut from = 0;
    for out in out {
        let rest = x.len().saturating_sub(from).min(S::F32_LANES);
        let tail = Tail::new(simd, rest);
        let (x, factors) = (&x[from.min(x.len())..], &factors[from.min(x.len())..]);
        *out = simd.mul_f32s(tail.load(simd, x), tail.load(simd, factors));
        from += S::F32_LANES;
    }
}

/// The way forward through a narrow front: x = T x, and each block of its edge is given
/// its part of -L₂ x.
#[inline(always)]
pub fn forward_narrow<S: Simd>(
    simd: S,
    front: Front<'_>,
    x: &mut [f32],
    mut give: impl FnMut(Range<usize>, &Halves),
) {
    turn::<S, false>(simd, front.triangles, x);
    let mut values = [0.0; STRIP];
    given(simd, x, front.factors, &mut values);
    let values = &values[..x.len()];
    let mut at = 0;
    for from in (0..front.shape.edge).step_by(BLOCK) {
        let to = front.shape.edge.min(from + BLOCK);
        let half = words_of(to - from);
        give(from..to, &spread::<S, Roots<S>>(simd, half, &front.words[at..], values));
        at += half * values.len();
    }
}

/// The way back through a narrow front, x = Tᵀ (x - L₂ᵀ edge), with the values of each
/// block of its edge.
#[inline(always)]
pub fn backward_narrow<S: Simd>(
    simd: S,
    front: Front<'_>,
    collected: &mut Collected,
    x: &mut [f32],
    take: impl Fn(Range<usize>) -> Halves,
) {
    let width = x.len();
    collected.begin::<S>(width);
    let mut at = 0;
    for from in (0..front.shape.edge).step_by(BLOCK) {
        let to = front.shape.edge.min(from + BLOCK);
        collected.add::<S, Roots<S>>(
            simd,
            width,
            &front.words[at..],
            -AHEAD,
            to - from,
            &take(from..to),
        );
        at += words_of(to - from) * width;
    }
    let mut sums = [0.0; STRIP];
    collected.total(simd, &mut sums[..width]);
    add(x, front.factors, &sums);
    turn::<S, true>(simd, front.triangles, x);
}

/// x = x + f s for the factors f of a strip's columns and what came together for them.
#[inline(always)]
fn add(x: &mut [f32], factors: &[f32], sums: &[f32]) {
    for ((x, factor), sum) in x.iter_mut().zip(factors).zip(sums) {
        *x += factor * sum;
    }
}

/// What the strips of a panel have for the rows below, see [`given`].
type Given = [[f32; STRIP]; TILE / STRIP];

/// x = L₁⁻¹ x, edge = edge - L₂ x for the two parts of a front's columns.
pub fn forward(front: Front<'_>, x: &mut [f32], edge: &mut [f32], shared: bool) {
    let Front { shape, mut words, mut triangles, factors } = front;
    for panel in panels(shape) {
        let (own, later) = x[panel.first..].split_at_mut(panel.width);
        let mut given: Given = [[0.0; STRIP]; TILE / STRIP];
        let part = Front { shape, words, triangles, factors: &factors[panel.first..] };
        pulp::Arch::new().dispatch(Inside { panel, part, own, given: &mut given });
        let given = &given;
        let of_own = panel.later.div_ceil(CHUNK);
        let chunk = |k: usize, y: &mut [f32]| {
            let words = &words[panel.chunk(k).1..];
            pulp::Arch::new().dispatch(Chunk { panel, words, given, y });
        };
        let in_own = |(k, y): (usize, &mut [f32])| chunk(k, y);
        let in_edge = |(k, y): (usize, &mut [f32])| chunk(of_own + k, y);
        if shared {
            rayon::join(
                || later.par_chunks_mut(CHUNK).enumerate().for_each(in_own),
                || edge.par_chunks_mut(CHUNK).enumerate().for_each(in_edge),
            );
        } else {
            later.chunks_mut(CHUNK).enumerate().for_each(in_own);
            edge.chunks_mut(CHUNK).enumerate().for_each(in_edge);
        }
        words = &words[panel.words()..];
        triangles = &triangles[panel.triangles()..];
    }
}

/// The way forward inside a panel.
struct Inside<'a> {
    panel: Panel,
    part: Front<'a>,
    own: &'a mut [f32],
    given: &'a mut Given,
}

impl pulp::WithSimd for Inside<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Inside { panel, part, own, given: all } = self;
        let (mut at, mut triangle) = (0, 0);
        for (k, strip) in panel.strips().enumerate() {
            let Strip { first, width } = strip;
            let (x, later) = own[first..].split_at_mut(width);
            let values = &mut all[k];
            turn::<S, false>(simd, &part.triangles[triangle..], x);
            triangle += strip.triangle();
            given(simd, x, &part.factors[first..], values);
            at += spread_over(simd, &part.words[at..], values, width, later);
        }
    }
}

/// The way forward from a strip to later rows of its panel; returns how many words that took.
#[inline(always)]
fn spread_over<S: Simd>(
    simd: S,
    words: &[u32],
    x: &[f32; STRIP],
    width: usize,
    y: &mut [f32],
) -> usize {
    let mut at = 0;
    for y in y.chunks_mut(BLOCK) {
        let half = words_of(y.len());
        spread::<S, Roots<S>>(simd, half, &words[at..], &x[..width]).add_to(y);
        at += half * width;
    }
    at
}

/// The way forward from a panel to one chunk.
struct Chunk<'a> {
    panel: Panel,
    words: &'a [u32],
    given: &'a Given,
    y: &'a mut [f32],
}

impl pulp::WithSimd for Chunk<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Chunk { panel, mut words, given, y } = self;
        let mut collected = Collected::new();
        for y in y.chunks_mut(BLOCK) {
            let packed = panel.packed && y.len() == BLOCK;
            if packed && let Some(rank) = rank_of(words[0]) {
                let x = &given.as_flattened()[..panel.width];
                let (given, taken) = spread_products(simd, &mut collected, rank, words, x);
                given.add_to(y);
                words = &words[taken..];
                continue;
            }
            words = &words[usize::from(packed)..];
            for (strip, values) in panel.strips().zip(given) {
                let taken = if packed {
                    let (given, taken) = spread_packed(simd, words, values, strip.width);
                    given.add_to(y);
                    taken
                } else {
                    spread_over(simd, words, values, strip.width, y)
                };
                words = &words[taken..];
            }
        }
    }
}

/// x = L₁⁻ᵀ (x - L₂ᵀ edge) for the two parts of a front's columns.
pub fn backward(front: Front<'_>, x: &mut [f32], edge: &[f32], shared: bool) {
    let mut at: usize = panels(front.shape).map(Panel::words).sum();
    let mut triangle: usize = panels(front.shape).map(Panel::triangles).sum();
    for panel in panels(front.shape).rev() {
        at -= panel.words();
        triangle -= panel.triangles();
        let (own, later) = x[panel.first..].split_at_mut(panel.width);
        let below = Below { panel, words: &front.words[at..], later, edge, shared };
        let sums = below.collect(0..panel.chunks());
        let part = Front {
            words: below.words,
            triangles: &front.triangles[triangle..],
            factors: &front.factors[panel.first..],
            ..front
        };
        pulp::Arch::new().dispatch(Back { panel, part, sums: &sums, own });
    }
}

/// What is below a panel.
struct Below<'a> {
    panel: Panel,
    words: &'a [u32],
    later: &'a [f32],
    edge: &'a [f32],
    shared: bool,
}

impl Below<'_> {
    /// Shares times values of some chunks, by column. Halves are added up, and so the
    /// bits do not depend on who does which.
    fn collect(&self, chunks: Range<usize>) -> [f32; TILE] {
        let Range { start, end } = chunks;
        if end - start <= 1 {
            let mut sums = [0.0; TILE];
            if start < end {
                let (rows, at) = self.panel.chunk(start);
                let later = self.panel.later;
                let y = if rows.start < later {
                    &self.later[rows]
                } else {
                    &self.edge[rows.start - later..rows.end - later]
                };
                let words = &self.words[at..];
                pulp::Arch::new().dispatch(Collect {
                    panel: self.panel,
                    words,
                    y,
                    sums: &mut sums,
                });
            }
            return sums;
        }
        let middle = start + (end - start) / 2;
        let halves = (|| self.collect(start..middle), || self.collect(middle..end));
        let (mut sums, more) =
            if self.shared { rayon::join(halves.0, halves.1) } else { (halves.0(), halves.1()) };
        sums.iter_mut().zip(&more).for_each(|(sum, v)| *sum += v);
        sums
    }
}

/// The way back from one chunk.
struct Collect<'a> {
    panel: Panel,
    words: &'a [u32],
    y: &'a [f32],
    sums: &'a mut [f32; TILE],
}

impl pulp::WithSimd for Collect<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Collect { panel, mut words, y, sums } = self;
        let mut of_strips = [const { Collected::new() }; TILE / STRIP];
        let mut of_products = Collected::new();
        for y in y.chunks(BLOCK) {
            let values = Halves::of(y);
            let packed = panel.packed && y.len() == BLOCK;
            if packed && let Some(rank) = rank_of(words[0]) {
                let sums = &mut sums[..panel.width];
                let taken = collect_products(simd, &mut of_products, rank, words, values, sums);
                words = &words[taken..];
                continue;
            }
            words = &words[usize::from(packed)..];
            for (strip, collected) in panel.strips().zip(&mut of_strips) {
                let taken = if packed {
                    collected.add_packed(simd, strip.width, words, &values)
                } else {
                    let width = strip.width;
                    collected.add::<S, Roots<S>>(simd, width, words, AHEAD, y.len(), &values);
                    words_of(y.len()) * width
                };
                words = &words[taken..];
            }
        }
        for (strip, collected) in panel.strips().zip(&of_strips) {
            let mut more = [0.0; STRIP];
            let more = &mut more[..strip.width];
            collected.total(simd, more);
            sums[strip.first..].iter_mut().zip(&*more).for_each(|(sum, v)| *sum += v);
        }
    }
}

/// The way back from later rows of a panel to a strip; returns how many words that took.
#[inline(always)]
fn collect_over<S: Simd>(
    simd: S,
    collected: &mut Collected,
    width: usize,
    words: &[u32],
    y: &[f32],
) -> usize {
    let mut at = 0;
    for y in y.chunks(BLOCK) {
        let values = Halves::of(y);
        collected.add::<S, Roots<S>>(simd, width, &words[at..], AHEAD, y.len(), &values);
        at += words_of(y.len()) * width;
    }
    at
}

/// The way back inside a panel.
struct Back<'a> {
    panel: Panel,
    part: Front<'a>,
    sums: &'a [f32; TILE],
    own: &'a mut [f32],
}

impl pulp::WithSimd for Back<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Back { panel, part, sums, own } = self;
        let mut collected = Collected::new();
        let (mut at, mut triangle) = (panel.all_inside(), panel.triangles());
        for strip in panel.strips().rev() {
            let Strip { first, width } = strip;
            at -= panel.inside(strip);
            triangle -= strip.triangle();
            let (x, later) = own[first..].split_at_mut(width);
            collected.begin::<S>(width);
            collect_over(simd, &mut collected, width, &part.words[at..], later);
            let mut all = [0.0; STRIP];
            let all = &mut all[..width];
            collected.total(simd, all);
            all.iter_mut().zip(&sums[first..]).for_each(|(all, v)| *all += v);
            add(x, &part.factors[first..], all);
            turn::<S, true>(simd, &part.triangles[triangle..], x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::block::Columns;
    use super::super::pivot;
    use super::super::shares::{self, Part, SLACK};
    use super::*;

    /// A front as a network's are, in double precision: columns that give away up to nine
    /// tenths of what they have, in parts that differ by nine decades, five decades less where
    /// that is far, and nothing to the last row of a wider edge; and its entries.
    struct Made {
        shape: Shape,
        dense: Vec<f64>,
        words: Vec<u32>,
        triangles: Vec<f32>,
        factors: Vec<f32>,
    }

    /// Of each four blocks of the edge the second, and the fourth for two columns of three.
    fn is_far(row: usize, column: usize) -> bool {
        match row / BLOCK % 4 {
            1 => true,
            3 => !column.is_multiple_of(3),
            _ => false,
        }
    }

    fn number(k: usize) -> f64 {
        ((k * 7919 + 13) % 101) as f64 / 101.0
    }

    impl Made {
        fn new(width: usize, edge: usize, shared: bool) -> Made {
            let shape = Shape { width, edge };
            let height = shape.height();
            let mut dense = vec![0.0; width * height];
            let mut l = vec![0.0f32; shape.len()];
            for j in 0..width {
                let column = &mut dense[j * height..(j + 1) * height];
                let raw = |i: usize| match edge > 1 && i + 1 == height {
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
                pivot::invert_strips(&mut l[start..start + w * w], w);
            }
            let words: usize = panels(shape).map(Panel::words).sum();
            let triangles: usize = panels(shape).map(Panel::triangles).sum();
            let mut made = Made {
                shape,
                dense,
                // What comes after the parts must not matter.
                words: vec![0x7fff_7fff; words + SLACK],
                triangles: vec![1e30; triangles + SLACK],
                factors: vec![0.0; width],
            };
            let part = Part {
                words: &mut made.words[..words],
                triangles: &mut made.triangles[..triangles],
                factors: &mut made.factors,
                inverse: &mut vec![0.0; width],
            };
            shares::take(shape, &l, true, part, shared);
            made
        }

        fn front(&self) -> Front<'_> {
            let Made { shape, words, triangles, factors, .. } = self;
            Front { shape: *shape, words, triangles, factors }
        }

        /// L₁⁻¹ x, and what is left to the edge.
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

        /// L₁⁻ᵀ x with the edge as it is.
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
            let (x, edge) = down.split_at_mut(front.shape.width);
            forward_narrow(simd, front, x, |rows, v| v.add_to(&mut edge[rows]));
            let take = |rows: Range<usize>| Halves::of(&above[rows]);
            backward_narrow(simd, front, &mut Collected::new(), x, take);
        }
    }

    /// What a front gives to its edge and what its columns get, against double precision:
    /// nothing is negative, so that the errors of entries are the most. Half a unit of its
    /// root is 2.3e-5 s^(2/3) of a share s, and with 8 bits up to 1.4e-4 s^(2/3) of those of
    /// 1e-5 at most; what is given comes from many. And what is given in all is right to single precision,
    /// however it is shared out.
    #[test]
    fn shares_are_right_and_nothing_is_lost() {
        let shapes = [(1, 0), (1, 1), (3, 13), (7, 33), (10, 54), (32, 64), (5, 300), (32, 600)];
        let wide = [(33, 0), (40, 1), (100, 777), (256, 513), (300, 70), (700, 1100)];
        for (width, edge) in shapes.into_iter().chain(wide) {
            let made = Made::new(width, edge, width > 256);
            let start: Vec<f64> = (0..width + edge)
                .map(|k| if k < width { number(k * k + 1) } else { 0.0 })
                .collect();
            let above: Vec<f32> = (0..edge).map(|k| number(3 * k + 2) as f32).collect();
            let down = made.down(&start);
            let back: Vec<f64> =
                down[..width].iter().copied().chain(above.iter().map(|&v| v.into())).collect();
            let up = made.up(&back);

            let single: Vec<f32> = start.iter().map(|&v| v as f32).collect();
            let mut found = vec![];
            if width <= STRIP {
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
            for shared in [false, true] {
                let mut all = single.clone();
                let (x, edge) = all.split_at_mut(width);
                forward(made.front(), x, edge, shared);
                backward(made.front(), x, &above, shared);
                found.push(all);
            }
            let [.., alone, together] = &found[..] else { unreachable!() };
            assert_eq!(alone, together, "{width} {edge}");
            for found in &found {
                for (k, (found, expected)) in
                    found.iter().zip(up[..width].iter().chain(&down[width..])).enumerate()
                {
                    let error = (f64::from(*found) - expected).abs();
                    let is_short = width > STRIP && k >= width && is_far(k - width, 0);
                    let digits = if is_short { 3e-4 } else { 1e-4 };
                    let bound = digits * expected.powf(2.0 / 3.0) + 1e-13;
                    assert!(error < bound, "{width} {edge} {k}: {found} {expected}");
                }
                let given: f64 = found[width..].iter().map(|&v| f64::from(v)).sum();
                let expected: f64 = down[width..].iter().sum();
                assert!((given - expected).abs() <= 3e-6 * expected, "{width} {edge} {given}");
            }
        }
    }

    /// Both ways through a full block with a head.
    struct Packed<'a> {
        words: &'a [u32],
        width: usize,
        x: &'a [f32; STRIP],
        y: &'a [f32],
    }

    impl pulp::WithSimd for Packed<'_> {
        type Output = (Vec<f32>, Vec<f32>);

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let Packed { words, width, x, y } = self;
            let mut given = vec![0.0; BLOCK];
            spread_packed(simd, words, x, width).0.add_to(&mut given);
            let mut collected = Collected::new();
            collected.begin::<S>(width);
            collected.add_packed(simd, width, words, &Halves::of(y));
            let mut sums = vec![0.0; width];
            collected.total(simd, &mut sums);
            (given, sums)
        }
    }

    /// In wide fronts the columns are short where they are far, and nowhere else; what these
    /// give and get is right (half a step is 1.4e-4 s^(2/3) of a share s of 1e-5 at most, and
    /// of 64 of them together four times as much); and vectors of all lengths read the same,
    /// but for the order of sums.
    #[test]
    fn far_columns_are_short() {
        for (width, edge) in [(33, 256), (100, 777), (700, 1100)] {
            let made = Made::new(width, edge, false);
            let before: usize =
                panels(made.shape).take(made.shape.panels() - 1).map(Panel::words).sum();
            let panel = Panel::new(made.shape, made.shape.panels() - 1);
            let mut words = &made.words[before + panel.chunk(0).1..];
            let height = made.shape.height();
            let near = |found: f32, expected: f64| {
                let bound = 6e-4 * expected.powf(2.0 / 3.0);
                assert!((f64::from(found) - expected).abs() <= bound, "{found} {expected}");
            };
            let y: Vec<f32> = (0..BLOCK).map(|k| number(5 * k + 1) as f32).collect();
            for row in (0..edge.min(CHUNK) / BLOCK * BLOCK).step_by(BLOCK) {
                // Numbers as these are no sum of few products.
                assert_eq!(rank_of(words[0]), None, "{width} {edge} {row}");
                words = &words[1..];
                for strip in panel.strips() {
                    let columns = Columns::of(words, strip.width);
                    let first = panel.first + strip.first;
                    let far = |k: &usize| is_far(row, first + k);
                    let expected = (0..strip.width).filter(far).fold(0u32, |mask, k| mask | 1 << k);
                    assert_eq!(columns.short, expected, "{width} {edge} {row}");
                    // Only far columns give something, if there are any.
                    let gives = |k: usize| expected == 0 || expected >> k & 1 == 1;
                    let x = std::array::from_fn(|k| match k < strip.width && gives(k) {
                        true => number(k + 3) as f32 * made.factors[first + k],
                        false => 0.0,
                    });
                    let entry =
                        |i: usize, k: usize| -made.dense[(first + k) * height + width + row + i];
                    let packed = || Packed { words, width: strip.width, x: &x, y: &y };
                    let (given, sums) = pulp::Arch::new().dispatch(packed());
                    for (i, &given) in given.iter().enumerate() {
                        let parts = (0..strip.width).filter(|&k| gives(k));
                        near(given, parts.map(|k| entry(i, k) * number(k + 3)).sum());
                    }
                    for (k, &sum) in sums.iter().enumerate() {
                        let parts = (0..BLOCK).map(|i| entry(i, k) * f64::from(y[i]));
                        near(sum * made.factors[first + k], parts.sum());
                    }
                    for (also_given, also_sums) in [
                        pulp::WithSimd::with_simd(packed(), pulp::Scalar512b),
                        pulp::WithSimd::with_simd(packed(), pulp::Scalar256b),
                        pulp::WithSimd::with_simd(packed(), pulp::Scalar128b),
                        pulp::WithSimd::with_simd(packed(), pulp::Scalar),
                    ] {
                        let pairs = given.iter().zip(also_given).chain(sums.iter().zip(also_sums));
                        for (a, b) in pairs {
                            assert!((a - b).abs() <= 1e-5 * a, "{width} {edge} {row}: {a} {b}");
                        }
                    }
                    words = &words[columns.len()..];
                }
            }
        }
    }
}
