//! The factor as solves read it: in 16 bits an entry, or 8.
//!
//! Columns are solved for in strips, by the inverse T of the strip's triangle on the
//! diagonal: `x = T x` on the way forward, `x = Tᵀ x` on the way back. T stays in single
//! precision, by columns and by rows, so that both ways are sums of columns. What is
//! below the triangle, L₂, says in which shares a column's flow goes on to later rows.
//! Kept are the third roots of its entries, relative to that of the column's largest, as
//! whole numbers of 16 bits: 15 digits, of base two, of the large shares, 5 of those that
//! are 10⁻⁹ of them. Each column has a factor, in single precision, that makes its shares
//! sum up to what they did before they were rounded: no fluid is lost and none added, only a
//! little of it goes to the neighbour of where it should. A correction then leaves 4·10⁻⁶ of
//! an error. (Of numbers with an exponent, 12 digits would be left for all shares alike, and
//! corrections leave 3·10⁻⁵; without those factors, up to 10⁻³. See docs/solver.md.)
//!
//! In fronts wide enough most shares are far smaller than their column's largest, and it is
//! enough to know these to 8 bits. There each full block of 64 rows says which of a strip's
//! columns are short in it: a short one has a step of its own there, and its roots are whole
//! numbers of steps, up to 255. Or the block, all strips of the panel together, is a sum of
//! few products, see [`super::products`].
//!
//! Shares of single columns are kept, never of a strip as a whole (L₂ T): of two unknowns
//! that are joined firmly the first gives to the second nearly all it has, and little to
//! others. Shares of the two together are nearly the same, and rounding each by itself
//! would drive them apart by more than what they are joined by.

use rayon::prelude::*;

use super::dense::Block;
use super::pivot::STRIP;
use super::products::{Products, head_words, product_words};
use super::shape::{Rows, Shape, TILE};
use super::symbolic::Pattern;

/// Rows of a block: what a solve keeps in registers while it goes through a strip.
pub const BLOCK: usize = 64;

/// Rows of a chunk, which one thread reads block by block.
pub const CHUNK: usize = 2 * TILE;

/// Words after the last that may be read, and have no effect.
pub const SLACK: usize = BLOCK;

/// Roots are whole numbers below this one.
const ROOTS: f32 = 65536.0;

/// Size of the largest share of a column, as it is kept: the third power of the largest
/// root.
const LARGEST: f32 = 0.999_954_2;

/// Shares from here down are none: their roots are far below one.
const NOTHING: f32 = 1e-20;

/// What a half of a word is added to: a number in single precision whose last bit is one,
/// and so the sum's bits are the number's or'ed with the half's. The root is the sum times
/// the scale and the offset added.
pub const ONES: f32 = 8_388_608.0;
pub const SCALE: f32 = 1.0 / ROOTS;
pub const OFFSET: f32 = -ONES * SCALE;

/// Blocks of a column whose shares are no larger have 8 bits an entry, see [`step_of`]. With
/// larger ones a correction leaves more, and a third becomes more frequent.
const SHORT: f32 = 5e-4;

/// Products take the place of a block where they have no more than this part of its words.
const WORTH: f32 = 0.85;

/// Words of such a block: each has rows k and k + 16, and the same of the upper half.
pub const QUARTER: usize = BLOCK / 4;

/// Steps of the roots of short blocks, from 2⁻¹⁰ down in steps of their own: single
/// precision with three binary digits, of which this is the first.
const STEPS: u32 = (127 - 10) << 3;

/// The step of a short block by its byte; roots are up to 255 of them.
#[inline(always)]
pub fn step_of(byte: u32) -> f32 {
    f32::from_bits((STEPS - byte) << 20)
}

/// The byte of the smallest step that is enough for shares up to this one. Blocks of zeros
/// have that of [`NOTHING`]: third powers of smaller steps times a solve's values leave the
/// range in which processors are fast.
fn step_for(largest: f32) -> u32 {
    let least = (largest.max(NOTHING).cbrt() / 255.0).to_bits();
    STEPS - least.div_ceil(1 << 20)
}

