//! How stiff the contacts hold each sphere: one pass over the blocks looks at the pairs that cross
//! them, a second one adds up for each sphere, in the order of the pairs.

use super::cell_pass::CellPass;
use super::law::{ContactLaw, History, SphereOnPlane, Stiffness, TwoSpheres};
use super::neighbours::{Bounds, Neighbours, WallPair};
use super::parameters::ParameterTable;
use super::stiffness_sum::StiffnessSum;
use super::walls::Wall;
use crate::parallel::{BLOCK, Span, cut, cut_mut, for_blocks};
use crate::{PerWall, Vec3};

/// Overlap, as a share of the radius, at which the stiffness of a contact that does not exist yet is
/// taken at least; the linear law's does not depend on it.
pub(super) const EXPECTED_OVERLAP_SHARE: f64 = 0.01;

/// What the pass reads.
#[derive(Clone, Copy)]
pub(super) struct StiffnessInput<'a> {
    pub list: &'a Neighbours,
    /// Centre and radius of each sphere.
    pub centre: &'a [[f64; 4]],
    pub mass: &'a [f64],
    /// Index of each sphere's material; empty where all are of the first.
    pub material: &'a [u16],
    pub walls: &'a PerWall<Wall>,
    /// The periodic cell, where there is one.
    pub cell: Option<&'a CellPass>,
    /// Whether spheres rotate.
    pub rotation: bool,
}

/// A contact that holds its spheres; of no stiffness where there is none.
#[derive(Clone, Copy, Debug, Default)]
struct Held {
    stiffness: Stiffness,
    normal: Vec3,
}

/// What the pass needs beside, kept from look to look.
#[derive(Clone, Debug, Default)]
pub(super) struct StiffnessScratch {
    sums: Vec<StiffnessSum>,
    outer: Vec<Held>,
}

/// The largest k/m (1/s²) of all spheres, k being the largest eigenvalue of the stiffness that the
/// contacts put against translation or rotation; 0 without contacts.
pub(super) fn fastest_held<L: ContactLaw>(
    law: &L,
    table: &ParameterTable<L>,
    input: StiffnessInput<'_>,
    scratch: &mut StiffnessScratch,
) -> f64 {
    let look = Look { law, table, input };
    let bounds = &input.list.bounds[..];
    // No list has been built yet.
    let Some(end) = bounds.last() else { return 0.0 };
    scratch.outer.resize(end.sent, Held::default());
    scratch.sums.resize(input.centre.len(), StiffnessSum::default());
    let span = OuterSpan { bounds, outer: &mut scratch.outer };
    for_blocks(span, &|span: OuterSpan<'_>| look.outer(span), &|(), ()| ());
    let span = SumSpan { first: 0, bounds, sums: &mut scratch.sums };
    let outer = &scratch.outer[..];
    for_blocks(span, &|span: SumSpan<'_>| look.sum(span, outer), &f64::max)
}

/// A run of blocks and the pairs with which they cross into others.
struct OuterSpan<'a> {
    bounds: &'a [Bounds],
    outer: &'a mut [Held],
}

impl Span for OuterSpan<'_> {
    fn blocks(&self) -> usize {
        self.bounds.len() - 1
    }

    fn split(self, blocks: usize) -> (Self, Self) {
        let outer = self.outer.split_at_mut(self.bounds[blocks].sent - self.bounds[0].sent);
        (
            OuterSpan { bounds: &self.bounds[..=blocks], outer: outer.0 },
            OuterSpan { bounds: &self.bounds[blocks..], outer: outer.1 },
        )
    }
}

/// A run of blocks and their spheres' sums.
struct SumSpan<'a> {
    /// Index of the first sphere.
    first: usize,
    bounds: &'a [Bounds],
    sums: &'a mut [StiffnessSum],
}

impl Span for SumSpan<'_> {
    fn blocks(&self) -> usize {
        self.bounds.len() - 1
    }

    fn split(self, blocks: usize) -> (Self, Self) {
        let sums = cut_mut(self.sums, blocks * BLOCK);
        let first = self.first + blocks * BLOCK;
        (
            SumSpan { first: self.first, bounds: &self.bounds[..=blocks], sums: sums.0 },
            SumSpan { first, bounds: &self.bounds[blocks..], sums: sums.1 },
        )
    }
}

/// A law with what its pass reads.
struct Look<'a, L: ContactLaw> {
    law: &'a L,
    table: &'a ParameterTable<L>,
    input: StiffnessInput<'a>,
}

