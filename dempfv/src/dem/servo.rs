//! Walls that a servo moves until they carry a stress.

use nalgebra::{SMatrix, SVector};

use crate::{Effect, EffectKey, Family};
use crate::{PerWall, WallId};

/// What this effect says of itself.
pub const EFFECT: Effect = Effect {
    name: "servo walls",
    family: Family::Boundaries,
    equation: "Δx = (F − σ A) / Σ (k_n + c_n/Δt), all servo walls jointly with the resistance of the fluid; |v| ≤ 10 σ/√(ρ E)",
    source: "docs/hard-cases.md, rows 15 and 22",
    keys: &[
        EffectKey { key: "stress of a wall in a run stage", unit: "Pa", default: "at rest" },
        EffectKey { key: "max_velocity in [walls]", unit: "m/s", default: "10 σ/√(ρ E)" },
    ],
    needs: "",
    test: "dempfv/tests/hard_servo.rs",
};

/// Share of the wanted shift that a servo wall leaves out, and share of its
/// previous shift that it adds: the values of YADE's triaxial controller.
const SERVO_DAMPING: f64 = 0.25;
const SERVO_MEMORY: f64 = 0.8;

/// Share of an excess force that counts as the drift of a fluid's force in each step to come: with a
/// quarter it is learned as fast as without an overshoot. Spheres that follow the wall take their
/// drag off it step by step, so that a servo without it is always late.
const DRIFT_GAIN: f64 = 0.25;
/// Of an excess force this share of the one wanted counts at most; one above the other share is a
/// knock, as of a load that is put on or of a new network, and no drift.
const DRIFT_RANGE: f64 = 0.01;
const KNOCK: f64 = 0.1;

/// What acts on a servo wall in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ServoLoad {
    /// Force of spheres and fluid along the outward normal, less the one asked for (N).
    pub excess: f64,
    /// What the contacts on the wall put up against its shift in the step (N/m): their normal springs,
    /// and the dashpots over the length of the step.
    pub stiffness: f64,
    /// Largest shift, inwards and outwards (m).
    pub limit: [f64; 2],
    /// Shift in the previous step (m), outwards.
    pub previous: f64,
    /// Whether spheres touch the wall now, and did in the previous step.
    pub in_touch: bool,
    /// By what the force is expected to change in the step, the shift aside (N).
    pub drift: f64,
}

/// What the fluid takes off the outward force on a wall (first index) per outward velocity of
/// another (N·s/m); zero between dry walls.
pub type WallResistance = PerWall<PerWall<f64>>;

/// Outward shifts (m) of the walls with a load, in a step of length `dt` (s).
pub(super) fn shifts(
    loads: &PerWall<Option<ServoLoad>>,
    resistance: &WallResistance,
    dt: f64,
) -> PerWall<f64> {
    let wet = |wall: WallId| loads[wall].is_some() && resistance[wall][wall] > 0.0;
    let joint = WallId::ALL.into_iter().filter(|&wall| wet(wall)).count() > 1;
    let mut shifts =
        PerWall::from_fn(|w| loads[w].map_or(0.0, |load| alone(load, resistance[w][w], dt)));
    if joint {
        together(loads, resistance, dt, wet, &mut shifts);
    }
    shifts
}

impl ServoLoad {
    /// The force that the shift should take off a wall on a fluid of this resistance over the time
    /// step (N/m).
    fn expected(&self, per_shift: f64) -> f64 {
        self.excess + wet_share(per_shift, self.stiffness + per_shift) * self.drift
    }

    /// The drift after a step with this shift, where `wanted` is the force wanted (N).
    pub fn next_drift(&self, shift: f64, wanted: f64, wet: bool) -> f64 {
        let [inwards, outwards] = self.limit;
        let free = -inwards < shift && shift < outwards;
        if !(wet && free) {
            return 0.0;
        }
        let share = |share: f64| share * wanted.abs();
        if self.excess.abs() > share(KNOCK) {
            return self.drift;
        }
        self.drift + DRIFT_GAIN * self.excess.clamp(-share(DRIFT_RANGE), share(DRIFT_RANGE))
    }