/// The root of a share to the nearest whole number.
#[inline(always)]
fn code(share: f32) -> u32 {
    let share = share.max(NOTHING);
    // A third of the exponent and its bias: within 7 %, of which each of Halley's steps
    // leaves less than the third power.
    let mut root = f32::from_bits(share.to_bits() / 3 + 0x2a51_1cd0);
    for _ in 0..2 {
        let cube = root * root * root;
        root *= (cube + 2.0 * share) / (2.0 * cube + share);
    }
    (root * ROOTS + ONES).to_bits() - ONES.to_bits()
}

#[inline(always)]
fn decoded(code: u32) -> f32 {
    let root = f32::from_bits(ONES.to_bits() | code) * SCALE + OFFSET;
    root * root * root
}

/// Words that a column takes for so many rows. Word k of a block of n words holds rows k
/// and k + n.
#[inline(always)]
pub fn words(rows: usize) -> usize {
    rows.div_ceil(2)
}

/// The columns of one panel as solves read them: first what goes to later rows of the
/// panel, strip by strip, then what goes to the rows below, chunk by chunk and in these block
/// by block.
#[derive(Clone, Copy)]
pub struct Panel {
    /// First column in the front, and number of columns.
    pub first: usize,
    pub width: usize,
    /// Rows of the front's own columns after the panel.
    pub later: usize,
    /// Rows of the edge.
    pub edge: usize,
    /// True if full blocks below tell which of their columns are short: in fronts of more
    /// than one strip.
    pub packed: bool,
}

/// Columns of a panel that are eliminated together.
#[derive(Clone, Copy)]
pub struct Strip {
    pub first: usize,
    pub width: usize,
}

impl Strip {
    /// Entries of the inverse of the triangle, T: for each k what row k has up to the
    /// diagonal, then what column k has from there on.
    #[inline(always)]
    pub fn triangle(self) -> usize {
        self.width * (self.width + 1)
    }
}

impl Panel {
    pub fn new(shape: Shape, panel: usize) -> Panel {
        let (first, width) = (panel * TILE, shape.panel_width(panel));
        Panel {
            first,
            width,
            later: shape.width - first - width,
            edge: shape.edge,
            packed: !is_narrow(shape),
        }
    }

    /// The strips, by columns of the panel.
    pub fn strips(self) -> impl DoubleEndedIterator<Item = Strip> + ExactSizeIterator {
        let width = self.width;
        (0..width.div_ceil(STRIP)).map(move |k| {
            let first = k * STRIP;
            Strip { first, width: STRIP.min(width - first) }
        })
    }

    /// Words of a strip's shares in later rows of the panel.
    #[inline(always)]
    pub fn inside(self, strip: Strip) -> usize {
        strip.width * words(self.width - strip.first - strip.width)
    }

    /// Words of all these.
    pub fn all_inside(self) -> usize {
        self.strips().map(|strip| self.inside(strip)).sum()
    }

    /// Chunks below the panel.
    pub fn chunks(self) -> usize {
        self.later.div_ceil(CHUNK) + self.edge.div_ceil(CHUNK)
    }

    /// Words that so many rows below may take: in full blocks a word for the number of
    /// products and one for each strip, if they are packed.
    fn room(self, rows: usize) -> usize {
        let heads = if self.packed { rows / BLOCK * (1 + self.strips().len()) } else { 0 };
        self.width * words(rows) + heads
    }

    /// A chunk's rows, as rows below the panel, and where its words start. It has room as if
    /// all its columns were long, and ends early where some are short.
    pub fn chunk(self, chunk: usize) -> (std::ops::Range<usize>, usize) {
        let own = self.later.div_ceil(CHUNK);
        let (from, len, before) = if chunk < own {
            (chunk * CHUNK, self.later, 0)
        } else {
            ((chunk - own) * CHUNK, self.edge, self.later)
        };
        let rows = before + from..before + len.min(from + CHUNK);
        (rows, self.all_inside() + self.room(before) + self.room(from))
    }

    pub fn words(self) -> usize {
        self.all_inside() + self.room(self.later) + self.room(self.edge)
    }

    /// Entries of the strips' triangles, see [`Strip::triangle`].
    pub fn triangles(self) -> usize {
        self.strips().map(Strip::triangle).sum()
    }
}

