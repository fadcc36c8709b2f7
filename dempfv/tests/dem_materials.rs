//! Spheres of several materials: a table of pairs, and the same bits where the materials are one.

mod dem_support;

use dem_support::{UNIT, bits, frictionless_walls, material, settled};
use dempfv::coupling::Coupled;
use dempfv::dem::law::Linear;
use dempfv::dem::{
    Dem, DemError, DemOptions, Material, MaterialPair, Particles, Partner, WallControl,
    WallMaterial,
};
use dempfv::{Vec3, WallId};

const OPTIONS: DemOptions = DemOptions { damping: 0.2, gravity: None, rotation: true, skin: 0.2 };

/// A stiff, heavy, rough material beside the usual one.
fn stone() -> Material {
    Material {
        young: 5e7,
        stiffness_ratio: 0.25,
        friction_angle: 40f64.to_radians(),
        density: 5200.0,
    }
}

/// Four spheres in a row along z, the first on the wall z_min and the last on z_max: soft, soft,
/// stone, stone.
fn row() -> Dem {
    let (radius, overlap) = (0.13, 0.01);
    let at = |k: usize| radius - overlap + (2.0 * radius - overlap) * k as f64;
    let positions = (0..4).map(|k| Vec3::new(0.5, 0.5, at(k))).collect();
    let materials = [material(), stone()];
    let spheres =
        Particles::of_materials(positions, vec![radius; 4], vec![0, 0, 1, 1], &materials).unwrap();
    let top = at(3) + radius - overlap;
    let box_ = dempfv::Aabb { max: Vec3::new(1.0, 1.0, top), ..UNIT };
    let walls = WallMaterial { young: 2e6, friction_angle: 0.1 };
    Dem::with_law(Linear, spheres, box_, &materials, walls, OPTIONS).unwrap()
}

/// Each contact has the stiffness of its two materials, k = 2 E₁ r₁ E₂ r₂ / (E₁ r₁ + E₂ r₂), as
/// YADE's linear law has it; masses follow from the densities.
#[test]
fn contacts_know_their_two_materials() {
    let mut dem = row();
    dem.compute_contacts().unwrap();
    let r = 0.13;
    let pair = |a: f64, b: f64| 2.0 * r * a * b / (a + b);
    let (soft, stone) = (material().young, stone().young);
    let mut seen = 0;
    for contact in dem.contacts() {
        let expected = match (contact.i, contact.partner) {
            (0, Partner::Wall(_)) => pair(soft, 2e6),
            (3, Partner::Wall(_)) => pair(stone, 2e6),
            (i, Partner::Sphere(j)) => {
                let of = |k: u32| if k < 2 { soft } else { stone };
                pair(of(i), of(j))
            }
            other => panic!("no such contact: {other:?}"),
        };
        let (k, force) = (contact.stiffness, contact.normal_force);
        assert!((k / expected - 1.0).abs() < 1e-14, "{contact:?} {expected}");
        assert!((force / (expected * 0.01) - 1.0).abs() < 1e-12, "{contact:?}");
        seen += 1;
    }
    assert_eq!(seen, 5);
    // The pass adds up the same forces.
    for i in 0..4 {
        let mut expected = 0.0;
        for contact in dem.contacts() {
            let force = contact.force().z;
            expected -= if contact.i == i { force } else { 0.0 };
            expected += if contact.partner == Partner::Sphere(i) { force } else { 0.0 };
        }
        let place = dem.storage().id.iter().position(|&id| id == i).unwrap();
        let found = dem.storage_forces()[place].z;
        assert!((found - expected).abs() < 1e-9 * stone * r, "{i}: {found} {expected}");
        let density = if i < 2 { 2600.0 } else { 5200.0 };
        let mass = density * 4.0 / 3.0 * std::f64::consts::PI * f64::powi(r, 3);
        assert!((dem.storage().mass[place] / mass - 1.0).abs() < 1e-14);
    }
}

