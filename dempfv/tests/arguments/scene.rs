//! Rows of plans, simulations and theory.

use std::path::Path;
use std::sync::Arc;

use super::{NO_LENGTHS, Table};
use dempfv::coupling::StandardBuilder;
use dempfv::pfv::{ImposedPressure, PoreSelection};
use dempfv::scene::{
    Cloud, Compact, Consolidate, Dem, FlowOnly, Fluid, GradingCurve, ParticleSource, Plan, Run,
    Sizes, Stage, StageKind, TimeStep, differences,
};
use dempfv::simulation::{
    Consolidation, Estimate, Simulation, Specimen, Stability, check_conditions, initial_packing,
};
use dempfv::{Aabb, InputError, Vec3, WallId, theory};

/// A plan that is right: spheres in a box that shake in a fluid.
fn good() -> Plan {
    let sizes = Sizes::Uniform { mean: 0.05, spread: 0.1 };
    let mut plan = Plan {
        dem: Some(Dem::default()),
        fluid: Some(Fluid::default()),
        stages: vec![Stage::new("shake", StageKind::Run(Run::default()))],
        ..Plan::default()
    };
    plan.particles.source = ParticleSource::Cloud(Cloud { count: 20, sizes });
    let fluid = plan.fluid.as_mut().unwrap();
    fluid.fluid.boundary.pressure[WallId::YMax] = Some(0.0);
    plan
}

type Spoil = fn(&mut Plan, f64);

/// Numbers of a plan, with the word that names each.
const NUMBERS: [(&str, Spoil); 10] = [
    ("young", |p, x| p.particles.material.young = x),
    ("density", |p, x| p.particles.material.density = x),
    ("young", |p, x| p.walls.material.young = x),
    ("dt", |p, x| p.dem.as_mut().unwrap().dt = TimeStep::Fixed(x)),
    ("safety", |p, x| p.dem.as_mut().unwrap().safety = x),
    ("viscosity", |p, x| p.fluid.as_mut().unwrap().fluid.viscosity = x),
    ("tolerance", |p, x| p.fluid.as_mut().unwrap().tolerance = x),
    ("remesh_strain", |p, x| p.fluid.as_mut().unwrap().remesh.strain = Some(x)),
    ("stress", |p, x| {
        p.stages[0].kind = StageKind::Compact(Compact { stress: x, ..Compact::default() });
    }),
    ("stress", |p, x| {
        p.stages[0].kind =
            StageKind::Consolidate(Consolidate { stress: x, ..Consolidate::default() });
    }),
];

fn estimate(plan: &Plan) -> Result<(), InputError> {
    let specimen = Specimen::of_cloud(plan).unwrap_or_default();
    Estimate::of(plan, &Specimen { smallest_radius: 0.01, ..specimen }).map(drop)
}

pub fn table() -> Table {
    let mut t = Table::default();
    let mut flows = good();
    flows.stages = vec![Stage::new("flow", StageKind::Flow(FlowOnly::default()))];
    let effects = &mut flows.fluid.as_mut().unwrap().effects;
    let pores = PoreSelection::Around { center: Vec3::repeat(0.5), radius: 0.2 };
    effects.imposed = vec![ImposedPressure { pores, pressure: 1.0 }];
    let unit = Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) };
    for (word, x, r) in [
        ("radius", vec![Vec3::repeat(0.5)], vec![]),
        ("position[0]", vec![Vec3::repeat(f64::NAN)], vec![0.1]),
        ("no spheres", vec![], vec![]),
    ] {
        t.refuses("simulation::check_conditions", word, || check_conditions(&flows, &x, &r, unit));
    }
    let mut refuse = |word: &str, plan: &dyn Fn() -> Plan| {
        t.refuses("simulation::Simulation::new", word, || Simulation::new(plan()).map(drop));
        t.refuses("simulation::Estimate::of", word, || estimate(&plan()));
        t.refuses("simulation::Estimate::with_threads", word, || {
            Estimate::with_threads(&plan(), &Specimen::of_radii(&[0.1]), 0)
        });
        t.refuses("simulation::Stability::of", word, || Stability::of(&plan()));
        t.refuses("simulation::initial_packing", word, || initial_packing(&plan()));
        let state = || Simulation::new(good()).unwrap().state();
        t.refuses("simulation::Simulation::restart", word, || {
            Simulation::restart(plan(), state()).map(drop)
        });
        t.refuses("simulation::Simulation::restart_with", word, || {
            Simulation::restart_with(plan(), state(), Arc::new(StandardBuilder)).map(drop)
        });
    };
    for (word, spoil) in NUMBERS {
        for value in NO_LENGTHS {
            refuse(word, &|| {
                let mut plan = good();
                spoil(&mut plan, value);
                plan
            });
        }
    }
    refuse("no stage", &|| Plan { stages: vec![], ..good() });
    refuse("max", &|| {
        let (min, max) = (Vec3::repeat(1.0), Vec3::zeros());
        Plan { bounds: Some(Aabb { min, max }), ..good() }
    });
    t.gives("simulation::Simulation::new", "the plan that the others spoil is right", || {
        Simulation::new(good()).is_ok() && estimate(&good()).is_ok()
    });
    for value in NO_LENGTHS.into_iter().filter(|value| *value != 0.0) {
        let specimen = Specimen { smallest_radius: value, ..Specimen::default() };
        t.refuses("simulation::Estimate::of", "smallest_radius", || {
            Estimate::of(&good(), &specimen)
        });
    }
    t.refuses("scene::Plan::from_toml", "not TOML", || Plan::from_toml("\u{0}", None));
    t.refuses("scene::Plan::from_toml", "sede", || {
        Plan::from_toml("sede = 1", Some(Path::new("")))
    });
    t.refuses("scene::Plan::load", "cannot read", || Plan::load(Path::new("/no/such.toml")));
    theories(&mut t);
    let curve = GradingCurve(vec![[1e-3, 0.0], [2e-3, 1.0]]);
    t.gives("scene::GradingCurve::radii", "none without memory", || {
        curve.radii(usize::MAX).is_none() && curve.radii(0).is_some_and(|r| r.is_empty())
    });
    for points in [vec![], vec![[f64::NAN; 2]; 3], vec![[1e-3, 0.0], [1e-3, 1.0]]] {
        t.gives("scene::GradingCurve::radii", "as many numbers, which are none", || {
            GradingCurve(points).radii(3).is_some_and(|r| r.len() == 3)
        });
    }
    t
}