/// Where a supernode's parts of the factor start, and its front's shape.
#[derive(Clone, Copy)]
pub struct Place {
    pub words: usize,
    pub triangles: usize,
    /// First column.
    pub column: u32,
    width: u32,
    edge: u32,
}

impl Place {
    #[inline(always)]
    pub fn shape(&self) -> Shape {
        Shape { width: self.width as usize, edge: self.edge as usize }
    }
}

/// Where the parts of the factor of all supernodes start, and where they end.
pub struct Places(Vec<Place>);

impl Places {
    pub fn new(pattern: &Pattern) -> Places {
        let mut next = Place { words: 0, triangles: 0, column: 0, width: 0, edge: 0 };
        let mut places = vec![];
        for s in 0..pattern.supernodes() {
            let shape = pattern.shape(s);
            places.push(Place { width: shape.width as u32, edge: shape.edge as u32, ..next });
            for panel in panels(shape) {
                next.words += panel.words();
                next.triangles += panel.triangles();
            }
            next.column += shape.width as u32;
        }
        places.push(next);
        Places(places)
    }

    /// A supernode's place, or the end's.
    #[inline(always)]
    pub fn of(&self, s: usize) -> &Place {
        &self.0[s]
    }

    /// The end's place.
    pub fn end(&self) -> &Place {
        &self.0[self.0.len() - 1]
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        size_of::<Place>() * self.0.len()
    }
}

/// True for fronts of one strip.
pub fn is_narrow(shape: Shape) -> bool {
    shape.width <= STRIP
}

pub fn panels(shape: Shape) -> impl DoubleEndedIterator<Item = Panel> {
    (0..shape.panels()).map(move |panel| Panel::new(shape, panel))
}

/// Parts of the factor: shares, two or four a word; inverses of the strips' triangles; and by
/// column the factors of the shares and the inverses of the diagonal.
pub struct Part<'a> {
    pub words: &'a mut [u32],
    pub triangles: &'a mut [f32],
    pub factors: &'a mut [f32],
    pub inverse: &'a mut [f32],
}

impl<'a> Part<'a> {
    pub fn split(self, words: usize, triangles: usize, columns: usize) -> (Part<'a>, Part<'a>) {
        let (words, more_words) = self.words.split_at_mut(words);
        let (triangles, more_triangles) = self.triangles.split_at_mut(triangles);
        let (factors, more_factors) = self.factors.split_at_mut(columns);
        let (inverse, more_inverse) = self.inverse.split_at_mut(columns);
        (
            Part { words, triangles, factors, inverse },
            Part {
                words: more_words,
                triangles: more_triangles,
                factors: more_factors,
                inverse: more_inverse,
            },
        )
    }
}

/// Takes over a factored front, in which the triangles of strips on the diagonal are
/// inverted. Blocks may become products where that is allowed.
pub fn take(shape: Shape, l: &[f32], products: bool, part: Part<'_>, shared: bool) {
    let mut rest = part;
    let mut work = vec![];
    for (k, panel) in panels(shape).enumerate() {
        let (this, after) = rest.split(panel.words(), panel.triangles(), panel.width);
        work.push((k, panel, this));
        rest = after;
    }
    let one = |(k, panel, part)| take_panel(shape, k, panel, l, products, part);
    if shared && work.len() > 1 {
        work.into_par_iter().for_each(one);
    } else {
        work.into_iter().for_each(one);
    }
}

