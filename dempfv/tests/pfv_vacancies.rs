//! Lattices with vacancies: rows of spheres along walls make pores that are
//! flat between planes, and whose centre round-off alone would choose.

mod common;

use common::{Random, Spheres, cubic};
use dempfv::Vec3;
use dempfv::WallId;
use dempfv::pfv::{Boundary, Clamp, Flow, Fluid};
use dempfv::solver::SolverKind;

/// `keep` of the sites of an `n`³ lattice, a little apart.
fn sparse(n: usize, keep: usize, seed: u64) -> Spheres {
    let mut s = cubic(n, 0.0);
    let mut random = Random(seed);
    while s.x.len() > keep {
        let out = (random.next() * s.x.len() as f64) as usize;
        s.x.remove(out);
    }
    s.r = vec![0.45; keep];
    s
}

fn permeability(s: &Spheres) -> f64 {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMin] = Some(1.0);
    boundary.pressure[WallId::YMax] = Some(0.0);
    let fluid = Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary };
    let mut flow = Flow::new(&s.x, &s.r, s.bounds, &fluid, SolverKind::default()).unwrap();
    flow.solve_static().unwrap();
    assert!(flow.network().center.iter().all(|c| c.iter().all(|v| v.is_finite())));
    flow.permeability(WallId::YMin).unwrap().value
}

/// 60 lattices with vacancies give finite answers, and the same within 3 % when
/// jittered by 1e-6 of the spacing. 59 of them change by less than 0.9 %, as a
/// full lattice does; in one (2.5 %) the jitter lets the triangulation split a
/// vacancy another way, which is another network. (With unbounded centres some
/// of these lattices have none that is finite, and others change by 20 %.)
#[test]
fn round_off_does_not_choose_flat_pores() {
    for (n, keep) in [(3, 20), (4, 40), (5, 90)] {
        for seed in 0..20 {
            let s = sparse(n, keep, seed);
            let still = permeability(&s);
            let mut random = Random(seed + 1000);
            let x: Vec<Vec3> = s.x.iter().map(|x| x + 1e-6 * random.vector()).collect();
            let jittered = permeability(&Spheres { x, ..s });
            let change = (jittered / still - 1.0).abs();
            assert!(change < 0.03, "{keep} of {n}³ sites, seed {seed}: {still} and {jittered}");
        }
    }
}
