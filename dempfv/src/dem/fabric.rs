//! What the contacts of a packing make of it: stress, fabric, coordination.

use super::contacts::Partner;
use super::system::Dem;
use crate::domain::ball_in_box;
use crate::{Aabb, Tensor};

/// What one look at all contacts tells of a packing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fabric {
    /// Stress of the contacts, Σ F ⊗ l / V (Pa, positive in compression): the effective stress of a
    /// packing at rest, with or without a fluid in its pores. See [`Dem::stress`].
    pub stress: Tensor,
    /// Fabric tensor Σ n ⊗ n / N_c over the contacts of two spheres, n their normals (1); its trace
    /// is 1. Zero without such contacts.
    pub fabric: Tensor,
    /// Contacts of two spheres.
    pub sphere_contacts: usize,
    /// Contacts of spheres with walls.
    pub wall_contacts: usize,
    /// Spheres with less than two contacts, those with walls counted: they carry nothing but
    /// themselves.
    pub rattlers: usize,
    /// Contacts per sphere without those with walls, 2 N_c / N (1).
    pub without_walls: f64,
    /// Contacts per sphere that carries load, (2 N_c + N_w − N₁) / (N − N₀ − N₁) (1; Thornton 2000): N_w
    /// contacts with walls, N₀ and N₁ spheres with none and with one. Zero where none carries.
    pub mechanical: f64,
}

impl Dem {
    /// Looks at all contacts of the last [`Dem::compute_contacts`].
    pub fn fabric(&self) -> Fabric {
        let mut ends = vec![0_u32; self.len()];
        let (mut moment, mut fabric) = (Tensor::zeros(), Tensor::zeros());
        let (mut sphere_contacts, mut wall_contacts) = (0, 0);
        for contact in self.contacts() {
            moment += contact.force() * (contact.distance * contact.normal).transpose();
            ends[contact.i as usize] += 1;
            match contact.partner {
                Partner::Sphere(other) => {
                    ends[other as usize] += 1;
                    sphere_contacts += 1;
                    fabric += contact.normal * contact.normal.transpose();
                }
                Partner::Wall(_) => wall_contacts += 1,
            }
        }
        let with = |count: u32| ends.iter().filter(|&&n| n == count).count();
        let (none, one) = (with(0), with(1));
        let carriers = self.len() - none - one;
        let all = 2 * sphere_contacts + wall_contacts;
        Fabric {
            stress: moment / self.volume(),
            fabric: fabric / sphere_contacts.max(1) as f64,
            sphere_contacts,
            wall_contacts,
            rattlers: none + one,
            without_walls: 2.0 * sphere_contacts as f64 / self.len().max(1) as f64,
            mechanical: (all - one) as f64 / carriers.max(1) as f64,
        }
    }

    /// Share of a region that no sphere fills, overlaps counted twice as solid: of the part of it
    /// that lies between the walls (1). Not a number where it has no such part.
    pub fn porosity_within(&self, region: &Aabb) -> f64 {
        let bounds = self.box_();
        let part = Aabb { min: region.min.sup(&bounds.min), max: region.max.inf(&bounds.max) };
        if !part.size().iter().all(|&edge| edge > 0.0) {
            return f64::NAN;
        }
        let p = &self.particles;
        let solid: f64 =
            p.position.iter().zip(&p.radius).map(|(x, &r)| ball_in_box(x, r, &part)).sum();
        1.0 - solid / part.volume()
    }
}
