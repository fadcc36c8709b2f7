//! The mass of a compressible fluid that is shut in while its packing deforms: what its pores take up
//! is what their volumes change by, over many networks, however these are renewed.

mod cell_support;
mod common;
mod moving;

use std::f64::consts::PI;

use common::{Spheres, settled};
use dempfv::coupling::{
    Acceleration, Coupled, FluidEffects, RemeshMode, RemeshRule, Saturation, Update,
};
use dempfv::dem::{CellControl, Dem, DemOptions, Material, Particles, WallControl, WallMaterial};
use dempfv::pfv::{Boundary, Clamp, Fluid};
use dempfv::scene::Plan;
use dempfv::simulation::Simulation;
use dempfv::solver::SolverKind;
use dempfv::{Tensor, WallId};
use moving::every;

/// Bulk modulus of the fluid (Pa): that of the skeleton, about.
const MODULUS: f64 = 1e6;
/// Length of a step (s): a third of the automatic one.
const DT: f64 = 1e-5;

/// The settled packing without a way out for its water.
fn shut(rule: RemeshRule, acceleration: Acceleration) -> Coupled {
    let Spheres { x, r, bounds, .. } = settled();
    let material =
        Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };
    let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
    let options = DemOptions { damping: 0.3, ..DemOptions::default() };
    let particles = Particles::new(x, r, material.density);
    let dem = Dem::new(particles, bounds, material, walls, options).unwrap();
    let boundary = Boundary::default();
    let fluid = Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary };
    let mut coupled = Coupled::new(dem);
    coupled.saturate(Saturation { fluid, solver: SolverKind::default(), remesh: rule });
    coupled
        .set_fluid_effects(FluidEffects { bulk_modulus: Some(MODULUS), ..FluidEffects::default() });
    coupled.accelerate(acceleration);
    coupled
}

/// What the books of a run say.
#[derive(Default)]
struct Books {
    /// What all pores have grown by in the steps' balances (m³).
    grown: f64,
    /// What the box has grown by until the last step began (m³).
    box_grown: f64,
    /// What the fluid is compressed by, Σ V_void p / K_f (m³); not for networks of earlier positions.
    compressed: f64,
    /// The worst of all steps of how far these are from each other (m³).
    worst: f64,
    networks: u64,
}

/// Makes steps and keeps the books.
fn keep_books(coupled: &mut Coupled, steps: usize) -> Books {
    let Acceleration { remesh, update, .. } = *coupled.acceleration();
    let volume = |coupled: &Coupled| coupled.dem().box_().volume();
    let (start, mut books, mut void) = (volume(coupled), Books::default(), vec![]);
    for _ in 0..steps {
        let (position, before) = (coupled.dem().storage().position.clone(), volume(coupled));
        coupled.step(DT).unwrap();
        let flow = coupled.storage_flow().unwrap();
        books.grown += flow.volume_rate().iter().sum::<f64>() * DT;
        books.box_grown = before - start;
        books.worst = (books.grown - books.box_grown).abs().max(books.worst);
        if remesh == RemeshMode::AtOnce {
            if coupled.remeshes() != books.networks || update == Update::EveryStep {
                let radius = &coupled.dem().storage().radius;
                void = flow.network().void_volumes(&position, radius).unwrap();
            }
            books.compressed = void.iter().zip(flow.pressure()).map(|(v, p)| v * p / MODULUS).sum();
            books.worst = (books.compressed + books.box_grown).abs().max(books.worst);
        }
        books.networks = coupled.remeshes();
    }
    books
}

/// Steps in which the box gets 10 % shorter and 11 % wider: a thousandth of its volume goes. In the first
/// order of the strain it would win ten times as much.
const STEPS: usize = 1000;

fn shear(coupled: &mut Coupled) {
    let size = coupled.dem().box_().size();
    let speed = |way: f64| way / (STEPS as f64 * DT);
    let mut controls = coupled.controls();
    controls.set_control(WallId::YMax, WallControl::Velocity(speed(-0.10 * size.y))).unwrap();
    controls.set_control(WallId::XMax, WallControl::Velocity(speed(0.11 * size.x))).unwrap();
}

/// A shut packing that is sheared by a tenth, with networks that live for 20 steps to all of them, at
/// once, ahead, by strain, and such that follow the spheres. In every step the fluid is compressed by
/// what the box has lost, to 1e-10 of that, or 1e-5 where the pressures are iterated to 1e-6. At the end
/// the pressure is K_f (V₀/V − 1) of the box less its spheres: within 1e-4 where networks follow the
/// spheres, 1e-3 where they are renewed by strain, and 0.5 % with all others.
#[test]
fn sheared_water_is_not_lost() {
    let at_once = Acceleration::default();
    let follows = Acceleration { update: Update::EveryStep, ..at_once };
    let strain = RemeshRule { interval: None, strain: Some(0.1) };
    let ways = [
        (every(100), follows, 1e-5, 1e-4),
        (strain, at_once, 1e-10, 1e-3),
        (every(20), at_once, 1e-10, 0.005),
        (every(100), at_once, 1e-10, 0.005),
        (every(100), Acceleration { parallel_tasks: true, ..at_once }, 1e-10, 0.005),
        (every(100), Acceleration { remesh: RemeshMode::Ahead, ..at_once }, 1e-10, 0.005),
        (every(100_000), at_once, 1e-10, 0.005),
    ];
    let solid: f64 = settled().r.iter().map(|r| 4.0 / 3.0 * PI * r.powi(3)).sum();
    for (rule, acceleration, mass, pressure) in ways {
        let mut coupled = shut(rule, acceleration);
        shear(&mut coupled);
        let before = coupled.dem().box_().volume();
        let books = keep_books(&mut coupled, STEPS);
        let case = format!("{rule:?} {acceleration:?}");
        let lost = -books.box_grown;
        assert!(lost > 9e-4 * before, "{case}: {lost:e} of {before:e}");
        assert!(books.worst < mass * lost, "{case}: {:e} of {lost:e}", books.worst);
        let off = coupled.mean_pressure() / (MODULUS * lost / (before - lost - solid)) - 1.0;
        assert!(off.abs() < pressure, "{case}: {off:e}");
    }
}

