//! Hard cases 7, 9 and 10: the unit of length, mass and time, a box far from the origin, thin
//! boxes, and viscosities and time steps of any size. The same problem has the same answer, bit for
//! bit for powers of two; where double precision has no digits for it, it is refused with that
//! reason.

mod common;

use common::{Random, Spheres, cubic, settled};
use dempfv::coupling::{Coupled, RemeshRule, Saturation};
use dempfv::dem::{Dem, DemOptions, Material, Particles, WallControl, WallMaterial};
use dempfv::pfv::{Boundary, Clamp, Flow, Fluid, PfvError};
use dempfv::solver::SolverKind;
use dempfv::{Aabb, Vec3, WallId};

fn along_y(viscosity: f64) -> Fluid {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMin] = Some(1.0);
    boundary.pressure[WallId::YMax] = Some(0.0);
    Fluid { viscosity, slip_walls: true, clamp: Clamp::None, boundary }
}

/// The same spheres in a unit of length that is this many times smaller.
fn scaled(s: &Spheres, factor: f64) -> Spheres {
    Spheres {
        x: s.x.iter().map(|x| factor * x).collect(),
        r: s.r.iter().map(|r| factor * r).collect(),
        bounds: Aabb { min: factor * s.bounds.min, max: factor * s.bounds.max },
    }
}

fn solved(s: &Spheres, viscosity: f64, solver: SolverKind) -> Result<Flow, PfvError> {
    let mut flow = Flow::new(&s.x, &s.r, s.bounds, &along_y(viscosity), solver)?;
    // All digits that the solver has: the default leaves 1e-11.
    flow.set_tolerance(1e-15)?;
    flow.solve_static()?;
    Ok(flow)
}

fn permeability(flow: &Flow) -> f64 {
    flow.permeability(WallId::YMin).unwrap().value
}

/// Largest difference of two lists, relative to the largest number.
fn difference<'a>(
    a: impl Iterator<Item = &'a f64> + Clone,
    b: impl Iterator<Item = &'a f64>,
    factor: f64,
) -> f64 {
    let largest = a.clone().fold(0.0f64, |m, x| m.max(x.abs()));
    a.zip(b).map(|(a, b)| (a - b / factor).abs()).fold(0.0, f64::max) / largest
}

/// Metres, millimetres, micrometres and kilometres, and powers of two between: pores, volumes,
/// pressures, forces and permeability are those of the unit.
#[test]
fn a_static_flow_is_the_same_in_any_unit_of_length() {
    let s = settled();
    for solver in [SolverKind::Cholmod, SolverKind::Frontal] {
        let one = solved(&s, 1e-3, solver).unwrap();
        let components = |flow: &Flow| -> Vec<f64> {
            flow.force().iter().flat_map(|f| [f.x, f.y, f.z]).collect()
        };
        for factor in
            [0.5f64.powi(40), 0.5f64.powi(10), 2f64.powi(10), 2f64.powi(40), 1e-12, 1e-3, 1e3, 1e6]
        {
            let other = solved(&scaled(&s, factor), 1e-3, solver).unwrap();
            let (n, m) = (one.network(), other.network());
            assert_eq!(n.tessellation, m.tessellation, "{factor}");
            let found = [
                difference(n.volume.iter(), m.volume.iter(), factor.powi(3)),
                difference(
                    n.throats.conductance.iter(),
                    m.throats.conductance.iter(),
                    factor.powi(3),
                ),
                difference(one.pressure().iter(), other.pressure().iter(), 1.0),
                difference(components(&one).iter(), components(&other).iter(), factor.powi(2)),
                (permeability(&other) / factor.powi(2) / permeability(&one) - 1.0).abs(),
            ];
            let exact = factor.log2().fract() == 0.0;
            // The largest conductances are those of pores whose centres nearly coincide: the
            // distance between these has lost digits.
            let bounds = if exact { [0.0; 5] } else { [5e-15, 1e-11, 5e-15, 5e-15, 5e-15] };
            assert!(found.iter().zip(&bounds).all(|(f, b)| f <= b), "{solver} {factor}: {found:?}");
        }
    }
}

/// Units of length, mass and time.
#[derive(Clone, Copy)]
struct Units {
    length: f64,
    mass: f64,
    time: f64,
}