fn take_panel(shape: Shape, k: usize, panel: Panel, l: &[f32], products: bool, part: Part<'_>) {
    let start = shape.panel_start(k);
    let w = panel.width;
    let diagonal = &l[start..start + w * w];
    let Part { words, triangles, factors, .. } = part;
    let mut columns = Columns::default();
    let (mut inside, mut triangle) = (0, 0);
    for strip in panel.strips() {
        let (from, size) = (strip.first, strip.width);
        let end = from + size;
        let both = &mut triangles[triangle..triangle + strip.triangle()];
        for (j, both) in both.chunks_exact_mut(size + 1).enumerate() {
            let (row, column) = both.split_at_mut(j + 1);
            column.copy_from_slice(&diagonal[(from + j) * w + from..][j..size]);
            for (i, x) in row.iter_mut().enumerate() {
                *x = diagonal[(from + i) * w + from + j];
            }
        }
        triangle += strip.triangle();

        // The strip's shares, run of rows by run of rows.
        let tile = |rows: Rows| {
            let at = start + shape.tile_start(k, rows.start) + from * rows.len;
            Block { data: &l[at..], rows: rows.len, stride: rows.len }
        };
        let below = Block { data: &diagonal[from * w..], rows: w, stride: w }.below(end);
        let mut sums = Sums::default();
        for block in std::iter::once(below).chain(shape.below(k).map(tile)) {
            pulp::Arch::new().dispatch(Sum { block, size, sums: &mut sums });
        }
        columns.scales[from..end].copy_from_slice(&sums.scales()[..size]);
        columns.total[from..end].copy_from_slice(&sums.total[..size]);
        let here = panel.inside(strip);
        let words = &mut words[inside..inside + here];
        pulp::Arch::new().dispatch(Put { strip, block: below, words, columns: &mut columns });
        inside += here;
    }

    // Then what is below, block by block.
    let mut products = (panel.packed && products).then(Products::new);
    let mut tiles = shape.below(k);
    for chunk in 0..panel.chunks() {
        let (rows, mut at) = panel.chunk(chunk);
        for rows in tiles.by_ref().take(rows.len().div_ceil(TILE)) {
            let tile = &l[start + shape.tile_start(k, rows.start)..];
            for from in (0..rows.len).step_by(BLOCK) {
                let len = BLOCK.min(rows.len - from);
                let block = Block { data: &tile[from..], rows: len, stride: rows.len };
                let packed = panel.packed && len == BLOCK;
                let products = products.as_mut().filter(|_| packed);
                let words = &mut words[at..];
                let columns = &mut columns;
                at += pulp::Arch::new().dispatch(Put64 {
                    panel,
                    block,
                    packed,
                    words,
                    columns,
                    products,
                });
            }
        }
    }
    for (j, factor) in factors[..w].iter_mut().enumerate() {
        let (total, kept) = (columns.total[j], columns.kept[j]);
        *factor = if kept > 0.0 { (total / kept) as f32 } else { 0.0 };
    }
}

/// What the columns of a panel are kept with.
struct Columns {
    /// What makes shares of their entries.
    scales: [f32; TILE],
    /// Sums of their entries, and of the shares that are kept.
    total: [f64; TILE],
    kept: [f64; TILE],
}

impl Default for Columns {
    fn default() -> Columns {
        Columns { scales: [0.0; TILE], total: [0.0; TILE], kept: [0.0; TILE] }
    }
}

/// Largest shares and sums of a strip's columns.
#[derive(Default)]
struct Sums {
    largest: [f32; STRIP],
    total: [f64; STRIP],
}

impl Sums {
    /// What brings each column's largest share to [`LARGEST`].
    fn scales(&self) -> [f32; STRIP] {
        let mut scales = [0.0; STRIP];
        for (scale, &largest) in scales.iter_mut().zip(&self.largest) {
            // A column so small that nothing of it would be left has no shares.
            *scale = if largest > f32::MIN_POSITIVE { LARGEST / largest } else { 0.0 };
        }
        scales
    }
}

struct Sum<'a> {
    block: Block<'a>,
    size: usize,
    sums: &'a mut Sums,
}

impl pulp::NullaryFnOnce for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Sum { block, size, sums } = self;
        let Sums { largest, total } = sums;
        for (k, (largest, total)) in largest.iter_mut().zip(total).enumerate().take(size) {
            let mut most = [0.0f32; 16];
            let mut sum = [0.0f64; 16];
            let column = &block.data[k * block.stride..][..block.rows];
            let chunks = column.chunks_exact(16);
            for (k, &v) in chunks.remainder().iter().enumerate() {
                most[k] = -v;
                sum[k] = f64::from(v);
            }
            for chunk in chunks {
                for ((most, sum), &v) in most.iter_mut().zip(&mut sum).zip(chunk) {
                    *most = if -v > *most { -v } else { *most };
                    *sum += f64::from(v);
                }
            }
            *largest = most.iter().fold(*largest, |m, &v| m.max(v));
            *total -= sum.iter().sum::<f64>();
        }
    }
}

