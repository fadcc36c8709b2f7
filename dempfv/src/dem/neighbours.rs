//! The neighbour list: which spheres and walls may touch, and the history of
//! those that do.
//!
//! The list holds every pair whose gap is less than the law's cut-off and a
//! skin. It stays complete until
//! something has moved by half the skin. The pairs of a block of particles
//! come first those inside the block, then those with a later block, each
//! sorted by first and second sphere. Pairs beyond the cut-off contribute
//! nothing, so results do not depend on when the list was built.

use rayon::prelude::*;

use super::cell_neighbours::{CellStrain, Sight, Wrapped};
use super::clumps::NO_CLUMP;
use super::error::DemError;
use super::grid::Grid;
use super::kept::{Kept, history_of, merge};
use super::particles::Particles;
use super::state::{ContactHistory, DemState};
use super::walls::{Wall, box_of};
use crate::parallel::{BLOCK, block_count};
use crate::{Cell, PerWall, Tensor, WallId};

/// Share of the skin that must be left for a list to be kept: with less, the
/// particles would be looked at in nearly every step.
const LEAST_LEFT: f64 = 0.1;

/// Where the entries of a block start; the next block's start ends them.
#[derive(Clone, Copy, Default)]
pub(super) struct Bounds {
    /// Pairs with both spheres in the block.
    pub inner: usize,
    /// Pairs whose second sphere is in a later block.
    pub outer: usize,
    /// The results of the outer pairs.
    pub sent: usize,
    /// Sphere-wall pairs.
    pub wall: usize,
}

/// A sphere near a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct WallPair {
    pub i: u32,
    pub wall: WallId,
}

/// The neighbour list. Scratch: what a checkpoint needs of it is copied out
/// by [`Neighbours::sphere_history`] and [`Neighbours::wall_history`].
#[derive(Default)]
pub(super) struct Neighbours {
    /// Numbers per contact in the histories.
    length: usize,
    /// Spheres that may touch, the smaller index first.
    pub pairs: Vec<[u32; 2]>,
    /// Which copy of its second sphere each pair means; empty without a periodic cell.
    pub image: Vec<u8>,
    /// Which of the pairs were within the law's reach when the contacts were
    /// last computed.
    pub touch: Vec<bool>,
    /// What each pair remembers; zero out of reach.
    pub history: Vec<f64>,
    /// Spheres that may touch a wall, sorted.
    pub wall_pairs: Vec<WallPair>,
    /// Which of them were within reach.
    pub wall_touch: Vec<bool>,
    /// What each of them remembers; zero out of reach.
    pub wall_history: Vec<f64>,
    /// Where each block's entries start, and one more entry for the end.
    pub bounds: Vec<Bounds>,
    /// Where each particle's entries in `incoming` start, and the end.
    pub incoming_start: Vec<u32>,
    /// For each particle, the results of outer pairs that act on it.
    pub incoming: Vec<u32>,
    /// Centre and radius of each particle when the list was built.
    reference: Vec<[f64; 4]>,
    /// Positions of the walls when the list was built.
    wall_reference: PerWall<f64>,
    /// Half the skin (m): how far a particle or a wall may move.
    slack: f64,
    /// How far any particle may go before one must look again (m).
    budget: f64,
    /// In a periodic cell: how it has deformed since the list was built.
    cell_strain: CellStrain,
    wrapped: Wrapped,
    grid: Grid,
    parts: Vec<Part>,
}

/// The entries of one block while a list is built.
#[derive(Default)]
struct Part {
    inner: Vec<[u32; 2]>,
    outer: Vec<[u32; 2]>,
    /// Images of the inner and the outer pairs, in a periodic cell.
    images: [Vec<u8>; 2],
    found: Vec<(u32, u8)>,
    walls: Vec<WallPair>,
    /// Histories carried over, places counted through inner, then outer.
    kept: Kept,
    wall_kept: Kept,
    coincident: Option<[u32; 2]>,
}

impl Neighbours {
    /// An empty list, with so many numbers of history per contact.
    pub fn new(length: usize) -> Neighbours {
        Neighbours { length, ..Neighbours::default() }
    }

    /// Whether there is a list.
    pub fn is_built(&self) -> bool {
        !self.bounds.is_empty()
    }

    /// Takes note that no particle has gone farther than `way` (m).
    pub fn moved(&mut self, way: f64) {
        self.budget -= way;
    }

    /// Takes note that particles have grown or shrunk.
    pub fn resized(&mut self) {
        self.budget = 0.0;
    }