    fn limited(&self, shift: f64) -> f64 {
        let [inwards, outwards] = self.limit;
        shift.clamp(-inwards, outwards)
    }

    /// Share of the previous shift that is added again. It is what the contacts asked for, so
    /// none is where they begin or end: the wall would strike what it has just let go.
    fn memory(&self) -> f64 {
        if self.in_touch { SERVO_MEMORY } else { 0.0 }
    }
}

/// Share of the fluid, with so much force per shift, in the whole stiffness (N/m).
pub(super) fn wet_share(per_shift: f64, whole: f64) -> f64 {
    match per_shift {
        // A step so short that the fluid is all that there is.
        f64::INFINITY => 1.0,
        per_shift if per_shift > 0.0 => per_shift / whole,
        _ => 0.0,
    }
}

/// The shift of a wall that no other moves with.
fn alone(load: ServoLoad, resistance: f64, dt: f64) -> f64 {
    let (excess, previous) = (load.expected(resistance / dt), load.previous);
    let stiffness = load.stiffness + resistance / dt;
    // A wall that touches nothing approaches as fast as it may.
    let wanted = load.limited(if stiffness > 0.0 {
        excess / stiffness
    } else if excess == 0.0 {
        0.0
    } else {
        f64::INFINITY.copysign(excess)
    });
    // A fluid holds the force up while the wall moves on, so of its
    // share the previous shift is kept and nothing is damped.
    let wet = wet_share(resistance / dt, stiffness);
    let damping = (1.0 - wet) * SERVO_DAMPING;
    let memory = load.memory() + wet * (1.0 - load.memory());
    let shift = (1.0 - damping) * wanted + memory * previous;
    if wet > 0.0 { load.limited(shift) } else { shift }
}

type Matrix = SMatrix<f64, 6, 6>;
type Vector = SVector<f64, 6>;

