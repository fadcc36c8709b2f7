//! Contacts in a periodic cell: lattices with a known stress, pairs across its faces, and what must
//! not depend on how the cell is chosen.

mod dem_support;

use dem_support::{cloud, material};
use dempfv::dem::law::Linear;
use dempfv::dem::{
    CellControl, CellControls, Dem, DemError, DemOptions, GrowthCompaction, GrowthOptions,
    Material, Particles, WallControl,
};
use dempfv::{Cell, CellError, Tensor, Vec3, WallId};

const RADIUS: f64 = 0.1;
/// k_n of two of these spheres: E r (N/m).
const STIFFNESS: f64 = 1e6 * RADIUS;

fn smooth() -> Material {
    Material { friction_angle: 0.0, ..material() }
}

fn dem(position: Vec<Vec3>, radius: f64, cell: Cell, material: Material) -> Dem {
    let radii = vec![radius; position.len()];
    let particles = Particles::new(position, radii, material.density);
    Dem::in_cell(Linear, particles, cell, &[material], DemOptions::default()).unwrap()
}

/// `count`³ copies of a sphere, one for each whole multiple of `edges`.
fn lattice(count: i32, edges: [Vec3; 3], material: Material) -> Dem {
    let unit = Cell::new(edges).unwrap();
    let cell = Cell::new(edges.map(|edge| f64::from(count) * edge)).unwrap();
    let all =
        (0..count).flat_map(|a| (0..count).flat_map(move |b| (0..count).map(move |c| [a, b, c])));
    let off = 0.37 * edges[0] + 0.11 * edges[1];
    dem(all.map(|n| off + unit.shift(n)).collect(), RADIUS, cell, material)
}

fn cube(edge: f64) -> [Vec3; 3] {
    [edge * Vec3::x(), edge * Vec3::y(), edge * Vec3::z()]
}

/// One step that strains the cell by `strain`.
fn strain(dem: &mut Dem, strain: Tensor) {
    let dt = 1e-6;
    dem.compute_contacts().unwrap();
    let rate = |a: usize, b: usize| CellControl::Rate(strain[(a, b)] / dt);
    dem.set_cell_controls([0, 1, 2].map(|a| [0, 1, 2].map(|b| rate(a, b)))).unwrap();
    dem.integrate(dt, None, None).unwrap();
    dem.set_cell_controls(CellControls::default()).unwrap();
    dem.compute_contacts().unwrap();
}

fn assert_near(found: Tensor, expected: Tensor, scale: f64) {
    let error = (found - expected).norm();
    assert!(error < 1e-12 * scale, "{error:e}: {found} {expected}");
}

/// A simple cubic lattice of spacing a with the overlap δ = 2r − a: each sphere has a contact along
/// each axis, so σ = k δ / a² in each direction. The cell is compressed by a step of its own.
#[test]
fn a_cubic_lattice_has_the_stress_of_its_springs() {
    let mut dem = lattice(5, cube(2.0 * RADIUS), smooth());
    strain(&mut dem, Tensor::from_diagonal(&Vec3::new(-0.01, -0.02, -0.03)));
    let a = 2.0 * RADIUS * Vec3::new(0.99, 0.98, 0.97);
    let volume = a.product();
    let expected = a.map(|a| STIFFNESS * (2.0 * RADIUS - a) * a / volume);
    let scale = expected.norm();
    assert_near(dem.stress_in_cell(), Tensor::from_diagonal(&expected), scale);
    assert_near(dem.stress(), Tensor::from_diagonal(&expected), scale);
    assert!((dem.mean_stress() / expected.mean() - 1.0).abs() < 1e-12);
    assert_eq!(dem.sphere_contact_count(), 3 * 125);
    // Σ k δ² / 2
    let energy = a.map(|a| 0.5 * STIFFNESS * (2.0 * RADIUS - a).powi(2)).sum() * 125.0;
    assert!((dem.elastic_energy() / energy - 1.0).abs() < 1e-12);
}