impl<L: ContactLaw> Look<'_, L> {
    fn outer(&self, span: OuterSpan<'_>) {
        let mut outer = span.outer.iter_mut();
        for of in span.bounds.windows(2) {
            for (k, held) in (of[0].outer..of[1].inner).zip(&mut outer) {
                *held = self.pair(k).unwrap_or_default();
            }
        }
    }

    fn sum(&self, span: SumSpan<'_>, outer: &[Held]) -> f64 {
        let SumSpan { first, bounds, sums } = span;
        let (list, input) = (self.input.list, &self.input);
        let mut fastest = 0.0f64;
        for (block, of) in bounds.windows(2).enumerate() {
            let (sums, _) = cut_mut(&mut sums[block * BLOCK..], BLOCK);
            let first = first + block * BLOCK;
            let starts = list.incoming_start[first..].windows(2);
            for (sum, range) in sums.iter_mut().zip(starts) {
                *sum = StiffnessSum::default();
                for &slot in &list.incoming[range[0] as usize..range[1] as usize] {
                    sum.add_held(&outer[slot as usize]);
                }
            }
            for k in of[0].inner..of[0].outer {
                if let Some(held) = self.pair(k) {
                    for i in list.pairs[k] {
                        sums[i as usize - first].add_held(&held);
                    }
                }
            }
            for (k, held) in (of[0].outer..of[1].inner).zip(&outer[of[0].sent..]) {
                sums[list.pairs[k][0] as usize - first].add_held(held);
            }
            for k in of[0].wall..of[1].wall {
                if let Some(held) = self.wall(k) {
                    sums[list.wall_pairs[k].i as usize - first].add_held(&held);
                }
            }
            let (mass, _) = cut(&input.mass[first..], BLOCK);
            for (sum, m) in sums.iter().zip(mass) {
                fastest = sum.fastest(*m, fastest);
                if input.rotation {
                    // I = 2/5 m r², and both k_r and I have the factor r².
                    fastest = sum.fastest_rotation(0.4 * m, fastest);
                }
            }
        }
        fastest
    }

    /// The contact of this pair of spheres, where there is one.
    fn pair(&self, k: usize) -> Option<Held> {
        let (list, input) = (self.input.list, &self.input);
        if !list.touch[k] {
            return None;
        }
        let [i, j] = list.pairs[k].map(|i| i as usize);
        let (a, b) = (&input.centre[i], &input.centre[j]);
        let shift = input.cell.map_or(Vec3::zeros(), |cell| cell.shift(list.image[k]));
        let apart = Vec3::new(b[0] - a[0], b[1] - a[1], b[2] - a[2]) + shift;
        let distance = apart.norm();
        let overlap = a[3] + b[3] - distance;
        if self.law.cut_off() > 0.0 && !self.acts(overlap, &list.history, k) {
            return None;
        }
        let [first, second] = [i, j].map(|i| self.material(i));
        let parameters = self.table.spheres(first, second);
        let stiffness = self.law.stiffness(&parameters, TwoSpheres(a[3], b[3]), overlap);
        Some(Held { stiffness, normal: apart / distance })
    }

    /// The contact of this pair of a sphere and a wall, where there is one.
    fn wall(&self, k: usize) -> Option<Held> {
        let (list, input) = (self.input.list, &self.input);
        if !list.wall_touch[k] {
            return None;
        }
        let WallPair { i, wall } = list.wall_pairs[k];
        let centre = &input.centre[i as usize];
        let distance = (centre[wall.axis()] - input.walls[wall].position) * wall.inward();
        let overlap = centre[3] - distance;
        if self.law.cut_off() > 0.0 && !self.acts(overlap, &list.wall_history, k) {
            return None;
        }
        let parameters = self.table.wall(self.material(i as usize));
        let stiffness = self.law.stiffness(&parameters, SphereOnPlane(centre[3]), overlap);
        Some(Held { stiffness, normal: -wall.inward_normal() })
    }

    fn acts(&self, overlap: f64, history: &[f64], k: usize) -> bool {
        let length = self.law.history_length();
        self.law.acts(overlap, &L::History::read(&history[k * length..][..length]))
    }

    fn material(&self, i: usize) -> u16 {
        self.input.material.get(i).copied().unwrap_or(0)
    }
}

impl StiffnessSum {
    fn add_held(&mut self, held: &Held) {
        self.add(held.stiffness, &held.normal);
    }
}

/// The largest k_n / m (1/s²) of a sphere in one contact with another of its size, of any material,
/// that comes at the speed whose square is `impact2` (m²/s²).
pub(super) fn fastest_lone<L: ContactLaw>(
    law: &L,
    table: &ParameterTable<L>,
    radius: &[f64],
    mass: &[f64],
    material: &[u16],
    impact2: f64,
) -> f64 {
    let frequency2 = |i: usize| {
        let (r, m) = (radius[i], mass[i]);
        let of = material.get(i).copied().unwrap_or(0);
        let stiffness = |partner: u16| {
            let parameters = table.spheres(of, partner);
            let radii = TwoSpheres(r, r);
            let usual = EXPECTED_OVERLAP_SHARE * r;
            // Two equal masses.
            let energy = 0.25 * m * impact2;
            let overlap = law.expected_overlap(&parameters, radii, energy, usual);
            law.stiffness(&parameters, radii, overlap).normal
        };
        (0..table.materials()).map(stiffness).fold(0.0, f64::max) / m
    };
    (0..radius.len()).map(frequency2).fold(0.0, f64::max)
}
