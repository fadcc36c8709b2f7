//! Injection into pores of choice and the start of a compressible flow, against what YADE found for the
//! same packing: its own check of injection (`checkDEM-PFVPressureInjection.py`) in small. `dempfv
//! compare yade --write-reference` wrote the file.

use std::collections::HashMap;
use std::path::PathBuf;

use dempfv::pfv::terms::{Compressibility, StepTerms};
use dempfv::pfv::{
    Assembled, Boundary, Clamp, ConductanceRules, Flow, Fluid, ImposedPressure, NetworkConditions,
    PoreSelection,
};
use dempfv::scene::load_packing;
use dempfv::solver::SolverKind;
use dempfv::{Aabb, Vec3, WallId};
use serde::Deserialize;

#[derive(Deserialize)]
struct Reference {
    viscosity: f64,
    pressure: f64,
    bulk_modulus: f64,
    dt: f64,
    steps: u32,
    injection: Injection,
    compression: Compression,
    /// m²/(Pa·s)
    mobility: f64,
    /// Into the box at the bottom and at the top (m³/s).
    darcy: [f64; 2],
}

#[derive(Deserialize)]
struct Injection {
    cells: Vec<[u32; 4]>,
    held: Vec<usize>,
    pressure: Vec<f64>,
    entering: f64,
    leaving: f64,
    void: Vec<f64>,
}

#[derive(Deserialize)]
struct Compression {
    pressure: Vec<f64>,
    flux: [f64; 2],
}

struct Packing {
    x: Vec<Vec3>,
    r: Vec<f64>,
    bounds: Aabb,
}

fn known() -> (Reference, Packing) {
    let file =
        |name: &str| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/reference").join(name);
    let text = std::fs::read(file("injection-200.json")).unwrap();
    let (packing, bounds) = load_packing(&file("loading-200.txt"), None).unwrap();
    let packing = Packing { x: packing.position, r: packing.radius, bounds };
    (serde_json::from_slice(&text).unwrap(), packing)
}

/// Throats as YADE has them, with pressures on bottom and top (Pa).
fn fluid(viscosity: f64, below: f64, above: Option<f64>) -> Fluid {
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMin] = Some(below);
    boundary.pressure[WallId::YMax] = above;
    Fluid { viscosity, slip_walls: true, clamp: Clamp::Unlimited, boundary }
}

fn assemble(p: &Packing, fluid: &Fluid, imposed: &[ImposedPressure], terms: StepTerms) -> Flow {
    let assembled = Assembled::with_terms(&p.x, &p.r, p.bounds, fluid, imposed, terms).unwrap();
    assembled.analyze(SolverKind::Cholmod, None).unwrap().factor().unwrap()
}

/// Our number of each of YADE's cells.
fn numbers(flow: &Flow, cells: &[[u32; 4]]) -> Vec<usize> {
    let sorted = |mut cell: [u32; 4]| {
        cell.sort_unstable();
        cell
    };
    let ours = &flow.network().tessellation.cells;
    let by_vertices: HashMap<[u32; 4], usize> =
        ours.iter().enumerate().map(|(i, cell)| (sorted(*cell), i)).collect();
    assert_eq!(ours.len(), cells.len());
    cells.iter().map(|cell| by_vertices[&sorted(*cell)]).collect()
}

/// Largest and median difference of two lists.
fn off(pairs: impl Iterator<Item = (f64, f64)>) -> [f64; 2] {
    let mut all: Vec<f64> = pairs.map(|(a, b)| (a - b).abs()).collect();
    all.sort_unstable_by(f64::total_cmp);
    [all[all.len() - 1], all[all.len() / 2]]
}

