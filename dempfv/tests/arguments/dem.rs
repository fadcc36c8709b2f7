//! Rows of the mechanics.

use super::dem_support::{UNIT, cloud, frictionless_walls, material, twin};
use super::{NO_LENGTHS, Table};
use dempfv::dem::law::{Adhesion, Bonds, Granular, GranularEffects, Hertz, Restitution};
use dempfv::dem::{
    BodyForce, BodyLoad, CloudScale, CloudSpec, Dem, DemError, DemOptions, GrowthCompaction,
    GrowthOptions, Material, Particles, SizeDistribution, SphereState, WallControl, WallMaterial,
    random_cloud,
};
use dempfv::{Aabb, PerWall, Vec3, WallId};

const NAN: Vec3 = Vec3::new(f64::NAN, f64::NAN, f64::NAN);

fn small() -> Dem {
    twin(20, 1, DemOptions::default())
}

/// A force that one sphere feels without limit.
pub struct Endless;

impl BodyForce for Endless {
    fn name(&self) -> &str {
        "endless"
    }

    fn load(&self, sphere: &SphereState, _: f64) -> BodyLoad {
        let force = if sphere.number == 7 { NAN } else { Vec3::zeros() };
        BodyLoad { force, torque: Vec3::zeros() }
    }
}

/// Spheres in contact.
fn pressed() -> Dem {
    let x = vec![Vec3::new(0.4, 0.5, 0.5), Vec3::new(0.59, 0.5, 0.5)];
    let p = Particles::new(x, vec![0.1; 2], 2600.0);
    let mut dem =
        Dem::new(p, UNIT, material(), frictionless_walls(), DemOptions::default()).unwrap();
    dem.compute_contacts().unwrap();
    dem
}

/// A way to make a `Dem` of what is given.
type Make = fn(Particles, Aabb, Material, WallMaterial, DemOptions) -> Result<Dem, DemError>;

fn making(t: &mut Table, function: &'static str, make: Make) {
    let (m, w, o) = (material(), frictionless_walls(), DemOptions::default());
    for value in NO_LENGTHS {
        let p = Particles { radius: vec![value; 20], ..cloud(20, 1) };
        t.refuses(function, "radius", || make(p, UNIT, m, w, o));
        let p = Particles { mass: vec![value; 20], ..cloud(20, 1) };
        t.refuses(function, "mass", || make(p, UNIT, m, w, o));
        let young = Material { young: value, ..m };
        t.refuses(function, "young", || make(cloud(20, 1), UNIT, young, w, o));
        let density = Material { density: value, ..m };
        t.refuses(function, "density", || make(cloud(20, 1), UNIT, density, w, o));
        let wall = WallMaterial { young: value, ..w };
        t.refuses(function, "wall young", || make(cloud(20, 1), UNIT, m, wall, o));
        let skin = DemOptions { skin: value, ..o };
        t.refuses(function, "skin", || make(cloud(20, 1), UNIT, m, w, skin));
    }
    for value in [f64::NAN, f64::INFINITY, -1.0, 1e300] {
        let ratio = Material { stiffness_ratio: -value.abs(), ..m };
        t.refuses(function, "stiffness_ratio", || make(cloud(20, 1), UNIT, ratio, w, o));
        let friction = Material { friction_angle: value, ..m };
        t.refuses(function, "friction_angle", || make(cloud(20, 1), UNIT, friction, w, o));
        let damping = DemOptions { damping: value, ..o };
        t.refuses(function, "damping", || make(cloud(20, 1), UNIT, m, w, damping));
    }
    let gravity = DemOptions { gravity: Some(NAN), ..o };
    t.refuses(function, "gravity", || make(cloud(20, 1), UNIT, m, w, gravity));
    for (word, p) in [
        ("position", Particles { position: vec![NAN; 20], ..cloud(20, 1) }),
        ("velocity", Particles { velocity: vec![NAN; 20], ..cloud(20, 1) }),
        ("spin", Particles { spin: vec![NAN; 20], ..cloud(20, 1) }),
        ("velocity", Particles { velocity: vec![], ..cloud(20, 1) }),
        ("radius", Particles { radius: vec![0.01; 21], ..cloud(20, 1) }),
        ("mass", Particles { radius: vec![1e-150; 20], mass: vec![0.0; 20], ..cloud(20, 1) }),
        ("id", Particles { id: vec![7; 20], ..cloud(20, 1) }),
        ("id", Particles { id: vec![u32::MAX; 20], ..cloud(20, 1) }),
    ] {
        t.refuses(function, word, || make(p, UNIT, m, w, o));
    }
    for box_ in [
        Aabb { min: UNIT.max, max: UNIT.min },
        Aabb { min: UNIT.min, max: UNIT.min },
        Aabb { min: UNIT.min, max: NAN },
    ] {
        t.refuses(function, "wall", || make(cloud(20, 1), box_, m, w, o));
    }
    let huge = Aabb { min: Vec3::repeat(-1e200), max: Vec3::repeat(1e200) };
    t.refuses(function, "volume of the box", || make(cloud(20, 1), huge, m, w, o));
    let far = Aabb { min: Vec3::repeat(-1e9), max: Vec3::repeat(1.0) };
    t.refuses(function, "lost their digits", || make(cloud(20, 1), far, m, w, o));
    let beside = Aabb { min: Vec3::repeat(5.0), max: Vec3::repeat(6.0) };
    t.refuses(function, "beyond the wall", || make(cloud(20, 1), beside, m, w, o));
}

