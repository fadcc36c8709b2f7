//! What the spheres leave of each pore to the fluid.
//!
//! A sphere takes of a pore its volume times the share of the solid angle under which it sees the
//! pore (Van Oosterom and Strackee 1983). Around each sphere the pores fill the whole solid angle, so
//! that the void volumes of all pores add up to the box less its spheres, overlaps counted twice.

use super::frame::{FACETS, Frame, Vertex};
use super::packing_check::require_length;
use super::{Network, PfvError};
use crate::Vec3;
use crate::parallel::for_each;

impl Network {
    /// Volume of the fluid in each pore (m³): its volume less the spheres' shares; 0 where these
    /// are larger, as in flat pores and where spheres overlap, and in pores that spheres fill.
    /// `position` (m) and `radius` (m) are those that the network was built of.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] for positions or radii that are not one per sphere or not finite.
    pub fn void_volumes(&self, position: &[Vec3], radius: &[f64]) -> Result<Vec<f64>, PfvError> {
        self.check_vertices(position, &self.bounds)?;
        require_length("radius", radius.len(), position.len(), "spheres")?;
        if let Some(index) = radius.iter().position(|r| !r.is_finite()) {
            return Err(PfvError::invalid("radius", index, "is not finite"));
        }
        let mut void = vec![0.0; self.pores()];
        self.write_void_volumes(&Frame::new(position, radius, &self.bounds), &mut void);
        Ok(void)
    }

    /// The same of spheres that are known to fit, with the volumes of the moment.
    pub(super) fn write_void_volumes(&self, frame: &Frame, void: &mut [f64]) {
        self.write_voids_of(frame, &self.tessellation.cells, void);
    }

    /// The same of pores with these vertices in the frame.
    pub(super) fn write_voids_of(&self, frame: &Frame, cells: &[[u32; 4]], void: &mut [f64]) {
        for_each(void, &|i, void| {
            let left = self.volume[i] - solid(frame, cells[i]);
            *void = if self.is_filled(i) { 0.0 } else { left.max(0.0) };
        });
    }
}

/// Volume of the spheres in a pore (m³); negative parts where the pore is inside out, as its volume.
fn solid(frame: &Frame, cell: [u32; 4]) -> f64 {
    let mut sum = 0.0;
    for (k, &v) in cell.iter().enumerate() {
        let Vertex::Sphere { x, r } = frame.vertex(v) else { continue };
        let directions = FACETS[k].map(|other| match frame.vertex(cell[other]) {
            Vertex::Sphere { x: y, .. } => y - x,
            Vertex::Wall(wall) => -wall.inward_normal(),
        });
        sum += r * r * r / 3.0 * solid_angle(directions);
    }
    sum
}

/// Solid angle of three directions, with the sign of their orientation.
fn solid_angle([a, b, c]: [Vec3; 3]) -> f64 {
    let (na, nb, nc) = (a.norm(), b.norm(), c.norm());
    let triple = a.dot(&b.cross(&c));
    let below = na * nb * nc + a.dot(&b) * nc + a.dot(&c) * nb + b.dot(&c) * na;
    2.0 * triple.atan2(below)
}
