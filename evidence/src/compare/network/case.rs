//! What is compared: one packing, its settings, and our own answer.

use std::path::{Path, PathBuf};

use dempfv::pfv::{Boundary, Clamp, Derivatives, Flow, Fluid, Network};
use dempfv::scene::load_packing;
use dempfv::solver::SolverKind;
use dempfv::{Aabb, Vec3, WallId};
use serde::{Deserialize, Serialize};

use crate::Error;

/// Dynamic viscosity of the fluid (Pa·s): water's.
pub const VISCOSITY: f64 = 1e-3;

/// Settings that both programs have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Case {
    /// Does the fluid slip along walls without imposed pressure?
    pub slip: bool,
    /// Are conductances clamped as YADE does by default?
    pub clamp: bool,
}

impl Case {
    /// All settings.
    pub const ALL: [Case; 4] = [
        Case { slip: true, clamp: false },
        Case { slip: true, clamp: true },
        Case { slip: false, clamp: false },
        Case { slip: false, clamp: true },
    ];

    /// The settings in words.
    pub fn name(self) -> String {
        let slip = if self.slip { "slip" } else { "no slip" };
        let clamp = if self.clamp { "YADE's clamp" } else { "no clamp" };
        format!("{slip}, {clamp}")
    }

    /// The fluid with these settings: 1 Pa at the bottom, 0 at the top.
    pub fn fluid(self) -> Fluid {
        let clamp = if self.clamp { Clamp::Yade } else { Clamp::Unlimited };
        Fluid { viscosity: VISCOSITY, slip_walls: self.slip, clamp, boundary: boundary() }
    }
}

/// 1 Pa at the bottom, 0 at the top, nothing through the other walls.
pub fn boundary() -> Boundary {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMin] = Some(1.0);
    boundary.pressure[WallId::YMax] = Some(0.0);
    boundary
}

/// A packing to compare on.
pub struct Packing {
    /// Name of its file.
    pub name: String,
    /// Centres (m).
    pub position: Vec<Vec3>,
    /// Radii (m).
    pub radius: Vec<f64>,
    /// The box (m).
    pub bounds: Aabb,
}

impl Packing {
    /// Reads a packing file.
    ///
    /// # Errors
    /// What is wrong in it.
    pub fn read(path: &Path) -> Result<Packing, Error> {
        let (packing, bounds) = load_packing(path, None)?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Packing { name, position: packing.position, radius: packing.radius, bounds })
    }

    /// Reads all of them.
    ///
    /// # Errors
    /// What is wrong in one of them.
    pub fn read_all(paths: &[PathBuf]) -> Result<Vec<Packing>, Error> {
        paths.iter().map(|path| Packing::read(path)).collect()
    }

    /// The same in another unit of length.
    pub fn scaled(&self, scale: f64) -> Packing {
        let Aabb { min, max } = self.bounds;
        Packing {
            name: self.name.clone(),
            position: self.position.iter().map(|x| x * scale).collect(),
            radius: self.radius.iter().map(|r| r * scale).collect(),
            bounds: Aabb { min: min * scale, max: max * scale },
        }
    }

    /// Our own flow through it.
    ///
    /// # Errors
    /// Those of the network and the solver.
    pub fn flow(&self, fluid: &Fluid) -> Result<Flow, Error> {
        let solver = SolverKind::default();
        let mut flow = Flow::new(&self.position, &self.radius, self.bounds, fluid, solver)
            .map_err(dempfv::Error::from)?;
        flow.solve_static().map_err(dempfv::Error::from)?;
        Ok(flow)
    }

    /// The derivatives of the network, which a flow keeps as operators only.
    ///
    /// # Errors
    /// Those of the network.
    pub fn derivatives(&self, fluid: &Fluid) -> Result<Derivatives, Error> {
        let network = Network::new(&self.position, &self.radius, self.bounds, fluid);
        Ok(network.map_err(dempfv::Error::from)?.1)
    }

    /// Centres and radii, as the scripts want them.
    pub fn spheres(&self) -> Vec<[f64; 4]> {
        self.position.iter().zip(&self.radius).map(|(x, &r)| [x.x, x.y, x.z, r]).collect()
    }

    /// The box's lower and upper corner, as the scripts want them.
    pub fn corners(&self) -> [f64; 6] {
        let Aabb { min, max } = self.bounds;
        [min.x, min.y, min.z, max.x, max.y, max.z]
    }

    /// Volume that no sphere fills, over the box's (1).
    pub fn porosity(&self) -> f64 {
        let solid: f64 = self.radius.iter().map(|r| r.powi(3)).sum();
        1.0 - 4.0 / 3.0 * std::f64::consts::PI * solid / self.bounds.volume()
    }
}
