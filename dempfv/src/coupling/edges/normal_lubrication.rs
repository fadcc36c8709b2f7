//! Normal lubrication: the film between two surfaces that come closer is squeezed out.

use std::f64::consts::PI;

use super::film::Film;
use crate::{Effect, EffectKey, Family};

/// What this effect says of itself.
pub const EFFECT: Effect = Effect {
    name: "normal lubrication",
    family: Family::Fluid,
    equation: "F/c + (dF/dt)/k = closing speed, c = 3/2 π μ R² / (h + F/k), h = max(gap, 0) + 2 ε R; \
               implicit in time; 6 π μ R² at walls without slip",
    source: "G. I. Taylor, in D. J. Jeffrey, Y. Onishi: J. Fluid Mech. 139 (1984); \
             D. Marzougui, B. Chareyre, J. Chauchat: Granular Matter 17 (2015)",
    keys: &[
        EffectKey { key: "normal_lubrication in [fluid]", unit: "", default: "false" },
        EffectKey { key: "eps in [fluid]", unit: "", default: "1e-5" },
        EffectKey {
            key: "lubrication_stiffness in [fluid]",
            unit: "Pa",
            default: "young of both bodies",
        },
    ],
    needs: "the edges of the triangulation",
    test: "dempfv/tests/coupling_lubrication.rs",
};

/// c h / (μ R²) between two spheres, and at a wall along which the fluid slips: that is a plane of
/// symmetry, where a sphere meets its own image at twice the speed across twice the gap.
pub const SYMMETRIC: f64 = 1.5 * PI;
/// The same at a wall that holds the fluid.
pub const HELD: f64 = 6.0 * PI;

/// Writes the force of each film after a step of length `dt` (s); `factor` is c h / (μ R²).
pub fn squeeze(films: &mut [Film], factor: f64, viscosity: f64, dt: f64) {
    for film in films {
        let element = Element {
            squeeze: factor * viscosity * film.radius.powi(2),
            thickness: film.thickness,
            stiffness: film.stiffness,
        };
        film.force_before = film.force;
        film.force = element.force(film.force, film.closing, dt);
    }
}

/// Force per closing speed of a film in a step of length `dt` (s), at most (N·s/m).
pub fn resistance(film: &Film, factor: f64, viscosity: f64, dt: f64) -> f64 {
    let squeeze = factor * viscosity * film.radius.powi(2);
    1.0 / (film.thickness / squeeze + 1.0 / (film.stiffness * dt))
}

/// The dashpot (N·s/m) that bounds the time step for what a film and its spring do in steps of up to
/// `dt` (s): the film itself, or one that brakes as much in such a step as the spring does.
pub fn damping(film: &Film, factor: f64, viscosity: f64, dt: f64) -> f64 {
    let squeeze = factor * viscosity * film.radius.powi(2);
    (squeeze / film.thickness).min(0.5 * film.stiffness * dt)
}

/// A film and a spring, one behind the other.
struct Element {
    /// c h (N·s).
    squeeze: f64,
    /// Thickness of the film that nothing presses (m).
    thickness: f64,
    /// Stiffness of the spring (N/m).
    stiffness: f64,
}

impl Element {
    /// The force at the end of a step of length `dt` (s) in which the two close at this speed (m/s):
    /// F (h + F⁺/k) / (c h) + (F − F₀) / (k dt) = v. Surfaces that the film presses apart make it
    /// thicker by F/k; suction, which would close it, is left out, so that F rises with v and there
    /// is one. It is finite for any thickness, 0 included.
    fn force(&self, before: f64, closing: f64, dt: f64) -> f64 {
        let Element { squeeze, thickness, stiffness } = *self;
        let compliance = 1.0 / (stiffness * dt);
        let driven = closing + before * compliance;
        let slope = thickness / squeeze + compliance;
        if driven <= 0.0 {
            return driven / slope;
        }
        let bend = 4.0 * driven / (stiffness * squeeze);
        2.0 * driven / (slope + (slope * slope + bend).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From closed films to such as thick as the sphere, pressed and sucked at, in steps from far
    /// below to far above the time of the element: the force is finite, solves its equation to
    /// round-off, and rises with the speed.
    #[test]
    fn the_force_is_finite_and_solves_its_equation() {
        for thickness in [0.0, 1e-12, 1e-3, 1.0] {
            for dt in [1e-9, 1e-3, 1e3] {
                for before in [-5.0, 0.0, 5.0] {
                    let element = Element { squeeze: 2.0, thickness, stiffness: 1e3 };
                    let mut last = f64::NEG_INFINITY;
                    for closing in [-1e3, -1.0, 0.0, 1e-6, 1.0, 1e3] {
                        let f = element.force(before, closing, dt);
                        let film = f * (thickness + f.max(0.0) / 1e3) / 2.0;
                        let spring = (f - before) / (1e3 * dt);
                        let size = film.abs() + f.abs().max(before.abs()) / (1e3 * dt);
                        let left = film + spring - closing;
                        assert!(left.abs() <= 1e-14 * size.max(closing.abs()), "{f} {left}");
                        assert!(f.is_finite() && f >= last, "{f} {last}");
                        last = f;
                    }
                }
            }
        }
    }
}