/// A face-centred cubic lattice, by its primitive cell (edges at 60°): 12 neighbours at l, σ = 2 k δ l
/// over the volume of a sphere's cell, l³/√2, alike in all directions.
#[test]
fn a_face_centred_lattice_is_isotropic_in_its_primitive_cell() {
    let a = 2.0 * RADIUS / 2f64.sqrt();
    let edges = [Vec3::new(0.0, a, a), Vec3::new(a, 0.0, a), Vec3::new(a, a, 0.0)];
    let mut dem = lattice(6, edges, smooth());
    strain(&mut dem, -0.01 * Tensor::identity());
    let l = 2.0 * RADIUS * 0.99;
    let expected = 2.0 * STIFFNESS * (2.0 * RADIUS - l) * l / (l.powi(3) / 2f64.sqrt());
    assert_near(dem.stress_in_cell(), expected * Tensor::identity(), expected);
    assert!((dem.coordination_number() - 12.0).abs() < 1e-15);
}

/// Simple shear γ = ∂x/∂y of a cubic lattice: the contact along y becomes (γ, 1, 0) a. Far beyond
/// whole turns of the cell, whose edges are shortened meanwhile.
#[test]
fn a_sheared_lattice_has_the_stress_of_its_springs() {
    let a = 2.0 * RADIUS * 0.95;
    let mut dem = lattice(5, cube(a), smooth());
    let mut gamma = 0.0;
    // 5 whole shears of the 5 layers bring the lattice back to itself.
    for k in 0..100 {
        let step = 0.05;
        strain(&mut dem, Tensor::new(0.0, step, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0));
        gamma += step;
        // The layer above is nearest at the copy of γ within half a spacing.
        let near = gamma - gamma.round();
        if near.abs() > 0.2 || k % 7 != 0 {
            continue;
        }
        let along = |l: Vec3| {
            let (distance, n) = (l.norm(), l.normalize());
            STIFFNESS * (2.0 * RADIUS - distance).max(0.0) * distance * n * n.transpose()
        };
        let ways = [a * Vec3::x(), a * Vec3::new(near, 1.0, 0.0), a * Vec3::z()];
        let expected: Tensor = ways.into_iter().map(along).sum::<Tensor>() / a.powi(3);
        // The round-off of a hundred steps, of places that the overlap is a twentieth of.
        let error = (dem.stress_in_cell() - expected).norm() / expected.norm();
        assert!(error < 1e-12, "{gamma}: {error:e}");
        let skew = dem.cell().unwrap().cell().angles()[2].cos().abs();
        assert!(skew < 0.5, "{gamma}: {skew}");
    }
    assert!((dem.cell().unwrap().strain()[(0, 1)] - 5.0).abs() < 1e-12);
}

/// Contacts that stick: the shear stress of a small shear, k_s along y beside what the turned
/// normal force does: σ_xy = (k δ γ a − k_s γ a²) / a³, to the second order in γ. The spins do not
/// change in the first step.
#[test]
fn a_rough_lattice_resists_shear_by_its_shear_springs() {
    let a = 2.0 * RADIUS * 0.95;
    let gamma = 1e-6;
    let mut dem = lattice(5, cube(a), material());
    strain(&mut dem, Tensor::new(0.0, gamma, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0));
    let delta = 2.0 * RADIUS - a;
    let expected = STIFFNESS * gamma * (delta - 0.5 * a) / a.powi(2);
    let found = dem.stress_in_cell()[(0, 1)];
    assert!((found - expected).abs() < 1e-12 * STIFFNESS / a, "{found:e} {expected:e}");
}

/// A packing in the unit cube, grown to 10 kPa with friction.
fn packing() -> Dem {
    let unit = Cell::of_size(Vec3::repeat(1.0)).unwrap();
    let mut dem =
        Dem::in_cell(Linear, cloud(300, 3), unit, &[material()], DemOptions::default()).unwrap();
    dem.set_damping(0.3).unwrap();
    let status =
        GrowthCompaction::new(GrowthOptions::new(1e4, 1e6)).unwrap().run(&mut dem).unwrap();
    assert!(status.done && (dem.mean_stress() / 1e4 - 1.0).abs() < 2e-3);
    dem
}

