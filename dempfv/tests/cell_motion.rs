//! A periodic cell in motion: momentum, energy, the servo, and the same bits.

mod dem_support;

use dem_support::{bits, cloud, material};
use dempfv::dem::law::Linear;
use dempfv::dem::{
    CellControl, CellControls, Dem, DemOptions, GrowthCompaction, GrowthOptions, Material,
    Particles,
};
use dempfv::{Cell, Tensor, Vec3};

fn unit() -> Cell {
    Cell::of_size(Vec3::repeat(1.0)).unwrap()
}

/// A gas of spheres without total momentum, in a unit cell that it fills.
fn gas(count: usize, friction_angle: f64) -> Dem {
    let mut p = cloud(count, 5);
    for i in 0..p.len() {
        let wave = |k: f64| (k * 1e5 * p.radius[i]).sin();
        p.velocity[i] = Vec3::new(wave(1.0), wave(2.0), wave(3.0));
        p.spin[i] = 20.0 * Vec3::new(wave(4.0), wave(5.0), wave(6.0));
    }
    let mass: f64 = p.mass.iter().sum();
    let momentum: Vec3 = p.mass.iter().zip(&p.velocity).map(|(&m, v)| m * v).sum();
    p.velocity.iter_mut().for_each(|v| *v -= momentum / mass);
    let m = Material { friction_angle, ..material() };
    Dem::in_cell(Linear, p, unit(), &[m], DemOptions::default()).unwrap()
}

fn rates(gradient: Tensor) -> CellControls {
    [0, 1, 2].map(|a| [0, 1, 2].map(|b| CellControl::Rate(gradient[(a, b)])))
}

/// What one sphere gets its partner loses, across faces too.
#[test]
fn momentum_is_conserved() {
    for gradient in [Tensor::zeros(), Tensor::new(0.1, 0.7, 0.0, 0.0, -0.2, 0.0, 0.3, 0.0, 0.0)] {
        let mut dem = gas(1000, 0.5);
        dem.set_cell_controls(rates(gradient)).unwrap();
        let size: f64 = {
            let p = dem.storage();
            p.mass.iter().zip(&p.velocity).map(|(m, v)| m * v.norm()).sum()
        };
        let mut contacts = 0;
        for _ in 0..5000 {
            dem.step(2e-4).unwrap();
            contacts = contacts.max(dem.sphere_contact_count());
        }
        assert!(contacts > 10, "only {contacts} contacts at a time: no test");
        assert!(dem.momentum().norm() < 1e-12 * size, "{:e}", dem.momentum().norm() / size);
    }
}

/// Kinetic energy of the velocities at the time of the positions, v + F/m Δt/2, and elastic (J).
fn energy(dem: &Dem, dt: f64) -> f64 {
    let p = dem.storage();
    let each = (0..p.len()).map(|i| {
        let v = p.velocity[i] + dem.storage_forces()[i] * (0.5 * dt / p.mass[i]);
        0.5 * p.mass[i] * v.norm_squared()
    });
    each.sum::<f64>() + dem.elastic_energy()
}

/// In a cell at rest an elastic gas has the energy that it had, within 1e-4 at 64 steps to the
/// shortest collision.
#[test]
fn the_energy_of_a_gas_does_not_drift() {
    let mut dem = gas(1000, 0.0);
    let dt = dem.collision_time_step() / 4.0;
    dem.compute_contacts().unwrap();
    let first = energy(&dem, dt);
    let mut contacts = 0;
    for _ in 0..10_000 {
        dem.step(dt).unwrap();
        contacts = contacts.max(dem.sphere_contact_count());
    }
    assert!(contacts > 10, "only {contacts} contacts at a time: no test");
    dem.compute_contacts().unwrap();
    let change = energy(&dem, dt) / first - 1.0;
    println!("{change:e}");
    assert!(change.abs() < 1e-4, "{change:e}");
}

/// Without collisions a cell that closes alike in all directions heats an ideal gas along its
/// adiabat, E V^(2/3) = const, to round-off.
#[test]
fn an_ideal_gas_follows_its_adiabat() {
    let mut dem = gas(200, 0.0);
    dem.scale_radii(1e-3).unwrap();
    dem.set_cell_controls(rates(-Tensor::identity())).unwrap();
    let constant = |dem: &Dem| dem.translational_energy() * dem.volume().powf(2.0 / 3.0);
    let first = constant(&dem);
    for _ in 0..2000 {
        dem.step(2e-4).unwrap();
        assert_eq!(dem.sphere_contact_count(), 0);
    }
    // 2,000 steps of 2e-4 s at 1/s: (1 − 2e-4)^2000 along each axis.
    assert!((dem.volume() / 0.9998f64.powi(6000) - 1.0).abs() < 1e-10);
    assert!((constant(&dem) / first - 1.0).abs() < 1e-10);
}

