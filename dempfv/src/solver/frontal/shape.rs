//! How the entries of a front lie in memory while it is factored.
//!
//! A front's lower trapezoid is cut into square tiles, each stored by columns (the block layout of
//! Gustavson 1997), and the tiles follow each other panel by panel: what one task works on is one run
//! of memory.

/// Rows and columns of a tile. Three of them fit into a core's second cache.
pub const TILE: usize = 256;

/// A lower trapezoid: `width` columns, and `width + border` rows of which the
/// first `width` belong to the same unknowns as the columns. Tiles do not
/// cross from these rows into those of the border.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    pub width: usize,
    pub border: usize,
}

/// A run of rows that share a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rows {
    pub start: usize,
    pub len: usize,
}

impl Shape {
    pub fn height(self) -> usize {
        self.width + self.border
    }

    pub fn panels(self) -> usize {
        self.width.div_ceil(TILE)
    }

    pub fn panel_width(self, panel: usize) -> usize {
        TILE.min(self.width - panel * TILE)
    }

    /// Where a panel starts; for one past the last, the number of entries.
    pub fn panel_start(self, panel: usize) -> usize {
        if panel == self.panels() {
            let full = self.width / TILE;
            let rest = self.width % TILE;
            return self.before(full) + rest * (self.height() - full * TILE);
        }
        self.before(panel)
    }

    /// Entries of so many full panels.
    fn before(self, panels: usize) -> usize {
        // Twice the sum of 0 .. panels first: it is even.
        TILE * (panels * self.height()) - TILE * TILE * (panels * panels.saturating_sub(1) / 2)
    }

    /// Number of entries.
    pub fn len(self) -> usize {
        self.panel_start(self.panels())
    }

    /// The tile that a row lies in.
    pub fn tile_of(self, row: usize) -> Rows {
        if row < self.width {
            let start = row / TILE * TILE;
            Rows { start, len: TILE.min(self.width - start) }
        } else {
            let start = self.width + (row - self.width) / TILE * TILE;
            Rows { start, len: TILE.min(self.height() - start) }
        }
    }

    /// The tiles of a panel below its diagonal tile.
    pub fn below(self, panel: usize) -> impl Iterator<Item = Rows> + Clone {
        let pivots = panel + 1..self.panels();
        let pivots = pivots.map(move |q| Rows { start: q * TILE, len: self.panel_width(q) });
        pivots.chain(self.border_tiles())
    }

    /// The tiles of the border.
    pub fn border_tiles(self) -> impl Iterator<Item = Rows> + Clone {
        (0..self.border.div_ceil(TILE)).map(move |k| Rows {
            start: self.width + k * TILE,
            len: TILE.min(self.border - k * TILE),
        })
    }

    /// Where a tile starts within its panel.
    pub fn tile_start(self, panel: usize, row: usize) -> usize {
        self.panel_width(panel) * (row - panel * TILE)
    }

    /// Where an entry lies.
    pub fn index(self, row: usize, column: usize) -> usize {
        let panel = column / TILE;
        let tile = self.tile_of(row);
        self.panel_start(panel)
            + self.tile_start(panel, tile.start)
            + (column - panel * TILE) * tile.len
            + (row - tile.start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every entry of the lower trapezoid (and of the upper halves of diagonal
    /// tiles) has a place of its own, and no place is left over.
    #[test]
    fn places_are_a_permutation() {
        for (width, border) in [(1, 0), (3, 5), (256, 0), (257, 300), (700, 13), (512, 512)] {
            let shape = Shape { width, border };
            let mut seen = vec![false; shape.len()];
            for column in 0..width {
                for row in column / TILE * TILE..shape.height() {
                    let at = &mut seen[shape.index(row, column)];
                    assert!(!std::mem::replace(at, true), "{width} {border}: {row}, {column}");
                }
            }
            assert!(seen.iter().all(|&s| s), "{width} {border}");
        }
    }
}
