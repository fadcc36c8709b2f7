//! What can be wrong with a pore network.

use std::fmt;

use crate::WallId;
use crate::solver::SolverError;

/// The vertices of a pore, for messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PoreVertices(pub [PoreVertex; 4]);

/// A vertex of a pore.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PoreVertex {
    /// The sphere with this number.
    Sphere(u32),
    /// A wall.
    Wall(WallId),
}

impl fmt::Display for PoreVertices {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, vertex) in self.0.iter().enumerate() {
            f.write_str(if k == 0 { "" } else { ", " })?;
            match vertex {
                PoreVertex::Sphere(number) => number.fmt(f)?,
                PoreVertex::Wall(wall) => f.write_str(wall.name())?,
            }
        }
        Ok(())
    }
}

/// The pore network cannot be built or used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PfvError {
    /// An argument cannot be right.
    #[error("{argument}{}: {problem}", index.map(|i| format!("[{i}]")).unwrap_or_default())]
    InvalidInput {
        /// Name of the argument.
        argument: &'static str,
        /// Which of its entries.
        index: Option<usize>,
        /// What is wrong, and what would be right.
        problem: String,
    },
    /// The linear solver failed.
    #[error(transparent)]
    Solver(#[from] SolverError),
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
    /// A pore lies between opposite walls or has no sphere, which happens where spheres are
    /// many times farther from each other than the walls.
    #[error(
        "pore {pore} (vertices {vertices}) has no place between sphere and walls: two walls face each \
         other with no sphere between; fill the box with more spheres, or take one that is not so flat"
    )]
    BadPore {
        /// The pore.
        pore: u32,
        /// Its vertices.
        vertices: PoreVertices,
    },
    /// A pore's geometry or a throat's conductance is not finite.
    #[error("pore {pore} (vertices {vertices}): {quantity} is not finite")]
    NotFinite {
        /// The pore.
        pore: u32,
        /// Its vertices.
        vertices: PoreVertices,
        /// What is not finite.
        quantity: &'static str,
    },
    /// Pores without a path to an imposed pressure would have to swallow fluid.
    #[error(
        "pore {pore} (vertices {vertices}){} no path to a pore with an imposed pressure, but would have to swallow \
         {rate:.3e} m³/s: there is no such flow of an incompressible fluid; impose a pressure, keep \
         spheres from overlapping so much that they close its throats, or let such pores drain \
         (`sealed_pores = \"drained\"` in [fluid])",
        others(*pores)
    )]
    SealedPores {
        /// One of the pores.
        pore: u32,
        /// Its vertices.
        vertices: PoreVertices,
        /// How many there are in its group.
        pores: usize,
        /// What they would have to swallow together (m³/s).
        rate: f64,
    },
    /// An incompressible fluid cannot follow a periodic cell that changes its volume.
    #[error(
        "the periodic cell would have to swallow {rate:.3e} m³/s of an incompressible fluid that no wall lets \
         in: deform it at constant volume, or give the fluid a bulk modulus"
    )]
    ClosedCell {
        /// What it would have to swallow (m³/s).
        rate: f64,
    },
    /// A pore reaches so far through a periodic cell that copies of it might meet.
    #[error(
        "the pore between the spheres {vertices} reaches through {:.0} % of the periodic cell along one of its \
         edges; a flow needs pores narrower than half of it: take a larger cell, such as one of several copies",
        100.0 * share
    )]
    WidePore {
        /// Its vertices.
        vertices: PoreVertices,
        /// How far it reaches, over the edge (1).
        share: f64,
    },
    /// The triangulation of a cell and its copies does not repeat itself.
    #[error(
        "the triangulation of {spheres} spheres in a periodic cell does not close: the pores between them are \
         wider than the cell; take a larger cell, such as one of several copies"
    )]
    NotPeriodic {
        /// Number of spheres in the cell.
        spheres: usize,
    },
    /// A pressure came out as NaN or infinite.
    #[error("the pressure of pore {pore} is not finite")]
    PressureNotFinite {
        /// The pore.
        pore: u32,
    },
}

/// How many pores there are beside the one that was named.
fn others(pores: usize) -> String {
    match pores {
        1 => " has".to_owned(),
        n => format!(" and {} others, joined to it, have", n - 1),
    }
}

impl PfvError {
    /// An entry of an argument cannot be right.
    pub(super) fn invalid(
        argument: &'static str,
        index: usize,
        problem: impl Into<String>,
    ) -> PfvError {
        PfvError::InvalidInput { argument, index: Some(index), problem: problem.into() }
    }

    /// The pore that the error is about, where it is about one.
    pub fn pore(&self) -> Option<u32> {
        match self {
            PfvError::BadPore { pore, .. }
            | PfvError::NotFinite { pore, .. }
            | PfvError::SealedPores { pore, .. }
            | PfvError::PressureNotFinite { pore } => Some(*pore),
            _ => None,
        }
    }

    /// The same error where sphere `i` has the number `number[i]`: the user's,
    /// when the network was built of spheres in another order.
    #[must_use]
    pub fn with_numbers(mut self, number: &[u32]) -> PfvError {
        if let PfvError::InvalidInput {
            argument: "position" | "radius", index: Some(index), ..
        } = &mut self
        {
            *index = number.get(*index).map_or(*index, |&number| number as usize);
        }
        if let PfvError::BadPore { vertices, .. }
        | PfvError::NotFinite { vertices, .. }
        | PfvError::WidePore { vertices, .. }
        | PfvError::SealedPores { vertices, .. } = &mut self
        {
            for vertex in &mut vertices.0 {
                if let PoreVertex::Sphere(sphere) = vertex {
                    *sphere = number.get(*sphere as usize).copied().unwrap_or(*sphere);
                }
            }
        }
        self
    }
}