/// Friction of a pair is the smaller angle's: a stone slides on a soft sphere as soft ones do, and
/// on a stone later. The shear force of a pair that was sheared far is tan φ times the normal one.
#[test]
fn friction_is_that_of_the_pair() {
    let materials = [material(), stone()];
    for (kinds, angle) in [([0, 0], 30.0), ([0, 1], 30.0), ([1, 0], 30.0), ([1, 1], 40.0f64)] {
        let positions = vec![Vec3::new(0.5, 0.5, 0.4), Vec3::new(0.5, 0.5, 0.5998)];
        let mut spheres =
            Particles::of_materials(positions, vec![0.1; 2], kinds.to_vec(), &materials).unwrap();
        spheres.velocity[1].x = 10.0;
        let walls = frictionless_walls();
        let options = DemOptions { rotation: false, ..OPTIONS };
        let mut dem = Dem::with_law(Linear, spheres, UNIT, &materials, walls, options).unwrap();
        // A step of 10⁻⁴ s shears the contact by 1 mm: more than tan φ k_n/k_s times the overlap.
        dem.step(1e-4).unwrap();
        dem.step(1e-7).unwrap();
        dem.compute_contacts().unwrap();
        let contact = dem.contacts().next().unwrap();
        let ratio = contact.shear.norm() / contact.normal_force;
        let expected = f64::to_radians(angle).tan();
        assert!((ratio / expected - 1.0).abs() < 1e-9, "{kinds:?}: {ratio} {expected}");
    }
}

/// Two entries with the same values are one material: the same bits as without a list.
#[test]
fn a_list_of_one_material_twice_changes_no_bit() {
    let packing = settled(300, 3, OPTIONS);
    let start = |several: bool| {
        let mut state = packing.state();
        let mut materials = vec![material()];
        if several {
            let kind = |number: &u32| u16::from(number.is_multiple_of(3));
            state.particles.material = state.particles.id.iter().map(kind).collect();
            materials.push(material());
        }
        let walls = WallMaterial { young: 1e6, friction_angle: 0.2 };
        let mut dem = Dem::with_law_from_state(Linear, state, &materials, walls, OPTIONS).unwrap();
        dem.set_control(WallId::YMax, WallControl::Velocity(-0.05)).unwrap();
        dem
    };
    let (mut one, mut two) = (start(false), start(true));
    for _ in 0..300 {
        let dt = one.step_auto(0.5).unwrap();
        assert_eq!(two.step_auto(0.5).unwrap(), dt);
    }
    assert!(one.sphere_contact_count() > 100);
    let positions = |dem: &Dem| dem.storage().position.clone();
    assert_eq!(positions(&one), positions(&two));
    assert_eq!(one.storage().spin, two.storage().spin);
    // Sorting takes the materials along.
    let of = |dem: &Dem, number: u32| {
        let p = dem.storage();
        p.material[p.id.iter().position(|&id| id == number).unwrap()]
    };
    two.sort_spatially().unwrap();
    assert!((0..300).all(|i| of(&two, i) == u16::from(i.is_multiple_of(3))));
}

/// A state goes on with its materials, alone and in a coupled run.
#[test]
fn a_state_keeps_its_materials() {
    let mut dem = row();
    dem.step(1e-6).unwrap();
    let state = dem.state();
    let materials = dem.materials().to_vec();
    let walls = *dem.wall_material();
    let mut again =
        Dem::with_law_from_state(Linear, state.clone(), &materials, walls, OPTIONS).unwrap();
    let mut coupled = Coupled::from_state(Coupled::new(dem).state()).unwrap();
    for _ in 0..20 {
        again.step(1e-6).unwrap();
        coupled.step(1e-6).unwrap();
    }
    assert_eq!(coupled.dem().materials(), &materials);
    assert_eq!(bits(&again), bits(coupled.dem()));
    let error = Dem::from_state(state, material(), walls, OPTIONS).unwrap_err();
    assert_eq!(error, DemError::NoSuchMaterial { particle: 2, index: 1, count: 1 });
}

#[test]
fn wrong_lists_are_named() {
    let materials = [material()];
    let two = || (vec![Vec3::repeat(0.3), Vec3::repeat(0.7)], vec![0.1; 2]);
    let of = |material| {
        let (positions, radii) = two();
        Particles::of_materials(positions, radii, material, &materials).map(|_| ())
    };
    assert_eq!(of(vec![0, 0]), Ok(()));
    assert_eq!(of(vec![0, 1]), Err(DemError::NoSuchMaterial { particle: 1, index: 1, count: 1 }));
    let length = DemError::Length { what: "material", found: 1, expected: 2 };
    assert_eq!(of(vec![0]), Err(length));
    let length = DemError::Length { what: "material", found: 0, expected: 2 };
    assert_eq!(of(vec![]), Err(length));
    let (positions, radii) = two();
    let light = [Material { density: -1.0, ..material() }];
    let error = Particles::of_materials(positions, radii, vec![0, 0], &light).unwrap_err();
    assert!(error.to_string().starts_with("density = -1"), "{error}");
    let (positions, radii) = two();
    let spheres = Particles::new(positions, radii, 2600.0);
    let error = Dem::with_law(Linear, spheres, UNIT, &[], frictionless_walls(), OPTIONS);
    let message = error.unwrap_err().to_string();
    assert_eq!(message, "0 materials; give from 1 to 65535");
}