/// With collisions, compression and shear: the energy grows by the work −V σ:L of the stress of
/// contacts and motion together.
#[test]
fn work_on_the_cell_is_what_the_gas_gains() {
    let dt = 1e-4;
    let mut dem = gas(1000, 0.0);
    let gradient = Tensor::new(-0.4, 1.0, 0.0, 0.0, -0.1, 0.0, 0.0, 0.3, 0.2);
    dem.set_cell_controls(rates(gradient)).unwrap();
    dem.compute_contacts().unwrap();
    let first = energy(&dem, dt);
    let mut work = 0.0;
    for _ in 0..8000 {
        dem.compute_contacts().unwrap();
        let power = |dem: &Dem| {
            let stress = dem.stress_in_cell() + dem.kinetic_stress();
            -dem.volume() * stress.component_mul(&gradient).sum()
        };
        // σ > 0 in compression: the work of closing is that of L < 0.
        work += dt * power(&dem);
        dem.integrate(dt, None, None).unwrap();
    }
    dem.compute_contacts().unwrap();
    let gain = energy(&dem, dt) - first;
    println!("{:e} {:e} {:e}", first, gain, work);
    assert!(gain > 0.3 * first, "{gain} {first}");
    assert!((work / gain - 1.0).abs() < 1e-3, "{}", work / gain);
}

fn damped(skin: f64) -> DemOptions {
    DemOptions { damping: 0.2, skin, ..DemOptions::default() }
}

fn stresses(normal: [f64; 3]) -> CellControls {
    let mut controls = CellControls::default();
    for (k, stress) in normal.into_iter().enumerate() {
        controls[k][k] = CellControl::Stress(stress);
    }
    controls
}

fn total(dem: &Dem) -> Tensor {
    dem.stress_in_cell() + dem.kinetic_stress()
}

/// A loose cloud that the servo closes on, at stresses of 10⁻⁴ to 10⁻² of the modulus, unequal
/// ones too: each is there within 0.1 % and stays, in each step.
#[test]
fn the_servo_reaches_its_stresses_and_stays() {
    for goal in [[1e2; 3], [1e3; 3], [1e4; 3], [1e3, 2e3, 1.5e3]] {
        let mut dem =
            Dem::in_cell(Linear, cloud(500, 4), unit(), &[material()], damped(0.1)).unwrap();
        dem.set_cell_controls(stresses(goal)).unwrap();
        let miss = |dem: &Dem| {
            let at = total(dem);
            (0..3).map(|k| (at[(k, k)] / goal[k] - 1.0).abs()).fold(0.0, f64::max)
        };
        let (mut steps, mut there) = (0, 0);
        while there < 2000 {
            dem.step_auto(0.8).unwrap();
            steps += 1;
            there = if miss(&dem) < 1e-3 { there + 1 } else { 0 };
            assert!(steps < 100_000, "{goal:?}: {:e} {}", miss(&dem), dem.porosity());
        }
        let mut worst: f64 = 0.0;
        for _ in 0..5000 {
            dem.step_auto(0.8).unwrap();
            worst = worst.max(miss(&dem));
        }
        let unbalanced = dem.unbalanced_force(None).unwrap();
        println!(
            "{goal:?}: {steps} steps, {worst:e}, unbalanced {unbalanced:e}, {}",
            dem.porosity()
        );
        assert!(worst < 1e-3, "{goal:?}: {worst:e}");
        assert!(dem.coordination_number() > 3.0);
    }
}

/// A packing in the cell, compacted to 10 kPa.
fn packed(count: usize, skin: f64) -> Dem {
    let mut dem =
        Dem::in_cell(Linear, cloud(count, 2), unit(), &[material()], damped(skin)).unwrap();
    GrowthCompaction::new(GrowthOptions::new(1e4, 1e6)).unwrap().run(&mut dem).unwrap();
    dem.sort_spatially().unwrap();
    dem
}

/// Simple shear at a constant normal stress, far past the peak: σ_yy within 0.1 % in the mean, and
/// a friction that granular matter has.
#[test]
fn shear_at_a_constant_normal_stress() {
    let mut dem = packed(800, 0.1);
    let mut controls = CellControls::default();
    controls[1][1] = CellControl::Stress(1e4);
    controls[0][1] = CellControl::Rate(0.5);
    dem.set_cell_controls(controls).unwrap();
    let (mut sum, mut worst, mut friction, mut steps) = (0.0, 0.0f64, 0.0, 0);
    while dem.cell().unwrap().strain()[(0, 1)] < 1.0 {
        dem.step_auto(0.8).unwrap();
        if dem.cell().unwrap().strain()[(0, 1)] > 0.1 {
            let at = total(&dem);
            sum += at[(1, 1)] / 1e4;
            worst = worst.max((at[(1, 1)] / 1e4 - 1.0).abs());
            friction -= at[(0, 1)] / at[(1, 1)];
            steps += 1;
        }
    }
    let (mean, friction) = (sum / f64::from(steps), friction / f64::from(steps));
    println!(
        "{steps} steps: mean {mean}, worst {worst}, friction {friction}, n {}",
        dem.porosity()
    );
    assert!((mean - 1.0).abs() < 1e-3, "{mean}");
    assert!(worst < 0.2, "{worst}");
    assert!((0.25..0.6).contains(&friction), "{friction}");
}

