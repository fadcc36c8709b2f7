//! Rows of coupled runs.

use std::sync::Arc;

use super::dem::Endless;
use super::dem_support::twin;
use super::{NO_LENGTHS, Table};
use dempfv::coupling::{
    Coupled, CoupledState, EdgeEffects, FluidEffects, RemeshRule, Saturation, StandardBuilder,
    TimeStepBounds, viscous_time_step,
};
use dempfv::dem::law::Linear;
use dempfv::dem::{DemOptions, WallControl};
use dempfv::pfv::{Boundary, Clamp, Fluid};
use dempfv::solver::SolverKind;
use dempfv::{Vec3, WallId};

const NAN: Vec3 = Vec3::new(f64::NAN, f64::NAN, f64::NAN);

fn dry() -> Coupled {
    Coupled::new(twin(20, 1, DemOptions::default()))
}

fn water(viscosity: f64, remesh: RemeshRule) -> Saturation {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMax] = Some(0.0);
    let fluid = Fluid { viscosity, slip_walls: true, clamp: Clamp::None, boundary };
    Saturation { fluid, solver: SolverKind::default(), remesh }
}

const RULE: RemeshRule = RemeshRule { interval: Some(10), strain: None };

fn wet() -> Coupled {
    let mut coupled = dry();
    coupled.saturate(water(1e-3, RULE));
    coupled
}

pub fn table() -> Table {
    let mut t = Table::default();
    for value in NO_LENGTHS {
        t.refuses("coupling::Coupled::step", "time step", || dry().step(value));
        t.refuses("coupling::Coupled::step", "time step", || wet().step(value));
        t.refuses("coupling::Coupled::step_fluid", "time step", || {
            // 0 stands for the flow of the moment.
            wet().step_fluid(if value == 0.0 { -0.5 } else { value })
        });
        t.refuses("coupling::Coupled::step_auto", "safety", || wet().step_auto(value));
        t.refuses("coupling::Coupled::automatic_time_step", "safety", || {
            dry().automatic_time_step(value)
        });
        t.refuses("coupling::Coupled::saturate", "fluid.viscosity", || {
            let mut coupled = dry();
            coupled.saturate(water(value, RULE));
            coupled.step(1e-5)
        });
        t.refuses("coupling::Coupled::saturate", "remesh.strain", || {
            let mut coupled = dry();
            let remesh = RemeshRule { interval: None, strain: Some(value) };
            coupled.saturate(water(1e-3, remesh));
            coupled.step(1e-5)
        });
        let bounds = TimeStepBounds {
            contact: value,
            viscous: None,
            viscous_estimate: None,
            collision: Some(1.0),
        };
        t.gives("coupling::TimeStepBounds::automatic", "no number", || {
            let known = TimeStepBounds { contact: 1.0, ..bounds };
            let of_bounds = value == f64::INFINITY || bounds.automatic(0.8).is_nan();
            let of_safety = value == f64::INFINITY || known.automatic(value).is_nan();
            of_bounds && of_safety
        });
        t.gives("coupling::viscous_time_step", "no number", || {
            let steps = [
                viscous_time_step(value, 1.0, 1.0),
                viscous_time_step(1.0, value, 1.0),
                viscous_time_step(1.0, 1.0, value),
            ];
            value == f64::INFINITY || steps.iter().all(|dt| dt.is_nan())
        });
    }
    for value in [f64::NAN, f64::INFINITY, -1.0] {
        let with = |edges: EdgeEffects| {
            let mut coupled = wet();
            coupled.set_fluid_effects(FluidEffects { edges, ..FluidEffects::default() });
            coupled.step(1e-5)
        };
        let function = "coupling::Coupled::set_fluid_effects";
        let squeezed = EdgeEffects { normal_lubrication: true, ..EdgeEffects::default() };
        t.refuses(function, "roughness", || with(EdgeEffects { roughness: value, ..squeezed }));
        t.refuses(function, "stiffness", || {
            with(EdgeEffects { stiffness: Some(value), ..squeezed })
        });
    }
    for value in [f64::NAN, f64::INFINITY, -1.0, 0.0, 2.0] {
        let function = "coupling::Coupled::set_tolerance";
        t.refuses(function, "tolerance", || dry().set_tolerance(value));
        t.refuses(function, "tolerance", || {
            let mut coupled = wet();
            coupled.step(1e-5).unwrap();
            coupled.set_tolerance(value)
        });
    }
    t.gives("coupling::Coupled::watch", "no pressure where there is no pore", || {
        let mut coupled = wet();
        coupled.watch(vec![NAN, Vec3::repeat(1e300), Vec3::repeat(0.5)]);
        coupled.step(1e-5).unwrap();
        let found: Vec<f64> = coupled.probe_pressures().collect();
        found[0].is_nan() && found[1].is_nan() && found[2].is_finite()
    });
    controls(&mut t);
    states(&mut t);
    t
}

