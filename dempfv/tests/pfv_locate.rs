//! Which pore a point lies in, against the pores' geometry.

mod common;

use common::{Random, Spheres, cubic, few, loose, settled};
use dempfv::Vec3;
use dempfv::pfv::{Boundary, Clamp, Fluid, NONE, Network};

fn network(s: &Spheres) -> Network {
    let fluid = Fluid {
        viscosity: 1e-3,
        slip_walls: true,
        clamp: Clamp::None,
        boundary: Boundary::default(),
    };
    Network::new(&s.x, &s.r, s.bounds, &fluid).unwrap().0
}

/// The middle of a pore: of its spheres' centres, half way to each of its walls.
fn middle(s: &Spheres, n: &Network, pore: usize) -> Vec3 {
    let cell = &n.tessellation.cells[pore];
    let centres: Vec<Vec3> = cell.iter().filter_map(|&v| s.x.get(v as usize)).copied().collect();
    let mut x = centres.iter().sum::<Vec3>() / centres.len() as f64;
    for wall in cell.iter().filter_map(|&v| n.tessellation.wall(v)) {
        x[wall.axis()] = 0.5 * (x[wall.axis()] + s.bounds.wall(wall));
    }
    x
}

#[test]
fn every_pore_contains_its_middle() {
    for s in [settled(), loose(), few(1), few(2)] {
        let n = network(&s);
        for pore in 0..n.pores() {
            assert_eq!(n.tessellation.locate(&s.x, &middle(&s, &n, pore)).unwrap(), pore as u32);
        }
    }
}

/// Random points fall into pores in proportion to the pores' volumes, which are computed
/// without any search: within four standard deviations for pores by their number of
/// walls and by halves of the list.
#[test]
fn points_fall_into_pores_by_volume() {
    const POINTS: usize = 4000;
    for s in [settled(), cubic(4, 0.1)] {
        let n = network(&s);
        let walls = |i: usize| {
            n.tessellation.cells[i].iter().filter(|&&v| n.tessellation.wall(v).is_some()).count()
        };
        let group = |i: usize| 2 * walls(i) + usize::from(2 * i < n.pores());
        let mut share = [0.0; 8];
        for i in 0..n.pores() {
            share[group(i)] += n.volume[i] / s.bounds.volume();
        }
        let mut random = Random(5);
        let mut hits = [0.0f64; 8];
        for _ in 0..POINTS {
            let at = random.vector().map(|c| 0.5 * (c + 1.0));
            let x = s.bounds.min + at.component_mul(&s.bounds.size());
            hits[group(n.tessellation.locate(&s.x, &x).unwrap() as usize)] += 1.0;
        }
        for (p, hit) in share.iter().zip(hits) {
            let deviation = (POINTS as f64 * p * (1.0 - p)).sqrt();
            assert!((hit - POINTS as f64 * p).abs() < 4.0 * deviation + 1.0, "{share:?} {hits:?}");
        }
    }
}

/// Corners of the box lie in the pores of three walls; sphere centres, which belong to
/// many pores, in one that has the sphere.
#[test]
fn corners_and_vertices_belong_to_their_pores() {
    let s = settled();
    let n = network(&s);
    for corner in 0..8 {
        let x = Vec3::from_fn(
            |k, _| {
                if corner >> k & 1 == 0 { s.bounds.min[k] } else { s.bounds.max[k] }
            },
        );
        let pore = n.tessellation.locate(&s.x, &x).unwrap() as usize;
        let walls = n.tessellation.cells[pore].iter().filter_map(|&v| n.tessellation.wall(v));
        assert!(
            walls.clone().count() == 3
                && walls.into_iter().all(|w| x[w.axis()] == s.bounds.wall(w))
        );
    }
    for (i, x) in s.x.iter().enumerate().step_by(37) {
        let pore = n.tessellation.locate(&s.x, x).unwrap();
        assert!(n.tessellation.cells[pore as usize].contains(&(i as u32)));
    }
    assert_eq!(n.tessellation.locate(&s.x, &Vec3::repeat(f64::NAN)).unwrap(), NONE);
}