    /// Takes note that a periodic cell and the particles with it have been strained, by Δt L.
    pub fn strained(&mut self, strain: &Tensor) {
        self.budget -= self.cell_strain.add(strain);
    }

    /// Takes note that particles are in other places of a periodic cell.
    pub fn outdate(&mut self) {
        self.slack = 0.0;
        self.budget = 0.0;
    }

    /// [`Neighbours::outdated`] in a periodic cell: what the cell takes along uses up less of the
    /// skin than it moves.
    pub fn outdated_in_cell(&mut self, centre: &[[f64; 4]]) -> bool {
        if self.budget > 0.0 {
            return false;
        }
        let slack = self.slack - self.cell_strain.approach();
        let left = centre.iter().zip(&self.reference).fold(slack, |left, (c, old)| {
            left.min(slack - (c[3] - old[3]) - self.cell_strain.way(c, old))
        });
        // Less than all that is left: later strains carry on what the particles have gone.
        self.budget = 0.9 * left;
        left <= LEAST_LEFT * self.slack
    }

    /// True when walls or particles have used up the skin, or nearly. Looks
    /// at the particles only where the ways noted could have used it up.
    pub fn outdated(&mut self, centre: &[[f64; 4]], walls: &PerWall<Wall>) -> bool {
        let moved = |(w, r): (&Wall, &f64)| (w.position - r).abs() > self.slack;
        if walls.values().zip(self.wall_reference.values()).any(moved) {
            return true;
        }
        if self.budget > 0.0 {
            return false;
        }
        let left = centre.iter().zip(&self.reference).fold(self.slack, |left, (c, old)| {
            let way2: f64 = (0..3).map(|k| (c[k] - old[k]).powi(2)).sum();
            left.min(self.slack - (c[3] - old[3]) - way2.sqrt())
        });
        // Less than all that is left, so that round-off cannot overdraw it.
        self.budget = 0.99 * left;
        left < LEAST_LEFT * self.slack
    }

    /// Builds the list anew, keeping the history. `cut_off` is the law's (m),
    /// `skin` a share of the mean radius. Spheres of one clump, by their indices in `clumps`, are no
    /// pair; the list is empty without clumps.
    ///
    /// # Errors
    /// [`DemError::OutsideBox`] or [`DemError::Coincident`]; the list is then
    /// as it was.
    pub fn build(
        &mut self,
        particles: &Particles,
        (walls, cell): (&PerWall<Wall>, Option<&Cell>),
        (cut_off, skin): (f64, f64),
        clumps: &[u32],
    ) -> Result<(), DemError> {
        let n = particles.len();
        let skin = skin * particles.radius.iter().sum::<f64>() / n.max(1) as f64;
        let margin = skin + cut_off;
        let largest = particles.radius.iter().copied().fold(0.0, f64::max);
        let sight = cell.map(|cell| Sight::new(cell, largest, margin)).transpose()?;
        let position = match cell {
            None => {
                check_inside(particles, walls)?;
                &particles.position
            }
            Some(cell) => {
                self.wrapped.fill(&particles.position, cell);
                &self.wrapped.position
            }
        };
        self.grid.fill(position, &particles.radius, &box_of(walls), margin);

        let mut parts = std::mem::take(&mut self.parts);
        parts.resize_with(block_count(n), Part::default);
        parts.par_iter_mut().enumerate().for_each(|(block, part)| {
            match &sight {
                None => part.find(block, particles, walls, &self.grid, margin),
                Some(sight) => {
                    part.find_in_cell(block, particles, &self.wrapped, &self.grid, sight);
                }
            }
            if !clumps.is_empty() {
                part.leave_out_clumps(clumps);
            }
            part.carry(block, self);
        });
        let coincident = parts.iter().find_map(|p| p.coincident);
        self.parts = parts;
        if let Some([i, j]) = coincident {
            let [first, second] = [i, j].map(|k| particles.id[k as usize]);
            return Err(DemError::Coincident { first, second });
        }

        self.join_parts();
        self.index_incoming(n);
        self.slack = 0.5 * skin;
        self.budget = 0.99 * self.slack;
        self.reference.clear();
        self.reference.extend(
            particles.position.iter().zip(&particles.radius).map(|(x, &r)| [x.x, x.y, x.z, r]),
        );
        self.wall_reference = walls.map(|w| w.position);
        self.cell_strain = CellStrain::none(sight.map_or(0.0, |sight| sight.reach()));
        Ok(())
    }