/// The same spheres anywhere, and by any cell of the same copies: the same stress, energy,
/// contacts, forces, in the same motion.
#[test]
fn nothing_depends_on_how_the_cell_is_chosen() {
    let grown = packing();
    let (x, r) = (grown.positions(), grown.radii());
    let seen = |shift: Vec3, cell: Cell| {
        let moved = x.iter().map(|x| x + shift).collect();
        let mut particles = Particles::new(moved, r.clone(), 2600.0);
        particles.velocity = x.iter().map(|x| x.map(|x| (40.0 * x).sin())).collect();
        let mut dem =
            Dem::in_cell(Linear, particles, cell, &[material()], DemOptions::default()).unwrap();
        let mut controls = CellControls::default();
        controls[0][1] = CellControl::Rate(1.0);
        controls[2][2] = CellControl::Rate(-0.5);
        dem.set_cell_controls(controls).unwrap();
        for _ in 0..100 {
            dem.step(1e-4).unwrap();
        }
        dem.compute_contacts().unwrap();
        let forces = dem.forces();
        let stress = dem.stress_in_cell();
        (forces, stress, dem.elastic_energy(), dem.kinetic_energy(), dem.sphere_contact_count())
    };
    let [a, b, c] = cube(1.0);
    let plain = seen(Vec3::zeros(), Cell::new([a, b, c]).unwrap());
    let largest = plain.0.iter().map(|f| f.norm()).fold(0.0, f64::max);
    for (shift, edges) in [
        (Vec3::new(0.3, -2.7, 11.1), [a, b, c]),
        (Vec3::zeros(), [a, b + a, c]),
        (Vec3::new(-0.5, 0.5, 0.1), [a, b - 2.0 * a, c + a - 3.0 * b]),
        (Vec3::zeros(), [b, c, a]),
    ] {
        let other = seen(shift, Cell::new(edges).unwrap());
        let off = plain.0.iter().zip(&other.0).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(off < 1e-8 * largest, "{shift}: {:e}", off / largest);
        assert!((plain.1 - other.1).norm() < 1e-9 * plain.1.norm(), "{shift}");
        assert!((plain.2 / other.2 - 1.0).abs() < 1e-9, "{shift}");
        assert!((plain.3 / other.3 - 1.0).abs() < 1e-9, "{shift}");
        assert_eq!(plain.4, other.4, "{shift}");
    }
}

/// Spheres of two materials that are the same are those of one, to the bit.
#[test]
fn materials_count_in_a_cell() {
    let grown = packing();
    let course = |of: fn(usize) -> u16, materials: &[Material]| {
        let mut particles = Particles::new(grown.positions(), grown.radii(), 2600.0);
        particles.material = (0..particles.len()).map(of).collect();
        particles.velocity.iter_mut().enumerate().for_each(|(i, v)| v.x = (i as f64).sin());
        let cell = Cell::of_size(Vec3::repeat(1.0)).unwrap();
        let mut dem =
            Dem::in_cell(Linear, particles, cell, materials, DemOptions::default()).unwrap();
        for _ in 0..50 {
            dem.step(1e-4).unwrap();
        }
        (dem.forces(), dem.stress_in_cell())
    };
    let mut one = material();
    let same = course(|_| 0, &[one]);
    assert!(course(|i| (i % 2) as u16, &[one, one]) == same);
    one.young = 2e6;
    assert!(course(|i| (i % 2) as u16, &[material(), one]).1.trace() > 1.1 * same.1.trace());
}