/// A servo wall comes to rest on stiff spheres, whatever softer ones lie below or are in the list
/// alone: what it touches first decides how near it may come in a step.
#[test]
fn a_servo_wall_rests_on_the_stiffer_spheres() {
    let (side, radius) = (4, 0.125);
    let at = |k: usize| radius * (2.0 * k as f64 + 1.0);
    let rock = Material { young: 1e8, ..material() };
    for soft_layers in [0, 2] {
        let (mut positions, mut kinds) = (vec![], vec![]);
        for k in 0..side * side * side {
            let (x, y, z) = (k % side, k / side % side, k / (side * side));
            positions.push(Vec3::new(at(x), at(y), at(z)));
            kinds.push(u16::from(y < soft_layers));
        }
        let materials = [rock, material()];
        let spheres =
            Particles::of_materials(positions, vec![radius; kinds.len()], kinds, &materials);
        let box_ = dempfv::Aabb { max: Vec3::new(1.0, 1.0 + 0.3 * radius, 1.0), ..UNIT };
        let walls = WallMaterial { young: 1e8, friction_angle: 0.0 };
        let mut dem =
            Dem::with_law(Linear, spheres.unwrap(), box_, &materials, walls, OPTIONS).unwrap();
        let servo = WallControl::Servo { stress: 1e3, max_velocity: None };
        dem.set_control(WallId::YMax, servo).unwrap();
        let (steps, mut most) = (12_000, 0.0f64);
        for step in 0..steps {
            dem.step_auto(0.5).unwrap();
            let stress = dem.wall_stress(WallId::YMax) / 1e3;
            most = most.max(stress);
            if step > steps - 500 {
                assert!((stress - 1.0).abs() < 0.02, "{soft_layers} layers: {stress}");
            }
        }
        assert!(most < 3.0, "{soft_layers} layers: {most} times the stress wanted");
    }
}

/// What a pair is given stands in the place of what follows from both materials, for that pair alone; a
/// friction for all takes the pair's along, until the materials come back.
#[test]
fn a_pair_has_its_own_constants() {
    let [soft, hard] = [1e6, 4e6].map(|young| Material { young, ..material() });
    let x = [0.0, 0.199, 0.398].map(|x| Vec3::new(0.3 + x, 0.5, 0.5)).to_vec();
    let p = Particles::of_materials(x, vec![0.1; 3], vec![0, 1, 1], &[soft, hard]).unwrap();
    let (walls, options) = (frictionless_walls(), DemOptions::default());
    let mut dem = Dem::with_law(Linear, p, UNIT, &[soft, hard], walls, options).unwrap();
    let stiffness = |dem: &mut Dem| {
        dem.compute_contacts().unwrap();
        let mut of_pairs: Vec<f64> = dem.contacts().map(|c| c.stiffness).collect();
        of_pairs.sort_by(f64::total_cmp);
        of_pairs
    };
    // 2 E r₁ r₂ / (r₁ + r₂) with the harmonic mean of both moduli.
    let near = |found: Vec<f64>, expected: [f64; 2]| {
        found.iter().zip(expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-12)
    };
    assert!(near(stiffness(&mut dem), [1.6e5, 4e5]));
    let pair = MaterialPair {
        between: [1, 0],
        young: Some(3e6),
        stiffness_ratio: None,
        friction_angle: Some(0.0),
    };
    dem.set_materials(&[soft, hard], &[pair]).unwrap();
    assert!(near(stiffness(&mut dem), [3e5, 4e5]));
    dem.sort_spatially().unwrap();
    dem.set_friction(0.1).unwrap();
    assert!(near(stiffness(&mut dem), [3e5, 4e5]));
    assert_eq!(dem.material_pairs()[0].friction_angle, None);
}
