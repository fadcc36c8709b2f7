//! What can be wrong with a pore network.

/// The pore network cannot be built or used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PfvError {
    /// The triangulation failed.
    #[error("triangulation of {spheres} spheres: {reason}")]
    Triangulation {
        /// Number of spheres.
        spheres: usize,
        /// What CGAL said.
        reason: String,
    },
    /// There is nothing to triangulate.
    #[error("no spheres: a pore network needs at least one")]
    NoSpheres,
    /// A pore lies between opposite walls or has no sphere, which happens only
    /// when spheres lie outside the box.
    #[error(
        "pore {pore} (vertices {vertices}) has no place between sphere and walls: are all spheres inside the box?"
    )]
    BadPore {
        /// The pore.
        pore: u32,
        /// Its vertices, by name.
        vertices: String,
    },
    /// A pore's geometry or a throat's conductance is not finite.
    #[error("pore {pore} (vertices {vertices}): {quantity} is not finite")]
    NotFinite {
        /// The pore.
        pore: u32,
        /// Its vertices, by name.
        vertices: String,
        /// What is not finite.
        quantity: &'static str,
    },
    /// No path leads from a pore to a wall with an imposed pressure.
    #[error(
        "pore {pore} (vertices {vertices}) and {others} others are isolated: no path to a wall with an imposed pressure, \
         so their pressure is undetermined"
    )]
    IsolatedPore {
        /// One of the isolated pores.
        pore: u32,
        /// Its vertices, by name.
        vertices: String,
        /// How many more are isolated.
        others: usize,
    },
    /// A pressure came out as NaN or infinite.
    #[error("the pressure of pore {pore} is not finite")]
    PressureNotFinite {
        /// The pore.
        pore: u32,
    },
}