/// Two rough spheres that meet, roll off and part: the same forces wherever in the cell they are,
/// and while they drift through a face, an edge, or a corner of it, with a list that is new in
/// nearly every step or in none.
#[test]
fn a_pair_across_faces_is_a_pair() {
    let start = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(0.17, 0.08, 0.06)];
    let course = |place: Vec3, drift: Vec3, skin: f64| {
        let mut p = Particles::new(start.map(|x| x + place).to_vec(), vec![RADIUS; 2], 2600.0);
        p.velocity = vec![drift + Vec3::new(0.4, 0.0, 0.1), drift];
        p.spin[1] = Vec3::new(0.0, 3.0, -2.0);
        let cell = Cell::of_size(Vec3::repeat(1.0)).unwrap();
        let options = DemOptions { skin, ..DemOptions::default() };
        let mut dem = Dem::in_cell(Linear, p, cell, &[material()], options).unwrap();
        let (mut forces, mut touched) = (vec![], 0);
        for _ in 0..2000 {
            dem.step(1e-4).unwrap();
            forces.push(dem.force(0));
            touched += dem.sphere_contact_count();
        }
        assert!((100..1900).contains(&touched), "{touched}");
        forces
    };
    let inside = course(Vec3::repeat(0.4), Vec3::zeros(), 0.1);
    let largest = inside.iter().map(|f| f.norm()).fold(0.0, f64::max);
    let sheared = inside.iter().filter(|f| f.norm() > 0.0).count();
    assert!(sheared > 100);
    for (place, drift) in [
        (Vec3::new(0.93, 0.4, 0.4), Vec3::zeros()),
        (Vec3::new(0.93, 0.97, 0.4), Vec3::zeros()),
        (Vec3::new(0.93, 0.97, 0.98), Vec3::zeros()),
        (Vec3::repeat(0.7), Vec3::new(4.0, 0.0, 0.0)),
        (Vec3::repeat(0.7), Vec3::new(4.0, 4.3, 0.0)),
        (Vec3::repeat(0.2), Vec3::new(-9.0, -7.0, 8.0)),
    ] {
        for skin in [1e-4, 0.1, 0.5] {
            let forces = course(place, drift, skin);
            let off = inside.iter().zip(&forces).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            assert!(off < 1e-9 * largest, "{place} {drift} {skin}: {:e}", off / largest);
        }
    }
}

/// A cell of less than four spheres with the skin, one that is flat or left-handed, a moving wall,
/// gravity, a stress twice: each is refused with what would be right.
#[test]
fn what_makes_no_sense_in_a_cell_is_refused() {
    let one = |size: f64| {
        let p = Particles::new(vec![Vec3::zeros()], vec![RADIUS], 2600.0);
        let cell = Cell::of_size(Vec3::new(1.0, size, 1.0)).unwrap();
        Dem::in_cell(Linear, p, cell, &[material()], DemOptions::default())
    };
    // Four radii, and twice the skin of a tenth of one.
    assert!(one(4.21 * RADIUS).is_ok());
    let error = one(4.19 * RADIUS).unwrap_err();
    assert!(matches!(error, DemError::CellTooSmall { .. }), "{error}");
    assert!(error.to_string().contains("take more spheres"), "{error}");
    let left = Cell::new([Vec3::x(), Vec3::z(), Vec3::y()]).unwrap_err();
    assert!(matches!(left, CellError::LeftHanded { .. }));
    assert!(left.to_string().contains("let two change places"), "{left}");

    let mut dem = one(1.0).unwrap();
    let error = dem.set_control(WallId::XMin, WallControl::Velocity(1.0)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "a moving wall in a periodic cell: there are no walls; move the cell"
    );
    let mut controls = CellControls::default();
    controls[0][2] = CellControl::Stress(1.0);
    controls[2][0] = CellControl::Stress(1.0);
    let error = dem.set_cell_controls(controls).unwrap_err();
    assert!(error.to_string().contains("given for xz and for zx"), "{error}");
    let p = Particles::new(vec![Vec3::zeros()], vec![RADIUS], 2600.0);
    let heavy = DemOptions { gravity: Some(Vec3::y()), ..DemOptions::default() };
    let cell = Cell::of_size(Vec3::repeat(1.0)).unwrap();
    let error = Dem::in_cell(Linear, p, cell, &[material()], heavy).unwrap_err();
    assert!(error.to_string().starts_with("gravity in a periodic cell"), "{error}");
    // A cell that would close on itself in a step strains by more than any may.
    controls[0][2] = CellControl::Rate(0.0);
    controls[1][1] = CellControl::Rate(-2e3);
    controls[2][0] = CellControl::Rate(0.0);
    dem.set_cell_controls(controls).unwrap();
    let error = dem.step(1e-3).unwrap_err();
    assert!(matches!(error, DemError::CellStrainPerStep { strain: 2.0, .. }), "{error}");
    assert!(error.to_string().contains("L_yy = -2e3 /s"), "{error}");
}
