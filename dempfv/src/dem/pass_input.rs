//! What the contact pass reads.

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
    /// Length of the step that the histories have yet to follow (s), or 0.
    pub dt: f64,
    /// Whether spheres rotate.
    pub rotation: bool,
    /// Whether the law books what contacts dissipate.
    pub tracks_energy: bool,
}
