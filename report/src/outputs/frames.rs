//! Arrays of the files for ParaView.

use super::{Entry, entry};

/// Excess pressure of pores.
pub const PRESSURE: &str = "pressure";
/// Their volume.
pub const VOLUME: &str = "volume";
/// Their pressure with the hydrostatic one.
pub const TOTAL_PRESSURE: &str = "total_pressure";
/// Normal force of contacts.
pub const NORMAL_FORCE: &str = "normal_force";
/// Magnitude of their shear force.
pub const SHEAR_FORCE: &str = "shear_force";
/// The force as a vector.
pub const CONTACT_FORCE: &str = "force";
/// Their overlap.
pub const OVERLAP: &str = "overlap";
/// Whether a wall is the partner.
pub const WALL_CONTACT: &str = "wall";
/// Volume of the periodic cell.
pub const CELL_VOLUME: &str = "volume";
/// Its angle between a and b.
pub const GAMMA: &str = "gamma";

/// A kind of files with its arrays.
pub struct File {
    /// Beginning of their names.
    pub name: &'static str,
    /// What is in them, and when there are any.
    pub what: &'static str,
    /// Their arrays.
    pub arrays: &'static [Entry],
}

/// All kinds.
pub static FILES: [File; 4] = [
    File {
        name: "spheres",
        what: "A point for each sphere, at its centre; in a periodic cell the copy inside it. \
         In ParaView: filter Glyph, sphere, scaled by `radius`, factor 2.",
        arrays: &[
            entry("radius", "m", "Radius."),
            entry(
                "velocity",
                "m/s",
                "Velocity, dt/2 before the positions; in a periodic cell relative to its mean \
         field.",
            ),
            entry(
                "force",
                "N",
                "Force of contacts and fluid on the sphere, buoyancy with it, without gravity and \
         damping.",
            ),
            entry("id", "", "Number in the packing, from 0."),
        ],
    },
    File {
        name: "pores",
        what: "A cell for each pore, from sphere centres and walls, where a flow is simulated.",
        arrays: &[
            entry(PRESSURE, "Pa", "Excess pressure."),
            entry(
                VOLUME,
                "m³",
                "Volume, solids included; negative where motion has turned a pore inside out.",
            ),
            entry(
                TOTAL_PRESSURE,
                "Pa",
                "Excess pressure and the hydrostatic one at the pore's centroid, where the fluid \
         has a `density`.",
            ),
        ],
    },
    File {
        name: "contacts",
        what: "A line for each contact that carries force, from the sphere's centre to its \
         partner's or to the wall, with `contacts = true`.",
        arrays: &[
            entry(NORMAL_FORCE, "N", "Normal force, positive where they press on each other."),
            entry(SHEAR_FORCE, "N", "Magnitude of the shear force."),
            entry(
                CONTACT_FORCE,
                "N",
                "Force on the partner, normal and shear: along the line where it presses.",
            ),
            entry(
                OVERLAP,
                "m",
                "Depth by which surfaces overlap; negative across a gap that the law bridges.",
            ),
            entry(WALL_CONTACT, "", "1 where the partner is a wall, else 0."),
        ],
    },
    File {
        name: "cell",
        what: "The periodic cell as a hexahedron, with [cell].",
        arrays: &[
            entry(CELL_VOLUME, "m³", "Its volume."),
            entry(GAMMA, "°", "Angle between its edges a and b."),
        ],
    },
];