/// Puts a strip's later rows of its panel into words, and sums up what was kept.
struct Put<'a> {
    strip: Strip,
    block: Block<'a>,
    words: &'a mut [u32],
    columns: &'a mut Columns,
}

impl pulp::NullaryFnOnce for Put<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Put { strip, block, words, columns } = self;
        let mut at = 0;
        for from in (0..block.rows).step_by(BLOCK) {
            let len = BLOCK.min(block.rows - from);
            let rows = Block { data: &block.data[from..], rows: len, ..block };
            at += put_strip(rows, strip, false, &mut words[at..], columns);
        }
    }
}

/// The same for up to 64 rows below a panel, and all its columns. A packed block says which of
/// its columns are short, or is a sum of products if there is memory to find these.
struct Put64<'a> {
    panel: Panel,
    block: Block<'a>,
    packed: bool,
    words: &'a mut [u32],
    columns: &'a mut Columns,
    products: Option<&'a mut Products>,
}

impl pulp::WithSimd for Put64<'_> {
    /// How many words that took.
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> usize {
        let Put64 { panel, block, packed, words, columns, products } = self;
        let mut at = 0;
        if let Some(products) = products {
            let scales = &columns.scales[..panel.width];
            let column = |k: usize| &block.data[k * block.stride..][..BLOCK];
            let is_short = |(k, scale): (usize, &f32)| largest_of(column(k)) * scale <= SHORT;
            let short = scales.iter().enumerate().filter(|&column| is_short(column)).count();
            let plain = panel.width * (BLOCK / 2) - short * QUARTER;
            let width = panel.width;
            let head = head_words(width);
            let each = product_words(1, width) - head;
            let most = ((plain as f32 * WORTH) as usize).saturating_sub(head) / each;
            if products.find(simd, block, scales, most) {
                return products.write(words, &mut columns.kept[..width]);
            }
        }
        if packed {
            words[0] = 0;
            at = 1;
        }
        for strip in panel.strips() {
            let strip_block = Block { data: &block.data[strip.first * block.stride..], ..block };
            at += put_strip(strip_block, strip, packed, &mut words[at..], columns);
        }
        at
    }
}

/// Puts up to 64 rows of a strip into words, with a head or without; returns how many
/// words that took.
#[inline(always)]
fn put_strip(
    block: Block<'_>,
    strip: Strip,
    packed: bool,
    words: &mut [u32],
    columns: &mut Columns,
) -> usize {
    let scales = &columns.scales[strip.first..strip.first + strip.width];
    let kept = &mut columns.kept[strip.first..strip.first + strip.width];
    let column = |k: usize| &block.data[k * block.stride..][..block.rows];
    let mut at = 0;
    let short = match packed {
        true => {
            let largest = |(k, scale): (usize, &f32)| largest_of(column(k)) * scale;
            let short = Shorts::of(scales.iter().enumerate().map(largest));
            at += short.write(words);
            short
        }
        false => Shorts::default(),
    };
    let half = self::words(block.rows);
    let is_short = |k: usize| short.mask >> k & 1 == 1;
    for k in (0..scales.len()).filter(|&k| !is_short(k)) {
        let (codes, sum) = coded(column(k), scales[k], 1.0);
        kept[k] += sum;
        let (low, high) = codes.split_at(half);
        for ((word, &low), &high) in words[at..at + half].iter_mut().zip(low).zip(high) {
            *word = low | high << 16;
        }
        at += half;
    }
    for (k, &byte) in (0..scales.len()).filter(|&k| is_short(k)).zip(&short.steps) {
        let step = step_of(byte.into());
        // Of a third root in units of the step.
        let to_unit = 1.0 / (ROOTS * step);
        let factor = to_unit * to_unit * to_unit;
        let (codes, sum) = coded(column(k), scales[k], factor);
        kept[k] += sum / f64::from(factor);
        for (i, word) in words[at..at + QUARTER].iter_mut().enumerate() {
            let byte = |quarter: usize| codes[i + quarter * QUARTER] << (8 * quarter);
            *word = byte(0) | byte(1) | byte(2) | byte(3);
        }
        at += QUARTER;
    }
    at
}

