//! Energy by cause in a periodic cell: the cell's work against contacts and motion is found again.

mod cell_support;
mod dem_support;

use cell_support::settled;
use dem_support::{bits, cloud, material};
use dempfv::dem::law::Linear;
use dempfv::dem::{CellControl, CellControls, Dem, DemOptions, EnergyBalance, Material};
use dempfv::{Cell, Tensor, Vec3};

fn balance(dem: &Dem) -> EnergyBalance {
    dem.energy_balance().unwrap()
}

fn rates(gradient: Tensor) -> CellControls {
    [0, 1, 2].map(|a| [0, 1, 2].map(|b| CellControl::Rate(gradient[(a, b)])))
}

/// A gas without friction that is compressed and sheared: what it gains is the cell's work, and the
/// residual falls with the time step.
#[test]
fn a_compressed_gas_has_the_work_of_the_cell() {
    let mut last = f64::INFINITY;
    for (steps, dt) in [(500, 2e-4), (1000, 1e-4), (2000, 5e-5)] {
        let mut p = cloud(500, 5);
        for i in 0..p.len() {
            let wave = |k: f64| (k * 1e5 * p.radius[i]).sin();
            p.velocity[i] = Vec3::new(wave(1.0), wave(2.0), wave(3.0));
        }
        let m = Material { friction_angle: 0.0, ..material() };
        let unit = Cell::of_size(Vec3::repeat(1.0)).unwrap();
        let mut dem = Dem::in_cell(Linear, p, unit, &[m], DemOptions::default()).unwrap();
        dem.set_cell_controls(rates(Tensor::new(-1.0, 1.0, 0.0, 0.0, -0.5, 0.0, 0.0, 0.7, -0.8)))
            .unwrap();
        dem.track_energy(true);
        for _ in 0..steps {
            dem.step(dt).unwrap();
        }
        let b = balance(&dem);
        let share = b.residual.abs() / b.moved();
        println!("{dt:e}: {share:e} {b:?}");
        assert!(b.cell_work > 1.0 && b.elastic > 0.0, "{b:?}");
        assert!(share < 0.6 * last, "{share} after {last}");
        last = share;
    }
    assert!(last < 1e-5, "{last}");
}

/// A packing with friction that is sheared while a servo holds its stress. At the automatic time step
/// the balance closes to 1e-6 of what was moved, with contacts that come and go in each step, and the
/// better the shorter the step; the ledger has the same bits on any number of threads and after a
/// restart.
#[test]
fn a_sheared_packing_is_balanced() {
    let sheared = |safety: f64, threads: usize, restarts: bool| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut dem = settled(1);
            dem.track_energy(true);
            let mut controls = rates(Tensor::new(0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0));
            for (k, row) in controls.iter_mut().enumerate() {
                row[k] = CellControl::Stress(1e3);
            }
            dem.set_cell_controls(controls).unwrap();
            let dt = dem.contact_time_step(safety).unwrap();
            for k in 0..(2000.0 * 0.8 / safety) as usize {
                dem.step(dt).unwrap();
                if restarts && k % 300 == 0 {
                    let options = *dem.options();
                    let (material, walls) = (*dem.material(), *dem.wall_material());
                    dem = Dem::from_state(dem.state(), material, walls, options).unwrap();
                }
            }
            dem
        })
    };
    let share = |dem: &Dem| {
        let b = balance(dem);
        println!("{:e} {b:?}", b.residual / b.moved());
        assert!(b.friction > 0.1 * b.cell_work && b.local_damping > 0.0, "{b:?}");
        b.residual.abs() / b.moved()
    };
    let dem = sheared(0.8, 1, false);
    let (whole, quarter) = (share(&dem), share(&sheared(0.2, 1, false)));
    assert!(whole < 1e-6 && quarter < 0.4 * whole, "{whole:e} {quarter:e}");
    for (threads, restarts) in [(3, false), (1, true)] {
        let again = sheared(0.8, threads, restarts);
        assert_eq!(bits(&again), bits(&dem), "{threads} threads, restarts {restarts}");
        assert_eq!(balance(&again), balance(&dem));
    }
}

/// A packing under 1 kPa that is pressed together and let go by turns. The forces of a pass act over half
/// a step at the rate before it and half a step at that after it: at the latter alone, the work would be
/// wrong by ½ p ΔL dt at each change of the rate, a thousandth of all in these 500 steps.
#[test]
fn the_work_of_the_cell_is_at_the_rates_before_and_after() {
    let mut dem = settled(1);
    dem.track_energy(true);
    let dt = dem.contact_time_step(0.8).unwrap();
    for k in 0..500 {
        let rate = if k / 25 % 4 < 3 { -0.5 } else { 0.3 };
        dem.set_cell_controls(rates(Tensor::from_diagonal_element(rate))).unwrap();
        dem.step(dt).unwrap();
    }
    let b = balance(&dem);
    println!("{:e} {b:?}", b.residual / b.moved());
    assert!(b.elastic > 0.1 * b.cell_work && b.cell_work > 1e-6, "{b:?}");
    assert!(b.residual.abs() < 1e-6 * b.moved(), "{b:?}");
}
