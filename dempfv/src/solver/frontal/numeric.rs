//! The numerical factorization, multifrontal (Duff and Reid 1983; Liu 1992): a front is assembled
//! from entries of the matrix and the contribution blocks of its children, its own columns are
//! eliminated panel by panel, and the Schur complement is its contribution block to the parent.
//! Pivots are sums of sizes (Grassmann, Taksar and Heyman 1985).

use rayon::prelude::*;

use super::block::Block;
use super::dense;
use super::extend_add::{self, ContributionBlock};
use super::packed::{self, FactorLayout, FactorSlices};
use super::pivot;
use super::product::Product;
use super::schedule::Schedule;
use super::shape::Shape;
use super::solve_right::solve_right;
use super::symbolic::Pattern;

/// Where a factorization stopped: a column of the factor.
pub struct Stopped(pub usize);

/// The factor as solves read it (see [`packed`]), with some slack after what may be read
/// beyond its end, and the inverses of its diagonal.
#[derive(Default)]
pub struct PackedFactor {
    pub words: Vec<u32>,
    pub triangles: Vec<f32>,
    pub factors: Vec<f32>,
    pub inverse: Vec<f32>,
}

impl PackedFactor {
    fn all(&mut self) -> FactorSlices<'_> {
        let PackedFactor { words, triangles, factors, inverse } = self;
        FactorSlices { words, triangles, factors, inverse }
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        let PackedFactor { words, triangles, factors, inverse } = self;
        4 * (words.len() + triangles.len() + factors.len() + inverse.len())
    }
}

/// Fronts of so many entries share their tiles between threads.
const PARALLEL_FRONT_ENTRIES: usize = 1 << 17;

pub struct Factorization<'a> {
    pub pattern: &'a Pattern,
    pub schedule: &'a Schedule,
    pub layout: &'a FactorLayout,
    /// Values of the matrix, scaled.
    pub values: &'a [f32],
    /// Row sums by column of the factor, scaled.
    pub row_excess: &'a [f32],
}

impl Factorization<'_> {
    /// Factors into memory of the right size or more.
    pub fn run(&self, into: &mut PackedFactor) -> Result<(), Stopped> {
        self.tasks(&self.schedule.roots, into.all(), &mut vec![]).map(|_| ())
    }

    /// Cuts off the front part: that of supernodes `from..to`, with which it starts.
    fn cut<'a>(
        &self,
        part: FactorSlices<'a>,
        from: usize,
        to: usize,
    ) -> (FactorSlices<'a>, FactorSlices<'a>) {
        let (from, to) = (self.layout.of(from), self.layout.of(to));
        let columns = (to.column - from.column) as usize;
        part.split(to.words - from.words, to.triangles - from.triangles, columns)
    }

    /// Works through tasks, two halves at a time, and collects what they leave.
    fn tasks(
        &self,
        tasks: &[u32],
        part: FactorSlices<'_>,
        contributions: &mut Vec<ContributionBlock>,
    ) -> Result<(), Stopped> {
        match tasks {
            [] => Ok(()),
            [task] => {
                contributions.push(self.task(*task as usize, part)?);
                Ok(())
            }
            _ => {
                let (a, b) = tasks.split_at(tasks.len() / 2);
                let all = |task: u32| &self.schedule.tasks[task as usize].all;
                let (part_a, part_b) = self.cut(part, all(a[0]).start, all(b[0]).start);
                let mut more = vec![];
                let (first, second) = rayon::join(
                    || self.tasks(a, part_a, contributions),
                    || self.tasks(b, part_b, &mut more),
                );
                first?;
                second?;
                contributions.append(&mut more);
                Ok(())
            }
        }
    }

    fn task(&self, task: usize, part: FactorSlices<'_>) -> Result<ContributionBlock, Stopped> {
        let task = &self.schedule.tasks[task];
        let mut stack: Vec<ContributionBlock> = vec![];
        let (below, mut rest) = self.cut(part, task.all.start, task.own.start);
        self.tasks(&task.children, below, &mut stack)?;
        for s in task.own.clone() {
            let children = self.pattern.children.of(s).len();
            let from = stack.len() - children;
            let (this, after) = self.cut(rest, s, s + 1);
            rest = after;
            let contribution = self.front(s, this, &stack[from..])?;
            stack.truncate(from);
            stack.push(contribution);
        }
        // The last supernode of a task is the root of all others in it.
        Ok(stack.pop().unwrap_or(ContributionBlock {
            from: 0,
            entries: vec![],
            row_excess: vec![],
        }))
    }

    fn front(
        &self,
        s: usize,
        part: FactorSlices<'_>,
        children: &[ContributionBlock],
    ) -> Result<ContributionBlock, Stopped> {
        let pattern = self.pattern;
        let shape = pattern.shape(s);
        let parallel = shape.height() * shape.height() / 2 >= PARALLEL_FRONT_ENTRIES;
        let mut l = vec![0.0; shape.len()];
        let l = &mut l[..];
        self.assemble(s, l);
        let columns = pattern.first[s] as usize..pattern.first[s + 1] as usize;
        let mut row_excess = vec![0.0; shape.height()];
        row_excess[..shape.width].copy_from_slice(&self.row_excess[columns.clone()]);
        for child in children {
            for (&row, e) in pattern.relative_indices(child.from).iter().zip(&child.row_excess) {
                row_excess[row as usize] += e;
            }
        }
        extend_add::pivot_columns(pattern, children, shape, l, parallel);
        for panel in 0..shape.panels() {
            eliminate(shape, panel, l, part.inverse, &mut row_excess, parallel)
                .map_err(|k| Stopped(columns.start + k))?;
        }
        let mut entries = vec![0.0; Shape { width: shape.border, border: 0 }.len()];
        schur_complement(shape, l, &mut entries, parallel);
        extend_add::schur_complement(pattern, children, shape, &mut entries, parallel);
        packed::pack(shape, l, self.schedule.low_rank, part, parallel);
        row_excess.drain(..shape.width);
        Ok(ContributionBlock { from: s, entries, row_excess })
    }

    /// The entries of the matrix.
    fn assemble(&self, s: usize, l: &mut [f32]) {
        let Pattern { first, entries, .. } = self.pattern;
        let from = entries.column_start[first[s] as usize] as usize;
        let to = entries.column_start[first[s + 1] as usize] as usize;
        for (&source, &target) in entries.source[from..to].iter().zip(&entries.target[from..to]) {
            l[target as usize] = self.values[source as usize];
        }
    }
}

