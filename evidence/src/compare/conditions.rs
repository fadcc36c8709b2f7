//! Flows through one packing at rest, as YADE has them: injection at points as in its check
//! `checkDEM-PFVPressureInjection.py`, the start of a flow of a compressible fluid, and a flow through a Darcy
//! medium.

use serde::{Deserialize, Serialize};

use super::loading::Packing;
use super::peer::Bench;
use crate::Error;

const SCRIPT: &str = include_str!("scripts/injection.py");

/// What the script is asked for: viscosity and pressure of YADE's check; pores above a third of the
/// height are held at zero, as it does.
#[derive(Serialize)]
pub struct Job {
    pub spheres: Vec<[f64; 4]>,
    #[serde(rename = "box")]
    pub bounds: [f64; 6],
    pub viscosity: f64,
    pub pressure: f64,
    pub level: f64,
    pub bulk_modulus: f64,
    pub dt: f64,
    /// Steps after which the compressible flow is looked at.
    pub looks: Vec<u32>,
    pub mobility: f64,
    cases: Vec<Case>,
}

/// A flow.
#[derive(Clone, Copy, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Case {
    Injection,
    Compression,
    Darcy,
}

/// What YADE found, of the cases that were wanted.
#[derive(Deserialize)]
pub struct Found {
    pub injection: Option<Injection>,
    pub compression: Option<Compression>,
    /// Flux into the box at bottom and top (m³/s).
    pub darcy: Option<[f64; 2]>,
}

/// Vertices of cells are spheres from 0 and, after them, the walls.
#[derive(Serialize, Deserialize)]
pub struct Injection {
    pub cells: Vec<[u32; 4]>,
    pub held: Vec<u32>,
    pub pressure: Vec<f64>,
    /// Through the bottom, and out of the pores that are held (m³/s).
    pub entering: f64,
    pub leaving: f64,
    /// Void volume of each cell (m³).
    pub void: Vec<f64>,
}

#[derive(Deserialize)]
pub struct Compression {
    pub cells: Vec<[u32; 4]>,
    pub void: Vec<f64>,
    pub looks: Vec<Look>,
}

/// After some steps.
#[derive(Serialize, Deserialize)]
pub struct Look {
    pub pressure: Vec<f64>,
    /// Into the box at bottom and top (m³/s).
    pub flux: [f64; 2],
}

impl Job {
    pub fn new(packing: &Packing, cases: &[Case]) -> Job {
        let [_, low, _, _, high, _] = packing.bounds;
        Job {
            spheres: packing.spheres.clone(),
            bounds: packing.bounds,
            viscosity: 0.1,
            pressure: 1000.0,
            level: low + (high - low) / 3.0,
            bulk_modulus: 1e6,
            dt: 1e-4,
            looks: vec![1, 5, 25],
            mobility: 2e-3,
            cases: cases.to_vec(),
        }
    }

    /// What YADE makes of it.
    ///
    /// # Errors
    /// When YADE fails.
    pub fn ask(&self, bench: &Bench, step: &str) -> Result<Found, Error> {
        Ok(bench.yade::<Found>(step, SCRIPT, 1, self)?.result)
    }
}