fn controls(t: &mut Table) {
    for value in [f64::NAN, f64::INFINITY, -0.1, 2.0] {
        t.refuses("coupling::Controls::set_friction", "friction_angle", || {
            dry().controls().set_friction(value)
        });
        t.refuses("coupling::Controls::set_damping", "damping", || {
            dry().controls().set_damping(value)
        });
    }
    t.refuses("coupling::Controls::set_control", "wall velocity", || {
        dry().controls().set_control(WallId::XMin, WallControl::Velocity(f64::NAN))
    });
    for value in [f64::NAN, f64::INFINITY] {
        t.refuses("coupling::Controls::set_wall_pressure", "pressure", || {
            wet().controls().set_wall_pressure(WallId::YMax, value)
        });
        t.refuses("coupling::Controls::set_imposed_pressure", "pressure", || {
            wet().controls().set_imposed_pressure(0, value)
        });
    }
    t.refuses("coupling::Controls::set_wall_pressure", "imposes none", || {
        let mut coupled = wet();
        coupled.controls().set_wall_pressure(WallId::YMin, 1.0)?;
        coupled.step(1e-5)
    });
    t.refuses("coupling::Controls::set_imposed_pressure", "imposed pressure[7]", || {
        let mut coupled = wet();
        coupled.controls().set_imposed_pressure(7, 1.0)?;
        coupled.step(1e-5)
    });
    t.panics("coupling::Controls::add_force", || dry().controls().add_force(20, Vec3::zeros()));
    t.panics("coupling::Controls::add_torque", || dry().controls().add_torque(20, Vec3::zeros()));
    t.refuses("coupling::Controls::add_force", "particle 7", || {
        let mut coupled = wet();
        coupled.controls().add_force(7, NAN);
        coupled.step(1e-5)
    });
    t.refuses("coupling::Controls::add_body_force", "particle 7", || {
        let mut coupled = wet();
        coupled.controls().add_body_force(Box::new(Endless));
        coupled.step(1e-5)
    });
    t.refuses("coupling::Controls::add_torque", "particle 7", || {
        let mut coupled = dry();
        coupled.controls().add_torque(7, NAN);
        coupled.step(1e-5)
    });
}

fn states(t: &mut Table) {
    type Spoil = fn(&mut CoupledState);
    let spoilt: [(&str, Spoil); 5] = [
        ("young", |s| s.parameters.materials[0].young = f64::NAN),
        ("wall young", |s| s.parameters.wall_material.young = -1.0),
        ("damping", |s| s.parameters.options.damping = 7.0),
        ("tolerance", |s| s.parameters.tolerance = Some(f64::NAN)),
        ("fluid.viscosity", |s| s.parameters.saturation = Some(water(-1.0, RULE))),
    ];
    for (word, spoil) in spoilt {
        let state = || {
            let mut coupled = wet();
            coupled.step(1e-5).unwrap();
            let mut state = coupled.state();
            spoil(&mut state);
            state
        };
        t.refuses("coupling::Coupled::from_state", word, || Coupled::from_state(state()));
        t.refuses("coupling::Coupled::from_state_with", word, || {
            Coupled::from_state_with(state(), Arc::new(StandardBuilder))
        });
        t.refuses("coupling::Coupled::from_state_with_law", word, || {
            Coupled::from_state_with_law(state(), Linear, Arc::new(StandardBuilder))
        });
    }
}
