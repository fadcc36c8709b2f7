//! The flow through a periodic cell of any shape.

mod cell_support;

use cell_support::{FLUID, cell_flow, lattice, packed_cell, permeability};
use dempfv::dem::{CloudScale, SizeDistribution, random_cloud_in_cell};
use dempfv::pfv::{Flow, Network, PfvError};
use dempfv::solver::SolverKind;
use dempfv::{Cell, Tensor, Vec3};

/// Copies of a cell's spheres side by side, in the cell of all of them.
fn tiled(x: &[Vec3], r: &[f64], cell: &Cell, copies: [i32; 3]) -> (Vec<Vec3>, Vec<f64>, Cell) {
    let (mut centres, mut radii) = (vec![], vec![]);
    for (i, j, k) in (0..copies[0])
        .flat_map(|i| (0..copies[1]).flat_map(move |j| (0..copies[2]).map(move |k| (i, j, k))))
    {
        centres.extend(x.iter().map(|x| x + cell.shift([i, j, k])));
        radii.extend_from_slice(r);
    }
    let [a, b, c] = cell.edges();
    let [i, j, k] = copies.map(f64::from);
    (centres, radii, Cell::new([i * a, j * b, k * c]).unwrap())
}

fn close(a: &Tensor, b: &Tensor, relative: f64) {
    let off = (a - b).norm() / b.norm();
    assert!(off < relative, "{off:e}\n{a}{b}");
}

/// The pores fill the cell once, each pair of neighbours has one throat, volumes add up, and a
/// uniform pressure pushes nothing.
#[test]
fn pores_fill_the_cell() {
    let (x, r, cell) = packed_cell(1);
    let flow = cell_flow(&x, &r, &cell);
    let network = flow.network();
    let volume: f64 = network.volume.iter().sum();
    assert!((volume / cell.volume() - 1.0).abs() < 1e-12);
    assert!(network.volume.iter().all(|v| *v > 0.0));
    assert_eq!(network.throats.pores.len(), 2 * network.pores());
    let t = &network.tessellation;
    for (i, around) in (0u32..).zip(&t.neighbors) {
        assert!(around.iter().all(|&j| t.neighbors[j as usize].contains(&i)));
    }
    let again = network.volumes_in_cell(&x, &cell).unwrap();
    let mean = volume / network.pores() as f64;
    assert!(again.iter().zip(&network.volume).all(|(a, b)| (a - b).abs() < 1e-12 * mean));
}

/// Spheres that go with the cell make each pore larger by the determinant of the deformation, and keep
/// their copies: where a pore reaches through nearly half of the cell, where the cell exchanges its edges
/// for shorter ones on the way, and whichever copies of the spheres are given. A cell that has changed
/// by more than a quarter is refused.
#[test]
fn pores_keep_their_copies_while_the_cell_exchanges_edges() {
    let sizes = SizeDistribution::Uniform { spread: 0.0 };
    let unit = Cell::of_size(Vec3::repeat(1.0)).unwrap();
    // Of few spheres some pores reach through nearly half of the cell; where one does more, none is built.
    let built = (1..60).filter(|&seed| {
        let cloud = random_cloud_in_cell(&unit, 60, &sizes, CloudScale::Porosity(0.85), seed);
        let (x, r): (Vec<Vec3>, Vec<f64>) = cloud.unwrap().into_iter().unzip();
        volumes_go_with_the_cell(&x, &r, &unit)
    });
    assert!(built.count() > 5);
}