pub fn table() -> Table {
    let mut t = Table::default();
    making(&mut t, "dem::Dem::new", Dem::new);
    making(&mut t, "dem::Dem::standing", |p, b, m, w, o| Dem::standing(p, b, &[m], w, o));
    making(&mut t, "dem::Dem::with_law", |p, b, m, w, o| {
        Dem::with_law(dempfv::dem::law::Linear, p, b, &[m], w, o)
    });
    making(&mut t, "dem::Dem::with_effects", |p, b, m, w, o| {
        Dem::with_effects(GranularEffects::default(), p, b, &[m], w, o)
    });
    effects(&mut t);
    states(&mut t);
    steps(&mut t);
    by_number(&mut t);
    clouds(&mut t);
    t.refuses("dem::Particles::new", "radius", || {
        Particles { radius: vec![], ..cloud(20, 1) }.sort_spatially()
    });
    t.gives("dem::Particles::new", "lengths that differ are refused by the `Dem`", || {
        let p = Particles::new(vec![Vec3::zeros(); 3], vec![f64::NAN], -1.0);
        let made = Dem::new(p, UNIT, material(), frictionless_walls(), DemOptions::default());
        made.is_err_and(|e| e.to_string().contains("radius"))
    });
    t.gives("domain::Aabb::of_spheres", "no box", || {
        Aabb::of_spheres(&[], &[]).is_none()
            && Aabb::of_spheres(&[Vec3::zeros()], &[]).is_none()
            && Aabb::of_spheres(&[NAN], &[1.0]).is_none()
            && Aabb::of_spheres(&[Vec3::zeros()], &[f64::INFINITY]).is_none()
    });
    t
}

/// Constants of effects of contacts.
fn effects(t: &mut Table) {
    let none = GranularEffects::default();
    for value in [f64::NAN, f64::INFINITY, -1.0] {
        for (word, effects) in [
            (
                "poisson_ratio",
                GranularEffects {
                    hertz: Some(Hertz { poisson_ratio: value, wall_poisson_ratio: 0.2 }),
                    ..none
                },
            ),
            (
                "restitution",
                GranularEffects {
                    restitution: Some(Restitution { spheres: value, walls: 1.0 }),
                    ..none
                },
            ),
            (
                "adhesion force",
                GranularEffects { adhesion: Some(Adhesion::Constant(value)), ..none },
            ),
            (
                "tension",
                GranularEffects {
                    bonds: Some(Bonds { tension: value, cohesion: 1.0, interaction_range: 1.0 }),
                    ..none
                },
            ),
        ] {
            t.refuses("dem::law::Granular::new", word, || Granular::new(effects));
        }
    }
    let (m, w, o) = (material(), frictionless_walls(), DemOptions::default());
    t.refuses("dem::Dem::with_effects_from_state", "linear", || {
        Dem::with_effects_from_state(none, small().state(), &[m], w, o)
    });
}

