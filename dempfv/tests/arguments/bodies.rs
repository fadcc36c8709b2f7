//! Rows of clumps and of motions that are given.

use super::Table;
use super::dem_support::{UNIT, frictionless_walls, material};
use dempfv::coupling::Coupled;
use dempfv::dem::{ClumpTemplate, Dem, DemOptions, MaterialPair, Motion, Particles};
use dempfv::scene::{OtherMaterial, Plan, SphereChoice};
use dempfv::{TimeFunction, Vec3};

const NAN: Vec3 = Vec3::new(f64::NAN, 0.0, 0.0);

/// Three spheres in a row, of which the first two touch.
fn three() -> Dem {
    let x = [0.2, 0.39, 0.8].map(|x| Vec3::new(x, 0.5, 0.5));
    let p = Particles::new(x.to_vec(), vec![0.1; 3], 2600.0);
    Dem::new(p, UNIT, material(), frictionless_walls(), DemOptions::default()).unwrap()
}

fn bound() -> Dem {
    let mut dem = three();
    dem.bind(&[vec![0, 1]]).unwrap();
    dem
}

fn fast(velocity: f64) -> Motion {
    Motion { velocity: [0.0, velocity, 0.0].map(TimeFunction::Constant), ..Motion::default() }
}

pub fn table() -> Table {
    let mut t = Table::default();
    t.refuses("dem::Dem::bind", "no sphere 3", || three().bind(&[vec![0, 3]]));
    t.refuses("dem::Dem::bind", "fewer than two", || three().bind(&[vec![]]));
    t.refuses("dem::Dem::bind", "in a clump already", || three().bind(&[vec![0, 0]]));
    t.refuses("dem::Dem::set_clump_motion", "is none", || {
        bound().set_clump_motion(1, Vec3::zeros(), Vec3::zeros())
    });
    t.refuses("dem::Dem::set_clump_motion", "not finite", || {
        bound().set_clump_motion(0, Vec3::zeros(), NAN)
    });
    t.panics("dem::Dem::clump_of", || bound().clump_of(3));
    t.refuses("dem::Dem::prescribe", "velocity", || three().prescribe(&[0], fast(f64::NAN)));
    t.refuses("dem::Dem::prescribe", "axis", || {
        three().prescribe(&[0], Motion { about: Some(NAN), ..Motion::default() })
    });
    t.refuses("dem::Dem::prescribe", "no sphere 3", || three().prescribe(&[3], fast(0.0)));
    t.refuses("dem::Dem::release", "no sphere 3", || three().release(&[3]));
    t.refuses("dem::Dem::set_time", "time", || three().set_time(f64::INFINITY));
    t.refuses("dem::Dem::prescribe", "not finite", || {
        let mut dem = three();
        dem.prescribe(&[0], fast(1e308)).unwrap();
        dem.step(10.0)
    });
    let pair = |index, young| MaterialPair {
        between: [0, index],
        young: Some(young),
        stiffness_ratio: None,
        friction_angle: None,
    };
    for (word, pair) in [("young", pair(0, -1.0)), ("material of a pair", pair(1, 1e6))] {
        t.refuses("dem::Dem::set_materials", word, || {
            three().set_materials(&[material()], &[pair])
        });
        let mut coupled = Coupled::new(three());
        t.refuses("coupling::Controls::set_materials", word, || {
            coupled.controls().set_materials(&[material()], &[pair])
        });
    }
    t.refuses("dem::Dem::set_materials", "materials", || three().set_materials(&[], &[]));
    let template = |place, radius| ClumpTemplate { members: vec![(place, radius); 2] };
    for (place, radius) in [(NAN, 0.1), (Vec3::x(), 0.5), (Vec3::zeros(), 0.0)] {
        let wrong = template(place, radius);
        t.refuses("dem::ClumpTemplate::in_place_of", "has a member", || {
            wrong.in_place_of(&[(Vec3::zeros(), 1.0)], 1)
        });
    }
    let which = SphereChoice { numbers: Some(vec![9]), ..SphereChoice::default() };
    let other = OtherMaterial { which, ..OtherMaterial::default() };
    let plan = Plan { other_materials: vec![other], ..Plan::default() };
    t.refuses("scene::Plan::material_of_each", "no sphere 9", || {
        plan.material_of_each(&[Vec3::zeros()], &[1.0])
    });
    let mut coupled = Coupled::new(bound());
    let mut controls = coupled.controls();
    t.refuses("coupling::Controls::prescribe", "no sphere 3", || {
        controls.prescribe(&[3], fast(0.0), 0.0)
    });
    t.refuses("coupling::Controls::release", "no sphere 3", || controls.release(&[3]));
    t.refuses("coupling::Controls::set_clump_motion", "is none", || {
        controls.set_clump_motion(1, Vec3::zeros(), Vec3::zeros())
    });
    t
}