/// A tile: row, number of rows, entries.
type Tile<'a> = (usize, usize, &'a mut [f32]);

/// The tiles of a panel below its diagonal.
fn tiles_below(shape: Shape, panel: usize, mut below: &mut [f32]) -> Vec<Tile<'_>> {
    let width = shape.panel_width(panel);
    shape
        .below(panel)
        .map(|rows| {
            let (tile, rest) = std::mem::take(&mut below).split_at_mut(rows.len * width);
            below = rest;
            (rows.start, rows.len, tile)
        })
        .collect()
}

/// Does something with each tile, on all threads if that pays.
fn each<T: Send>(items: Vec<T>, parallel: bool, work: impl Fn(T) + Sync + Send) {
    if parallel && items.len() > 1 {
        items.into_par_iter().for_each(work);
    } else {
        items.into_iter().for_each(work);
    }
}

/// Eliminates one panel of a front whose earlier panels are done.
fn eliminate(
    shape: Shape,
    panel: usize,
    l: &mut [f32],
    inverse: &mut [f32],
    row_excess: &mut [f32],
    parallel: bool,
) -> Result<(), usize> {
    let first = panel * super::shape::TILE;
    let width = shape.panel_width(panel);
    let (done, rest) = l.split_at_mut(shape.panel_start(panel));
    let this = &mut rest[..width * (shape.height() - first)];
    let (diagonal, below) = this.split_at_mut(width * width);

    // Subtracts what earlier panels of this front contribute.
    let contributions = |row: usize, rows: usize, tile: &mut [f32]| {
        for earlier in 0..panel {
            let start = shape.panel_start(earlier);
            let k = shape.panel_width(earlier);
            let a = start + shape.tile_start(earlier, row);
            let b = start + shape.tile_start(earlier, first);
            let product = Product {
                a: Block::packed(&done[a..a + rows * k], rows),
                b: Block::packed(&done[b..b + width * k], width),
                depth: k,
                lower: row == first,
                fresh: false,
            };
            product.subtract_from(tile, rows);
        }
    };
    if panel > 0 {
        let mut tiles = tiles_below(shape, panel, below);
        tiles.push((first, width, &mut *diagonal));
        each(tiles, parallel, |(row, rows, tile)| contributions(row, rows, tile));
    }

    let mut rest = row_excess[first..first + width].to_vec();
    for (_, rows, tile) in tiles_below(shape, panel, below) {
        dense::subtract_column_sums(tile, rows, &mut rest);
    }
    let inverse = &mut inverse[first..first + width];
    pivot::factor_diagonal(diagonal, &mut rest, inverse).map_err(|k| first + k)?;
    let (triangle, inverse) = (&*diagonal, &*inverse);
    each(tiles_below(shape, panel, below), parallel, |(_, rows, tile)| {
        solve_right(tile, rows, triangle, inverse);
    });
    pivot::invert_pivot_blocks(diagonal, width);

    // The row excess of a row grows by its part of those that it is relieved of.
    let (own, later) = row_excess[first..].split_at_mut(width);
    dense::solve_lower(own, diagonal);
    for (row, rows, tile) in tiles_below(shape, panel, below) {
        let at = row - first - width;
        dense::subtract_times(&mut later[at..at + rows], tile, own);
    }
    Ok(())
}

/// What the eliminated columns subtract from the rest of the front, which is zero before.
/// The first of them write and do not read: memory whose zeros are read before they are
/// written to comes twice from the system, and the second time all threads wait.
fn schur_complement(shape: Shape, l: &[f32], entries: &mut [f32], parallel: bool) {
    let square = Shape { width: shape.border, border: 0 };
    let mut rest = entries;
    let mut tiles = vec![];
    for column in 0..square.panels() {
        let (n, from) = (square.panel_width(column), column * super::shape::TILE);
        let panel = n * (square.width - from);
        let (mut this, after) = std::mem::take(&mut rest).split_at_mut(panel);
        rest = after;
        let rows = square.panel_width(column);
        let diagonal = std::iter::once(super::shape::Rows { start: from, len: rows });
        for tile in diagonal.chain(square.below(column)) {
            let (entries, after) = std::mem::take(&mut this).split_at_mut(tile.len * n);
            this = after;
            tiles.push((tile, from, n, entries));
        }
    }
    each(tiles, parallel, |(rows, from, n, tile)| {
        for panel in 0..shape.panels() {
            let start = shape.panel_start(panel);
            let k = shape.panel_width(panel);
            let a = start + shape.tile_start(panel, shape.width + rows.start);
            let b = start + shape.tile_start(panel, shape.width + from);
            let product = Product {
                a: Block::packed(&l[a..a + rows.len * k], rows.len),
                b: Block::packed(&l[b..b + n * k], n),
                depth: k,
                lower: rows.start == from,
                fresh: panel == 0,
            };
            product.subtract_from(tile, rows.len);
        }
    });
}