/// The same where servos move the walls: six of them, that of y asking for a third more than the others.
#[test]
fn water_between_servo_walls_is_not_lost() {
    for interval in [10, 100] {
        let mut coupled = shut(every(interval), Acceleration::default());
        for wall in WallId::ALL {
            let stress = if wall.axis() == 1 { 4e3 } else { 3e3 };
            let servo = WallControl::Servo { stress, max_velocity: None };
            coupled.controls().set_control(wall, servo).unwrap();
        }
        let books = keep_books(&mut coupled, STEPS);
        let moved = coupled.dem().walls().map(|wall| wall.displacement.abs());
        assert!(books.compressed > 0.0 && moved.values().all(|way| *way > 0.0));
        assert!(books.worst < 1e-10 * books.grown.abs(), "{interval}: {:e}", books.worst);
    }
}

/// Each pore by itself: over 300 steps of one network it takes up what its volume changes by, to 1e-12
/// of the mean volume.
#[test]
fn each_pore_takes_up_its_growth() {
    let mut coupled = shut(every(100_000), Acceleration::default());
    shear(&mut coupled);
    let (mut grown, mut last) = (vec![], vec![]);
    for _ in 0..300 {
        let (position, bounds) = (coupled.dem().storage().position.clone(), coupled.dem().box_());
        coupled.step(DT).unwrap();
        let flow = coupled.storage_flow().unwrap();
        grown.resize(flow.network().pores(), 0.0);
        grown.iter_mut().zip(flow.volume_rate()).for_each(|(sum, rate)| *sum += rate * DT);
        last = flow.network().volumes_at(&position, &bounds).unwrap();
    }
    let built = coupled.storage_flow().unwrap().built_volume();
    let mean = built.iter().sum::<f64>() / built.len() as f64;
    for ((grown, last), built) in grown.iter().zip(&last).zip(built) {
        let off = (last - built - grown) / mean;
        assert!(off.abs() < 1e-12, "{off:e}");
    }
}

/// A periodic cell that is sheared while it closes, by a hundredth in 200 steps: its pores together grow
/// as it does in every step, whichever copies of its spheres are looked at, to 1e-12 of its volume.
#[test]
fn a_periodic_cell_loses_none() {
    let mut coupled = Coupled::new(cell_support::settled(3));
    let (fluid, solver) = (cell_support::FLUID, SolverKind::default());
    coupled.saturate(Saturation { fluid, solver, remesh: every(50) });
    let effects = FluidEffects { bulk_modulus: Some(MODULUS), ..FluidEffects::default() };
    coupled.set_fluid_effects(effects);
    let gradient = Tensor::new(-10.0, 50.0, 0.0, 0.0, -20.0, 0.0, 0.0, 0.0, 20.0);
    let controls = [0, 1, 2].map(|a| [0, 1, 2].map(|b| CellControl::Rate(gradient[(a, b)])));
    coupled.controls().set_cell_controls(controls).unwrap();
    let (start, mut grown) = (coupled.dem().volume(), 0.0);
    for step in 0..200 {
        let before = coupled.dem().volume();
        coupled.step(5e-6).unwrap();
        grown += coupled.storage_flow().unwrap().volume_rate().iter().sum::<f64>() * 5e-6;
        let off = (grown - (before - start)) / start;
        assert!(off.abs() < 1e-12, "step {step}: {off:e}");
    }
    assert!(grown < -0.009 * start && coupled.mean_pressure() > 0.0, "{grown:e} {start:e}");
}

/// A cell of 40 spheres that is sheared by 0.6 with one network, whose pores reach through nearly half
/// of it, and exchanges its edges on the way: a pore that took its sphere for another copy would make
/// K_f times its share of the cell of pressure out of nothing (1 MPa was seen). The network is beyond
/// what its volumes are known for, so that rates of the first order have the rest: what the cell
/// gains or loses by them stays of the order of the cell's own change, a hundredth.
#[test]
fn a_small_cell_keeps_its_pores_through_a_large_shear() {
    let text = "seed = 1\n[cell]\nsize = [0.1, 0.1, 0.1]\n\
        [particles]\ncloud = { count = 40, spread = 0.1, porosity = 0.75 }\nyoung = 1.0e7\n\
        [dem]\ndamping = 0.2\n\
        [fluid]\nviscosity = 1e-3\nbulk_modulus = 1e6\nremesh_interval = 20000\n\
        [[stage]]\nkind = \"compact\"\nstress = 1.0e4\nfriction_angle = 10.0\n\
        [[stage]]\nkind = \"run\"\nname = \"shear\"\ntime = 0.3\n\
        velocity_gradient = { xy = 2.0, xx = 0.05, yy = -0.1, zz = 0.05 }\n";
    let mut simulation = Simulation::new(Plan::from_toml(text, None).unwrap()).unwrap();
    let mut most = 0.0f64;
    while simulation.advance().unwrap() {
        most = most.max(simulation.coupled().mean_pressure().abs());
    }
    assert!(simulation.coupled().dem().cell().unwrap().strain()[(0, 1)] > 0.55);
    assert!(most < 1e-2 * MODULUS, "{most:e}");
}