fn states(t: &mut Table) {
    let (m, w, o) = (material(), frictionless_walls(), DemOptions::default());
    let good = || small().state();
    for value in [f64::NAN, f64::INFINITY, -1.0] {
        let mut state = good();
        state.pending_dt = value;
        t.refuses("dem::Dem::from_state", "pending_dt", || Dem::from_state(state, m, w, o));
    }
    let mut state = good();
    state.walls[WallId::XMin].control = WallControl::Velocity(f64::NAN);
    t.refuses("dem::Dem::from_state", "wall velocity", || Dem::from_state(state, m, w, o));
    let mut state = good();
    state.walls[WallId::XMin].displacement = f64::NAN;
    t.refuses("dem::Dem::from_state", "displacement", || Dem::from_state(state, m, w, o));
    let mut state = good();
    (state.sphere_history.bodies, state.sphere_history.numbers) = (vec![[3, 99]], vec![0.0; 3]);
    t.refuses("dem::Dem::from_state", "contact history", || Dem::from_state(state, m, w, o));
    let mut state = good();
    state.sphere_history.numbers.push(1.0);
    t.refuses("dem::Dem::from_state", "contact history", || Dem::from_state(state, m, w, o));
    let mut state = good();
    (state.sphere_history.bodies, state.sphere_history.numbers) = (vec![[3, 4]], vec![f64::NAN; 3]);
    t.refuses("dem::Dem::from_state", "contact history", || Dem::from_state(state, m, w, o));
    let mut state = good();
    state.law = "another".to_owned();
    t.refuses("dem::Dem::with_law_from_state", "another", || {
        Dem::with_law_from_state(dempfv::dem::law::Linear, state, &[m], w, o)
    });
}

