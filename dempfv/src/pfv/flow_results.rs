//! What a flow has found: pressures, forces, fluxes, permeability, and how it was solved.

use super::flow::Flow;
use super::{BuildTimes, NetworkRemarks};
use crate::solver::Placement;
use crate::{Vec3, WallId};

/// A measured permeability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Permeability {
    /// Intrinsic permeability `k = Q μ L / (A Δp)` (m²).
    pub value: f64,
    /// Flux along the axis (m³/s).
    pub flux: f64,
    /// What enters less what leaves, relative to the flux (1).
    pub imbalance: f64,
}

impl Flow {
    /// Mean pressure of the pores around each sphere, weighted by their volumes (Pa), in the order of the
    /// positions that the network was built of; 0 for a sphere that is a vertex of no pore.
    pub(crate) fn pressure_at_spheres(&self, spheres: usize) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); spheres];
        let (cells, volume) = (&self.network().tessellation.cells, &self.network().volume);
        for ((cell, v), p) in cells.iter().zip(volume).zip(self.pressure()) {
            for &vertex in cell {
                if let Some(sum) = sums.get_mut(vertex as usize) {
                    *sum = (sum.0 + v * p, sum.1 + v);
                }
            }
        }
        let mean = |(weighted, volume)| if volume > 0.0 { weighted / volume } else { 0.0 };
        sums.into_iter().map(mean).collect()
    }

    /// What the last [`Flow::update_pressure`] left, where its refinements did not come down to
    /// the tolerance: the larger of the estimated error of the pressures, relative to the largest, and
    /// of the imbalance of fluid mass (1).
    pub fn unmet_tolerance(&self) -> Option<f64> {
        self.solver.statistics.unmet
    }

    /// What throats brought to each pore in the last solve (m³/s).
    pub(super) fn demand(&self) -> &[f64] {
        self.terms.last_demand(&self.volume_rate)
    }

    /// Volume of each pore when the network was built (m³).
    pub fn built_volume(&self) -> &[f64] {
        match &self.geometry {
            Some(geometry) => geometry.built_volume(),
            None => &self.network.volume,
        }
    }

    /// Pressure of each pore (Pa).
    pub fn pressure(&self) -> &[f64] {
        self.pressures.absolute()
    }

    /// Rate at which each pore grows (m³/s).
    pub fn volume_rate(&self) -> &[f64] {
        &self.volume_rate
    }

    /// The fluid's force on each sphere (N).
    pub fn force(&self) -> &[Vec3] {
        &self.force
    }

    /// The fluid's force on each wall (N).
    pub fn wall_force(&self) -> &[Vec3; 6] {
        &self.wall_force
    }

    /// Flux through each wall, positive into the box (m³/s).
    pub fn flux(&self) -> [f64; 6] {
        let mut flux = [0.0; 6];
        self.operators.evaluate_flux(&self.pressures.relative, self.demand(), &mut flux);
        flux
    }

    /// Flux from the pores of each of [`Flow::imposed_pressures`], positive into the box
    /// (m³/s).
    pub fn imposed_flux(&self) -> Vec<f64> {
        let mut flux = vec![0.0; self.operators.conditions().sets()];
        self.operators.evaluate_flux(&self.pressures.relative, self.demand(), &mut flux);
        flux.truncate(self.operators.conditions().imposed_sets());
        flux.split_off(6)
    }

    /// Residual of the first solve after the factorization; `None` before it.
    pub fn residual(&self) -> Option<f64> {
        self.solver.statistics.residual
    }

    /// What entered from pores with an imposed pressure less what the pores swallowed in the
    /// last solve, over the larger of both ([`Operators::imbalance`](super::Operators::imbalance)).
    pub fn imbalance(&self) -> f64 {
        self.solver.statistics.imbalance
    }

    /// How long the network and its factorization took.
    pub fn build_times(&self) -> BuildTimes {
        self.build_times
    }

    /// Where the factorization was computed.
    pub fn placement(&self) -> &Placement {
        static NOTHING: Placement = Placement::Cpu;
        self.solver.factor().map_or(&NOTHING, |f| f.placement())
    }

    /// Name of the solver that has the factor, where `auto` has chosen one; `None` when
    /// nothing is unknown.
    pub fn solved_by(&self) -> Option<&'static str> {
        self.solver.factor().map(|factor| factor.solver())
    }

    /// Number of entries of the factor; 0 when nothing is unknown.
    pub fn nnz_l(&self) -> u64 {
        self.solver.factor().map_or(0, |f| f.analysis().nnz_l)
    }

    /// What is out of the ordinary in the network, as it was built.
    pub fn remarks(&self) -> NetworkRemarks {
        let sealed = self.operators.sealed_pores();
        NetworkRemarks {
            sealed_pores: match self.network.periodic() {
                None => sealed.in_groups() as u32,
                // Most pores of a cell are one group, which nothing seals.
                Some(_) => sealed.beside_largest() as u32,
            },
            drained_pores: sealed.drained() as u32,
            filled_pores: sealed.filled.len() as u32,
            contested_pores: self.operators.conditions().contested(),
            ..self.network.remarks
        }
    }

    /// Permeability between two walls with imposed pressures, from the current
    /// pressures. `None` before a solve, with terms beside throats and motion, and unless `wall`
    /// and the opposite wall, and nothing else, have imposed pressures, the same all along, and these
    /// differ.
    pub fn permeability(&self, wall: WallId) -> Option<Permeability> {
        let imposed = &self.fluid.boundary.pressure;
        let drop = imposed[wall]? - imposed[wall.opposite()]?;
        let others = imposed.values().flatten().count() != 2
            || !self.conditions.imposed.is_empty()
            || self.conditions.profiles.values().any(Option::is_some);
        let others = others || self.terms().next().is_some();
        if drop == 0.0 || others || !self.solver.statistics.solved {
            return None;
        }
        let flux = self.flux();
        let (entering, leaving) = (flux[wall.index()], -flux[wall.opposite().index()]);
        let bounds = &self.network.bounds;
        let length = bounds.size()[wall.axis()];
        let viscosity = self.fluid.viscosity;
        Some(Permeability {
            value: entering * viscosity * length / (bounds.wall_area(wall) * drop),
            flux: entering,
            imbalance: (entering - leaving).abs() / entering.abs(),
        })
    }
}