/// Spheres under shear, at a stress, with friction and across faces.
fn busy(count: usize, skin: f64) -> Dem {
    let mut dem =
        Dem::in_cell(Linear, cloud(count, 2), unit(), &[material()], damped(skin)).unwrap();
    let mut growth = GrowthCompaction::new(GrowthOptions::new(1e4, 1e6)).unwrap();
    for _ in 0..600 {
        growth.step(&mut dem).unwrap();
    }
    dem.sort_spatially().unwrap();
    let mut controls = stresses([2e4, 1e4, 1e4]);
    controls[0][1] = CellControl::Rate(20.0);
    controls[2][0] = CellControl::Rate(-3.0);
    dem.set_cell_controls(controls).unwrap();
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
            let mut dem = busy(3000, 0.2);
            advance(&mut dem, 300);
            assert!(dem.sphere_contact_count() > 3000);
            bits(&dem)
        })
    };
    let one = run(1);
    assert!(one == run(2));
    assert!(one == run(3));
}

/// New lists in nearly every step or hardly any: spheres are put back into the cell, and its edges
/// shortened, when they have gone far, whatever the list.
#[test]
fn history_survives_new_lists_and_new_edges() {
    let [narrow, usual, wide] = [1e-5, 0.2, 0.6].map(|skin| {
        let mut dem = busy(1500, skin);
        let edges = dem.cell().unwrap().cell().edges();
        advance(&mut dem, 600);
        let [now, before] = [dem.cell().unwrap().cell().edges()[1].x, edges[1].x];
        assert!(before == 0.0 && now < 0.3, "600 steps of 20/s: 1.2, so once shortened: {now}");
        let sheared = dem.contacts().filter(|c| c.shear.norm() > 0.0).count();
        assert!(sheared > 1500, "{sheared}");
        bits(&dem)
    });
    assert!(narrow == usual);
    assert!(wide == usual);
}

/// The state goes through the bytes of a checkpoint, once between two steps and once between forces
/// and motion, at moments before and after spheres were put back.
#[test]
fn a_restart_changes_no_bit() {
    let mut dem = busy(1500, 0.2);
    for wait in [50, 150, 150, 200] {
        advance(&mut dem, wait);
        for between in [false, true] {
            if between {
                dem.compute_contacts().unwrap();
            }
            let state = postcard::from_bytes(&bits(&dem)).unwrap();
            let walls = *dem.wall_material();
            let mut again = Dem::from_state(state, material(), walls, damped(0.2)).unwrap();
            let state = postcard::from_bytes(&bits(&dem)).unwrap();
            let mut straight = Dem::from_state(state, material(), walls, damped(0.2)).unwrap();
            advance(&mut again, 60);
            straight.compute_contacts().unwrap();
            advance(&mut straight, 60);
            assert!(bits(&again) == bits(&straight));
            advance(&mut dem, 60);
            assert!(bits(&dem) == bits(&again), "{wait} {between}");
        }
    }
}

/// Forces may be asked for twice, with the cell in motion.
#[test]
fn computing_contacts_twice_changes_nothing() {
    let mut dem = busy(600, 0.2);
    advance(&mut dem, 20);
    dem.compute_contacts().unwrap();
    let (once, forces, stress) = (bits(&dem), dem.forces(), dem.stress_in_cell());
    dem.compute_contacts().unwrap();
    assert!(once == bits(&dem) && forces == dem.forces() && stress == dem.stress_in_cell());
    // One look at the contacts from outside finds the same tensor.
    assert!((dem.stress() - stress).norm() < 1e-12 * stress.norm());
}

/// Growth in a cell of any shape ends at the stress asked for, at rest.
#[test]
fn radii_grow_in_a_skew_cell() {
    let edges = [Vec3::x(), Vec3::new(0.4, 0.9, 0.0), Vec3::new(-0.3, 0.2, 1.1)];
    let cell = Cell::new(edges).unwrap();
    let p = cloud(300, 7);
    let inside: Vec<Vec3> = p.position.iter().map(|x| cell.matrix() * x).collect();
    let radii = p.radius.iter().map(|r| 0.8 * r).collect();
    let p = Particles::new(inside, radii, 2600.0);
    let mut dem = Dem::in_cell(Linear, p, cell, &[material()], damped(0.1)).unwrap();
    let status =
        GrowthCompaction::new(GrowthOptions::new(1e4, 1e6)).unwrap().run(&mut dem).unwrap();
    assert!((status.stress / 1e4 - 1.0).abs() < 1e-3 && status.unbalanced < 1e-3);
    let stress = dem.stress();
    let deviator = stress - stress.trace() / 3.0 * Tensor::identity();
    assert!(deviator.norm() < 0.3 * stress.trace(), "{stress}");
    assert!((0.3..0.45).contains(&dem.porosity()), "{}", dem.porosity());
    let all = dem.wrapped_positions();
    assert!(all.iter().all(|x| cell.fractions(x).iter().all(|f| (-1e-9..1.0).contains(f))));
}