fn steps(t: &mut Table) {
    for value in NO_LENGTHS {
        t.refuses("dem::Dem::integrate", "time step", || small().integrate(value, None, None));
        t.refuses("dem::Dem::step", "time step", || small().step(value));
        t.refuses("dem::Dem::scale_radii", "radius factor", || small().scale_radii(value));
        t.refuses("dem::Dem::scale_space", "factor of lengths", || small().scale_space(value));
        t.refuses("dem::GrowthCompaction::set_time_step", "time step", || {
            let mut growth = GrowthCompaction::new(GrowthOptions::new(1e4, 1e6)).unwrap();
            growth.set_time_step(Some(value));
            growth.step(&mut small())
        });
    }
    for value in [f64::NAN, f64::NEG_INFINITY, -1.0, 0.0] {
        t.refuses("dem::Dem::step_auto", "safety", || small().step_auto(value));
        t.gives("dem::Dem::safe_time_step", "no number", || small().safe_time_step(value).is_nan());
        t.gives("dem::Dem::contact_time_step", "no number", || {
            pressed().contact_time_step(value).is_some_and(f64::is_nan)
        });
        t.gives("dem::Dem::steps_between_looks", "no steps", || {
            let mut dem = small();
            dem.set_velocity(0, Vec3::x());
            value == 0.0 || dem.steps_between_looks(value) == 0
        });
    }
    for factor in [1e-150, 1e150] {
        t.refuses("dem::Dem::scale_radii", "radius factor", || small().scale_radii(factor));
        t.refuses("dem::Dem::scale_space", "volume of the box", || small().scale_space(factor));
    }
    t.refuses("dem::Dem::step", "not finite", || {
        let mut dem = small();
        dem.set_velocity(3, Vec3::x());
        dem.step(1e300)
    });
    t.refuses("dem::Dem::integrate", "fluid force", || {
        small().integrate(1e-5, Some(&[Vec3::zeros(); 19]), None)
    });
    t.refuses("dem::Dem::integrate", "fluid force", || {
        small().integrate(1e-5, Some(&[NAN; 20]), None)
    });
    t.refuses("dem::Dem::integrate", "fluid wall force", || {
        small().integrate(1e-5, None, Some(&PerWall([NAN; 6])))
    });
    for length in [0, 19, 21] {
        t.refuses("dem::Dem::unbalanced_force", "fluid_force", || {
            pressed().unbalanced_force(Some(&vec![Vec3::zeros(); length]))
        });
        t.refuses("dem::Dem::by_number", "in_storage_order", || {
            small().by_number(&vec![0; length])
        });
    }
    t.refuses("dem::Dem::unbalanced_force", "fluid_force", || {
        pressed().unbalanced_force(Some(&[NAN; 2]))
    });
    t.refuses("dem::Dem::set_wall_resistance", "wall resistance", || {
        small().set_wall_resistance(PerWall([PerWall([f64::NAN; 6]); 6]))
    });
    for value in [f64::NAN, f64::INFINITY, -0.1, 2.0] {
        t.refuses("dem::Dem::set_friction", "friction_angle", || small().set_friction(value));
        t.refuses("dem::Dem::set_damping", "damping", || small().set_damping(value));
    }
    for control in [
        WallControl::Velocity(f64::INFINITY),
        WallControl::Servo { stress: f64::NAN, max_velocity: Some(1.0) },
        WallControl::Servo { stress: 1.0, max_velocity: Some(-1.0) },
    ] {
        let word = if let WallControl::Velocity(_) = control { "wall velocity" } else { "servo" };
        t.refuses("dem::Dem::set_control", word, || small().set_control(WallId::XMin, control));
    }
    let options = GrowthOptions::new(1e4, 1e6);
    for value in NO_LENGTHS {
        let stress = GrowthOptions { stress: value, ..options };
        t.refuses("dem::GrowthCompaction::new", "stress", || GrowthCompaction::new(stress));
        let safety = GrowthOptions { time_step_safety: value, ..options };
        t.refuses("dem::GrowthCompaction::new", "safety", || GrowthCompaction::new(safety));
        let goal = GrowthOptions { unbalanced_tolerance: value, ..options };
        t.refuses("dem::GrowthCompaction::new", "unbalanced", || GrowthCompaction::new(goal));
        let slow = GrowthOptions { slow_factor: value, ..options };
        t.refuses("dem::GrowthCompaction::new", "slow_factor", || GrowthCompaction::new(slow));
        t.refuses("dem::GrowthOptions::new", "factor", || {
            GrowthCompaction::new(GrowthOptions::new(1e4, value))
        });
    }
    t.refuses("dem::GrowthCompaction::set_options", "slow_factor", || {
        let slow = GrowthOptions { slow_factor: 0.0, ..options };
        GrowthCompaction::new(options).unwrap().set_options(slow)
    });
    t.refuses("dem::Particles::of_materials", "material", || {
        Particles::of_materials(vec![Vec3::zeros()], vec![1.0], vec![0, 0], &[material()])
    });
    t.refuses("dem::Particles::of_materials", "material 1, of 1", || {
        Particles::of_materials(vec![Vec3::zeros()], vec![1.0], vec![1], &[material()])
    });
    let never = GrowthOptions { interval: 0, ..options };
    t.refuses("dem::GrowthCompaction::new", "interval", || GrowthCompaction::new(never));
}