    /// Puts the blocks' entries one after the other.
    fn join_parts(&mut self) {
        for list in [&mut self.touch, &mut self.wall_touch] {
            list.clear();
        }
        for list in [&mut self.history, &mut self.wall_history] {
            list.clear();
        }
        self.pairs.clear();
        self.image.clear();
        self.wall_pairs.clear();
        self.bounds.clear();
        let mut sent = 0;
        for part in &self.parts {
            let inner = self.pairs.len();
            self.bounds.push(Bounds {
                inner,
                outer: inner + part.inner.len(),
                sent,
                wall: self.wall_pairs.len(),
            });
            self.pairs.extend_from_slice(&part.inner);
            self.pairs.extend_from_slice(&part.outer);
            self.image.extend(part.images.iter().flatten());
            self.wall_pairs.extend_from_slice(&part.walls);
            sent += part.outer.len();
        }
        let (pairs, wall) = (self.pairs.len(), self.wall_pairs.len());
        self.bounds.push(Bounds { inner: pairs, outer: pairs, sent, wall });
        self.touch.resize(pairs, false);
        self.history.resize(pairs * self.length, 0.0);
        self.wall_touch.resize(wall, false);
        self.wall_history.resize(wall * self.length, 0.0);
        for (part, at) in self.parts.iter().zip(&self.bounds) {
            part.kept.put_back(at.inner, &mut self.touch, &mut self.history, self.length);
            let (touch, history) = (&mut self.wall_touch, &mut self.wall_history);
            part.wall_kept.put_back(at.wall, touch, history, self.length);
        }
    }

    /// Lists for each particle the outer pairs of which it is the second.
    fn index_incoming(&mut self, n: usize) {
        let starts = &mut self.incoming_start;
        starts.clear();
        starts.resize(n + 1, 0);
        let outer =
            || self.bounds.windows(2).flat_map(|b| &self.pairs[b[0].outer..b[1].inner]).zip(0u32..);
        for ([_, j], _) in outer() {
            starts[*j as usize + 1] += 1;
        }
        for k in 0..n {
            starts[k + 1] += starts[k];
        }
        self.incoming.clear();
        self.incoming.resize(starts[n] as usize, 0);
        for ([_, j], k) in outer() {
            let slot = &mut starts[*j as usize];
            self.incoming[*slot as usize] = k;
            *slot += 1;
        }
        // The starts have moved on to the ends: shift them back by one.
        starts.copy_within(0..n, 1);
        starts[0] = 0;
    }

    /// The histories of all contacts of spheres, for a checkpoint.
    pub fn sphere_history(&self) -> ContactHistory<[u32; 2]> {
        history_of(&self.pairs, &self.touch, &self.history, self.length)
    }

    /// The histories of all contacts with walls, for a checkpoint.
    pub fn wall_history(&self) -> ContactHistory<(u32, WallId)> {
        let all = history_of(&self.wall_pairs, &self.wall_touch, &self.wall_history, self.length);
        let bodies = all.bodies.iter().map(|p| (p.i, p.wall)).collect();
        ContactHistory { bodies, numbers: all.numbers }
    }

    /// Takes up the history of a checkpoint; [`Neighbours::build`] then keeps
    /// it.
    ///
    /// # Errors
    /// [`DemError::Length`] for an entry that names no particle, or a history
    /// of another length.
    pub fn load(&mut self, state: &DemState) -> Result<(), DemError> {
        let n = state.particles.len();
        state.sphere_history.check(self.length)?;
        state.wall_history.check(self.length)?;
        self.parts.clear();
        self.parts.resize_with(block_count(n), Part::default);
        let spheres = state.sphere_history.sorted(self.length);
        let bad = |found: u32| DemError::Length {
            what: "contact history (index of a sphere)",
            found: found as usize,
            expected: n,
        };
        for outer in [false, true] {
            for &([i, j], history) in &spheres {
                if i >= j || j as usize >= n {
                    return Err(bad(j));
                }
                let block = i as usize / BLOCK;
                if (j as usize / BLOCK != block) != outer {
                    continue;
                }
                let part = &mut self.parts[block];
                part.kept.push(part.inner.len() + part.outer.len(), history);
                let list = if outer { &mut part.outer } else { &mut part.inner };
                list.push([i, j]);
            }
        }
        for ((i, wall), history) in state.wall_history.sorted(self.length) {
            if i as usize >= n {
                return Err(bad(i));
            }
            let part = &mut self.parts[i as usize / BLOCK];
            part.wall_kept.push(part.walls.len(), history);
            part.walls.push(WallPair { i, wall });
        }
        self.join_parts();
        Ok(())
    }
}

