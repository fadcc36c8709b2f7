//! Bad input is refused with the particle or the parameter named.

mod dem_support;

use dem_support::{UNIT, cloud, frictionless_walls, material};
use dempfv::dem::{Dem, DemError, DemOptions, Leaving, Material, Particles, WallControl};
use dempfv::{Vec3, WallId};

fn make(p: Particles) -> Result<Dem, DemError> {
    Dem::new(p, UNIT, material(), frictionless_walls(), DemOptions::default())
}

fn error_of(p: Particles) -> DemError {
    make(p).err().unwrap()
}

#[test]
fn bad_particles_are_named() {
    let mut p = cloud(20, 1);
    p.position[7].y = f64::NAN;
    assert_eq!(error_of(p), DemError::NotFinite { particle: 7, quantity: "position" });

    let mut p = cloud(20, 1);
    p.radius[3] = -0.1;
    let expected = DemError::BadParticle { particle: 3, quantity: "radius", value: -0.1 };
    assert_eq!(error_of(p), expected);

    let mut p = cloud(20, 1);
    p.position[5].z = 1.01;
    assert_eq!(error_of(p), DemError::OutsideBox { particle: 5, wall: WallId::ZMax });

    let mut p = cloud(20, 1);
    p.position[11] = p.position[4];
    let DemError::Coincident { first, second } = error_of(p) else { panic!() };
    assert_eq!([first.min(second), first.max(second)], [4, 11]);

    let mut p = cloud(20, 1);
    p.spin.pop();
    assert_eq!(error_of(p), DemError::Length { what: "spin", found: 19, expected: 20 });

    let mut p = cloud(20, 1);
    p.id[7] = 3;
    assert_eq!(error_of(p), DemError::Numbers { number: 3, count: 20 });
}

#[test]
fn bad_parameters_are_named() {
    let with = |m: Material, o: DemOptions| {
        Dem::new(cloud(2, 1), UNIT, m, frictionless_walls(), o).err().unwrap().to_string()
    };
    let (m, o) = (material(), DemOptions::default());
    assert!(with(Material { young: 0.0, ..m }, o).starts_with("young = 0"));
    assert!(with(Material { density: -1.0, ..m }, o).starts_with("density = -1"));
    assert!(with(Material { stiffness_ratio: -1.0, ..m }, o).starts_with("stiffness_ratio = -1"));
    assert!(with(Material { friction_angle: 1.6, ..m }, o).starts_with("friction_angle = 1.6"));
    assert!(with(m, DemOptions { damping: 1.0, ..o }).starts_with("damping = 1"));
    assert!(with(m, DemOptions { skin: 0.0, ..o }).starts_with("skin = 0"));
    let mut dem = make(cloud(2, 1)).unwrap();
    assert!(dem.step(0.0).unwrap_err().to_string().starts_with("time step = 0"));
    let servo = WallControl::Servo { stress: 1.0, max_velocity: Some(0.0) };
    let error = dem.set_control(WallId::XMin, servo).unwrap_err();
    assert!(error.to_string().starts_with("servo max_velocity = 0"));
}

/// A fluid force that is not finite names the sphere it was meant for.
#[test]
fn what_is_not_finite_is_named() {
    let mut dem = make(cloud(2000, 1)).unwrap();
    let k = 1234;
    let mut fluid = vec![Vec3::zeros(); 2000];
    fluid[k].x = f64::INFINITY;
    dem.compute_contacts().unwrap();
    let particle = dem.storage().id[k];
    let error = dem.integrate(1e-4, Some(&fluid), None).unwrap_err();
    assert_eq!(error, DemError::NotFinite { particle, quantity: "the fluid force" });

    let mut dem = make(cloud(20, 1)).unwrap();
    dem.add_torque(7, Vec3::new(f64::NAN, 0.0, 0.0));
    let error = dem.step(1e-4).unwrap_err();
    assert_eq!(error, DemError::NotFinite { particle: 7, quantity: "the external torque" });
}

/// A sphere shot through a wall is found and named.
#[test]
fn a_sphere_that_leaves_is_named() {
    let mut dem = make(cloud(50, 1)).unwrap();
    dem.set_velocity(20, Vec3::new(0.0, 1e5, 0.0));
    let error = (0..10).find_map(|_| dem.step(1e-4).err()).unwrap();
    let DemError::LeftBox { particle: 20, wall: WallId::YMax, speed, radii, cause } = error else {
        panic!("{error}")
    };
    let radius = dem.storage().radius[dem.storage().id.iter().position(|&i| i == 20).unwrap()];
    assert!((speed / 1e5 - 1.0).abs() < 1e-9 && (radii / (10.0 / radius) - 1.0).abs() < 1e-9);
    assert_eq!(cause, Some(Leaving::FastSphere));

    // A wall that goes over a sphere at rest.
    let mut dem = make(cloud(50, 1)).unwrap();
    dem.set_control(WallId::XMin, WallControl::Velocity(5e3)).unwrap();
    let error = (0..10).find_map(|_| dem.step(1e-4).err()).unwrap();
    let DemError::LeftBox { wall, cause, .. } = error else { panic!("{error}") };
    assert_eq!((wall, cause), (WallId::XMin, Some(Leaving::FastWall)));

    // A weight that the contact cannot carry.
    let heavy = DemOptions { gravity: Some(Vec3::new(0.0, 0.0, -2e4)), ..DemOptions::default() };
    let sphere = Particles::new(vec![Vec3::repeat(0.1)], vec![0.1], 2600.0);
    let mut dem = Dem::new(sphere, UNIT, material(), frictionless_walls(), heavy).unwrap();
    let error = (0..10_000).find_map(|_| dem.step(1e-5).err()).unwrap();
    assert!(error.to_string().contains("the stiffness is too low"), "{error}");
}

/// Nothing at all, and one sphere alone, are legal.
#[test]
fn few_spheres_are_legal() {
    for count in 0..3 {
        let mut dem = make(cloud(count, 1)).unwrap();
        dem.step(1e-4).unwrap();
        assert_eq!(dem.len(), count);
        assert_eq!(dem.coordination_number(), 0.0);
        assert_eq!(dem.unbalanced_force(None), Ok(0.0));
    }
}