/// The largest share among a column's entries in a full block, before it is scaled.
#[inline(always)]
fn largest_of(column: &[f32]) -> f32 {
    let mut most = [0.0f32; 16];
    for chunk in column.as_chunks::<16>().0 {
        for (most, &v) in most.iter_mut().zip(chunk) {
            *most = if -v > *most { -v } else { *most };
        }
    }
    most.into_iter().fold(0.0, f32::max)
}

/// Roots of a column's entries in a block, and the sum of the shares that they stand for. The
/// scale makes shares of entries; the factor fits those to the step, and both together may
/// be more than a number can hold.
#[inline(always)]
fn coded(column: &[f32], scale: f32, factor: f32) -> ([u32; BLOCK], f64) {
    let mut codes = [0u32; BLOCK];
    for (code, &v) in codes.iter_mut().zip(column) {
        *code = self::code(-v * scale * factor);
    }
    let mut sums = [0.0f32; 16];
    for codes in codes.chunks_exact(16) {
        for (sum, &code) in sums.iter_mut().zip(codes) {
            *sum += decoded(code);
        }
    }
    (codes, sums.iter().map(|&v| f64::from(v)).sum())
}

/// Which columns of a block are short, and the bytes of their steps, one after the other.
#[derive(Default)]
struct Shorts {
    mask: u32,
    steps: [u8; STRIP],
}

impl Shorts {
    /// By the largest share of each column.
    #[inline(always)]
    fn of(largest: impl Iterator<Item = f32>) -> Shorts {
        let mut shorts = Shorts::default();
        let mut count = 0;
        for (k, largest) in largest.enumerate() {
            if largest <= SHORT {
                shorts.mask |= 1 << k;
                shorts.steps[count] = step_for(largest) as u8;
                count += 1;
            }
        }
        shorts
    }

    /// Puts the block's head where its words start; returns its length.
    fn write(&self, words: &mut [u32]) -> usize {
        let len = head(self.mask);
        words[0] = self.mask;
        for (word, bytes) in words[1..len].iter_mut().zip(self.steps.as_chunks().0) {
            *word = u32::from_le_bytes(*bytes);
        }
        len
    }
}

/// Words of the head of a block with these short columns: the columns, and the bytes of
/// their steps. After it come its long columns, then its short ones.
#[inline(always)]
pub fn head(mask: u32) -> usize {
    1 + (mask.count_ones() as usize).div_ceil(4)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every whole number is the root of the share that it stands for; and a share in
    /// between becomes one of the two beside it, whose roots differ from its own by half a
    /// unit at most, but for round-off.
    #[test]
    fn roots_are_rounded_to_the_nearest() {
        for root in 0..ROOTS as u32 {
            assert_eq!(code(decoded(root)), root);
            let between = (f64::from(root) + 0.4) / f64::from(ROOTS);
            let above = (f64::from(root) + 0.6) / f64::from(ROOTS);
            assert_eq!(code(between.powi(3) as f32), root);
            assert_eq!(code(above.powi(3) as f32), root + 1);
        }
        assert_eq!(code(LARGEST), ROOTS as u32 - 1);
        assert_eq!(code(0.0), 0);
    }

    /// The step of a short block is large enough for its largest share, and an eighth
    /// larger than that needs at most; its byte is one.
    #[test]
    fn steps_fit() {
        for k in 0..160 {
            let largest = SHORT * 0.8f32.powi(k);
            let byte = step_for(largest);
            let (step, root) = (step_of(byte), largest.cbrt());
            assert!(root <= 255.4 * step && root >= 226.0 * step && byte < 256, "{largest}");
        }
        assert_eq!(step_for(0.0), step_for(NOTHING));
        // What is multiplied by it stays a normal number, unless it is as small as that.
        assert!(step_of(step_for(0.0)).powi(3) > 1e-28);
    }
}
