//! The same bits: for any number of threads, any neighbour list, and after a
//! restart.

mod dem_support;

use dem_support::{bits, frictionless_walls, material, twin};
use dempfv::dem::{Dem, DemOptions, GrowthCompaction, GrowthOptions, WallControl, WallMaterial};
use dempfv::{Vec3, WallId};

const SKIN: f64 = 0.2;

fn options(skin: f64) -> DemOptions {
    DemOptions { damping: 0.1, gravity: Some(Vec3::new(0.0, -1.0, 0.0)), rotation: true, skin }
}

/// A packing in the thick of things: still growing, then sheared by gravity
/// and two moving walls, one of them servo-controlled, all with friction.
fn busy(count: usize, skin: f64) -> Dem {
    let dem = twin(count, 2, options(skin));
    let rough = WallMaterial { young: 2e6, friction_angle: 0.3 };
    let mut dem = Dem::from_state(dem.state(), material(), rough, options(skin)).unwrap();
    let mut growth = GrowthCompaction::new(GrowthOptions::new(1e4, 1e6)).unwrap();
    for _ in 0..600 {
        growth.step(&mut dem).unwrap();
    }
    dem.sort_spatially().unwrap();
    let servo = WallControl::Servo { stress: 2e4, max_velocity: Some(0.1) };
    dem.set_control(WallId::YMax, servo).unwrap();
    dem.set_control(WallId::XMin, WallControl::Velocity(0.02)).unwrap();
    dem
}

fn advance(dem: &mut Dem, steps: usize) {
    for _ in 0..steps {
        dem.step(1e-4).unwrap();
    }
}

/// 3000 spheres are six blocks: enough for the work to be shared out.
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut dem = busy(3000, SKIN);
            advance(&mut dem, 300);
            assert!(dem.sphere_contact_count() > 3000);
            bits(&dem)
        })
    };
    let one = run(1);
    assert!(one == run(2));
    assert!(one == run(3));
    assert!(one == run(1));
}

/// A skin that everything leaves at once means a new list nearly every step;
/// a wide one means hardly any. The list only says where to look.
#[test]
fn history_survives_new_lists() {
    let [narrow, usual, wide] = [1e-5, SKIN, 1.0].map(|skin| {
        let mut dem = busy(1500, skin);
        advance(&mut dem, 300);
        let sheared = dem.contacts().filter(|c| c.shear.norm() > 0.0).count();
        assert!(sheared > 1500, "{sheared}");
        bits(&dem)
    });
    assert!(narrow == usual);
    assert!(wide == usual);
}

/// The state goes through the bytes of a checkpoint, once between two steps
/// and once between forces and motion.
#[test]
fn a_restart_changes_no_bit() {
    let mut dem = busy(1500, SKIN);
    advance(&mut dem, 50);
    let rough = *dem.wall_material();
    let restart = |dem: &Dem| {
        let state = postcard::from_bytes(&bits(dem)).unwrap();
        Dem::from_state(state, material(), rough, options(SKIN)).unwrap()
    };
    let mut again = restart(&dem);
    advance(&mut dem, 100);
    advance(&mut again, 100);
    assert!(bits(&dem) == bits(&again));

    dem.compute_contacts().unwrap();
    let mut again = restart(&dem);
    advance(&mut dem, 100);
    advance(&mut again, 100);
    assert!(bits(&dem) == bits(&again));
}

/// Forces may be asked for twice: the shear forces follow a step only once.
#[test]
fn computing_contacts_twice_changes_nothing() {
    let mut dem = busy(600, SKIN);
    advance(&mut dem, 20);
    dem.compute_contacts().unwrap();
    let (once, forces) = (bits(&dem), dem.forces());
    dem.compute_contacts().unwrap();
    assert!(once == bits(&dem));
    assert!(forces == dem.forces());
}

/// A compaction continues from its serialized self.
#[test]
fn a_compaction_can_be_interrupted() {
    let mut dem = twin(400, 2, options(SKIN));
    let mut growth = GrowthCompaction::new(GrowthOptions::new(1e4, 1e6)).unwrap();
    for _ in 0..137 {
        growth.step(&mut dem).unwrap();
    }
    let bytes = postcard::to_stdvec(&(dem.state(), &growth)).unwrap();
    let (state, mut growth_again): (_, GrowthCompaction) = postcard::from_bytes(&bytes).unwrap();
    let mut again =
        Dem::from_state(state, material(), frictionless_walls(), options(SKIN)).unwrap();
    for _ in 0..200 {
        growth.step(&mut dem).unwrap();
        growth_again.step(&mut again).unwrap();
    }
    assert!(bits(&dem) == bits(&again));
    assert_eq!(growth, growth_again);
}
