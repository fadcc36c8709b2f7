//! What the contact pass reads.

use super::cell_pass::CellPass;
use super::law::ContactLaw;
use super::walls::Wall;
use crate::{PerWall, Vec3};

/// What the contact pass reads.
#[derive(Clone, Copy)]
pub(super) struct Input<'a> {
    /// Centre and radius of each sphere.
    pub centre: &'a [[f64; 4]],
    pub velocity: &'a [Vec3],
    pub spin: &'a [Vec3],
    /// Index of each sphere's material; empty where all are of the first.
    pub material: &'a [u16],
    pub walls: &'a PerWall<Wall>,
    /// The periodic cell, where there is one and no walls.
    pub cell: Option<&'a CellPass>,
    /// Length of the step that the histories have yet to follow (s), or 0.
    pub dt: f64,
    /// Whether spheres rotate.
    pub rotation: bool,
    /// Whether the law books what contacts dissipate.
    pub tracks_energy: bool,
    /// Whether what turning contacts lose is booked, too.
    pub tracks_turning: bool,
}

impl Input<'_> {
    /// Index of the material of a sphere.
    pub fn material_at(&self, i: u32) -> u16 {
        self.material.get(i as usize).copied().unwrap_or(0)
    }

    /// What a sphere turned by in the last step (rad).
    pub fn turn(&self, i: u32) -> Vec3 {
        if self.rotation { self.dt * self.spin[i as usize] } else { Vec3::zeros() }
    }
}

/// Index of the material of a body; the list is empty where all are of the first, which only
/// general kernels meet.
#[inline(always)]
pub(super) fn material_of<L: ContactLaw>(material: &[u16], body: u32) -> u16 {
    if L::GENERAL_KERNELS {
        material.get(body as usize).copied().unwrap_or(0)
    } else {
        material[body as usize]
    }
}
