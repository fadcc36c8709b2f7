//! What the contacts of a packing make of it, against lattices and chains whose answers are known.

mod common;
mod moving;

use common::{Spheres, cubic, unit_box};
use dempfv::{Aabb, Tensor, Vec3, deviatoric_stress, mean_stress};
use moving::dem_of;

/// A simple cubic lattice of n³ spheres whose neighbours overlap by 2δ, and the walls by δ: F = E r 2δ
/// between spheres, half of it on walls. Each of n² lines along an axis has n − 1 contacts over a
/// length of 1 and two walls at 1/2, so σ = ((n − 1) F + F/2) n² / n³ along each axis, no shear; normals
/// point along three axes alike.
#[test]
fn a_cubic_lattice_has_its_closed_form() {
    let (n, delta) = (4, 1e-3);
    let mut s = cubic(n, 0.0);
    s.r.iter_mut().for_each(|r| *r += delta);
    let mut dem = dem_of(s);
    dem.compute_contacts().unwrap();
    let seen = dem.fabric();
    let lines = (n * n) as f64;
    let force = 1e6 * (0.5 + delta) * 2.0 * delta;
    let stress = lines * ((n - 1) as f64 * force + 0.5 * force) / (n * n * n) as f64;
    let expected = Tensor::from_diagonal_element(stress);
    assert!((seen.stress - expected).norm() < 1e-10 * stress, "{}", seen.stress);
    assert!((seen.fabric - Tensor::from_diagonal_element(1.0 / 3.0)).norm() < 1e-12);
    assert_eq!((seen.sphere_contacts, seen.wall_contacts), (3 * n * n * (n - 1), 6 * n * n));
    assert_eq!(seen.rattlers, 0);
    assert!((seen.without_walls - 6.0 * (1.0 - 1.0 / n as f64)).abs() < 1e-12);
    assert!((seen.mechanical - dem.coordination_number()).abs() < 1e-12);
    assert!((mean_stress(&seen.stress) / stress - 1.0).abs() < 1e-10);
    assert!(deviatoric_stress(&seen.stress) < 1e-10 * stress);
}

/// A chain of three that touches nothing else, and one sphere alone: N = 4, N₀ = 1, N₁ = 2, so the one in
/// the middle carries with (2·2 − 2) / 1 = 2 contacts; all normals point along the chain.
#[test]
fn chains_end_in_rattlers() {
    let x = [0.2, 0.299, 0.398].map(|x| Vec3::new(x, 0.5, 0.5)).to_vec();
    let x = [x, vec![Vec3::new(0.8, 0.8, 0.8)]].concat();
    let mut dem = dem_of(Spheres { x, r: vec![0.05; 4], bounds: unit_box(1.0) });
    dem.compute_contacts().unwrap();
    let seen = dem.fabric();
    assert_eq!((seen.sphere_contacts, seen.wall_contacts, seen.rattlers), (2, 0, 3));
    assert_eq!((seen.mechanical, seen.without_walls), (2.0, 1.0));
    assert_eq!(seen.fabric, Tensor::from_diagonal(&Vec3::x()));
}

/// The part of a box in which a lattice is cut through the middle of its spheres has the porosity of
/// the whole, 1 − π/6; two halves of a random packing have that of the whole as their mean; a region
/// that walls have left has none.
#[test]
fn regions_cut_spheres_at_their_faces() {
    let lattice = dem_of(cubic(4, 0.0));
    let region = Aabb { min: Vec3::repeat(0.5), max: Vec3::new(2.5, 3.5, 1.5) };
    let exact = 1.0 - std::f64::consts::PI / 6.0;
    assert!((lattice.porosity_within(&region) - exact).abs() < 1e-9);
    let random = dem_of(common::settled());
    let bounds = random.box_();
    let [mut low, mut high] = [bounds; 2];
    (low.max.y, high.min.y) = (bounds.center().y, bounds.center().y);
    // Spheres reach through walls by their overlaps, which belong to no region.
    let mean = 0.5 * (random.porosity_within(&low) + random.porosity_within(&high));
    assert!((mean - random.porosity_within(&bounds)).abs() < 1e-9);
    assert!((mean - random.porosity()).abs() < 1e-3, "{mean} {}", random.porosity());
    let outside = Aabb { min: bounds.max, max: bounds.max.add_scalar(1.0) };
    assert!(random.porosity_within(&outside).is_nan());
}
