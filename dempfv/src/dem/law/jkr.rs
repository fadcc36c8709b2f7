//! Adhesion of soft contacts: Johnson, Kendall and Roberts.

use std::f64::consts::PI;

use super::batch::{Batch, ZERO_LANE, get};
use super::geometry::{Geometry, Radii};
use super::loss::Loss;
use super::terms::{GranularParameters, Memory, Terms};
use super::vector::dot;
use crate::effect::{Effect, EffectKey, Family};

/// JKR adhesion, as an effect.
pub const EFFECT: Effect = Effect {
    name: "JKR adhesion",
    family: Family::Contacts,
    equation: "F_n = 4E*a³/3R* − √(8π w E* a³), δ = a²/R* − √(2π w a/E*), w the work of adhesion per area; \
               begins at δ = 0, ends where dδ/da = 0; friction and rolling resistance go with F_n + 3π w R*",
    source: "K. L. Johnson, K. Kendall, A. D. Roberts: Proc. R. Soc. A 324 (1971); friction: C. Thornton, J. \
             Phys. D 24 (1991)",
    keys: &[
        EffectKey { key: "adhesion in [contacts]", unit: "", default: "\"none\"" },
        EffectKey { key: "work_of_adhesion in [contacts]", unit: "J/m²", default: "required" },
    ],
    needs: "Hertz-Mindlin contacts",
    test: "dempfv/tests/dem_adhesion.rs",
};

/// With a = a₀ s² and a₀³ = 9π w R*²/2E*: δ = a₀²/R* (s⁴ − 2s/3), which is least at s³ = 1/6, and
/// F_n = 6π w R* (s⁶ − s³).
const LEAST_ROOT: f64 = 0.550_321_208_149_104_4;
/// The overlap there over a₀²/R*.
const LEAST_OVERLAP: f64 = -0.5 * LEAST_ROOT;
/// Newton's steps to the last digit from the starts of [`root`].
const STEPS: usize = 7;

/// A contact of this shape.
#[derive(Clone, Copy)]
pub(super) struct Jkr {
    /// E* (Pa).
    modulus: f64,
    /// Work of adhesion (J/m²).
    work: f64,
    /// R* (m).
    radius: f64,
    /// a₀ (m).
    unit: f64,
}

impl Jkr {
    #[inline(always)]
    pub fn new(modulus: f64, work: f64, radii: impl Radii) -> Jkr {
        let radius = radii.reduced(1.0);
        let unit = (4.5 * PI * work * radius * radius / modulus).cbrt();
        Jkr { modulus, work, radius, unit }
    }

    /// The overlap at which the contact tears (m), which is negative.
    pub fn least_overlap(&self) -> f64 {
        LEAST_OVERLAP * self.unit * self.unit / self.radius
    }

    /// s of an overlap (m); where none is, not a number or of no meaning.
    #[inline(always)]
    fn root(&self, overlap: f64) -> f64 {
        root(overlap * self.radius / (self.unit * self.unit))
    }

    /// Contact radius (m).
    #[inline(always)]
    pub fn contact_radius(&self, overlap: f64) -> f64 {
        let s = self.root(overlap);
        self.unit * s * s
    }

    /// By what the bodies push and pull each other (N).
    #[inline(always)]
    pub fn forces(&self, overlap: f64) -> [f64; 2] {
        let s = self.root(overlap);
        let (cube, most) = (s * s * s, 4.0 * self.pull_off());
        [most * cube * cube, most * cube]
    }

    /// The largest tension (N): 3/2 π w R*.
    #[inline(always)]
    pub fn pull_off(&self) -> f64 {
        1.5 * PI * self.work * self.radius
    }

    /// Elastic energy less that of the joined surfaces (J): Hertz's for the contact radius, and
    /// what a flat punch gives back.
    pub fn energy(&self, overlap: f64) -> f64 {
        let Jkr { modulus, work, radius, .. } = *self;
        let a = self.contact_radius(overlap);
        let back = a * a / radius - overlap;
        let hertz = 8.0 / 15.0 * a.powi(5) / radius.powi(2);
        modulus * (hertz - 4.0 / 3.0 * a.powi(3) / radius * back + a * back * back)
            - PI * work * a * a
    }
}