/// Spheres that fly about, in these units, wet or dry.
fn flying(u: Units, wet: bool) -> Coupled {
    let mut s = cubic(4, 0.1);
    s.r.iter_mut().for_each(|r| *r *= 0.9);
    let s = scaled(&s, u.length);
    let (pressure, speed) = (u.mass / (u.length * u.time * u.time), u.length / u.time);
    let young = 1e6 * pressure;
    let density = 2600.0 * u.mass / u.length.powi(3);
    let material = Material { young, stiffness_ratio: 0.5, friction_angle: 0.5, density };
    let walls = WallMaterial { young, friction_angle: 0.0 };
    let gravity = Some(Vec3::new(0.0, -9.81, 0.0) * (speed / u.time));
    let options = DemOptions { gravity, ..DemOptions::default() };
    let spheres = Particles::new(s.x, s.r, density);
    let mut dem = Dem::new(spheres, s.bounds, material, walls, options).unwrap();
    let mut random = Random(5);
    for v in dem.storage_velocities_mut().0 {
        *v = 0.5 * speed * random.vector();
    }
    let servo = WallControl::Servo { stress: 100.0 * pressure, max_velocity: Some(0.1 * speed) };
    dem.set_control(WallId::YMax, servo).unwrap();
    let mut coupled = Coupled::new(dem);
    if wet {
        let mut fluid = along_y(pressure * u.time);
        fluid.boundary.pressure[WallId::YMin] = None;
        let remesh = RemeshRule { interval: Some(7), strain: None };
        coupled.saturate(Saturation { fluid, solver: SolverKind::default(), remesh });
    }
    coupled
}

/// Steps of a fixed and of the automatic length, dry and wet: the same bits in any units that are
/// powers of two of each other.
#[test]
fn steps_have_the_same_bits_in_any_units() {
    let course = |u: Units, wet: bool| {
        let mut coupled = flying(u, wet);
        let mut all = vec![];
        for step in 0..30 {
            let dt = match step % 2 {
                0 => coupled.step_auto(0.5).unwrap(),
                _ => coupled.step(1e-4 * u.time).map(|()| 1e-4 * u.time).unwrap(),
            };
            all.push(dt / u.time);
            let p = coupled.dem().storage();
            all.extend(p.position.iter().flat_map(|x| [x.x, x.y, x.z]).map(|x| x / u.length));
            let speed = u.length / u.time;
            all.extend(p.velocity.iter().flat_map(|v| [v.x, v.y, v.z]).map(|v| v / speed));
            let pressure = u.mass / (u.length * u.time * u.time);
            let flow = coupled.storage_flow();
            all.extend(flow.map_or(&[][..], |f| f.pressure()).iter().map(|p| p / pressure));
        }
        all
    };
    let two = |exponent: i32| 2f64.powi(exponent);
    for wet in [false, true] {
        let one = course(Units { length: 1.0, mass: 1.0, time: 1.0 }, wet);
        for (length, mass, time) in [(10, 0, 0), (-20, -30, 0), (0, 16, -8), (-10, 6, 12)] {
            let other =
                course(Units { length: two(length), mass: two(mass), time: two(time) }, wet);
            assert!(one == other, "wet: {wet}, 2^({length}, {mass}, {time})");
        }
    }
}

/// The packing where the origin is so many box lengths away.
fn shifted(s: &Spheres, lengths: f64) -> Spheres {
    let shift = Vec3::repeat(lengths * s.bounds.size().max());
    Spheres {
        x: s.x.iter().map(|x| x + shift).collect(),
        r: s.r.clone(),
        bounds: Aabb { min: s.bounds.min + shift, max: s.bounds.max + shift },
    }
}

fn dem_of(s: &Spheres) -> Result<Dem, dempfv::dem::DemError> {
    let material =
        Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };
    let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
    let spheres = Particles::new(s.x.clone(), s.r.clone(), material.density);
    Dem::new(spheres, s.bounds, material, walls, DemOptions::default())
}

/// What the rounding of coordinates to their spacing leaves of a permeability and of the contacts'
/// energy, or the refusal that names it.
#[test]
fn far_from_the_origin_digits_are_lost_by_the_spacing_alone_or_it_is_refused() {
    let s = settled();
    let k = permeability(&solved(&s, 1e-3, SolverKind::Cholmod).unwrap());
    let energy = |s: &Spheres| {
        let mut dem = dem_of(s)?;
        dem.compute_contacts()?;
        Ok::<f64, dempfv::dem::DemError>(dem.elastic_energy())
    };
    let near = energy(&s).unwrap();
    let smallest = s.r.iter().copied().fold(f64::INFINITY, f64::min);
    for lengths in [1e3, 1e6, 1e9] {
        let far = shifted(&s, lengths);
        let spacing = far.bounds.max.x.next_up() - far.bounds.max.x;
        let off = permeability(&solved(&far, 1e-3, SolverKind::Cholmod).unwrap()) / k - 1.0;
        assert!(
            off.abs() <= 10.0 * spacing / smallest,
            "{lengths:e}: {off:e}, spacing {spacing:e}"
        );
    }
    for lengths in [1e3, 1e6] {
        let far = shifted(&s, lengths);
        let spacing = far.bounds.max.x.next_up() - far.bounds.max.x;
        // Overlaps are some 1e-3 of a radius.
        let off = energy(&far).unwrap() / near - 1.0;
        assert!(off.abs() <= 1e4 * spacing / smallest, "{lengths:e}: {off:e}, spacing {spacing:e}");
    }
    let refused = solved(&shifted(&s, 1e12), 1e-3, SolverKind::Cholmod).unwrap_err().to_string();
    assert!(refused.contains("lost their digits"), "{refused}");
    for lengths in [1e9, 1e12] {
        let refused = energy(&shifted(&s, lengths)).unwrap_err().to_string();
        assert!(refused.contains("lost their digits"), "{refused}");
    }
}

