//! A compressible fluid: what the pores store, in a box that is closed or drained.

mod common;

use common::{Spheres, cubic, settled};
use dempfv::pfv::terms::{Compressibility, StepTerms};
use dempfv::pfv::{Assembled, Boundary, Clamp, Flow, Fluid};
use dempfv::solver::{SolverKind, condition_number};
use dempfv::{Vec3, WallId};

/// Length of a step (s).
const DT: f64 = 1e-5;

fn fluid(pressure: Option<f64>) -> Fluid {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMax] = pressure;
    Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary }
}

fn compressible(s: &Spheres, fluid: &Fluid, modulus: f64, dt: f64, solver: SolverKind) -> Flow {
    let terms = vec![Box::new(Compressibility::new(modulus).unwrap()) as _];
    let step = StepTerms { terms, time_step: dt };
    let assembled = Assembled::with_terms(&s.x, &s.r, s.bounds, fluid, &[], step).unwrap();
    assembled.analyze(solver, None).unwrap().factor().unwrap()
}

/// The void volumes of a flow's pores.
fn void(s: &Spheres, flow: &Flow) -> Vec<f64> {
    flow.network().void_volumes(&s.x, &s.r).unwrap()
}

/// The upper wall comes in at 1 cm/s, the spheres with it in proportion to their height.
fn squeeze(s: &Spheres) -> (Vec<Vec3>, [f64; 6]) {
    let (low, height) = (s.bounds.min.y, s.bounds.size().y);
    let speed = -1e-2;
    let v = s.x.iter().map(|x| Vec3::new(0.0, speed * (x.y - low) / height, 0.0)).collect();
    (v, [0.0, 0.0, 0.0, speed, 0.0, 0.0])
}

/// The pores hold what the spheres leave of the box: the sum of the void volumes is the box less its
/// spheres, to round-off, in a lattice of spheres that do not touch and in the settled packing. No
/// pore of these has less than nothing, which would count as none.
#[test]
fn void_volumes_add_up() {
    let mut lattice = cubic(5, 0.05);
    lattice.r.iter_mut().for_each(|r| *r *= 0.85);
    for s in [lattice, settled()] {
        let flow = Flow::new(&s.x, &s.r, s.bounds, &fluid(Some(0.0)), SolverKind::Cholmod).unwrap();
        let spheres: f64 = s.r.iter().map(|r| 4.0 / 3.0 * std::f64::consts::PI * r.powi(3)).sum();
        let sum: f64 = void(&s, &flow).iter().sum();
        let off = sum / (s.bounds.volume() - spheres) - 1.0;
        assert!(off.abs() < 1e-12, "{off}");
    }
}

/// A closed box that is squeezed, from 1 Pa (a foam) past water to what is incompressible: what the
/// pores lose in volume is what the fluid is compressed by, Σ V_void p / K_f = −Σ V̇ Δt, to 1e-11, by
/// both solvers. The mean pressure is K_f times the strain of the fluid.
#[test]
fn a_closed_box_is_compressed() {
    let s = settled();
    let (v, walls) = squeeze(&s);
    for solver in [SolverKind::Cholmod, SolverKind::Frontal] {
        for modulus in [1.0, 1e3, 1e6, 2.2e9, 1e15, 1e30] {
            let mut flow = compressible(&s, &fluid(None), modulus, DT, solver);
            flow.solve(&v, &walls).unwrap();
            let lost: f64 = -flow.volume_rate().iter().sum::<f64>() * DT;
            let held: f64 =
                void(&s, &flow).iter().zip(flow.pressure()).map(|(v, p)| v * p / modulus).sum();
            let case = format!("{solver:?} {modulus:e}");
            assert!((held / lost - 1.0).abs() < 1e-11, "{case}: {}", held / lost - 1.0);
            assert!(flow.imbalance() < 1e-11, "{case}: {}", flow.imbalance());
            assert_eq!(flow.unmet_tolerance(), None, "{case}");
            let strain =
                1e-2 * DT * s.bounds.wall_area(WallId::YMax) / void(&s, &flow).iter().sum::<f64>();
            let mean = held * modulus / void(&s, &flow).iter().sum::<f64>();
            assert!((mean / (modulus * strain) - 1.0).abs() < 1e-9, "{case}");
        }
    }
}

/// The stiffer the fluid, the nearer its pressures in a drained box are to those of an incompressible
/// one: the difference falls as 1/K_f until the tolerance of a solve, and goes on without a jump to
/// 1e30 Pa.
#[test]
fn a_stiff_fluid_has_a_smooth_limit() {
    let s = settled();
    let (v, walls) = squeeze(&s);
    let mut rigid =
        Flow::new(&s.x, &s.r, s.bounds, &fluid(Some(0.0)), SolverKind::Cholmod).unwrap();
    rigid.solve(&v, &walls).unwrap();
    let largest = rigid.pressure().iter().fold(0.0f64, |m, p| m.max(p.abs()));
    let off = |modulus: f64| {
        let mut flow = compressible(&s, &fluid(Some(0.0)), modulus, DT, SolverKind::Cholmod);
        flow.solve(&v, &walls).unwrap();
        let pairs = flow.pressure().iter().zip(rigid.pressure());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
    };
    let mut last = f64::INFINITY;
    for exponent in (6..=30).step_by(2) {
        let now = off(10f64.powi(exponent));
        assert!(now < 0.1 * last || now < 1e-11, "1e{exponent} Pa: {now:e} after {last:e}");
        last = now;
    }
}

