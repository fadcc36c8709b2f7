//! The packed factor, as solves read it: quantized to 16 bits an entry, or 8, with the sum of each
//! column kept (as the compensated incomplete factorizations of Gustafsson 1978 keep row sums).
//!
//! Columns are solved for in pivot blocks, by the inverse T of the pivot block's triangle on the
//! diagonal: `x = T x` in the forward substitution, `x = Tᵀ x` in the backward substitution. T stays in single
//! precision, by columns and by rows, so that both ways are sums of columns. What is
//! below the triangle, L₂, says in which multipliers a column's flow goes on to later rows.
//! Kept are the cube roots of its entries, relative to that of the column's largest, as
//! whole numbers of 16 bits: 15 digits, of base two, of the large multipliers, 5 of those that
//! are 10⁻⁹ of them. Each column has a factor, in single precision, that makes its multipliers
//! sum up to what they did before they were rounded: no fluid is lost and none added, only a
//! little of it goes to the neighbour of where it should. A correction then leaves 4·10⁻⁶ of
//! an error. (Of numbers with an exponent, 12 digits would be left for all multipliers alike, and
//! corrections leave 3·10⁻⁵; without those factors, up to 10⁻³. See docs/solver.md.)
//!
//! In fronts wide enough most multipliers are far smaller than their column's largest, and it is
//! enough to know these to 8 bits. There each full block of 64 rows says which of a pivot block's
//! columns are 8-bit in it: a 8-bit one has a step of its own there, and its roots are whole
//! numbers of steps, up to 255. Or the block, all pivot blocks of the panel together, is a sum of
//! few rank-one terms, see [`super::low_rank`].
//!
//! Multipliers of single columns are kept, never of a pivot block as a whole (L₂ T): of two unknowns
//! that are joined firmly the first gives to the second nearly all it has, and little to
//! others. Multipliers of the two together are nearly the same, and rounding each by itself
//! would drive them apart by more than what they are joined by.

mod pack;
mod quantize;

use super::block::PIVOT_BLOCK;
pub use super::block::{BLOCK_ROWS, words};
use super::shape::{Shape, TILE};
use super::symbolic::Pattern;
pub use pack::pack;
pub use quantize::{CODE_BASE, ROOT_OFFSET, ROOT_SCALE, step_of};

/// Rows of a chunk, which one thread reads block by block.
pub const CHUNK_ROWS: usize = 2 * TILE;

/// Words after the last that may be read, and have no effect.
pub const OVERREAD_WORDS: usize = BLOCK_ROWS;

/// Words of such a block: each has rows k and k + 16, and the same of the upper half.
pub const EIGHT_BIT_COLUMN_WORDS: usize = BLOCK_ROWS / 4;

/// The columns of one panel as solves read them: first what goes to later rows of the
/// panel, pivot block by pivot block, then what goes to the rows below, chunk by chunk and in these block
/// by block.
#[derive(Clone, Copy)]
pub struct Panel {
    /// First column in the front, and number of columns.
    pub first: usize,
    pub width: usize,
    /// Rows of the front's own columns after the panel.
    pub later_rows: usize,
    /// Rows of the border.
    pub border: usize,
    /// True if full blocks below tell which of their columns are 8-bit: in fronts of more
    /// than one pivot block.
    pub mixed: bool,
}

/// Columns of a panel that are eliminated together.
#[derive(Clone, Copy)]
pub struct PivotBlock {
    pub first: usize,
    pub width: usize,
}

