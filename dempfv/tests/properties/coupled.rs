//! Coupled steps, and what larger spheres leave open.

use dempfv::coupling::{Coupled, RemeshRule, Saturation};
use dempfv::dem::{Dem, DemOptions, Material, Particles, WallMaterial};
use dempfv::pfv::Flow;
use dempfv::solver::SolverKind;
use dempfv::{Error, WallId};
use proptest::prelude::*;

use crate::common::{Random, Spheres, cubic, face_centred};
use crate::packings::{draws, packing_with_gaps, through_flow};

fn config() -> ProptestConfig {
    let cases = std::env::var("DEMPFV_PROPERTIES").ok().and_then(|n| n.parse().ok());
    ProptestConfig { cases: cases.unwrap_or(64), failure_persistence: None, ..Default::default() }
}

fn permeability(s: &Spheres) -> f64 {
    let fluid = through_flow();
    let mut flow = Flow::new(&s.x, &s.r, s.bounds, &fluid, SolverKind::default()).unwrap();
    flow.solve_static().unwrap();
    flow.permeability(WallId::YMin).unwrap().value
}

fn coupled(s: &Spheres) -> Result<Coupled, Error> {
    let material =
        Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.5, density: 2600.0 };
    let walls = WallMaterial { young: 1e6, friction_angle: 0.5 };
    let options = DemOptions { damping: 0.0, ..DemOptions::default() };
    let spheres = Particles::new(s.x.clone(), s.r.clone(), material.density);
    let mut dem = Dem::new(spheres, s.bounds, material, walls, options)?;
    dem.compute_contacts()?;
    let mut fluid = through_flow();
    fluid.boundary.pressure[WallId::YMin] = Some(0.0);
    let mut coupled = Coupled::new(dem);
    let remesh = RemeshRule { interval: Some(5), strain: None };
    coupled.saturate(Saturation { fluid, solver: SolverKind::default(), remesh });
    Ok(coupled)
}

proptest! {
    #![proptest_config(config())]

    /// A fluid between walls at rest and at a pressure of zero has no energy to give: after each
    /// of some steps of spheres in random motion, kinetic and elastic energy together are what
    /// they were or less. Contacts gain up to 1e-3 where they open and close (docs/time-step.md),
    /// which is allowed for; none is there at the start, when velocities are not yet those of the
    /// middle of a step.
    #[test]
    fn coupled_steps_create_no_energy(draw in draws()) {
        let Some(s) = packing_with_gaps(draw) else { return Ok(()) };
        let Ok(mut coupled) = coupled(&s) else { return Ok(()) };
        let mut random = Random(draw.seed ^ 2);
        for v in coupled.controls().storage_velocities_mut().0.iter_mut() {
            *v = 1e-2 * random.vector();
        }
        let energy = |c: &Coupled| {
            let seen = c.observe();
            seen.kinetic_energy + seen.elastic_energy
        };
        let before = energy(&coupled);
        for step in 0..10 {
            let stepped = coupled
                .update_viscous_mode(true)
                .map(|_| 0.8 * coupled.time_step_bounds().limit())
                .and_then(|dt| coupled.step(dt));
            if let Err(error) = stepped {
                prop_assert!(error.to_string().len() > 10);
                return Ok(());
            }
            let now = energy(&coupled);
            prop_assert!(now <= before * (1.0 + 1e-3), "step {step}: {now:e} J from {before:e} J");
        }
    }

    /// Spheres of a dense packing that all grow leave no more open. Only there: of one sphere alone
    /// it does not hold, since the faces of the power diagram move away from it and throats between
    /// its neighbours become shorter; nor of few spheres in wide pores, whose throats conduct what
    /// a tube around the facet and its spheres does, and that widens with them.
    #[test]
    fn permeability_falls_as_dense_spheres_grow(
        jitter in 0.0..0.05f64,
        growth in 1e-4..2e-2f64,
        edge in 2..5usize,
        lattice in 0..2u8,
    ) {
        let s = if lattice == 0 { cubic(edge, jitter) } else { face_centred(edge, jitter) };
        let r = s.r.iter().map(|r| r / (1.0 + growth)).collect();
        let before = permeability(&Spheres { r, x: s.x.clone(), bounds: s.bounds });
        let after = permeability(&s);
        prop_assert!(after <= before, "{before:e} m², then {after:e} m²");
    }
}
