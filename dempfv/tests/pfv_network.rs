//! The pore network: volumes, conductances and operators against geometry.

mod common;

use common::{Random, Spheres, cubic, face_centred, few, loose, settled, unit_box};
use dempfv::pfv::{
    Boundary, Clamp, Flow, Fluid, NONE, Network, Operators, PfvError, SealedPoreRule,
};
use dempfv::solver::SolverKind;
use dempfv::{Aabb, PerWall, Vec3, WallId};

const DRAINED_TOP: Fluid = Fluid {
    viscosity: 1e-3,
    slip_walls: true,
    clamp: Clamp::None,
    boundary: Boundary {
        pressure: PerWall([None, None, None, Some(0.0), None, None]),
        sealed_pores: SealedPoreRule::Closed,
    },
};

fn network(s: &Spheres) -> Network {
    Network::new(&s.x, &s.r, s.bounds, &DRAINED_TOP).unwrap().0
}

fn operators(s: &Spheres, fluid: &Fluid) -> (Network, Operators) {
    let (network, derivatives) = Network::new(&s.x, &s.r, s.bounds, fluid).unwrap();
    let operators = Operators::new(&network, derivatives, fluid.boundary).unwrap();
    (network, operators)
}

fn wall_vertices(n: &Network, pore: usize) -> usize {
    n.tessellation.cells[pore].iter().filter(|&&v| n.tessellation.wall(v).is_some()).count()
}

/// Tetrahedra, prisms, wedges and corner boxes fill the box: their signed
/// volumes add up to it exactly, so to round-off (1e-12).
#[test]
fn pore_volumes_add_up_to_the_box() {
    for s in
        [settled(), loose(), cubic(4, 0.0), cubic(4, 1e-6), face_centred(3, 0.0), few(1), few(2)]
    {
        let n = network(&s);
        let sum: f64 = n.volume.iter().sum();
        assert!((sum / s.bounds.volume() - 1.0).abs() < 1e-12, "{} spheres: {sum}", s.x.len());
        assert!(n.volume.iter().all(|&v| v > 0.0));
    }
}

/// From 5,000 spheres on, threads triangulate slabs. The lattice has ties in
/// every pore, where cells could be chosen one way or the other.
#[test]
fn networks_do_not_depend_on_the_number_of_threads() {
    for s in [cubic(18, 0.0), cubic(18, 0.3)] {
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| operators(&s, &DRAINED_TOP))
        };
        let (one, ones) = with(1);
        for threads in [2, 3] {
            let (n, o) = with(threads);
            assert_eq!(n.tessellation, one.tessellation);
            assert_eq!((n.center, n.volume), (one.center.clone(), one.volume.clone()));
            assert_eq!(n.throats.pores, one.throats.pores);
            assert_eq!(n.throats.conductance, one.throats.conductance);
            assert_eq!(n.throat_of, one.throat_of);
            assert_eq!(o.matrix, ones.matrix);
        }
    }
}

/// The cells that YADE 2023.02a finds for the same packing: 5,685, eight of
/// them in the corners.
#[test]
fn the_settled_packing_has_the_known_pores() {
    let n = network(&settled());
    let count = |walls| (0..n.pores()).filter(|&i| wall_vertices(&n, i) == walls).count();
    assert_eq!([count(0), count(1), count(2), count(3)], [4651, 932, 94, 8]);
    assert_eq!(n.pores(), 5685);
}

/// Centres have equal power to all spheres of the pore and lie on its walls
/// (the definition), to round-off in units of the box.
#[test]
fn centres_have_equal_power() {
    let s = loose();
    let n = network(&s);
    for (i, cell) in n.tessellation.cells.iter().enumerate() {
        let c = n.center[i];
        let mut powers = vec![];
        for &v in cell {
            match n.tessellation.wall(v) {
                Some(w) => {
                    assert!((c[w.axis()] - s.bounds.wall(w)).abs() < 1e-12 * (1.0 + c.norm()))
                }
                None => powers.push((c - s.x[v as usize]).norm_squared() - s.r[v as usize].powi(2)),
            }
        }
        let scale = 1.0 + c.norm_squared();
        assert!(
            powers.iter().all(|p| (p - powers[0]).abs() < 1e-9 * scale),
            "pore {i}: {powers:?}"
        );
    }
}

