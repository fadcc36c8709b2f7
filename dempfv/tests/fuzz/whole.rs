//! From an input to a result.

use dempfv::io::packing::Packing;
use dempfv::io::{checkpoint, matrix_market};
use dempfv::pfv::{Boundary, Clamp, Flow, Fluid};
use dempfv::scene::{Plan, validate_packing};
use dempfv::simulation::{Estimate, Simulation, SimulationState, Specimen};
use dempfv::solver::SolverKind;
use dempfv::{Aabb, Vec3, WallId};

use super::corpus;
use super::harness::{fuzz, inputs};
use super::readers::vouch;

/// A flow that is computed is one of numbers.
#[test]
fn packings_give_a_flow_of_numbers_or_an_error() {
    fuzz("packing to flow", &corpus::few_spheres(), inputs(400, 0.02), |bytes| {
        let text = String::from_utf8_lossy(bytes);
        let packing = Packing::parse(&text).map_err(|e| e.to_string())?;
        let bounds = packing.bounds_or_tight().ok_or("no box")?;
        validate_packing(&packing.position, &packing.radius, None, &bounds, None)
            .map_err(|e| e.to_string())?;
        flow(&packing.position, &packing.radius, bounds)
    });
}

fn flow(position: &[Vec3], radius: &[f64], bounds: Aabb) -> Result<(), String> {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMin] = Some(1.0);
    boundary.pressure[WallId::YMax] = Some(0.0);
    let fluid = Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary };
    let mut flow = Flow::new(position, radius, bounds, &fluid, SolverKind::default())
        .map_err(|e| e.to_string())?;
    flow.solve_static().map_err(|e| e.to_string())?;
    let n = flow.network();
    assert!(n.volume.iter().all(|v| v.is_finite()), "a volume is no number");
    assert!(n.throats.conductance.iter().all(|g| g.is_finite() && *g >= 0.0), "a conductance");
    assert!(flow.pressure().iter().all(|p| p.is_finite()), "a pressure is no number");
    assert!(flow.force().iter().flat_map(|f| f.iter()).all(|f| f.is_finite()), "a force");
    assert!(flow.flux().iter().all(|q| q.is_finite()), "a flux is no number");
    let k = flow.permeability(WallId::YMin);
    assert!(k.is_none_or(|k| k.value.is_finite()), "the permeability is no number");
    Ok(())
}

/// A few steps of a scene give numbers.
#[test]
fn scenes_give_steps_of_numbers_or_an_error() {
    let folder = corpus::folder("small");
    std::fs::write(folder.join("few.txt"), &corpus::few_spheres()[0]).unwrap();
    let file = folder.join("scene.toml");
    fuzz("scene to steps", &corpus::small_scenes(), inputs(150, 0.005), |bytes| {
        let text = String::from_utf8_lossy(bytes);
        let plan = Plan::from_toml(&text, Some(&file)).map_err(|e| e.to_string())?;
        let cloud = Specimen::of_cloud(&plan).unwrap_or_default();
        // As the program does: what does not fit is refused before.
        let memory = Estimate::of(&plan, &cloud).map_err(|e| e.to_string())?.memory;
        if cloud.spheres > 1000 || memory > 1e8 {
            return Err("too large".to_owned());
        }
        steps(&mut Simulation::new(plan).map_err(|e| e.to_string())?)
    });
    std::fs::remove_dir_all(folder).unwrap();
}

/// What a checkpoint with a right checksum holds may be anything.
#[test]
fn states_go_on_in_numbers_or_are_refused() {
    let folder = corpus::folder("states");
    let file = folder.join("a.dempfv");
    checkpoint::save(&file, &corpus::state()).unwrap();
    let whole = std::fs::read(&file).unwrap();
    let plan = corpus::plan();
    fuzz("state to steps", std::slice::from_ref(&whole), inputs(300, 0.02), |bytes| {
        let mut bytes = bytes.to_vec();
        vouch(&mut bytes);
        std::fs::write(&file, &bytes).unwrap();
        let state: SimulationState = checkpoint::load(&file).map_err(|e| e.to_string())?;
        steps(&mut Simulation::restart(plan.clone(), state).map_err(|e| e.to_string())?)
    });
    std::fs::remove_dir_all(folder).unwrap();
}

fn steps(simulation: &mut Simulation) -> Result<(), String> {
    for _ in 0..3 {
        let more = simulation.advance().map_err(|e| e.to_string())?;
        let dem = simulation.coupled().dem();
        let is_finite = |x: &[Vec3]| x.iter().all(|x| x.iter().all(|x| x.is_finite()));
        assert!(is_finite(&dem.storage().position), "a position is no number");
        assert!(is_finite(&dem.storage().velocity), "a velocity is no number");
        if let Some(flow) = simulation.coupled().storage_flow() {
            assert!(flow.pressure().iter().all(|p| p.is_finite()), "a pressure is no number");
        }
        if !more {
            break;
        }
    }
    Ok(())
}

/// Any solver's solution is one of numbers.
#[test]
fn matrices_give_solutions_of_numbers_or_an_error() {
    let folder = corpus::folder("systems");
    let file = folder.join("a.mtx");
    fuzz("matrix to solution", &corpus::matrices(), inputs(400, 0.02), |bytes| {
        std::fs::write(&file, bytes).unwrap();
        let a = matrix_market::read_matrix(&file).map_err(|e| e.to_string())?;
        let mut outcome = Ok(());
        for kind in [SolverKind::Cholmod, SolverKind::Frontal] {
            let mut x = vec![0.0; a.n];
            let solved = kind
                .backend()
                .analyze(&a, None)
                .and_then(|symbolic| symbolic.factor(&a))
                .and_then(|mut factor| factor.solve_checked(&a, &vec![1.0; a.n], &mut x));
            match solved {
                Ok(_) => assert!(x.iter().all(|x| x.is_finite()), "{kind:?}: no number"),
                Err(e) => outcome = Err(e.to_string()),
            }
        }
        outcome
    });
    std::fs::remove_dir_all(folder).unwrap();
}
