//! The scenes that come with the program say what their comments promise.

use std::path::Path;

use dempfv::scene::*;
use dempfv::{Axis, WallId};

fn load(name: &str) -> Plan {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    Plan::load(path).unwrap_or_else(|e| panic!("{e}"))
}

/// The numbers are those of YADE's own oedometer example.
#[test]
fn oedometer_is_the_twin_of_yades() {
    let plan = load("oedometer.toml");
    assert_eq!(plan.bounds.unwrap().volume(), 1.0);
    let ParticleSource::Cloud(cloud) = &plan.particles.source else { panic!("no cloud") };
    assert_eq!(cloud.count, 1000);
    let solid = 1000.0 * cloud.sizes.mean_volume();
    assert!((solid - 0.05).abs() < 1e-12, "porosity {}", 1.0 - solid);
    assert!((cloud.sizes.largest() / cloud.sizes.smallest() - 1.3333 / 0.6667).abs() < 1e-9);
    assert!((plan.particles.material.friction_angle.to_degrees() - 30.0).abs() < 1e-12);
    assert_eq!(plan.walls.material.friction_angle, 0.0);
    assert_eq!(plan.walls.material.young, 1e6);
    let fluid = plan.fluid.as_ref().unwrap();
    assert_eq!(fluid.fluid.viscosity, 10.0);
    assert_eq!(fluid.pressure_walls().collect::<Vec<_>>(), [(WallId::YMax, 0.0)]);
    assert_eq!(plan.dem.as_ref().unwrap().dt, TimeStep::Fixed(1e-4));
    let kinds: Vec<_> = plan.stages.iter().map(|s| s.kind.name()).collect();
    assert_eq!(kinds, ["compact", "cycle", "permeability", "consolidate"]);
    let StageKind::Consolidate(last) = &plan.stages[3].kind else { panic!("not the last") };
    assert_eq!((last.stress, last.until_tv, last.wall), (1.1e4, 1.5, WallId::YMax));
    assert_eq!(last.max_velocity, Some(0.1));
}

/// Settings of the paper's appendix: 1 kPa on y, drained at the top, 600 steps of 1e-6 s.
#[test]
fn caulk2020_has_the_papers_settings() {
    let plan = load("caulk2020.toml");
    let ParticleSource::Packing(path) = &plan.particles.source else { panic!("no packing") };
    assert!(path.ends_with("packings/oedometer-5000.txt"));
    assert_eq!(plan.bounds, None);
    let fluid = plan.fluid.as_ref().unwrap();
    assert_eq!((fluid.fluid.viscosity, fluid.remesh.interval), (1e-3, Some(200)));
    let [Stage { kind: StageKind::Run(run), .. }] = plan.stages.as_slice() else {
        panic!("one run stage")
    };
    assert_eq!(run.until, Until::Steps(600));
    assert!(run.fluid);
    for wall in WallId::ALL {
        let expected = match wall {
            WallId::YMax => WallControl::Servo { stress: 1e3, max_velocity: None },
            _ => WallControl::Fixed,
        };
        assert_eq!(run.walls[wall], expected, "{wall}");
    }
}

#[test]
fn permeability_moves_nothing() {
    let plan = load("permeability.toml");
    assert!(plan.dem.is_none());
    assert!(plan.stages.iter().all(|s| !s.kind.moves()));
    let axis = |s: &Stage| match &s.kind {
        StageKind::Permeability(p) => p.axis.index(),
        other => panic!("{other:?}"),
    };
    assert_eq!(plan.stages.iter().map(axis).collect::<Vec<_>>(), [0, 1, 2]);
}

#[test]
fn dry_triaxial_has_no_fluid() {
    let plan = load("dry-triaxial.toml");
    assert!(plan.fluid.is_none());
    let StageKind::Run(run) = &plan.stages[1].kind else { panic!("no run stage") };
    assert!(!run.fluid);
    assert_eq!(run.walls[WallId::YMax], WallControl::Velocity(-0.01));
    assert!(matches!(run.until, Until::Strain { strain: 0.15, axis: Axis::Y, .. }));
}

/// Cemented from the first stage on; the walls aside let go of it before it is pressed.
#[test]
fn the_cemented_column_is_unconfined() {
    let plan = load("cemented-column.toml");
    let bonds = plan.bonds.as_ref().unwrap();
    assert_eq!(bonds.from.as_deref(), Some("release"));
    assert!(bonds.strength.tension > 0.0 && bonds.strength.cohesion > 0.0);
    assert!(plan.effects_on().contains(&"brittle bonds"));
    let run = |stage: &Stage| match &stage.kind {
        StageKind::Run(run) => run.clone(),
        other => panic!("{other:?}"),
    };
    let [release, press] = [0, 1].map(|k| run(&plan.stages[k]));
    for wall in [WallId::XMin, WallId::XMax, WallId::ZMin, WallId::ZMax] {
        let WallControl::Velocity(v) = release.walls[wall] else { panic!("{wall} stays") };
        assert!(v * wall.inward() < 0.0, "{wall} comes in");
        assert_eq!(press.walls[wall], WallControl::Fixed);
    }
    assert!(matches!(press.until, Until::Strain { axis: Axis::Y, .. }));
}

/// Viscosity rules: films are on, and the Stokes number of a sphere at its own speed of sinking is below
/// 1.
#[test]
fn sedimentation_is_viscous() {
    let plan = load("sedimentation.toml");
    let on = plan.effects_on();
    for effect in ["viscous shear", "normal lubrication", "buoyancy"] {
        assert!(on.contains(&effect), "{effect}: {on:?}");
    }
    let ParticleSource::Cloud(cloud) = &plan.particles.source else { panic!("no cloud") };
    let fluid = plan.fluid.as_ref().unwrap();
    let (d, mu) = (2.0 * cloud.sizes.largest(), fluid.fluid.viscosity);
    let density = plan.particles.material.density;
    let speed = (density - fluid.effects.density.unwrap()) * 9.81 * d * d / (18.0 * mu);
    assert!(density * d * speed / (18.0 * mu) < 1.0, "{speed}");
}