/// The larger root of s⁴ − 2s/3 = x. Convex: from any start on its right Newton's way comes down
/// to it; near the turning point the parabola there is on the right, far from it the fourth root.
#[inline(always)]
fn root(x: f64) -> f64 {
    let near = LEAST_ROOT + ((x - LEAST_OVERLAP) / (6.0 * LEAST_ROOT * LEAST_ROOT)).sqrt();
    let far = x.max(0.0).sqrt().sqrt() + 1.0;
    let mut s = near.min(far);
    for _ in 0..STEPS {
        let (cube, slope) = (s * s * s, 4.0 * (s * s * s) - 2.0 / 3.0);
        let step = (s * (cube - 2.0 / 3.0) - x) / slope;
        s -= if slope > 0.0 { step } else { 0.0 };
    }
    s
}

/// Which contacts there are, and the normal forces of a batch; `slot` of the history has the
/// contact radius.
#[inline(always)]
pub(super) fn press<G: Geometry>(
    batch: &mut Batch<G, Memory>,
    terms: &mut Terms,
    parameters: impl Fn(usize) -> GranularParameters,
    work: f64,
    slot: usize,
) {
    for l in batch.lanes() {
        let contact = Jkr::new(parameters(l).modulus, work, batch.geometry.radii(l));
        let (overlap, before) = (batch.geometry.overlap(l), batch.history[slot][l]);
        let held = before > 0.0 && overlap >= contact.least_overlap();
        let exists = held || overlap >= 0.0;
        let radius = if exists { contact.contact_radius(overlap) } else { 0.0 };
        let [push, pull] = if exists { contact.forces(overlap) } else { [0.0; 2] };
        terms.stiffness[l] = 2.0 * contact.modulus * radius;
        terms.push[l] = push;
        terms.pull[l] = pull;
        terms.pull_off[l] = if exists { contact.pull_off() } else { 0.0 };
        terms.growth[l] = if before > 0.0 { radius / before } else { 1.0 };
        terms.before[0][l] = before;
        batch.history[slot][l] = radius;
    }
}

/// What is lost where a contact begins, which pulls at once, and where it tears: the energy that it
/// had, less the work of the mean of its forces before and after. Friction has the shear of one that tears.
#[inline(always)]
pub(super) fn lose<G: Geometry, const TORQUES: bool>(
    batch: &mut Batch<G, Memory>,
    terms: &Terms,
    parameters: impl Fn(usize) -> GranularParameters,
    work: f64,
    slot: usize,
) {
    let (mut lost, mut slipped) = (ZERO_LANE, ZERO_LANE);
    for l in batch.lanes() {
        let p = parameters(l);
        let contact = Jkr::new(p.modulus, work, batch.geometry.radii(l));
        let (radius, is) = (terms.before[0][l], batch.history[slot][l] > 0.0);
        let (from, to) = (batch.geometry.overlap_before(l, batch.dt), batch.geometry.overlap(l));
        let force = |overlap| contact.forces(overlap)[0] - contact.forces(overlap)[1];
        match (radius > 0.0, is) {
            (false, true) => lost[l] = -contact.energy(to) - 0.5 * force(to) * (from - to),
            (true, false) => {
                lost[l] = contact.energy(from) - 0.5 * force(from) * (from - to);
                let (shear, stiffness) = (get(&terms.turned, l), 2.0 * p.modulus * radius);
                let slip = batch.geometry.sliding::<TORQUES>(l, batch.dt).slip;
                let held = dot(shear, shear) / (p.shear_ratio * stiffness);
                slipped[l] = 0.5 * (held - dot(shear, slip));
            }
            _ => {}
        }
    }
    batch.book(Loss::Breakage, &lost);
    batch.book(Loss::Friction, &slipped);
}

/// What friction goes with: F_n + 2 F_c.
#[inline(always)]
pub(super) fn grip<G: Geometry>(batch: &Batch<G, Memory>, terms: &mut Terms) {
    for l in batch.lanes() {
        let normal = terms.push[l] - terms.pull[l];
        terms.grip[l] = (normal + 2.0 * terms.pull_off[l]).max(0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Newton's way ends at the root wherever it starts, but for the very turning point, where it
    /// halves its distance.
    #[test]
    fn roots_to_the_last_digit() {
        for k in 1..4000 {
            let s = LEAST_ROOT * 1.003f64.powi(k);
            let x = s.powi(4) - 2.0 / 3.0 * s;
            let found = root(x);
            let tolerance = if k < 10 { 1e-11 } else { 1e-14 };
            assert!((found / s - 1.0).abs() < tolerance, "{s} {found}");
        }
        assert!((LEAST_ROOT.powi(3) - 1.0 / 6.0).abs() < 1e-16);
        assert!((root(LEAST_OVERLAP) / LEAST_ROOT - 1.0).abs() < 1e-7);
    }
}