/// `V̇ = E v` against central differences of the volumes of the same cells, for
/// pores with 0, 1, 2 and 3 walls; walls move too. Volumes are cubic in the
/// motion, so a central difference over h is off by h² relative: 1e-6 holds
/// with a wide margin at h = 1e-5 of the sphere spacing.
#[test]
fn volume_rates_are_derivatives_of_the_volumes() {
    for s in [settled(), loose()] {
        let (n, o) = operators(&s, &DRAINED_TOP);
        let mut random = Random(5);
        let speed = (s.bounds.volume() / s.x.len() as f64).cbrt();
        let v: Vec<Vec3> = s.x.iter().map(|_| speed * random.vector()).collect();
        let wall_v: [f64; 6] = std::array::from_fn(|_| speed * (2.0 * random.next() - 1.0));
        let mut rate = vec![0.0; n.pores()];
        o.volume_rate(&v, &wall_v, &mut rate).unwrap();
        let h = 1e-5;
        let moved = |t: f64| {
            let x: Vec<Vec3> = s.x.iter().zip(&v).map(|(x, v)| x + t * v).collect();
            let mut b = s.bounds;
            for w in WallId::ALL {
                let side = if w.is_max() { &mut b.max } else { &mut b.min };
                side[w.axis()] += t * wall_v[w.index()];
            }
            n.volumes_at(&x, &b).unwrap()
        };
        let (before, after) = (moved(-h), moved(h));
        let mut seen = [0; 4];
        for i in 0..n.pores() {
            let numeric = (after[i] - before[i]) / (2.0 * h);
            // Rates of single pores can cancel: measure against the pore's size.
            let scale = rate[i].abs().max(n.volume[i]);
            assert!(
                (numeric - rate[i]).abs() < 1e-6 * scale,
                "pore {i}: {numeric:e} against {:e}",
                rate[i]
            );
            seen[wall_vertices(&n, i)] += 1;
        }
        assert!(seen.iter().all(|&k| k > 0), "{seen:?}");
    }
}

/// The matrix, read entry by entry from both of a throat's pores, is exactly
/// symmetric, and its rows add up to what flows to imposed pressures.
#[test]
fn the_conductance_matrix_is_symmetric_and_balanced() {
    let (n, o) = operators(&settled(), &DRAINED_TOP);
    let find =
        |i: usize, j: usize| n.tessellation.neighbors[i].iter().position(|&k| k as usize == j);
    let mut entries = 0;
    for (u, &i) in o.pore_of.iter().enumerate() {
        let range = o.matrix.col_ptr[u] as usize..o.matrix.col_ptr[u + 1] as usize;
        let rows = &o.matrix.row_idx[range.clone()];
        assert_eq!(rows[0] as usize, u);
        assert!(rows.is_sorted());
        for (&row, &value) in rows[1..].iter().zip(&o.matrix.values[range][1..]) {
            let j = o.pore_of[row as usize] as usize;
            let (i, entry) = (i as usize, -value);
            assert_eq!(n.conductances_of(i)[find(i, j).unwrap()].to_bits(), entry.to_bits());
            assert_eq!(n.conductances_of(j)[find(j, i).unwrap()].to_bits(), entry.to_bits());
            entries += 1;
        }
    }
    let both_free = |p: &&[u32; 2]| p.iter().all(|&p| o.unknown_of[p as usize] != NONE);
    assert_eq!(entries, n.throats.pores.iter().filter(both_free).count());
}

/// A uniform pressure pushes no sphere (its throats' forces cancel in pairs),
/// and pushes each wall with p times its area; 1e-12 of p·r².
#[test]
fn a_uniform_pressure_pushes_only_walls() {
    for s in [settled(), loose(), cubic(3, 1e-6), few(2)] {
        for slip_walls in [true, false] {
            let fluid = Fluid { slip_walls, ..DRAINED_TOP };
            let (n, o) = operators(&s, &fluid);
            let p = 3.0;
            let (mut force, mut wall) = (vec![Vec3::zeros(); s.x.len()], [Vec3::zeros(); 6]);
            o.forces(&vec![p; n.pores()], &mut force, &mut wall).unwrap();
            for (i, f) in force.iter().enumerate() {
                assert!(f.norm() < 1e-12 * p * s.r[i].powi(2), "sphere {i}: {f:?}");
            }
            for w in WallId::ALL {
                let expected = -p * s.bounds.wall_area(w) * w.inward_normal();
                assert!((wall[w.index()] - expected).norm() < 1e-12 * expected.norm(), "{w}");
            }
        }
    }
}

/// A sphere inside the power cell of larger ones is no vertex: it is named,
/// and the pores are those of the packing without it.
#[test]
fn a_hidden_sphere_is_named() {
    let mut s = cubic(3, 1e-3);
    s.r.iter_mut().for_each(|r| *r *= 1.4);
    let without = network(&s);
    s.x.push(s.x[13] + Vec3::new(0.3, 0.1, 0.2));
    s.r.push(0.01);
    let n = network(&s);
    assert_eq!(n.tessellation.hidden, [27]);
    assert_eq!(n.pores(), without.pores());
}

