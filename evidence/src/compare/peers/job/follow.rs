//! Orderings of a network, and of the same network after small motion.

use std::collections::HashSet;
use std::path::PathBuf;
use std::time::Instant;

use dempfv::Vec3;
use dempfv::scene::load_packing;
use dempfv::solver::ordering::{Ordering, factor_entries};
use serde::{Deserialize, Serialize};

use super::system::Meshed;
use crate::Error;

/// How far a sphere moves along each axis at most, in mean radii.
pub const MOTION: f64 = 0.01;

/// The packing, and how often its network is ordered.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Follow {
    pub packing: PathBuf,
    pub repeats: usize,
    pub run: usize,
}

/// What came out.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Followed {
    pub unknowns: usize,
    /// Share of the pores that were not there before the motion.
    pub new_pores: f64,
    /// An ordering of its own (s).
    pub order_s: Vec<f64>,
    /// The ordering that follows the first network's (s).
    pub follow_s: Vec<f64>,
    /// Entries of the factor with an ordering of its own and with the one that follows.
    pub nnz_own: f64,
    pub nnz_followed: f64,
}

impl Follow {
    /// Orders both networks.
    ///
    /// # Errors
    /// What is wrong in the packing.
    pub fn measure(&self) -> Result<Followed, Error> {
        let (packing, bounds) = load_packing(&self.packing, None).map_err(dempfv::Error::from)?;
        let before = Meshed::new(&packing.position, &packing.radius, bounds)?;
        let reach = MOTION * packing.radius.iter().sum::<f64>() / packing.len().max(1) as f64;
        let move_by = |(i, x): (usize, &Vec3)| {
            let step = |axis: u64| reach * (2.0 * share(3 * i as u64 + axis) - 1.0);
            let moved = x + Vec3::new(step(0), step(1), step(2));
            moved.zip_zip_map(&bounds.min, &bounds.max, f64::clamp)
        };
        let position: Vec<Vec3> = packing.position.iter().enumerate().map(move_by).collect();
        let after = Meshed::new(&position, &packing.radius, bounds)?;
        let first = Ordering::new(&before.operators.matrix, &before.points);
        let (a, points) = (&after.operators.matrix, &after.points);
        let (mut order_s, mut follow_s, mut nnz) = (vec![], vec![], [0; 2]);
        for _ in 0..self.repeats {
            let start = Instant::now();
            let own = Ordering::new(a, points);
            order_s.push(start.elapsed().as_secs_f64());
            let start = Instant::now();
            let followed = first.follow(a, points);
            follow_s.push(start.elapsed().as_secs_f64());
            if nnz == [0; 2] {
                nnz = [&own, &followed].map(|ordering| factor_entries(a, ordering.permutation()));
            }
        }
        Ok(Followed {
            unknowns: a.n,
            new_pores: new_cells(before.cells(), after.cells()),
            order_s,
            follow_s,
            nnz_own: nnz[0] as f64,
            nnz_followed: nnz[1] as f64,
        })
    }
}

/// A number from 0 to 1 that looks random (Steele, Lea and Flood 2014).
fn share(seed: u64) -> f64 {
    let mut z = seed.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) as f64 / u64::MAX as f64
}

/// Share of the cells that were not there before.
fn new_cells(before: &[[u32; 4]], after: &[[u32; 4]]) -> f64 {
    let sorted = |cell: &[u32; 4]| {
        let mut cell = *cell;
        cell.sort_unstable();
        cell
    };
    let old: HashSet<[u32; 4]> = before.iter().map(sorted).collect();
    let new = after.iter().filter(|cell| !old.contains(&sorted(cell))).count();
    new as f64 / after.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_known_by_their_corners() {
        assert_eq!(new_cells(&[[0, 1, 2, 3]], &[[3, 1, 2, 0], [0, 1, 2, 4]]), 0.5);
    }

    #[test]
    fn steps_fill_the_range() {
        let shares: Vec<f64> = (0..1000).map(share).collect();
        assert!(shares.iter().all(|s| (0.0..=1.0).contains(s)));
        let mean = shares.iter().sum::<f64>() / 1000.0;
        // Three standard deviations of the mean of so many: 3 / sqrt(12 · 1000).
        assert!((mean - 0.5).abs() < 0.03, "{mean}");
    }
}
