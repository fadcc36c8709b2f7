//! Order along a Hilbert curve: neighbours in space end up near in memory.

use crate::Vec3;

/// Bits per axis: 2¹⁶ cells along the longest side of the cloud of points.
const BITS: u32 = 16;

/// The permutation that puts points in spatial order: entry k is the index
/// of the point that comes k-th. Points in one cell keep their order.
pub(super) fn spatial_order(position: &[Vec3]) -> Vec<u32> {
    let Some(first) = position.first() else { return Vec::new() };
    let (low, high) = position.iter().fold((*first, *first), |(a, b), x| (a.inf(x), b.sup(x)));
    let extent = (high - low).max();
    let scale = if extent > 0.0 { f64::from((1u32 << BITS) - 1) / extent } else { 0.0 };
    let mut keyed: Vec<(u64, u32)> = position
        .iter()
        .zip(0u32..)
        .map(|(x, i)| {
            let cell = (x - low) * scale;
            (key([cell.x as u32, cell.y as u32, cell.z as u32]), i)
        })
        .collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, i)| i).collect()
}

/// Distance along the Hilbert curve of a cell, by Skilling's transform (AIP
/// Conf. Proc. 707, 381, 2004): undo the curve's rotations from the coarsest
/// level down, Gray-decode, interleave.
fn key(mut x: [u32; 3]) -> u64 {
    let mut bit = 1u32 << (BITS - 1);
    while bit > 1 {
        let low_bits = bit - 1;
        for axis in 0..3 {
            if x[axis] & bit != 0 {
                x[0] ^= low_bits;
            } else {
                let swap = (x[0] ^ x[axis]) & low_bits;
                x[0] ^= swap;
                x[axis] ^= swap;
            }
        }
        bit >>= 1;
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    let mut parity = 0;
    let mut bit = 1u32 << (BITS - 1);
    while bit > 1 {
        if x[2] & bit != 0 {
            parity ^= bit - 1;
        }
        bit >>= 1;
    }
    let mut key = 0u64;
    for level in (0..BITS).rev() {
        for component in x {
            key = key << 1 | u64::from((component ^ parity) >> level & 1);
        }
    }
    key
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The defining property of the curve: it visits every cell of a cube
    /// once, and consecutive cells share a face.
    #[test]
    fn consecutive_cells_share_a_face() {
        let side = 8u32;
        let mut cells: Vec<[u32; 3]> = (0..side)
            .flat_map(|x| (0..side).flat_map(move |y| (0..side).map(move |z| [x, y, z])))
            .collect();
        cells.sort_by_key(|&c| key(c));
        for pair in cells.windows(2) {
            let apart: u32 = (0..3).map(|k| pair[0][k].abs_diff(pair[1][k])).sum();
            assert_eq!(apart, 1, "{pair:?}");
        }
    }
}
