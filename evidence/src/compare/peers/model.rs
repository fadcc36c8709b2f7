//! What the phases of a step must read, write and compute at least, by pore, contact and
//! sphere: numbers of 64 bits, indices of 32.

use super::coupled::{Case, PHASES, Side};
use crate::limits::Limits;

const NUMBER: f64 = 8.0;
const INDEX: f64 = 4.0;
const VECTOR: f64 = 3.0 * NUMBER;

/// A phase's least work.
pub struct Work {
    pub bytes: f64,
    pub flops: f64,
    /// The same in words, by pore, contact or sphere.
    pub words: String,
}

/// What the phases of a step, in the order of [`PHASES`], have to do on a packing. `entry`:
/// bytes of an entry of the factor.
pub fn phases(case: &Case, side: &Side, entry: f64) -> [Work; PHASES.len()] {
    let (pores, spheres, contacts) = (case.pores as f64, case.spheres as f64, side.contacts);
    let each = |count: f64, bytes: f64, flops: f64, unit: &str| Work {
        bytes: count * bytes,
        flops: count * flops,
        words: format!("{bytes:.0} B and {flops:.0} operations a {unit}"),
    };
    // Two spheres, and the shear force, which is read and written; of each sphere place,
    // velocity, spin, radius are read once, and force and torque written.
    let contact = 2.0 * INDEX + 2.0 * VECTOR;
    let sphere = 3.0 * VECTOR + NUMBER + 2.0 * VECTOR;
    // Force and torque and mass are read; place, velocity, spin are read and written.
    let motion = 2.0 * VECTOR + NUMBER + 6.0 * VECTOR;
    // Four corners and a vector for each.
    let gradient = 4.0 * (INDEX + VECTOR) + NUMBER;
    let nnz = case.pressure.nnz_l;
    [
        Work {
            bytes: contacts * contact + spheres * sphere,
            flops: contacts * 150.0,
            words: format!("{contact:.0} B and 150 operations a contact, {sphere:.0} B a sphere"),
        },
        each(spheres, motion, 60.0, "sphere"),
        each(pores, gradient, 24.0, "pore"),
        Work {
            bytes: 2.0 * nnz * entry,
            flops: 4.0 * nnz,
            words: format!("L twice: up to {:.0} B a pore", 2.0 * nnz * entry / pores),
        },
        each(pores, gradient, 24.0, "pore"),
    ]
}

impl Work {
    /// The least time for it on two threads (s).
    pub fn floor(&self, limits: &Limits) -> f64 {
        limits.floor(self.bytes, self.flops)
    }
}

/// Bytes of an entry of the factor of a solver of ours, at most: parts of large ones take fewer.
pub fn entry(solver: &str) -> f64 {
    if solver == "frontal" { 2.0 } else { 8.0 }
}