/// Pressures that were put in stay in: at rest, a closed box goes to its mean, and a drained one
/// empties to what is imposed with a rate that depends on the step no more than implicit Euler
/// does.
#[test]
fn what_is_stored_is_not_lost() {
    let s = settled();
    let (v, walls) = squeeze(&s);
    let rest = vec![Vec3::zeros(); s.x.len()];
    let mut flow = compressible(&s, &fluid(None), 1e5, DT, SolverKind::Cholmod);
    flow.solve(&v, &walls).unwrap();
    let volumes = void(&s, &flow);
    let content =
        |flow: &Flow| volumes.iter().zip(flow.pressure()).map(|(v, p)| v * p).sum::<f64>();
    let before = content(&flow);
    for _ in 0..20 {
        flow.solve(&rest, &[0.0; 6]).unwrap();
    }
    assert!((content(&flow) / before - 1.0).abs() < 1e-12);
    let mean = before / volumes.iter().sum::<f64>();
    // A long step: there is no gradient left.
    flow.set_time_step(1e3).unwrap();
    flow.solve(&rest, &[0.0; 6]).unwrap();
    assert!(flow.pressure().iter().all(|p| (p / mean - 1.0).abs() < 1e-9));
    assert!((content(&flow) / before - 1.0).abs() < 1e-12);

    // A network of other positions stores as much.
    let moved: Vec<Vec3> =
        s.x.iter().map(|x| x.map(|c| c * (1.0 + 1e-4 * (1e4 * c).sin()))).collect();
    let flow = flow.renew(&moved, &s.r, s.bounds, &fluid(None)).unwrap();
    let volumes = flow.network().void_volumes(&moved, &s.r).unwrap();
    let after: f64 = volumes.iter().zip(flow.pressure()).map(|(v, p)| v * p).sum();
    assert!((after / before - 1.0).abs() < 1e-12, "{}", after / before - 1.0);
}

/// A drained box that shrinks across a network keeps its pressures above the one that is imposed,
/// however large that is: what the box stored at it has left with the volume.
#[test]
fn a_network_adds_nothing_to_a_large_imposed_pressure() {
    let s = settled();
    let (v, walls) = squeeze(&s);
    let (mut bounds, lost) = (s.bounds, 1e-3 * s.bounds.size().y);
    bounds.max.y -= lost;
    let moved: Vec<Vec3> =
        s.x.iter()
            .map(|x| x - lost * (x.y - s.bounds.min.y) / s.bounds.size().y * Vec3::y())
            .collect();
    let above = |imposed: f64| {
        let mut flow = compressible(&s, &fluid(Some(imposed)), 1e7, DT, SolverKind::Cholmod);
        flow.solve(&v, &walls).unwrap();
        let flow = flow.renew(&moved, &s.r, bounds, &fluid(Some(imposed))).unwrap();
        flow.pressure().iter().map(|p| p - imposed).collect::<Vec<_>>()
    };
    let (low, high) = (above(0.0), above(1e6));
    let largest = low.iter().fold(0.0, |largest: f64, p| largest.max(p.abs()));
    for (low, high) in low.iter().zip(&high) {
        assert!((high - low).abs() < 1e-6 * largest, "{high} after {low} of {largest}");
    }
}

/// A factor for another time step is another factor: the pressures are those of a flow that was built
/// for it, bit for bit.
#[test]
fn another_time_step_is_another_factor() {
    let s = settled();
    let (v, walls) = squeeze(&s);
    let mut changed = compressible(&s, &fluid(Some(0.0)), 1e6, DT, SolverKind::Cholmod);
    assert!(!changed.set_time_step(DT * (1.0 + 1e-14)).unwrap());
    assert!(changed.set_time_step(2.0 * DT).unwrap());
    let mut built = compressible(&s, &fluid(Some(0.0)), 1e6, 2.0 * DT, SolverKind::Cholmod);
    for flow in [&mut changed, &mut built] {
        flow.solve(&v, &walls).unwrap();
    }
    assert_eq!(changed.pressure(), built.pressure());
    assert_eq!(changed.flux(), built.flux());
}

/// The stiffer the fluid, the nearer the matrix of a closed box is to a singular one: the rows add up to
/// S/Δt alone, so that its condition number goes with K_f where conductances rule the diagonals, by
/// nearly 1e3 from 1e7 to 1e10 Pa (776 is found); a foam has that of its void volumes. The balances above hold all
/// the same, by what does not go through the factor.
#[test]
fn the_condition_goes_with_the_modulus() {
    let s = settled();
    let conditions = [1.0, 1e4, 1e7, 1e10].map(|modulus| {
        let flow = compressible(&s, &fluid(None), modulus, DT, SolverKind::Cholmod);
        let a = &flow.operators().matrix;
        let symbolic = SolverKind::Cholmod.backend().analyze(a, None).unwrap();
        condition_number(&mut *symbolic.factor(a).unwrap(), a).unwrap()
    });
    assert!(conditions.windows(2).all(|pair| pair[0] < pair[1]), "{conditions:?}");
    let growth = conditions[3] / conditions[2];
    assert!((500.0..1010.0).contains(&growth), "{conditions:?}");
    assert!(conditions[0] < 1e4 && conditions[3] > 1e9, "{conditions:?}");
}
