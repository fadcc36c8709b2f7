//! Pressures of which only the difference matters: a fluid under 1e5 Pa (the weight of the air) or
//! 1e7 Pa (a kilometre of water) flows as without.

mod common;
mod coupling_support;

use common::settled;
use coupling_support::start;
use dempfv::pfv::{Boundary, Clamp, Flow, Fluid};
use dempfv::solver::SolverKind;
use dempfv::{Vec3, WallId};

/// 100 Pa more at y_min than at y_max, which has `above`.
fn flow(above: f64, slip_walls: bool) -> Flow {
    let s = settled();
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMin] = Some(above + 100.0);
    boundary.pressure[WallId::YMax] = Some(above);
    let fluid = Fluid { viscosity: 1e-3, slip_walls, clamp: Clamp::None, boundary };
    let mut flow = Flow::new(&s.x, &s.r, s.bounds, &fluid, SolverKind::default()).unwrap();
    let velocity: Vec<Vec3> =
        s.x.iter().map(|x| 1e-3 * Vec3::new(x.z, -x.y, x.x) / s.bounds.size().y).collect();
    flow.solve(&velocity, &[0.0; 6]).unwrap();
    flow
}

/// Moving spheres between two pressures: with both of them higher, or lower, pressures differ from
/// each other as before, to 1e-12 of the drop (1e-10 Pa) and the spacing of doubles at the
/// pressure itself; fluxes and the forces on spheres are the same to 1e-11, and walls are pushed
/// by the additional pressure on their whole area. The default tolerance, 1e-11, is met.
#[test]
fn only_differences_of_pressure_matter() {
    for slip_walls in [true, false] {
        let without = flow(0.0, slip_walls);
        assert_eq!(without.unmet_tolerance(), None);
        let largest = without.force().iter().map(Vec3::norm).fold(0.0, f64::max);
        for above in [1e5, 1e7, -1e5] {
            let with = flow(above, slip_walls);
            assert_eq!(with.unmet_tolerance(), None, "{above}");
            let spacing = f64::EPSILON * above.abs();
            for (p, q) in with.pressure().iter().zip(without.pressure()) {
                assert!(((p - above) - q).abs() <= 1e-10 + spacing, "{above}: {p} {q}");
            }
            for (a, b) in with.flux().iter().zip(without.flux()) {
                assert!((a - b).abs() <= 1e-11 * b.abs(), "{above}: {a:e} {b:e}");
            }
            for (a, b) in with.force().iter().zip(without.force()) {
                assert!((a - b).norm() <= 1e-11 * largest, "{above}: {a:?} {b:?}");
            }
            let bounds = settled().bounds;
            for wall in WallId::ALL {
                let [a, b] = [&with, &without].map(|flow| flow.wall_force()[wall.index()]);
                let pushed = -wall.inward_normal() * (above * bounds.wall_area(wall));
                let off = (a - b - pushed).norm();
                assert!(off <= 1e-15 * pushed.norm() + 1e-11 * largest, "{above} {wall}: {off:e}");
            }
        }
    }
}

/// What lets the pressure that all pores share be left out: by the operators, it pushes no sphere
/// (of what a pore's pressure does to one, 1e-13 is round-off), and a wall by its area.
#[test]
fn a_uniform_pressure_pushes_walls_alone() {
    for slip_walls in [true, false] {
        let flow = flow(0.0, slip_walls);
        let s = settled();
        let uniform = vec![1.0; flow.network().pores()];
        let (mut spheres, mut walls) = (vec![Vec3::zeros(); s.x.len()], [Vec3::zeros(); 6]);
        flow.operators().forces(&uniform, &mut spheres, &mut walls).unwrap();
        let area = std::f64::consts::PI * s.r[0] * s.r[0];
        assert!(spheres.iter().all(|f| f.norm() < 1e-13 * area));
        for wall in WallId::ALL {
            let expected = -wall.inward_normal() * s.bounds.wall_area(wall);
            let off = (walls[wall.index()] - expected).norm();
            assert!(off < 1e-12 * expected.norm(), "{wall}: {off:e}");
        }
    }
}

/// A run under 1e5 Pa is the run without, and has no warning: before, pressures had no digits left
/// for the default tolerance.
#[test]
fn a_run_under_pressure_is_the_same_run() {
    let run = |above: f64| {
        let text = format!(
            r#"
            [particles]
            packing = "{}/../packings/oedometer-1000.txt"
            young = 1.0e6
            [dem]
            damping = 0.2
            [fluid]
            viscosity = 1.0e-3
            remesh_interval = 15
            pressure = {{ y_min = {:?}, y_max = {above:?} }}
            [[stage]]
            kind = "run"
            steps = 40
            walls = {{ x_min = {{ velocity = 1.0e-3 }} }}
            "#,
            env!("CARGO_MANIFEST_DIR"),
            above + 100.0
        );
        let mut simulation = start(&text);
        while simulation.advance().unwrap() {}
        assert_eq!(simulation.warnings(), [""; 0], "{above}");
        simulation.coupled().dem().storage().position.clone()
    };
    let without = run(0.0);
    for above in [1e5, 1e7] {
        assert_eq!(run(above), without, "{above}");
    }
}
