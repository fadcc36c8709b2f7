//! What the edges ask of the time step.

use super::film::{Bodies, Film};
use super::forces::EdgeForces;
use super::normal_lubrication::damping;
use crate::dem::law::Stiffness;
use crate::dem::{Dem, StiffnessSum};

/// Two surfaces come nearer by less than this share of the smallest radius between two looks at the
/// bounds ([`Dem::steps_between_looks`]).
const APPROACH: f64 = 0.005;
/// Inverse inertia of a sphere's rim, m r² / I.
const RIM: f64 = 2.5;

impl EdgeForces {
    /// No less than the largest rate (1/s) at which the edges stop a motion of the spheres, in steps of up
    /// to `dt` (s), as thin as films may become until the next look.
    ///
    /// The power of all edges is a sum of squares, c |Σ u|² with a share u of each body's velocity and of
    /// the velocity of its rim. By Cauchy's inequality each is at most c (Σ p) Σ u²/p; with p = 1 for
    /// velocities and p = m r²/I for rims the sum is 2 (1 + 2.5) c, and the square of every sphere is
    /// left with its own sum of edges, over its mass.
    pub fn rate(&mut self, dem: &Dem, dt: f64) -> f64 {
        let [mut moved, mut turned] = std::mem::take(&mut self.sums);
        let bodies = Bodies::of(dem);
        let p = dem.storage();
        let smallest = p.radius.iter().copied().fold(f64::INFINITY, f64::min);
        let rotation = dem.options().rotation;
        let slip_share = if rotation { 1.0 + RIM } else { 1.0 };
        for (sums, n) in [(&mut moved, p.len()), (&mut turned, if rotation { p.len() } else { 0 })]
        {
            sums.clear();
            sums.resize(n, StiffnessSum::default());
        }
        for (e, &pair) in self.pairs.iter().enumerate() {
            let film = self.thinned(e, pair, &bodies, APPROACH * smallest);
            let drag = slip_share * (film.viscous_shear + film.shear_lubrication);
            let normal = match self.effects.normal_lubrication {
                true => damping(&film, self.factor_of(self.is_at_wall(e)), self.viscosity, dt),
                false => 0.0,
            };
            for (end, arm) in pair.map(|v| v as usize).into_iter().zip(film.arms) {
                if end >= p.len() {
                    continue;
                }
                moved[end].add(Stiffness { normal, shear: drag }, &film.normal);
                if let Some(sum) = turned.get_mut(end) {
                    let radius = p.radius[end];
                    let rim = (arm / radius).powi(2) * drag;
                    let couple = |c: f64| RIM / radius.powi(2) * c;
                    let both =
                        Stiffness { normal: couple(film.twist), shear: rim + couple(film.pump) };
                    sum.add(both, &film.normal);
                }
            }
        }
        let sums = moved.iter().zip(&p.mass).chain(turned.iter().zip(&p.mass));
        let fastest = sums.fold(0.0, |fastest, (sum, &mass)| sum.fastest(mass, fastest));
        self.sums = [moved, turned];
        2.0 * fastest
    }

    /// An edge as it is now, its surfaces nearer by so much (m).
    fn thinned(&self, e: usize, pair: [u32; 2], bodies: &Bodies, nearer: f64) -> Film {
        let roughness = self.effects.roughness;
        let mut film = self.films[e];
        film.measure(bodies, pair, roughness);
        film.thickness = (film.gap - nearer).max(0.0) + 2.0 * roughness * film.radius;
        self.resist(self.is_at_wall(e)).write_drags(std::slice::from_mut(&mut film));
        film
    }
}
