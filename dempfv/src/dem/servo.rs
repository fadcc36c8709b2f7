//! Walls that a servo moves until they carry a stress.

use nalgebra::{SMatrix, SVector};

use crate::{PerWall, WallId};

/// Share of the wanted shift that a servo wall leaves out, and share of its
/// previous shift that it adds: the values of YADE's triaxial controller.
const SERVO_DAMPING: f64 = 0.25;
const SERVO_MEMORY: f64 = 0.8;

/// What acts on a servo wall in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ServoLoad {
    /// Force of spheres and fluid along the outward normal, less the one asked for (N).
    pub excess: f64,
    /// Sum of the normal stiffnesses of the contacts on the wall (N/m).
    pub stiffness: f64,
    /// Largest shift (m).
    pub limit: f64,
    /// Shift in the previous step (m), outwards.
    pub previous: f64,
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

/// The shift of a wall that no other moves with.
fn alone(load: ServoLoad, resistance: f64, dt: f64) -> f64 {
    let ServoLoad { excess, stiffness, limit, previous } = load;
    let stiffness = stiffness + resistance / dt;
    // A wall that touches nothing approaches at the largest speed.
    let wanted = if stiffness > 0.0 {
        (excess / stiffness).clamp(-limit, limit)
    } else if excess == 0.0 {
        0.0
    } else {
        limit.copysign(excess)
    };
    // A fluid holds the force up while the wall moves on, so of its
    // share the previous shift is kept and nothing is damped.
    let wet = match resistance / dt {
        // A step so short that the fluid is all that there is.
        f64::INFINITY => 1.0,
        per_shift if per_shift > 0.0 => per_shift / stiffness,
        _ => 0.0,
    };
    let damping = (1.0 - wet) * SERVO_DAMPING;
    let memory = SERVO_MEMORY + wet * (1.0 - SERVO_MEMORY);
    let shift = (1.0 - damping) * wanted + memory * previous;
    if wet > 0.0 { shift.clamp(-limit, limit) } else { shift }
}

type Matrix = SMatrix<f64, 6, 6>;
type Vector = SVector<f64, 6>;

/// The shifts of walls that squeeze one fluid.
///
/// With contact stiffnesses k, resistances R, excess forces e and previous shifts s₀ the shifts
/// s leave e − k s − R/Δt (s − s₀). Wall by wall each would correct what all of them cause, and
/// three or more of them would overshoot without end. Together they solve for u in
/// (k + R/Δt) u = e; of the contacts' part of it, D = (k + R/Δt)⁻¹ k, the same is damped and
/// remembered as of a dry wall: s = u − 0.25 D u + s₀ − 0.2 D s₀. A wall that would be too
/// fast goes at its limit, and the others reckon with that.
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
        let mut contacts = Vector::zeros();
        for wall in WallId::ALL.into_iter().filter(|&wall| free[wall]) {
            let i = wall.index();
            let ServoLoad { excess: own, stiffness, previous: before, .. } = load(wall);
            (excess[i], previous[i], contacts[i]) = (own, before, stiffness);
            for other in WallId::ALL.into_iter().filter(|&other| all[other]) {
                let per_shift = resistance[wall][other] / dt;
                if free[other] {
                    matrix[(i, other.index())] = per_shift;
                } else {
                    excess[i] -= per_shift * (shifts[other] - load(other).previous);
                }
            }
            matrix[(i, i)] += stiffness;
        }
        let solver = matrix.lu();
        let dry = |x: &Vector| solver.solve(&contacts.component_mul(x));
        let Some(u) = solver.solve(&excess) else { return };
        let (Some(damped), Some(remembered)) = (dry(&u), dry(&previous)) else { return };
        let found = u - SERVO_DAMPING * damped + previous - (1.0 - SERVO_MEMORY) * remembered;
        if !found.iter().all(|s| s.is_finite()) {
            return;
        }
        let mut still_free = free;
        for wall in WallId::ALL.into_iter().filter(|&wall| free[wall]) {
            let (shift, limit) = (found[wall.index()], load(wall).limit);
            shifts[wall] = shift.clamp(-limit, limit);
            still_free[wall] = shift.abs() <= limit;
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
                Some(ServoLoad { excess, stiffness: 0.0, limit: 1.0, previous })
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
            Some(ServoLoad { excess: -5.0, stiffness: 0.0, limit, previous: 0.0 })
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
        let load = ServoLoad { excess: 3.0, stiffness: 1e5, limit: 1e-3, previous: 2e-6 };
        loads[WallId::YMax] = Some(load);
        for resistance in [PerWall::default(), fluid(1e2, 1e3)] {
            let shift = shifts(&loads, &resistance, 1e-5)[WallId::YMax];
            assert_eq!(shift, alone(load, resistance[WallId::YMax][WallId::YMax], 1e-5));
        }
    }
}
