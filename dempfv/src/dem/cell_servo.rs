//! The servo of a periodic cell: its strain in a step, until a stress is there.

use super::cell::{CellControl, PeriodicCell};
use super::cell_pass::CellSum;
use super::system::Dem;
use crate::{Effect, EffectKey, Family, Tensor};

/// What the effect says of itself.
pub const EFFECT: Effect = Effect {
    name: "servo cell",
    family: Family::Boundaries,
    equation: "dt L_ab = (sigma_ab - goal) / (2 K_ab) + drift, \
               K_ab = sum l_b^2 (k_n n_a^2 + k_s (1 - n_a^2)) / V, \
               at most dt 0.01 sqrt(sigma / rho) / d",
    source: "proportional and integral control by the affine stiffness of the contacts; the limit is an \
             inertial number (GDR MiDi 2004)",
    keys: &[EffectKey { key: "cell_stress in a run stage", unit: "Pa", default: "none" }],
    needs: "a periodic cell",
    test: "dempfv/tests/cell_motion.rs",
};

/// Share of an excess of stress that a step takes away. Strains along the axes feel each other:
/// together they may be three times as stiff as each alone, and this share stays below 2/3.
const GAIN: f64 = 0.5;
/// Share of it that counts as the strain of the steps to come: learned in some fifty steps, which
/// the first share damps without an overshoot.
const DRIFT_GAIN: f64 = 0.02;
/// Largest rate as an inertial number, ε̇ d √(ρ/σ).
const INERTIAL: f64 = 0.01;
/// Largest approach of two of the largest spheres in a step, over the smallest radius: as for a
/// wall.
const APPROACH: f64 = 0.02;

/// What the spheres are like, as a servo has to know.
#[derive(Clone, Copy, Debug)]
struct Bodies {
    /// Σ m c ⊗ c (J).
    motion: Tensor,
    /// Mean, smallest and largest radius (m).
    mean: f64,
    smallest: f64,
    largest: f64,
}

/// A component of the stress, and what shall become of it.
#[derive(Clone, Copy, Debug)]
struct CellLoad {
    /// Stress less the one wanted (Pa).
    excess: f64,
    /// By how much the stress falls for a unit of strain (Pa).
    stiffness: f64,
    /// Largest strain in a step (1).
    limit: f64,
    /// What has been learned of the strain in a step (1).
    drift: f64,
}

impl CellLoad {
    /// The strain of a step, and what is learned of those to come.
    fn strain(self) -> (f64, f64) {
        let CellLoad { excess, stiffness, limit, drift } = self;
        let wanted = excess / stiffness;
        if excess == 0.0 && stiffness == 0.0 {
            return (0.0, 0.0);
        }
        let strain = GAIN * wanted + drift;
        match strain.abs() < limit {
            true => (strain, drift + DRIFT_GAIN * wanted),
            // Nothing is learned of a way that is not free.
            false => (limit.copysign(excess), 0.0),
        }
    }
}

impl Dem {
    /// The velocity gradient of a step of length `dt` (s), and what the servo learns.
    pub(super) fn cell_gradient(&self, cell: &PeriodicCell, dt: f64) -> (Tensor, Tensor) {
        let bodies = cell.has_servo().then(|| self.bodies());
        let (mut gradient, mut drift) = (Tensor::zeros(), Tensor::zeros());
        for (a, b) in (0..3).flat_map(|a| (0..3).map(move |b| (a, b))) {
            match (cell.controls[a][b], &bodies) {
                (CellControl::Rate(rate), _) => gradient[(a, b)] = rate,
                (CellControl::Stress(wanted), Some(bodies)) => {
                    let load = self.cell_load(cell, bodies, (a, b), wanted, dt);
                    let (strain, learned) = load.strain();
                    (gradient[(a, b)], drift[(a, b)]) = (strain / dt, learned / dt);
                }
                (CellControl::Stress(_), None) => {}
            }
        }
        (gradient, drift)
    }

    fn cell_load(
        &self,
        cell: &PeriodicCell,
        bodies: &Bodies,
        (a, b): (usize, usize),
        wanted: f64,
        dt: f64,
    ) -> CellLoad {
        let CellSum { moment, stiffness } = &self.cell_sum;
        let volume = cell.cell().volume();
        let at = 3 * a + b;
        // A shear stress is that of both planes.
        let forces = 0.5 * (moment[at] + moment[3 * b + a]);
        let stress = (forces + bodies.motion[(a, b)]) / volume;
        let scale = stress.abs().max(wanted.abs());
        let rate = INERTIAL * (scale / self.softest.density).sqrt() / (2.0 * bodies.mean);
        let closest = APPROACH * bodies.smallest / (2.0 * bodies.largest);
        CellLoad {
            excess: stress - wanted,
            stiffness: stiffness[at] / volume,
            limit: (rate * dt).min(closest),
            drift: cell.drift[(a, b)] * dt,
        }
    }

    fn bodies(&self) -> Bodies {
        let p = &self.particles;
        let start =
            Bodies { motion: Tensor::zeros(), mean: 0.0, smallest: f64::INFINITY, largest: 0.0 };
        let all = p.mass.iter().zip(&p.velocity).zip(&p.radius);
        let mut sum = all.fold(start, |sum, ((&m, c), &r)| Bodies {
            motion: sum.motion + m * c * c.transpose(),
            mean: sum.mean + r,
            smallest: sum.smallest.min(r),
            largest: sum.largest.max(r),
        });
        sum.mean /= p.len().max(1) as f64;
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A packing whose stress falls by `softness` of what is expected, and grows by `flow` in
    /// each step: the stress after so many steps.
    fn after(steps: usize, softness: f64, flow: f64) -> f64 {
        let (mut stress, mut drift) = (0.5, 0.0);
        for _ in 0..steps {
            let load = CellLoad { excess: stress - 1.0, stiffness: 1e3, limit: 1.0, drift };
            let (strain, learned) = load.strain();
            drift = learned;
            stress += flow - softness * 1e3 * strain;
        }
        stress
    }

    /// From a tenth to three times as stiff as expected, at rest and while the packing dilates.
    #[test]
    fn the_stress_wanted_is_reached_and_held() {
        for softness in [0.1, 0.3, 1.0, 2.0, 3.0] {
            for flow in [0.0, 1e-2, -1e-2] {
                let stress = after(2_000, softness, flow);
                assert!((stress - 1.0).abs() < 1e-6, "{softness} {flow}: {stress}");
            }
        }
    }

    /// Without contacts the cell closes at its limit and learns nothing.
    #[test]
    fn a_loose_cell_closes_at_its_limit() {
        let load = CellLoad { excess: -5.0, stiffness: 0.0, limit: 1e-4, drift: 0.3 };
        assert_eq!(load.strain(), (-1e-4, 0.0));
        assert_eq!(CellLoad { excess: 0.0, ..load }.strain(), (0.0, 0.0));
    }
}