fn by_number(t: &mut Table) {
    t.panics("dem::Dem::storage_index", || small().storage_index(20));
    t.panics("dem::Dem::position", || small().position(usize::MAX));
    t.panics("dem::Dem::velocity", || small().velocity(20));
    t.panics("dem::Dem::spin", || small().spin(20));
    t.panics("dem::Dem::radius", || small().radius(20));
    t.panics("dem::Dem::mass", || small().mass(20));
    t.panics("dem::Dem::force", || small().force(20));
    t.panics("dem::Dem::torque", || small().torque(20));
    t.panics("dem::Dem::set_velocity", || small().set_velocity(20, Vec3::zeros()));
    t.panics("dem::Dem::set_spin", || small().set_spin(20, Vec3::zeros()));
    t.panics("dem::Dem::add_force", || small().add_force(20, Vec3::zeros()));
    t.panics("dem::Dem::add_torque", || small().add_torque(20, Vec3::zeros()));
    type Spoil = fn(&mut Dem);
    let spoil: [(&'static str, Spoil); 5] = [
        ("dem::Dem::set_velocity", |dem| dem.set_velocity(7, NAN)),
        ("dem::Dem::set_spin", |dem| dem.set_spin(7, NAN)),
        ("dem::Dem::add_force", |dem| dem.add_force(7, NAN)),
        ("dem::Dem::add_torque", |dem| dem.add_torque(7, NAN)),
        ("dem::Dem::add_body_force", |dem| dem.add_body_force(Box::new(Endless))),
    ];
    for (function, change) in spoil {
        t.refuses(function, "particle 7", || {
            let mut dem = small();
            change(&mut dem);
            dem.step(1e-5)
        });
    }
}

fn clouds(t: &mut Table) {
    const CLOUD: &str = "dem::random_cloud";
    let spec = |sizes, scale| CloudSpec { box_: UNIT, count: 10, sizes, scale, seed: 1 };
    let uniform = SizeDistribution::Uniform { spread: 0.0 };
    for value in NO_LENGTHS {
        let mean = spec(uniform.clone(), CloudScale::MeanRadius(value));
        t.refuses(CLOUD, "mean radius", || random_cloud(&mean));
        let porosity = spec(uniform.clone(), CloudScale::Porosity(value));
        t.refuses(CLOUD, "porosity", || random_cloud(&porosity));
        let radius = spec(SizeDistribution::List(vec![(value, 1.0)]), CloudScale::AsListed);
        t.refuses(CLOUD, "radius", || random_cloud(&radius));
        let share = spec(SizeDistribution::List(vec![(0.1, value)]), CloudScale::AsListed);
        t.refuses(CLOUD, "share", || random_cloud(&share));
    }
    for spread in [f64::NAN, -0.1, 1.0, f64::INFINITY] {
        let sizes = SizeDistribution::Uniform { spread };
        let spread = spec(sizes, CloudScale::Porosity(0.9));
        t.refuses(CLOUD, "spread", || random_cloud(&spread));
    }
    let nothing = spec(SizeDistribution::List(vec![]), CloudScale::AsListed);
    t.refuses(CLOUD, "share", || random_cloud(&nothing));
    let huge = spec(SizeDistribution::List(vec![(1e200, 1.0)]), CloudScale::Porosity(0.9));
    t.refuses(CLOUD, "radius", || random_cloud(&huge));
    let large = spec(uniform.clone(), CloudScale::MeanRadius(1e300));
    t.refuses(CLOUD, "0 of 10", || random_cloud(&large));
    for count in [usize::MAX, u32::MAX as usize] {
        let many = CloudSpec { count, ..spec(uniform.clone(), CloudScale::Porosity(0.9)) };
        t.refuses(CLOUD, "count", || random_cloud(&many));
    }
    let inverted = Aabb { min: UNIT.max, max: UNIT.min };
    let inside_out = CloudSpec { box_: inverted, ..spec(uniform, CloudScale::Porosity(0.9)) };
    t.refuses(CLOUD, "wall", || random_cloud(&inside_out));
}
