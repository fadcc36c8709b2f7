//! The live contacts, one by one, for observables and output.

use super::cell_pass::CellPass;
use super::compiled::{Surfaces, Touch};
use super::law::{SphereOnPlane, TwoSpheres};
use super::neighbours::WallPair;
use super::system::Dem;
use crate::{Vec3, WallId};

/// The other side of a sphere's contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partner {
    /// The sphere with this number of the user's.
    Sphere(u32),
    /// A wall.
    Wall(WallId),
}

/// A contact that carries force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The user's number of the sphere; of two spheres either comes first.
    pub i: u32,
    /// What it touches.
    pub partner: Partner,
    /// Unit normal from the sphere to its partner.
    pub normal: Vec3,
    /// Depth by which the two overlap (m); negative across a gap that the
    /// law's cut-off bridges.
    pub overlap: f64,
    /// Distance from the sphere's centre to the partner's, or to the wall's
    /// plane (m).
    pub distance: f64,
    /// Normal stiffness k_n (N/m).
    pub stiffness: f64,
    /// Normal force, positive in compression (N).
    pub normal_force: f64,
    /// Shear force on the partner (N).
    pub shear: Vec3,
}

impl Contact {
    /// Force on the partner (N); the sphere gets the opposite.
    pub fn force(&self) -> Vec3 {
        self.normal_force * self.normal + self.shear
    }
}

/// The partner of a contact, by places in storage.
#[derive(Clone, Copy, Debug)]
pub(super) enum Other {
    Sphere(usize),
    Wall(WallId),
}

/// Where a contact is, at the current positions, before any law is asked.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place<'a> {
    /// Place of the sphere in storage.
    pub i: usize,
    pub other: Other,
    pub normal: Vec3,
    pub distance: f64,
    pub touch: Touch,
    pub history: &'a [f64],
}

impl Dem {
    /// The contacts of the last [`Dem::compute_contacts`], with the normal and
    /// overlap of the current positions: sphere pairs first, then walls.
    pub fn contacts(&self) -> impl Iterator<Item = Contact> + '_ {
        self.places().map(|place| self.contact(&place))
    }

    fn contact(&self, place: &Place<'_>) -> Contact {
        let force = self.law.force(&place.touch, place.history);
        Contact {
            i: self.particles.id[place.i],
            partner: match place.other {
                Other::Sphere(j) => Partner::Sphere(self.particles.id[j]),
                Other::Wall(wall) => Partner::Wall(wall),
            },
            normal: place.normal,
            overlap: place.touch.overlap,
            distance: place.distance,
            stiffness: self.law.stiffness(&place.touch).normal,
            normal_force: force.normal,
            shear: force.shear,
        }
    }

    /// The same contacts by places in storage.
    pub(super) fn places(&self) -> impl Iterator<Item = Place<'_>> + '_ {
        let list = &self.list;
        let length = self.law.history_length();
        let pass = self.cell.as_ref().map(CellPass::new);
        let spheres = (0..list.pairs.len()).filter(|&k| list.touch[k]).map(move |k| {
            let shift = pass.map_or(Vec3::zeros(), |pass| pass.shift(list.image[k]));
            self.sphere_place(list.pairs[k], shift, &list.history[k * length..][..length])
        });
        let walls = (0..list.wall_pairs.len()).filter(|&k| list.wall_touch[k]).map(move |k| {
            self.wall_place(list.wall_pairs[k], &list.wall_history[k * length..][..length])
        });
        // Without a cut-off what touches acts.
        let beyond = self.law.cut_off() > 0.0;
        let acts = move |place: &Place<'_>| self.law.acts(&place.touch, place.history);
        spheres.chain(walls).filter(move |place| !beyond || acts(place))
    }

    /// `shift` leads to the copy of the second sphere that is meant (m).
    pub(super) fn sphere_place<'a>(
        &self,
        pair: [u32; 2],
        shift: Vec3,
        history: &'a [f64],
    ) -> Place<'a> {
        let p = &self.particles;
        let [i, j] = pair.map(|k| k as usize);
        let apart = p.position[j] - p.position[i] + shift;
        let distance = apart.norm();
        let surfaces = Surfaces::Spheres(
            TwoSpheres(p.radius[i], p.radius[j]),
            [p.material_of(i), p.material_of(j)],
        );
        let overlap = p.radius[i] + p.radius[j] - distance;
        let touch = Touch { surfaces, overlap };
        Place { i, other: Other::Sphere(j), normal: apart / distance, distance, touch, history }
    }

    pub(super) fn wall_place<'a>(
        &self,
        WallPair { i, wall }: WallPair,
        history: &'a [f64],
    ) -> Place<'a> {
        let i = i as usize;
        let plane = self.walls[wall].position;
        let distance = (self.particles.position[i][wall.axis()] - plane) * wall.inward();
        let radius = self.particles.radius[i];
        let surfaces = Surfaces::Wall(SphereOnPlane(radius), self.particles.material_of(i));
        let touch = Touch { surfaces, overlap: radius - distance };
        let normal = -wall.inward_normal();
        Place { i, other: Other::Wall(wall), normal, distance, touch, history }
    }

    /// Number of contacts between spheres at the last
    /// [`Dem::compute_contacts`].
    pub fn sphere_contact_count(&self) -> usize {
        let acting =
            || self.places().filter(|place| matches!(place.other, Other::Sphere(_))).count();
        if self.law.cut_off() > 0.0 { acting() } else { touching(&self.list.touch) }
    }

    /// Number of contacts of spheres with walls, likewise.
    pub fn wall_contact_count(&self) -> usize {
        let acting = || self.places().filter(|place| matches!(place.other, Other::Wall(_))).count();
        if self.law.cut_off() > 0.0 { acting() } else { touching(&self.list.wall_touch) }
    }
}

fn touching(touch: &[bool]) -> usize {
    touch.iter().filter(|touch| **touch).count()
}
