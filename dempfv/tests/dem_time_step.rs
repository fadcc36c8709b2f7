//! The bound of the contacts, sphere by sphere, in a packing of several blocks.

mod dem_support;

use dem_support::material;
use dempfv::dem::{Dem, DemOptions, Particles, Partner, WallMaterial};
use dempfv::{Aabb, Vec3};

/// Spheres along an edge: 1,331 of them, in three blocks.
const EDGE: usize = 11;

/// A cubic lattice that overlaps by a hundredth, within walls that it presses on, in which one sphere is
/// a thousand times lighter than the others and rules the bound.
fn lattice(light: usize) -> Dem {
    let place = |k: usize| [k % EDGE, k / EDGE % EDGE, k / (EDGE * EDGE)];
    let position = (0..EDGE.pow(3)).map(|k| Vec3::from(place(k).map(|i| i as f64 + 0.5)));
    let (material, edge) = (material(), EDGE as f64);
    let mut particles =
        Particles::new(position.collect(), vec![0.505; EDGE.pow(3)], material.density);
    particles.mass[light] *= 1e-3;
    let walls = WallMaterial { young: material.young, friction_angle: material.friction_angle };
    let options = DemOptions { rotation: false, ..DemOptions::default() };
    let bounds = Aabb { min: Vec3::zeros(), max: Vec3::repeat(edge) };
    let mut dem = Dem::new(particles, bounds, material, walls, options).unwrap();
    dem.compute_contacts().unwrap();
    dem
}

/// √(2 m / k), k the largest entry of Σ k_s 1 + (k_n − k_s) n⊗n, which is diagonal where contacts lie
/// along the axes: of spheres all over the lattice, whose contacts are in their block, in an earlier one,
/// in a later one and with walls.
#[test]
fn every_contact_of_a_sphere_counts() {
    for light in (0..EDGE.pow(3)).step_by(37) {
        let mut dem = lattice(light);
        let mass = dem.mass(light);
        let ratio = material().stiffness_ratio;
        let mut k = Vec3::zeros();
        for contact in dem.contacts() {
            let is_its =
                contact.i as usize == light || contact.partner == Partner::Sphere(light as u32);
            if is_its {
                let along = contact.normal.component_mul(&contact.normal);
                let kept = along.map(|along| ratio + (1.0 - ratio) * along);
                k += contact.stiffness * kept;
            }
        }
        let expected = (2.0 * mass / k.max()).sqrt();
        let found = dem.contact_time_step(1.0).unwrap();
        assert!((found / expected - 1.0).abs() < 1e-12, "sphere {light}: {found}, {expected}");
    }
}
