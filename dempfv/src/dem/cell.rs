//! A periodic cell around the spheres: no walls, and copies of the spheres beyond its faces.
//!
//! With the velocity gradient L, a place x that goes with the cell has the velocity L x, and the
//! edges H change by H' = (1 + Δt L) H in a step. Velocities of spheres are relative to that mean
//! field: c = v − L x. Newton's equation for v, with the affine acceleration (L̇ + L²) x that moves
//! spheres and cell together, is
//!
//! ```text
//! m ċ = f − m L c,    ẋ = L x + c
//! ```
//!
//! and its step x' = (1 + Δt L) x + Δt c', with c' = (1 + Δt L)⁻¹ c + Δt f/m. The term L c takes
//! from the motion, or gives to it, what the kinetic part of the stress does: the energy of the
//! spheres changes by −V σ:L, with σ of contacts and motion together. (YADE leaves the term out.)
//! The velocity of a copy at distance l is c_j − c_i + L l relative to a sphere.

use serde::{Deserialize, Serialize};

use super::error::DemError;
use super::material::{finite, positive};
use crate::{Cell, Effect, EffectKey, Family, Tensor};

/// What the effect says of itself.
pub const EFFECT: Effect = Effect {
    name: "periodic cell",
    family: Family::Boundaries,
    equation: "x' = (1 + dt L) x + dt c',  c' = (1 + dt L)^-1 c + dt f/m,  H' = (1 + dt L) H; \
               of a pair l = x_j + H n - x_i, and its velocity c_j - c_i + L l",
    source: "Lees and Edwards 1972 (images); Evans and Morriss 1984 (SLLOD equations)",
    keys: &[
        EffectKey { key: "size in [cell]", unit: "m", default: "that of the packing file" },
        EffectKey { key: "edges in [cell]", unit: "m", default: "those of the packing file" },
        EffectKey { key: "velocity_gradient in a run stage", unit: "1/s", default: "0" },
    ],
    needs: "a cell with heights of twice the reach of the largest pair; no walls or gravity",
    test: "dempfv/tests/cell_contacts.rs, dempfv/tests/cell_motion.rs",
};

/// What moves the cell in one component of its velocity gradient L_ab = ∂v_a/∂x_b.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CellControl {
    /// The component has this value (1/s): on the diagonal positive where the cell grows.
    Rate(f64),
    /// The component is such that σ_ab of contacts and motion becomes this (Pa, positive in
    /// compression, so that shear with L_ab > 0 makes it negative).
    ///
    /// Its speed follows from the stiffness of the contacts. It is at most 0.01 √(σ/ρ) / d, with
    /// the larger of the stress wanted and the one there as σ, and the mean diameter d: an
    /// inertial number of 0.01.
    Stress(f64),
}

impl Default for CellControl {
    /// The cell keeps its shape.
    fn default() -> CellControl {
        CellControl::Rate(0.0)
    }
}

/// What moves the cell: entry `[a][b]` for L_ab.
pub type CellControls = [[CellControl; 3]; 3];

/// Largest strain in a step: two spheres that touch come as much nearer, over their distance.
const MOST_STRAIN: f64 = 0.1;

/// A periodic cell in motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PeriodicCell {
    cell: Cell,
    pub(super) controls: CellControls,
    /// L in the last step (1/s), and that step (s).
    velocity_gradient: Tensor,
    last_dt: f64,
    strain: Tensor,
    /// What the servo has learned of the rates that the stresses ask for (1/s).
    pub(super) drift: Tensor,
}

impl PeriodicCell {
    /// A cell at rest, by its short edges.
    pub(super) fn new(cell: Cell) -> PeriodicCell {
        PeriodicCell {
            cell: cell.reduced().unwrap_or(cell),
            controls: CellControls::default(),
            velocity_gradient: Tensor::zeros(),
            last_dt: 0.0,
            strain: Tensor::zeros(),
            drift: Tensor::zeros(),
        }
    }

    /// The cell. Its edges are those of the same copies that are short: where shear has made
    /// others shorter, these take their place.
    pub fn cell(&self) -> &Cell {
        &self.cell
    }

    /// Velocity gradient of the last step (1/s).
    pub fn velocity_gradient(&self) -> &Tensor {
        &self.velocity_gradient
    }

    /// ∫ L dt since the cell was made (1): on the diagonal logarithmic strains, positive in
    /// extension; beside it shear strains.
    pub fn strain(&self) -> &Tensor {
        &self.strain
    }

    /// What moves the cell.
    pub fn controls(&self) -> &CellControls {
        &self.controls
    }

    /// Length of the last step (s); 0 before the first.
    pub(super) fn last_step(&self) -> f64 {
        self.last_dt
    }

    /// Whether a stress is prescribed.
    pub(super) fn has_servo(&self) -> bool {
        self.controls.iter().flatten().any(|c| matches!(c, CellControl::Stress(_)))
    }

    /// Changes what moves the cell; where a stress was not asked for before, the servo begins
    /// without memory.
    pub(super) fn set_controls(&mut self, controls: CellControls) -> Result<(), DemError> {
        check(&controls)?;
        let held = |c: CellControl| matches!(c, CellControl::Stress(_));
        for (a, b) in (0..3).flat_map(|a| (0..3).map(move |b| (a, b))) {
            if !(held(controls[a][b]) && held(self.controls[a][b])) {
                self.drift[(a, b)] = 0.0;
            }
        }
        self.controls = controls;
        Ok(())
    }

    /// Takes a step of length `dt` (s) with this velocity gradient.
    pub(super) fn advance(&mut self, gradient: Tensor, dt: f64) -> Result<(), DemError> {
        for (first, second) in (0..3).flat_map(|a| (0..3).map(move |b| (a, b))) {
            let rate = gradient[(first, second)];
            let (strain, most) = ((dt * rate).abs(), MOST_STRAIN);
            if strain > most {
                return Err(DemError::CellStrainPerStep { first, second, rate, dt, strain, most });
            }
        }
        self.cell = self.cell.deformed(&gradient, dt)?;
        self.velocity_gradient = gradient;
        self.last_dt = dt;
        self.strain += dt * gradient;
        Ok(())
    }

    /// Takes the short edges; returns whether they were others.
    pub(super) fn reduce(&mut self) -> bool {
        match self.cell.reduced() {
            Some(cell) => {
                self.cell = cell;
                true
            }
            None => false,
        }
    }

    /// Refuses numbers that no step leaves.
    pub(super) fn check(&self) -> Result<(), DemError> {
        for (name, tensor) in [
            ("velocity gradient of the cell", &self.velocity_gradient),
            ("strain of the cell", &self.strain),
            ("drift of the cell", &self.drift),
        ] {
            tensor.iter().try_for_each(|&x| finite(name, x))?;
        }
        if self.last_dt != 0.0 {
            positive("last step of the cell", self.last_dt)?;
        }
        check(&self.controls)
    }
}

/// Refuses controls that make no sense.
fn check(controls: &CellControls) -> Result<(), DemError> {
    for (a, b) in (0..3).flat_map(|a| (0..3).map(move |b| (a, b))) {
        match controls[a][b] {
            CellControl::Rate(rate) => finite("velocity gradient", rate)?,
            CellControl::Stress(stress) => {
                finite("cell stress", stress)?;
                if a != b && matches!(controls[b][a], CellControl::Stress(_)) {
                    return Err(DemError::StressTwice { first: a.min(b), second: a.max(b) });
                }
            }
        }
    }
    Ok(())
}
