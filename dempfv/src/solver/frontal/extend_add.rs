//! The extend-add: contribution blocks of children are added to the parent's front, by the relative
//! indices of their rows in it (Schreiber 1982; Liu 1992).

use rayon::prelude::*;

use super::shape::{Rows, Shape, TILE};
use super::symbolic::Pattern;

/// What a front leaves to its parent.
pub struct ContributionBlock {
    /// The supernode of the front.
    pub from: usize,
    /// The Schur complement, in tiles; its diagonal is not kept.
    pub entries: Vec<f32>,
    /// What the rows' row excesses have grown by.
    pub row_excess: Vec<f32>,
}

/// Rows of a child that share a tile in it and a tile of the parent.
struct Segment {
    from: usize,
    to: usize,
    /// The child's tile.
    source: Rows,
    /// The parent's tile, and the first row's place in it.
    target: Rows,
    offset: usize,
    /// The rows follow each other in the parent too.
    contiguous: bool,
}

/// Rows `range` of a child in a parent of the given shape, whose row 0 is row
/// `base` of the parent's front.
fn segments(
    map: &[u32],
    range: std::ops::Range<usize>,
    parent: Shape,
    base: usize,
) -> Vec<Segment> {
    let source = Shape { width: map.len(), border: 0 };
    let mut out = vec![];
    let mut from = range.start;
    while from < range.end {
        let first = map[from] as usize - base;
        let target = parent.tile_of(first);
        let tile = source.tile_of(from);
        let end = range.end.min(tile.start + tile.len);
        let limit = (target.start + target.len + base) as u32;
        let to = from + map[from..end].partition_point(|&row| row < limit);
        let contiguous = map[to - 1] as usize - base - first == to - 1 - from;
        let offset = first - target.start;
        out.push(Segment { from, to, source: tile, target, offset, contiguous });
        from = to;
    }
    out
}

/// Adds columns of a child to one panel of the parent.
struct Addition<'a> {
    map: &'a [u32],
    entries: &'a [f32],
    segments: &'a [Segment],
    parent: Shape,
    base: usize,
}

impl Addition<'_> {
    fn columns(&self, columns: std::ops::Range<usize>, panel: usize, out: &mut [f32]) {
        let source = Shape { width: self.map.len(), border: 0 };
        let mut first = 0;
        for column in columns {
            let target = self.map[column] as usize - self.base - panel * TILE;
            let own = column / TILE;
            let start = source.panel_start(own);
            while self.segments[first].to <= column {
                first += 1;
            }
            for segment in &self.segments[first..] {
                let from = segment.from.max(column);
                let tile = segment.source;
                let at = start
                    + source.tile_start(own, tile.start)
                    + (column - own * TILE) * tile.len
                    + (from - tile.start);
                let values = &self.entries[at..at + segment.to - from];
                let column = self.parent.tile_start(panel, segment.target.start)
                    + target * segment.target.len;
                let column = &mut out[column..column + segment.target.len];
                if segment.contiguous {
                    let to = segment.offset + from - segment.from;
                    let out = &mut column[to..to + values.len()];
                    out.iter_mut().zip(values).for_each(|(x, v)| *x += v);
                } else {
                    let base = (self.base + segment.target.start) as u32;
                    for (&row, v) in self.map[from..segment.to].iter().zip(values) {
                        column[(row - base) as usize] += v;
                    }
                }
            }
        }
    }
}

/// Adds to the columns that the parent eliminates.
pub fn pivot_columns(
    pattern: &Pattern,
    children: &[ContributionBlock],
    shape: Shape,
    l: &mut [f32],
    parallel: bool,
) {
    add(pattern, children, shape, 0..shape.width, l, parallel);
}

/// Adds to what the parent leaves to its own parent.
pub fn schur_complement(
    pattern: &Pattern,
    children: &[ContributionBlock],
    shape: Shape,
    out: &mut [f32],
    parallel: bool,
) {
    let square = Shape { width: shape.border, border: 0 };
    add(pattern, children, square, shape.width..shape.height(), out, parallel);
}

/// Adds the columns of the children that lie in `range` of the parent's front.
fn add(
    pattern: &Pattern,
    children: &[ContributionBlock],
    parent: Shape,
    range: std::ops::Range<usize>,
    out: &mut [f32],
    parallel: bool,
) {
    if parent.width == 0 || children.is_empty() {
        return;
    }
    let base = range.start;
    let lists: Vec<Vec<Segment>> = children
        .iter()
        .map(|child| {
            let map = pattern.relative_indices(child.from);
            let from = map.partition_point(|&row| (row as usize) < base);
            segments(map, from..map.len(), parent, base)
        })
        .collect();
    let panel = |panel: usize, out: &mut [f32]| {
        let from = (base + panel * TILE) as u32;
        let to = from + parent.panel_width(panel) as u32;
        for (child, segments) in children.iter().zip(&lists) {
            let map = pattern.relative_indices(child.from);
            let columns =
                map.partition_point(|&row| row < from)..map.partition_point(|&row| row < to);
            let addition = Addition { map, entries: &child.entries, segments, parent, base };
            addition.columns(columns, panel, out);
        }
    };
    let mut schur_complement = out;
    let mut panels = vec![];
    for k in 0..parent.panels() {
        let size = parent.panel_width(k) * (parent.height() - k * TILE);
        let (this, after) = std::mem::take(&mut schur_complement).split_at_mut(size);
        schur_complement = after;
        panels.push((k, this));
    }
    if parallel && panels.len() > 1 {
        panels.into_par_iter().for_each(|(k, out)| panel(k, out));
    } else {
        panels.into_iter().for_each(|(k, out)| panel(k, out));
    }
}