/// The shifts of walls that squeeze one fluid.
///
/// With contact stiffnesses k, resistances R, excess forces e and previous shifts s₀ the shifts
/// s leave e − k s − R/Δt (s − s₀). Wall by wall each would correct what all of them cause, and
/// three or more of them would overshoot without end. Together they solve for u in
/// (k + R/Δt) u = e; of the contacts' part of it, D = (k + R/Δt)⁻¹ k, the same is damped and
/// remembered as of a dry wall: s = u − 0.25 D u + s₀ − D (1 − m) s₀ with its memory m, 0.8 or
/// 0. A wall that would be too fast goes at its limit, and the others reckon with that.
fn together(
    loads: &PerWall<Option<ServoLoad>>,
    resistance: &WallResistance,
    dt: f64,
    wet: impl Fn(WallId) -> bool,
    shifts: &mut PerWall<f64>,
) {
    let mut free = PerWall::from_fn(wet);
    let all = free;
    let load = |wall: WallId| loads[wall].unwrap_or_default();
    for _ in 0..6 {
        let mut matrix = Matrix::identity();
        let (mut excess, mut previous) = (Vector::zeros(), Vector::zeros());
        let (mut contacts, mut forgotten) = (Vector::zeros(), Vector::zeros());
        for wall in WallId::ALL.into_iter().filter(|&wall| free[wall]) {
            let i = wall.index();
            let own = load(wall);
            let per_shift = resistance[wall][wall] / dt;
            (previous[i], contacts[i]) = (own.previous, own.stiffness);
            excess[i] = own.expected(per_shift);
            forgotten[i] = (1.0 - own.memory()) * own.previous;
            for other in WallId::ALL.into_iter().filter(|&other| all[other]) {
                let per_shift = resistance[wall][other] / dt;
                if free[other] {
                    matrix[(i, other.index())] = per_shift;
                } else {
                    excess[i] -= per_shift * (shifts[other] - load(other).previous);
                }
            }
            matrix[(i, i)] += own.stiffness;
        }
        let solver = matrix.lu();
        let dry = |x: &Vector| solver.solve(&contacts.component_mul(x));
        let Some(u) = solver.solve(&excess) else { return };
        let (Some(damped), Some(forgotten)) = (dry(&u), dry(&forgotten)) else { return };
        let found = u - SERVO_DAMPING * damped + previous - forgotten;
        if !found.iter().all(|s| s.is_finite()) {
            return;
        }
        let mut still_free = free;
        for wall in WallId::ALL.into_iter().filter(|&wall| free[wall]) {
            let shift = found[wall.index()];
            shifts[wall] = load(wall).limited(shift);
            still_free[wall] = shifts[wall] == shift;
        }
        if still_free == free {
            return;
        }
        free = still_free;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [WallId; 6] = WallId::ALL;

    /// Six walls around a fluid that yields to a change of volume hardly and to a change of
    /// shape easily, each with a share of one matrix.
    fn fluid(bulk: f64, shear: f64) -> WallResistance {
        PerWall::from_fn(|a| PerWall::from_fn(|b| bulk + if a == b { shear } else { 0.0 }))
    }

    /// Walls that correct together are there at once, from any pressures; alone each would
    /// overshoot six times over.
    #[test]
    fn walls_around_one_fluid_reach_their_loads() {
        let (dt, resistance) = (1e-5, fluid(1e6, 1e3));
        let goal = PerWall::from_fn(|w| 10.0 + w.index() as f64);
        let mut shift = PerWall::from_fn(|_| 0.0);
        let mut excess = PerWall::from_fn(|w| -goal[w]);
        for _ in 0..3 {
            let loads = PerWall::from_fn(|w| {
                let (excess, previous) = (excess[w], shift[w]);
                Some(ServoLoad { excess, limit: [1.0; 2], previous, ..ServoLoad::default() })
            });
            shift = shifts(&loads, &resistance, dt);
            excess = PerWall::from_fn(|w| {
                let force: f64 = ALL.map(|b| -resistance[w][b] * shift[b] / dt).iter().sum();
                force - goal[w]
            });
        }
        for w in ALL {
            assert!(excess[w].abs() < 1e-6 * goal[w], "{w}: {}", excess[w]);
        }
    }

    /// One wall at its limit: the others carry their loads all the same.
    #[test]
    fn a_slow_wall_does_not_upset_the_others() {
        let (dt, resistance) = (1e-5, fluid(1e5, 1e5));
        let loads = PerWall::from_fn(|w| {
            let limit = if w == WallId::XMin { 1e-12 } else { 1.0 };
            Some(ServoLoad { excess: -5.0, limit: [limit; 2], ..ServoLoad::default() })
        });
        let shift = shifts(&loads, &resistance, dt);
        assert_eq!(shift[WallId::XMin], -1e-12);
        for w in ALL.into_iter().filter(|&w| w != WallId::XMin) {
            let force: f64 = ALL.map(|b| -resistance[w][b] * shift[b] / dt).iter().sum();
            assert!((force - 5.0).abs() < 1e-9, "{w}: {force}");
        }
    }

    /// A single wall has the bits of the law for one, wet or dry.
    #[test]
    fn a_single_wall_is_alone() {
        let mut loads = PerWall::from_fn(|_| None);
        let load = ServoLoad {
            excess: 3.0,
            stiffness: 1e5,
            limit: [1e-3; 2],
            previous: 2e-6,
            in_touch: true,
            drift: 0.1,
        };
        loads[WallId::YMax] = Some(load);
        for resistance in [PerWall::default(), fluid(1e2, 1e3)] {
            let shift = shifts(&loads, &resistance, 1e-5)[WallId::YMax];
            assert_eq!(shift, alone(load, resistance[WallId::YMax][WallId::YMax], 1e-5));
        }
    }
}