/// Without any imposed pressure all pores are one sealed group: at rest they have the pressure
/// of the pinned one; a wall that moves inward squeezes what cannot be squeezed, and is refused.
#[test]
fn a_closed_box_is_solved_at_rest_and_refused_in_motion() {
    let s = few(1);
    let closed = Fluid { boundary: Boundary::default(), ..DRAINED_TOP };
    let mut flow = Flow::new(&s.x, &s.r, s.bounds, &closed, SolverKind::default()).unwrap();
    assert_eq!(flow.operators().sealed_pores().groups, [(0..8).collect::<Vec<u32>>()]);
    flow.solve_static().unwrap();
    assert!(flow.pressure().iter().all(|&p| p == 0.0));
    let mut walls = [0.0; 6];
    walls[WallId::YMax.index()] = -1.0;
    let error = flow.solve(&[Vec3::zeros()], &walls).unwrap_err();
    let area = s.bounds.wall_area(WallId::YMax);
    let PfvError::SealedPores { pore: 0, pores: 8, rate, .. } = error else { panic!("{error}") };
    assert!((rate + area).abs() < 1e-12 * area, "{rate}");
    // The sphere has the number that its owner gave it.
    assert!(error.to_string().split(['(', ',', ')', ' ']).any(|w| w == "0"), "{error}");
    let error = error.with_numbers(&[17]).to_string();
    assert!(error.contains("17") && error.contains("_min"), "{error}");
    // Opposite walls that move together only shift what is between them.
    walls[WallId::YMin.index()] = -1.0;
    flow.solve(&[Vec3::new(0.0, -1.0, 0.0)], &walls).unwrap();
    assert!(flow.pressure().iter().all(|p| p.abs() < 1e-9), "nothing is squeezed");
}

/// Input that cannot be right is refused, with the argument's name and the entry's number.
#[test]
fn impossible_packings_are_errors() {
    assert_eq!(
        Network::new(&[], &[], unit_box(1.0), &DRAINED_TOP).unwrap_err(),
        PfvError::NoSpheres
    );
    let (inside, outside) = (Vec3::repeat(0.5), Vec3::new(0.5, 1.5, 0.5));
    let inverted = Aabb { min: Vec3::repeat(1.0), max: Vec3::new(2.0, 0.0, 2.0) };
    let cube = unit_box(1.0);
    let viscosity = Fluid { viscosity: 0.0, ..DRAINED_TOP };
    let mut pressure = DRAINED_TOP;
    pressure.boundary.pressure[WallId::YMax] = Some(f64::INFINITY);
    type Case<'a> = (&'a [Vec3], &'a [f64], Aabb, Fluid, &'a str, Option<usize>);
    let cases: [Case; 9] = [
        (&[inside, Vec3::repeat(f64::NAN)], &[0.1; 2], cube, DRAINED_TOP, "position", Some(1)),
        (&[inside, outside], &[0.1; 2], cube, DRAINED_TOP, "position", Some(1)),
        (&[inside], &[0.1; 2], cube, DRAINED_TOP, "radius", None),
        (&[inside; 3], &[0.1, -0.1, 0.1], cube, DRAINED_TOP, "radius", Some(1)),
        (&[inside; 3], &[0.1, 0.1, f64::NAN], cube, DRAINED_TOP, "radius", Some(2)),
        (&[inside], &[0.1], inverted, DRAINED_TOP, "bounds", Some(1)),
        (&[inside], &[0.1], unit_box(f64::NAN), DRAINED_TOP, "bounds", Some(0)),
        (&[inside], &[0.1], cube, viscosity, "fluid.viscosity", None),
        (&[inside], &[0.1], cube, pressure, "fluid.boundary.pressure", Some(3)),
    ];
    for (x, r, bounds, fluid, name, entry) in cases {
        match Network::new(x, r, bounds, &fluid) {
            Err(PfvError::InvalidInput { argument, index, .. }) => {
                assert_eq!((argument, index), (name, entry));
            }
            other => panic!("{name}: {other:?}"),
        }
    }
    // The sphere has the number that its owner gave it.
    let error = Network::new(&[inside, outside], &[0.1; 2], cube, &DRAINED_TOP).unwrap_err();
    assert!(error.with_numbers(&[7, 17]).to_string().starts_with("position[17]: "));
}

/// The pores fill the box: their volumes times their centroids are the box's, to round-off,
/// whatever walls they reach to.
#[test]
fn centroids_are_the_middles_of_volumes() {
    for s in [settled(), loose(), few(1), few(2), cubic(4, 0.1)] {
        let n = network(&s);
        let centroids = n.centroids(&s.x, &s.bounds).unwrap();
        let moment: Vec3 = centroids.iter().zip(&n.volume).map(|(x, v)| *v * x).sum();
        let off = moment / s.bounds.volume() - s.bounds.center();
        assert!(off.norm() < 1e-12 * s.bounds.size().norm(), "{off:?}");
        // Each lies in its pore.
        for (pore, x) in centroids.iter().enumerate().step_by(97) {
            assert_eq!(n.tessellation.locate(&s.x, x).unwrap(), pore as u32);
        }
    }
}