/// Whether there is a network of these spheres in the skewed cell; its volumes as the cell shears on.
fn volumes_go_with_the_cell(x: &[Vec3], r: &[f64], cell: &Cell) -> bool {
    let edges = Tensor::from_columns(&cell.edges());
    let skewed = Tensor::new(1.0, 0.42, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    let built = Cell::new(
        (skewed * edges).column_iter().map(Into::into).collect::<Vec<Vec3>>().try_into().unwrap(),
    )
    .unwrap();
    let x: Vec<Vec3> = x.iter().map(|x| skewed * x).collect();
    let r: Vec<f64> = r.iter().map(|r| 0.5 * r).collect();
    let Ok((network, _)) = Network::in_cell(&x, &r, &built, &FLUID) else { return false };
    for by in [0.05, 0.12, 0.2] {
        let deformation = Tensor::new(1.0, by, 0.0, 0.0, 0.95, 0.0, 0.0, 0.0, 1.02);
        let columns: Vec<Vec3> = built.edges().iter().map(|edge| deformation * edge).collect();
        let whole = Cell::new(columns.try_into().unwrap()).unwrap();
        let cell = whole.reduced().unwrap_or(whole);
        let moved =
            (0i32..).zip(&x).map(|(i, x)| deformation * x + cell.shift([i % 3 - 1, 0, i % 2]));
        let found = network.volumes_in_cell(&moved.collect::<Vec<_>>(), &cell).unwrap();
        let mean = built.volume() / network.pores() as f64;
        for (found, volume) in found.iter().zip(&network.volume) {
            let expected = deformation.determinant() * volume;
            assert!((found - expected).abs() < 1e-10 * mean, "{by}: {found:e} {expected:e}");
        }
    }
    let double = Cell::new(built.edges().map(|edge| 1.3 * edge)).unwrap();
    let error = network.volumes_in_cell(&x, &double).unwrap_err();
    assert!(error.to_string().contains("more than a quarter"), "{error}");
    true
}

/// The mean gradient puts −G V on the spheres together; what flows through each pore is balanced,
/// and the work of the gradient is what throats dissipate.
#[test]
fn forces_add_up_to_the_gradient_on_the_volume() {
    let (x, r, cell) = packed_cell(2);
    let mut flow = cell_flow(&x, &r, &cell);
    let gradient = Vec3::new(3.0, -1.0, 2.0);
    flow.set_pressure_gradient(gradient).unwrap();
    flow.solve_static().unwrap();
    let drag: Vec3 = flow.force().iter().sum();
    let size: f64 = flow.force().iter().map(|f| f.norm()).sum();
    let off = (drag + gradient * cell.volume()).norm() / size;
    assert!(off < 1e-12, "{off:e}");
    assert!(flow.imbalance() < 1e-10, "{:e}", flow.imbalance());
    // No pore of it counts as one that is shut in.
    assert_eq!(flow.remarks().warnings(), Vec::<String>::new());

    let (network, p) = (flow.network(), flow.pressure());
    let periodic = network.periodic().unwrap();
    let throats = network.throats.pores.iter().zip(&network.throats.conductance);
    let mut gain = vec![0.0; network.pores()];
    let (mut dissipated, mut passed) = (0.0, 0.0f64);
    for ((&[i, j], g), way) in throats.zip(&periodic.way) {
        let drop = p[i as usize] - p[j as usize] - gradient.dot(way);
        gain[i as usize] -= g * drop;
        gain[j as usize] += g * drop;
        dissipated += g * drop * drop;
        passed = passed.max((g * drop).abs());
    }
    assert!(gain.iter().all(|q| q.abs() < 1e-10 * passed));
    let work = -cell.volume() * flow.mean_velocity().unwrap().dot(&gradient);
    assert!((dissipated / work - 1.0).abs() < 1e-9, "{dissipated} {work}");

    // In the frame that goes with the spheres nothing is left.
    let mass: Vec<f64> = r.iter().map(|r| r.powi(3)).collect();
    flow.move_with_spheres(&mass).unwrap();
    flow.update_force();
    let left: Vec3 = flow.force().iter().sum();
    assert!(left.norm() < 1e-12 * size);
}

/// The same where large spheres reach past the edges between small ones.
#[test]
fn forces_add_up_where_spheres_reach_past_a_facet() {
    let (x, mut r, cell) = packed_cell(2);
    r.iter_mut().enumerate().filter(|(i, _)| i % 3 != 0).for_each(|(_, r)| *r *= 0.2);
    let mut flow = cell_flow(&x, &r, &cell);
    let gradient = Vec3::new(3.0, -1.0, 2.0);
    flow.set_pressure_gradient(gradient).unwrap();
    flow.solve_static().unwrap();
    let drag: Vec3 = flow.force().iter().sum();
    let size: f64 = flow.force().iter().map(|f| f.norm()).sum();
    let off = (drag + gradient * cell.volume()).norm() / size;
    assert!(off < 1e-12, "{off:e}");
}

/// The permeability is that of any copies side by side, of the same spheres elsewhere in the cell, of
/// the same copies described by other edges, and of a turned cell turned back; K is symmetric and
/// positive.
#[test]
fn the_description_of_the_cell_does_not_count() {
    let (x, r, cell) = packed_cell(3);
    let k = permeability(&x, &r, &cell);
    close(&k, &k.transpose(), 1e-9);
    assert!(k.symmetric_eigenvalues().iter().all(|k| *k > 0.0));
    for copies in [[2, 1, 1], [2, 2, 2]] {
        let (x, r, cell) = tiled(&x, &r, &cell, copies);
        close(&permeability(&x, &r, &cell), &k, 1e-10);
    }
    let shift = Vec3::new(0.123, 4.56, -0.789);
    let shifted: Vec<Vec3> = x.iter().map(|x| x + shift).collect();
    close(&permeability(&shifted, &r, &cell), &k, 1e-10);
    let [a, b, c] = cell.edges();
    for edges in [[a, b + a, c], [a, b, c - a + b], [b, c, a]] {
        close(&permeability(&x, &r, &Cell::new(edges).unwrap()), &k, 1e-10);
    }
    let turn = nalgebra::Rotation3::from_euler_angles(0.4, -0.7, 1.1);
    let turned: Vec<Vec3> = x.iter().map(|x| turn * x).collect();
    let cell = Cell::new(cell.edges().map(|e| turn * e)).unwrap();
    let back = turn.matrix().transpose() * permeability(&turned, &r, &cell) * turn.matrix();
    close(&back, &k, 1e-10);
}

/// A fluid that flows with the spheres, and a cell that grows: the pores grow together by what the
/// cell does; an incompressible fluid cannot follow.
#[test]
fn volume_rates_are_those_of_the_cell() {
    let (x, r, cell) = packed_cell(4);
    let mut flow = cell_flow(&x, &r, &cell);
    let uniform = vec![Vec3::new(1.0, 2.0, 3.0); x.len()];
    flow.update_volume_rate_in_cell(&uniform, 0.0).unwrap();
    let largest = |flow: &Flow| flow.volume_rate().iter().fold(0.0f64, |m, v| m.max(v.abs()));
    assert!(largest(&flow) < 1e-13);
    let wave: Vec<Vec3> = x.iter().map(|x| x.map(|x| (1e3 * x).sin())).collect();
    flow.update_volume_rate_in_cell(&wave, 0.0).unwrap();
    let sum: f64 = flow.volume_rate().iter().sum();
    assert!(largest(&flow) > 1e-6 && sum.abs() < 1e-13, "{} {sum}", largest(&flow));
    flow.update_pressure().unwrap();
    flow.update_volume_rate_in_cell(&wave, 0.1).unwrap();
    let sum: f64 = flow.volume_rate().iter().sum();
    assert!((sum / (0.1 * cell.volume()) - 1.0).abs() < 1e-10);
    let error = flow.update_pressure().unwrap_err();
    assert!(matches!(error, PfvError::ClosedCell { .. }), "{error}");
}

/// In a lattice all centres of pores coincide in clusters, and round-off would choose; the copies of a
/// tie are broken as the tie is. Simple, body- and face-centred, in cells of other descriptions.
#[test]
fn lattices_close() {
    for (basis, name) in [(1, "simple"), (2, "body-centred"), (4, "face-centred")] {
        let (x, cell) = lattice(basis, 4, 1.0 / 3.0);
        let r = vec![0.12; x.len()];
        let k = permeability(&x, &r, &cell);
        let one = k.trace() / 3.0;
        // Coinciding pores are joined by throats of a millionth of their width: so much of k is round-off.
        close(&k, &(one * Tensor::identity()), 1e-5);
        let shifted: Vec<Vec3> = x.iter().map(|x| x + Vec3::new(0.1, 0.077, 0.0123)).collect();
        let [a, b, c] = cell.edges();
        let skew = Cell::new([a, b + a, c + b]).unwrap();
        let off = (permeability(&shifted, &r, &skew) - k).norm() / k.norm();
        println!("{name}: {one:e}, {off:e}");
        assert!(off < 1e-5, "{name}: {off:e}");
    }
}

/// Too few spheres: a pore reaches through half of the cell, or the triangulation does not close.
#[test]
fn a_cell_without_room_is_refused() {
    let (x, cell) = lattice(1, 2, 1.0);
    let error = Flow::in_cell(&x, &[0.4; 8], &cell, &FLUID, SolverKind::default()).unwrap_err();
    assert!(error.to_string().contains("take a larger cell"), "{error}");
    let one = [Vec3::zeros()];
    let cell = Cell::of_size(Vec3::repeat(1.0)).unwrap();
    let error = Flow::in_cell(&one, &[0.4], &cell, &FLUID, SolverKind::default()).unwrap_err();
    assert!(error.to_string().contains("take a larger cell"), "{error}");
    let mut fluid = FLUID;
    fluid.boundary.pressure.0[0] = Some(1.0);
    let error = Flow::in_cell(&x, &[0.4; 8], &cell, &fluid, SolverKind::default()).unwrap_err();
    assert!(error.to_string().contains("no walls in a periodic cell"), "{error}");
}