/// Two spheres in a plate a millionth as thick as long: pores fill the plate, and what enters at one
/// end leaves at the other.
#[test]
fn a_thin_plate_is_filled_with_pores() {
    let bounds = Aabb { min: Vec3::zeros(), max: Vec3::new(1.0, 1e-6, 1.0) };
    let x = [Vec3::new(0.25, 5e-7, 0.5), Vec3::new(0.6, 5e-7, 0.4)];
    let mut fluid = along_y(1e-3);
    fluid.boundary.pressure = Boundary::default().pressure;
    fluid.boundary.pressure[WallId::XMin] = Some(1.0);
    fluid.boundary.pressure[WallId::XMax] = Some(0.0);
    let mut flow = Flow::new(&x, &[5e-7; 2], bounds, &fluid, SolverKind::default()).unwrap();
    flow.solve_static().unwrap();
    let volume: f64 = flow.network().volume.iter().sum();
    assert!((volume / bounds.volume() - 1.0).abs() < 1e-9, "{volume:e}");
    let k = flow.permeability(WallId::XMin).unwrap();
    assert!(k.value > 0.0 && k.imbalance < 1e-9, "{k:?}");
}

/// Pressures of a motion go with the viscosity, and fluxes of imposed pressures with one over it:
/// bit for bit for powers of four, to round-off for others, from 1e-300 to 1e300 or refused.
#[test]
fn pressures_go_with_the_viscosity() {
    let s = settled();
    let velocity: Vec<Vec3> = s.x.iter().map(|x| Vec3::new(x.y, -x.x * x.z, 0.3 * x.y)).collect();
    for solver in [SolverKind::Cholmod, SolverKind::Frontal] {
        let pressures = |viscosity: f64| -> Result<Vec<f64>, PfvError> {
            let mut fluid = along_y(viscosity);
            fluid.boundary.pressure[WallId::YMin] = None;
            let mut flow = Flow::new(&s.x, &s.r, s.bounds, &fluid, solver)?;
            flow.set_tolerance(1e-15)?;
            flow.solve(&velocity, &[0.0; 6])?;
            Ok(flow.pressure().iter().map(|p| p / viscosity).collect())
        };
        let one = pressures(1.0).unwrap();
        let mut refused = 0;
        for exponent in [-300, -250, -200, -100, -30, -6, 6, 30, 100, 200, 250, 300] {
            match pressures(10f64.powi(exponent)) {
                Ok(other) => {
                    let off = difference(one.iter(), other.iter(), 1.0);
                    assert!(off < 1e-12, "{solver} 1e{exponent}: {off:e}");
                }
                Err(error) => {
                    refused += 1;
                    assert!(
                        error.to_string().contains("viscosity"),
                        "{solver} 1e{exponent}: {error}"
                    );
                }
            }
        }
        assert!(refused <= 4, "{solver}: {refused} refused");
        for exponent in [-600, -100, -20, 20, 100, 600] {
            let other = pressures(2f64.powi(exponent)).unwrap();
            assert!(one == other, "{solver}: 2^{exponent}");
        }
    }
}

/// As the time step goes to nothing, velocities over it go to the accelerations, and the spheres
/// stay.
#[test]
fn short_time_steps_have_a_smooth_limit() {
    for wet in [false, true] {
        let accelerations = |dt: f64| -> Vec<f64> {
            let mut coupled = flying(Units { length: 1.0, mass: 1.0, time: 1.0 }, wet);
            coupled.controls().storage_velocities_mut().0.fill(Vec3::zeros());
            coupled.step(dt).unwrap();
            let v = &coupled.dem().storage().velocity;
            v.iter().flat_map(|v| [v.x / dt, v.y / dt, v.z / dt]).collect()
        };
        let usual = accelerations(1e-6);
        for dt in [1e-9, 1e-30, 1e-100, 1e-200, 1e-300] {
            let off = difference(usual.iter(), accelerations(dt).iter(), 1.0);
            assert!(off < 1e-12, "wet: {wet}, {dt:e}: {off:e}");
        }
    }
}