impl PivotBlock {
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
            later_rows: shape.width - first - width,
            border: shape.border,
            mixed: !is_narrow(shape),
        }
    }

    /// The pivot blocks, by columns of the panel.
    pub fn pivot_blocks(self) -> impl DoubleEndedIterator<Item = PivotBlock> + ExactSizeIterator {
        let width = self.width;
        (0..width.div_ceil(PIVOT_BLOCK)).map(move |k| {
            let first = k * PIVOT_BLOCK;
            PivotBlock { first, width: PIVOT_BLOCK.min(width - first) }
        })
    }

    /// Words of a pivot block's multipliers in later rows of the panel.
    #[inline(always)]
    pub fn diagonal_words(self, pivot_block: PivotBlock) -> usize {
        pivot_block.width * words(self.width - pivot_block.first - pivot_block.width)
    }

    /// Words of all these.
    pub fn all_diagonal_words(self) -> usize {
        self.pivot_blocks().map(|pivot_block| self.diagonal_words(pivot_block)).sum()
    }

    /// Chunks below the panel.
    pub fn chunks(self) -> usize {
        self.later_rows.div_ceil(CHUNK_ROWS) + self.border.div_ceil(CHUNK_ROWS)
    }

    /// Words that so many rows below may take: in full blocks a word for the number of
    /// terms and one for each pivot block, if they are packed.
    fn capacity(self, rows: usize) -> usize {
        let heads =
            if self.mixed { rows / BLOCK_ROWS * (1 + self.pivot_blocks().len()) } else { 0 };
        self.width * words(rows) + heads
    }

    /// A chunk's rows, as rows below the panel, and where its words start. It has room as if
    /// all its columns were 16-bit, and ends early where some are 8-bit.
    pub fn chunk(self, chunk: usize) -> (std::ops::Range<usize>, usize) {
        let own = self.later_rows.div_ceil(CHUNK_ROWS);
        let (from, len, before) = if chunk < own {
            (chunk * CHUNK_ROWS, self.later_rows, 0)
        } else {
            ((chunk - own) * CHUNK_ROWS, self.border, self.later_rows)
        };
        let rows = before + from..before + len.min(from + CHUNK_ROWS);
        (rows, self.all_diagonal_words() + self.capacity(before) + self.capacity(from))
    }

    pub fn words(self) -> usize {
        self.all_diagonal_words() + self.capacity(self.later_rows) + self.capacity(self.border)
    }

    /// Entries of the pivot blocks' triangles, see [`PivotBlock::triangle`].
    pub fn triangles(self) -> usize {
        self.pivot_blocks().map(PivotBlock::triangle).sum()
    }
}

/// Where a supernode's parts of the factor start, and its front's shape.
#[derive(Clone, Copy)]
pub struct FrontOffsets {
    pub words: usize,
    pub triangles: usize,
    /// First column.
    pub column: u32,
    width: u32,
    border: u32,
}

impl FrontOffsets {
    #[inline(always)]
    pub fn shape(&self) -> Shape {
        Shape { width: self.width as usize, border: self.border as usize }
    }
}

/// Where the parts of the factor of all supernodes start, and where they end.
pub struct FactorLayout(Vec<FrontOffsets>);

impl FactorLayout {
    pub fn new(pattern: &Pattern) -> FactorLayout {
        let mut next = FrontOffsets { words: 0, triangles: 0, column: 0, width: 0, border: 0 };
        let mut layout = vec![];
        for s in 0..pattern.supernodes() {
            let shape = pattern.shape(s);
            layout.push(FrontOffsets {
                width: shape.width as u32,
                border: shape.border as u32,
                ..next
            });
            for panel in panels(shape) {
                next.words += panel.words();
                next.triangles += panel.triangles();
            }
            next.column += shape.width as u32;
        }
        layout.push(next);
        FactorLayout(layout)
    }

    /// A supernode's place, or the end's.
    #[inline(always)]
    pub fn of(&self, s: usize) -> &FrontOffsets {
        &self.0[s]
    }

    /// The end's place.
    pub fn end(&self) -> &FrontOffsets {
        &self.0[self.0.len() - 1]
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        size_of::<FrontOffsets>() * self.0.len()
    }
}

/// True for fronts of one pivot block.
pub fn is_narrow(shape: Shape) -> bool {
    shape.width <= PIVOT_BLOCK
}

pub fn panels(shape: Shape) -> impl DoubleEndedIterator<Item = Panel> {
    (0..shape.panels()).map(move |panel| Panel::new(shape, panel))
}

/// Parts of the factor: multipliers, two or four a word; inverses of the pivot blocks' triangles; and by
/// column the factors of the multipliers and the inverses of the diagonal.
pub struct FactorSlices<'a> {
    pub words: &'a mut [u32],
    pub triangles: &'a mut [f32],
    pub factors: &'a mut [f32],
    pub inverse: &'a mut [f32],
}

impl<'a> FactorSlices<'a> {
    pub fn split(
        self,
        words: usize,
        triangles: usize,
        columns: usize,
    ) -> (FactorSlices<'a>, FactorSlices<'a>) {
        let (words, more_words) = self.words.split_at_mut(words);
        let (triangles, more_triangles) = self.triangles.split_at_mut(triangles);
        let (factors, more_factors) = self.factors.split_at_mut(columns);
        let (inverse, more_inverse) = self.inverse.split_at_mut(columns);
        (
            FactorSlices { words, triangles, factors, inverse },
            FactorSlices {
                words: more_words,
                triangles: more_triangles,
                factors: more_factors,
                inverse: more_inverse,
            },
        )
    }
}

/// Words of the header of a block with these 8-bit columns: the columns, and the bytes of
/// their steps. After it come its 16-bit columns, then its 8-bit ones.
#[inline(always)]
pub fn header(mask: u32) -> usize {
    1 + (mask.count_ones() as usize).div_ceil(4)
}