/// Water under 1000 Pa at the bottom goes into the pores that are held at none: what enters is what
/// they take, to 1e-12 (YADE's check asks for 1e-11 m³ of all of it, and warns above), and as much as
/// in YADE, to what its walls, which are spheres, cost it.
#[test]
fn injection_is_that_of_yade() {
    let (reference, p) = known();
    let Reference { viscosity, pressure, injection: theirs, .. } = reference;
    let fluid = fluid(viscosity, pressure, None);
    let plain = assemble(&p, &fluid, &[], StepTerms::default());
    let number = numbers(&plain, &theirs.cells);
    let held = theirs.held.iter().map(|&i| number[i] as u32).collect();
    let imposed = [ImposedPressure { pores: PoreSelection::Pores(held), pressure: 0.0 }];
    let mut flow = assemble(&p, &fluid, &imposed, StepTerms::default());
    flow.set_tolerance(1e-14).unwrap();
    flow.solve_static().unwrap();
    let (entering, taken) = (flow.flux()[WallId::YMin.index()], -flow.imposed_flux()[0]);
    assert!((entering / taken - 1.0).abs() < 1e-12, "{entering:e} {taken:e}");
    assert!((theirs.entering / theirs.leaving - 1.0).abs() < 1e-12);
    let flux = entering / theirs.entering - 1.0;
    let ours = number.iter().map(|&i| flow.pressure()[i] / pressure);
    let [largest, median] = off(ours.zip(theirs.pressure.iter().map(|p| p / pressure)));
    assert!(flux.abs() < 5e-5, "{flux:e}");
    assert!(largest < 2e-4 && median < 1e-5, "{largest:e} {median:e}");
}

/// The pores of a compressible fluid begin to fill: after five steps pressures and fluxes are YADE's,
/// to what its void volumes at walls are off.
#[test]
fn a_compressible_flow_is_that_of_yade() {
    let (reference, p) = known();
    let Reference { viscosity, pressure, bulk_modulus, dt, steps, .. } = reference;
    let Reference { injection, compression, .. } = reference;
    // The pores begin at the mean of the imposed pressures, YADE's at none.
    let fluid = fluid(viscosity, 0.0, Some(0.0));
    let terms = vec![Box::new(Compressibility::new(bulk_modulus).unwrap()) as _];
    let mut flow = assemble(&p, &fluid, &[], StepTerms { terms, time_step: dt });
    let number = numbers(&flow, &injection.cells);
    flow.set_wall_pressure(WallId::YMin, pressure).unwrap();
    for _ in 0..steps {
        flow.solve_static().unwrap();
    }
    let void = flow.network().void_volumes(&p.x, &p.r).unwrap();
    let share = number.iter().zip(&injection.void).map(|(&i, theirs)| (void[i] / theirs, 1.0));
    let inside = number
        .iter()
        .map(|&i| flow.network().tessellation.cells[i].iter().all(|&v| (v as usize) < p.x.len()));
    let [void_off, _] = off(share.zip(inside).filter(|(_, inside)| *inside).map(|(pair, _)| pair));
    let ours = number.iter().map(|&i| flow.pressure()[i] / pressure);
    let [largest, median] = off(ours.zip(compression.pressure.iter().map(|p| p / pressure)));
    let flux = [2, 3].map(|w| flow.flux()[w]);
    let fluxes = [0, 1].map(|k| flux[k] / compression.flux[k] - 1.0);
    let figures = format!("{void_off:e} {largest:e} {median:e} {fluxes:?}");
    assert!(void_off < 1e-6, "{figures}");
    assert!(largest < 2e-4 && median < 1e-5, "{figures}");
    assert!(fluxes.iter().all(|off| off.abs() < 5e-5), "{figures}");
}

/// Darcy conductances (YADE's negative `permeabilityFactor`) make the same flux, which is that of the
/// medium: mobility times area times gradient, to round-off in ours.
#[test]
fn a_darcy_medium_is_that_of_yade() {
    let (reference, p) = known();
    let Reference { viscosity, pressure, mobility, darcy, .. } = reference;
    let darcy_permeability = Some(mobility * viscosity);
    let conductances = ConductanceRules { darcy_permeability, ..Default::default() };
    let conditions = NetworkConditions { conductances, ..Default::default() };
    let fluid = fluid(viscosity, pressure, Some(0.0));
    let terms = StepTerms::default();
    let assembled = Assembled::with_conditions(&p.x, &p.r, p.bounds, &fluid, conditions, terms);
    let mut flow = assembled.unwrap().analyze(SolverKind::Cholmod, None).unwrap().factor().unwrap();
    flow.solve_static().unwrap();
    let size = p.bounds.size();
    let medium = mobility * size.x * size.z * pressure / size.y;
    let [below, above] = [2, 3].map(|w| flow.flux()[w]);
    assert!((below / medium - 1.0).abs() < 1e-9, "{below} {medium}");
    let off = [below / darcy[0] - 1.0, above / darcy[1] - 1.0];
    assert!(off.iter().all(|off| off.abs() < 5e-5), "{off:?}");
}