impl Part {
    /// Finds the pairs of the block's particles whose gap is less than
    /// `margin` (m).
    fn find(
        &mut self,
        block: usize,
        p: &Particles,
        walls: &PerWall<Wall>,
        grid: &Grid,
        margin: f64,
    ) {
        let end = ((block + 1) * BLOCK).min(p.len());
        self.inner.clear();
        self.outer.clear();
        self.walls.clear();
        self.coincident = None;
        for i in block * BLOCK..end {
            let (x, r) = (p.position[i], p.radius[i]);
            let (inner, outer) = (self.inner.len(), self.outer.len());
            grid.around(&x, r, margin, |j| {
                let k = j as usize;
                if k <= i {
                    return;
                }
                let d2 = (p.position[k] - x).norm_squared();
                let reach = r + p.radius[k] + margin;
                if d2 < reach * reach {
                    let list = if k < end { &mut self.inner } else { &mut self.outer };
                    list.push([i as u32, j]);
                    if d2 == 0.0 {
                        self.coincident = Some([i as u32, j]);
                    }
                }
            });
            self.inner[inner..].sort_unstable();
            self.outer[outer..].sort_unstable();
            for wall in WallId::ALL {
                let distance = (x[wall.axis()] - walls[wall].position) * wall.inward();
                if distance < r + margin {
                    self.walls.push(WallPair { i: i as u32, wall });
                }
            }
        }
    }

    /// [`Part::find`] in a periodic cell, which has no walls.
    fn find_in_cell(
        &mut self,
        block: usize,
        p: &Particles,
        wrapped: &Wrapped,
        grid: &Grid,
        sight: &Sight<'_>,
    ) {
        let end = ((block + 1) * BLOCK).min(p.len());
        self.inner.clear();
        self.outer.clear();
        self.images.iter_mut().for_each(Vec::clear);
        self.coincident = None;
        let mut found = std::mem::take(&mut self.found);
        for i in block * BLOCK..end {
            wrapped.around(i, p, grid, sight, &mut found);
            for &(j, image) in &found {
                let is_inner = (j as usize) < end;
                let list = if is_inner { &mut self.inner } else { &mut self.outer };
                list.push([i as u32, j]);
                self.images[usize::from(!is_inner)].push(image);
                if wrapped.position[i] == wrapped.position[j as usize] {
                    self.coincident = Some([i as u32, j]);
                }
            }
        }
        self.found = found;
    }

    /// Leaves out the pairs within clumps.
    fn leave_out_clumps(&mut self, clumps: &[u32]) {
        let apart = |pair: &[u32; 2]| {
            let [a, b] = pair.map(|i| clumps[i as usize]);
            a != b || a == NO_CLUMP
        };
        self.inner.retain(apart);
        self.outer.retain(apart);
    }

    /// Carries the history of the block over from the old list.
    fn carry(&mut self, block: usize, old: &Neighbours) {
        self.kept.clear();
        self.wall_kept.clear();
        let (Some(from), Some(to)) = (old.bounds.get(block), old.bounds.get(block + 1)) else {
            return;
        };
        let length = old.length;
        let split = self.inner.len();
        let kept = &mut self.kept;
        for (range, new, offset) in
            [(from.inner..from.outer, &self.inner, 0), (from.outer..to.inner, &self.outer, split)]
        {
            let of = &old.pairs[range.clone()];
            merge(of, &old.touch[range.clone()], new, |a, b| {
                let history = &old.history[(range.start + a) * length..][..length];
                kept.push(offset + b, history);
            });
        }
        let range = from.wall..to.wall;
        let of = &old.wall_pairs[range.clone()];
        let kept = &mut self.wall_kept;
        merge(of, &old.wall_touch[range.clone()], &self.walls, |a, b| {
            let history = &old.wall_history[(range.start + a) * length..][..length];
            kept.push(b, history);
        });
    }
}

/// Refuses a centre beyond a wall.
pub(super) fn check_inside(particles: &Particles, walls: &PerWall<Wall>) -> Result<(), DemError> {
    let box_ = box_of(walls);
    super::walls::check_box(&box_)?;
    for (x, &particle) in particles.position.iter().zip(&particles.id) {
        for wall in WallId::ALL {
            if (x[wall.axis()] - box_.wall(wall)) * wall.inward() < 0.0 {
                return Err(DemError::OutsideBox { particle, wall });
            }
        }
    }
    Ok(())
}