fn theories(t: &mut Table) {
    use theory::*;
    let nan = f64::NAN;
    t.gives("theory::degree_of_consolidation", "its limits", || {
        degree_of_consolidation(nan).is_nan()
            && degree_of_consolidation(-1.0) == 0.0
            && degree_of_consolidation(f64::INFINITY) == 1.0
    });
    t.gives("theory::excess_pressure", "its limits", || {
        excess_pressure(nan, 0.0).is_nan()
            && excess_pressure(0.5, nan).is_nan()
            && excess_pressure(0.5, -1.0) == 1.0
            && excess_pressure(-7.0, 0.1) == 0.0
    });
    t.gives("theory::excess_pressure_both_ends", "its limits", || {
        excess_pressure_both_ends(nan, 0.1).is_nan()
            && excess_pressure_both_ends(0.5, nan).is_nan()
            && excess_pressure_both_ends(7.0, 0.1) == 0.0
    });
    t.refuses("scene::differences", "TOML", || differences("seed = ", "seed = 1"));
    let number = |layers: WallLayers| {
        !layers.degree(0.1).is_nan() || !layers.excess_pressure(0.5, 0.1).is_nan()
    };
    t.gives("theory::WallLayers::new", "no number", || {
        let shares = [[nan, 0.0], [0.0, nan], [-0.1, 0.0], [0.0, -0.1], [0.5, 0.5], [1e300, 0.0]];
        !shares.iter().any(|&[drained, sealed]| number(WallLayers::new(drained, sealed)))
            && number(WallLayers::new(0.0, 0.0))
            && number(WallLayers::new(0.0, 0.999))
    });
    let layers = WallLayers::new(0.1, 0.1);
    t.gives("theory::WallLayers::degree", "its limits", || {
        layers.degree(nan).is_nan()
            && layers.degree(-1.0) == 0.1
            && layers.degree(f64::INFINITY) == 1.0
    });
    t.gives("theory::WallLayers::excess_pressure", "its limits", || {
        layers.excess_pressure(nan, 0.1).is_nan()
            && layers.excess_pressure(0.5, nan).is_nan()
            && layers.excess_pressure(0.5, -1.0) == 1.0
            && layers.excess_pressure(-7.0, 0.1) == 0.0
            && layers.excess_pressure(7.0, 0.1) == layers.excess_pressure(1.0, 0.1)
    });
    t.gives("theory::time_factor", "its limits", || {
        time_factor(nan).is_nan() && time_factor(-1.0) == 0.0 && time_factor(2.0) == f64::INFINITY
    });
    t.gives("theory::kozeny_carman", "no number", || {
        [nan, -0.1, 1.1].iter().all(|&n| kozeny_carman(n, 1.0).is_nan())
            && [nan, 0.0, -1.0].iter().all(|&d| kozeny_carman(0.4, d).is_nan())
    });
    t.gives("theory::sauter_diameter", "no number", || {
        [nan, 0.0, -1.0].iter().all(|&r| sauter_diameter(&[1.0, r]).is_nan())
    });
    let measured = Consolidation {
        wall: WallId::YMax,
        load_pa: 1.0,
        height_m: 1.0,
        drained_walls: vec![WallId::YMax],
        drainage_path_m: 1.0,
        modulus_pa: 1.0,
        permeability_m2: 1.0,
        c_v_m2_s: 1.0,
        final_settlement_m: 1.0,
        drained_share: 0.0,
        sealed_share: 0.0,
        drained_settlement: 0.0,
        sealed_settlement: 0.0,
        samples: vec![],
        profiles: vec![],
    };
    t.gives("simulation::Consolidation::largest_error", "0 where there is no sample", || {
        measured.largest_error(nan, nan) == 0.0 && measured.largest_error(1.0, 0.0) == 0.0
    });
}
