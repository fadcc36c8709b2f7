//! Hard case 4: one large sphere among many small ones, of a tenth to a thousandth of its size.

mod common;
mod dem_support;

use common::Random;
use dem_support::{UNIT, frictionless_walls, material};
use dempfv::dem::{Dem, DemOptions, Particles};
use dempfv::pfv::{Boundary, Clamp, Flow, Fluid};
use dempfv::solver::SolverKind;
use dempfv::{Vec3, WallId};

const LARGE: f64 = 0.3;
const SMALL: usize = 600;

/// A large sphere in the middle of the unit box, a third of the small ones on its surface with an
/// overlap of a hundredth of their radius, some of which touch each other, and the others anywhere
/// outside of it.
fn planet(ratio: f64) -> (Vec<Vec3>, Vec<f64>) {
    let mut random = Random(7);
    let (centre, small) = (Vec3::repeat(0.5), LARGE / ratio);
    let mut positions = vec![centre];
    let mut radii = vec![LARGE];
    let mut number = || random.next();
    while positions.len() <= SMALL {
        let cube = Vec3::new(number() - 0.5, number() - 0.5, number() - 0.5);
        let on_surface = positions.len() <= SMALL / 3;
        let x = match on_surface {
            true => centre + cube.normalize() * (LARGE + 0.99 * small),
            false => centre + (1.0 - 2.0 * small) * cube,
        };
        let free = (x - centre).norm() >= LARGE + 0.99 * small;
        let apart = |y: &Vec3| (y - x).norm() > 1.9 * small;
        if free && positions[1..].iter().all(apart) {
            positions.push(x);
            radii.push(small);
        }
        // A row of pairs: the next one beside the last.
        if on_surface && positions.len() % 40 == 0 {
            let last = positions[positions.len() - 1] - centre;
            let beside = last.cross(&Vec3::new(0.3, 0.5, 0.8)).normalize() * 1.95 * small;
            let x = centre + (last + beside).normalize() * (LARGE + 0.99 * small);
            if positions[1..positions.len() - 1].iter().all(|y| (y - x).norm() > 1.9 * small) {
                positions.push(x);
                radii.push(small);
            }
        }
    }
    (positions, radii)
}

/// Every contact that a comparison of all with all finds, in the first step and after it; and with
/// the automatic time step the energy of the packing, damped, never grows by more than round-off.
#[test]
fn contacts_of_spheres_of_very_different_sizes_are_right() {
    for ratio in [10.0, 100.0, 1000.0] {
        let (positions, radii) = planet(ratio);
        let spheres = Particles::new(positions, radii.clone(), material().density);
        let options = DemOptions { damping: 0.3, ..DemOptions::default() };
        let mut dem = Dem::new(spheres, UNIT, material(), frictionless_walls(), options).unwrap();
        let mut most = f64::INFINITY;
        for step in 0..200 {
            if step % 50 == 0 {
                dem.compute_contacts().unwrap();
                let x = dem.positions();
                let pairs = |i: usize| {
                    (i + 1..x.len()).filter(|&j| (x[i] - x[j]).norm() < radii[i] + radii[j]).count()
                };
                let expected: usize = (0..x.len()).map(pairs).sum();
                assert_eq!(dem.sphere_contact_count(), expected, "ratio {ratio}, step {step}");
                assert!(step > 0 || expected > SMALL / 3, "{expected}");
                let energy = dem.kinetic_energy() + dem.elastic_energy();
                assert!(energy < most * (1.0 + 1e-12), "ratio {ratio}, step {step}: {energy}");
                most = energy;
            }
            let dt = dem.step_auto(0.8).unwrap();
            assert!(dt > 0.0 && dt.is_finite());
        }
    }
}

/// A flow from wall to wall around them: a factor, pressures between those of the walls, and as much
/// fluid out as in.
#[test]
fn flows_around_spheres_of_very_different_sizes_are_right() {
    for ratio in [10.0, 100.0, 1000.0] {
        let (positions, radii) = planet(ratio);
        let mut boundary = Boundary::default();
        boundary.pressure[WallId::YMin] = Some(1.0);
        boundary.pressure[WallId::YMax] = Some(0.0);
        let fluid = Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary };
        for solver in [SolverKind::Frontal, SolverKind::Cholmod] {
            let mut flow = Flow::new(&positions, &radii, UNIT, &fluid, solver).unwrap();
            flow.solve_static().unwrap();
            let case = format!("ratio {ratio}, {solver:?}");
            let inside = flow.pressure().iter().all(|p| (-1e-9..=1.0 + 1e-9).contains(p));
            assert!(inside, "{case}");
            let flux = flow.flux();
            let (into, out) = (flux[WallId::YMin.index()], flux[WallId::YMax.index()]);
            assert!(into > 0.0 && (into + out).abs() < 1e-9 * into, "{case}: {into} {out}");
        }
    }
}
