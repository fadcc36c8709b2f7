//! The parts `injection` and `compressible` of the comparison: flows through packings at rest, pore for pore.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use dempfv::pfv::terms::{Compressibility, StepTerms};
use dempfv::pfv::{
    Assembled, Boundary, Clamp, ConductanceRules, Flow, Fluid, ImposedPressure, NetworkConditions,
    PfvError, PoreSelection,
};
use dempfv::solver::SolverKind;
use dempfv::{Aabb, Vec3, WallId};
use serde::{Deserialize, Serialize};

use super::conditions::{Case, Compression, Found, Injection, Job};
use super::loading::Packing;
use super::peer::Bench;
use super::verdict::Verdict;
use crate::Error;
use crate::bench::sample::{Sample, worst};

/// Packings of more spheres take YADE too long.
const LARGEST: usize = 6000;
/// What may differ: fluxes, of themselves; pressures, of that at the bottom; void volumes, of
/// themselves. YADE's walls are huge spheres.
const FLUX: f64 = 5e-5;
const PRESSURE: f64 = 2e-4;
const VOID: f64 = 1e-12;
/// What enters over what leaves, of a flow without storage.
const BALANCE: f64 = 1e-11;

/// Injection at points, and a Darcy medium.
#[derive(Serialize, Deserialize)]
pub struct Injected {
    verdicts: Vec<Verdict>,
}

/// The start of a flow of a compressible fluid.
#[derive(Serialize, Deserialize)]
pub struct Compressible {
    verdicts: Vec<Verdict>,
}

impl super::Part for Injected {
    const NAME: &'static str = "injection";

    fn measure(bench: &Bench, packings: &[PathBuf]) -> Result<Injected, Error> {
        let cases = [Case::Injection, Case::Darcy];
        Ok(Injected { verdicts: on_each(bench, packings, (Self::NAME, &cases), injected)? })
    }

    fn verdicts(&self) -> Vec<Verdict> {
        self.verdicts.clone()
    }

    fn section(&self, _: &Path) -> Result<String, Error> {
        Ok(format!("{INJECTED}{}", Verdict::table(&self.verdicts)))
    }
}

impl super::Part for Compressible {
    const NAME: &'static str = "compressible";

    fn measure(bench: &Bench, packings: &[PathBuf]) -> Result<Compressible, Error> {
        let cases = [Case::Compression];
        Ok(Compressible { verdicts: on_each(bench, packings, (Self::NAME, &cases), compressed)? })
    }

    fn verdicts(&self) -> Vec<Verdict> {
        self.verdicts.clone()
    }

    fn section(&self, _: &Path) -> Result<String, Error> {
        Ok(format!("{COMPRESSIBLE}{}", Verdict::table(&self.verdicts)))
    }
}

const INJECTED: &str = "\
## Injection

YADE's own check of injection (`checkDEM-PFVPressureInjection.py`) on these packings, at rest: 1000 Pa at the
bottom drive water of 0.1 Pa·s into pores that are held at zero above a third of the height; what enters must
be what they take. Then Darcy conductances, YADE's `permeabilityFactor` of −2·10⁻³ m²/(Pa·s), between 1000 Pa
and 0. Slip walls, no clamp. YADE's walls are huge spheres, which is what bounds the rest (see Walls).

";

const COMPRESSIBLE: &str = "\
## A compressible fluid

The same packings, at rest, full of a fluid of 0.1 Pa·s and a bulk modulus of 1 MPa (YADE's
`fluidBulkModulus`) without pressure; from the first step on 1000 Pa at the bottom and 0 at the top. Steps of
10⁻⁴ s, backward Euler in both. Slip walls, no clamp. What pores store goes with their void volume: YADE
integrates that of a pore at a wall over the sphere that its wall is, so those are compared inside only. In
the first step the pores at the bottom fill as their pressure jumps: ours counts that in the flux through the
wall, YADE what passes on from them only; it is taken off ours here (0.4 of what enters).

";

/// What one packing gives, for all that YADE is quick enough with.
fn on_each(
    bench: &Bench,
    packings: &[PathBuf],
    (name, cases): (&str, &[Case]),
    compare: fn(&Specimen, &Found) -> Result<Vec<Verdict>, Error>,
) -> Result<Vec<Verdict>, Error> {
    let mut verdicts = vec![];
    for path in packings {
        let packing = Packing::load(path)?;
        if packing.spheres.len() > LARGEST {
            continue;
        }
        let specimen = Specimen::new(&packing, cases);
        let found = specimen.job.ask(bench, &format!("{name}-{}", specimen.name))?;
        verdicts.extend(compare(&specimen, &found)?);
    }
    Ok(verdicts)
}

/// A packing in ours.
struct Specimen {
    name: String,
    job: Job,
    position: Vec<Vec3>,
    radius: Vec<f64>,
    bounds: Aabb,
}

impl Specimen {
    fn new(packing: &Packing, cases: &[Case]) -> Specimen {
        let spheres = packing.spheres.iter();
        let (position, radius) = spheres.map(|&[x, y, z, r]| (Vec3::new(x, y, z), r)).unzip();
        let [a, b, c, d, e, f] = packing.bounds;
        let bounds = Aabb { min: Vec3::new(a, b, c), max: Vec3::new(d, e, f) };
        Specimen { name: packing.name(), job: Job::new(packing, cases), position, radius, bounds }
    }

    fn flow(
        &self,
        [below, above]: [Option<f64>; 2],
        conditions: NetworkConditions,
        terms: StepTerms,
    ) -> Result<Flow, PfvError> {
        let mut boundary = Boundary::default();
        boundary.pressure[WallId::YMin] = below;
        boundary.pressure[WallId::YMax] = above;
        let viscosity = self.job.viscosity;
        let fluid = Fluid { viscosity, slip_walls: true, clamp: Clamp::Unlimited, boundary };
        let Specimen { position, radius, bounds, .. } = self;
        let flow =
            Assembled::with_conditions(position, radius, *bounds, &fluid, conditions, terms)?;
        flow.analyze(SolverKind::Cholmod, None)?.factor()
    }

    fn verdict(&self, quantity: &str, off: &[f64], bound: f64) -> Verdict {
        let off: Sample = off.iter().map(|x| x.abs()).collect();
        Verdict {
            on: self.name.clone(),
            quantity: quantity.to_owned(),
            largest: worst(off.0.iter().copied()),
            median: (off.0.len() > 2).then(|| off.median()),
            bound,
            explanation: None,
        }
    }

    /// How far pressures are apart, of that at the bottom.
    fn pressures(&self, flow: &Flow, number: &[usize], theirs: &[f64]) -> Vec<f64> {
        // Pores that both hold at nothing tell nothing.
        let pairs = number.iter().zip(theirs).filter(|(_, theirs)| **theirs != 0.0);
        pairs.map(|(&i, theirs)| (flow.pressure()[i] - theirs) / self.job.pressure).collect()
    }
}

/// Our number of each of YADE's cells.
fn numbers(flow: &Flow, cells: &[[u32; 4]]) -> Result<Vec<usize>, Error> {
    let sorted = |mut cell: [u32; 4]| {
        cell.sort_unstable();
        cell
    };
    let ours = &flow.network().tessellation.cells;
    let by_vertices: HashMap<[u32; 4], usize> =
        ours.iter().enumerate().map(|(i, cell)| (sorted(*cell), i)).collect();
    let found = cells.iter().map(|cell| by_vertices.get(&sorted(*cell)).copied());
    let all: Option<Vec<usize>> = found.collect();
    all.filter(|all| all.len() == ours.len()).ok_or_else(|| Error::Peer {
        step: "pores".to_owned(),
        what: "the two programs triangulate the packing differently; the part network shows where"
            .to_owned(),
        log: None,
    })
}

fn injected(specimen: &Specimen, found: &Found) -> Result<Vec<Verdict>, Error> {
    let wrong = dempfv::Error::from;
    let job = &specimen.job;
    let mut verdicts = vec![];
    if let Some(Injection { cells, held, pressure, entering, leaving, .. }) = &found.injection {
        let drained = [Some(job.pressure), None];
        let plain = specimen.flow(drained, NetworkConditions::default(), StepTerms::default());
        let number = numbers(&plain.map_err(wrong)?, cells)?;
        let held = held.iter().map(|&i| number[i as usize] as u32).collect();
        let imposed = vec![ImposedPressure { pores: PoreSelection::Pores(held), pressure: 0.0 }];
        let conditions = NetworkConditions { imposed, ..Default::default() };
        let mut flow = specimen.flow(drained, conditions, StepTerms::default()).map_err(wrong)?;
        flow.set_tolerance(1e-14).map_err(wrong)?;
        flow.solve_static().map_err(wrong)?;
        let [ours, taken] = [flow.flux()[WallId::YMin.index()], -flow.imposed_flux()[0]];
        verdicts.extend([
            specimen.verdict(
                "ours, what enters over what held pores take",
                &[ours / taken - 1.0],
                BALANCE,
            ),
            specimen.verdict("YADE, the same", &[entering / leaving - 1.0], BALANCE),
            specimen.verdict("injection, flux", &[ours / entering - 1.0], FLUX),
            specimen.verdict(
                "injection, pressures",
                &specimen.pressures(&flow, &number, pressure),
                PRESSURE,
            ),
        ]);
    }
    if let Some(theirs) = found.darcy {
        let darcy_permeability = Some(job.mobility * job.viscosity);
        let conductances = ConductanceRules { darcy_permeability, ..Default::default() };
        let conditions = NetworkConditions { conductances, ..Default::default() };
        let ends = [Some(job.pressure), Some(0.0)];
        let mut flow = specimen.flow(ends, conditions, StepTerms::default()).map_err(wrong)?;
        flow.solve_static().map_err(wrong)?;
        let off = [2, 3].map(|wall| flow.flux()[wall] / theirs[wall - 2] - 1.0);
        verdicts.push(specimen.verdict("Darcy medium, fluxes", &off, FLUX));
    }
    Ok(verdicts)
}

fn compressed(specimen: &Specimen, found: &Found) -> Result<Vec<Verdict>, Error> {
    let wrong = dempfv::Error::from;
    let job = &specimen.job;
    let Some(Compression { cells, void, looks }) = &found.compression else { return Ok(vec![]) };
    let terms = vec![Box::new(Compressibility::new(job.bulk_modulus).map_err(wrong)?) as _];
    let terms = StepTerms { terms, time_step: job.dt };
    // The pores begin at the mean of the imposed pressures, YADE's at none.
    let still = [Some(0.0), Some(0.0)];
    let mut flow = specimen.flow(still, NetworkConditions::default(), terms).map_err(wrong)?;
    flow.set_wall_pressure(WallId::YMin, job.pressure).map_err(wrong)?;
    let number = numbers(&flow, cells)?;
    let spheres = specimen.position.len();
    let is_inside =
        |i: usize| flow.network().tessellation.cells[i].iter().all(|&v| (v as usize) < spheres);
    let ours = flow.network().void_volumes(&specimen.position, &specimen.radius).map_err(wrong)?;
    let inside = number.iter().zip(void).filter(|(i, _)| is_inside(**i));
    let off: Vec<f64> = inside.map(|(&i, theirs)| ours[i] / theirs - 1.0).collect();
    let mut verdicts = vec![specimen.verdict("void volumes of pores inside", &off, VOID)];
    let mut done = 0;
    for (look, theirs) in job.looks.iter().zip(looks) {
        for _ in done..*look {
            flow.solve_static().map_err(wrong)?;
        }
        done = *look;
        let off = specimen.pressures(&flow, &number, &theirs.pressure);
        verdicts.push(specimen.verdict(&format!("pressures after {look} steps"), &off, PRESSURE));
        let mut fluxes = [2, 3].map(|wall| flow.flux()[wall]);
        if *look == 1 {
            // YADE does not count what the pores at the bottom take up as their pressure jumps.
            let held = flow.pressure().iter().zip(&ours).filter(|(p, _)| **p >= job.pressure);
            let taken: f64 = held.map(|(p, void)| p * void).sum();
            fluxes[0] -= taken / (job.bulk_modulus * job.dt);
        }
        // What has reached the top is little at first: both are compared with what enters.
        let off = [0, 1].map(|k| (fluxes[k] - theirs.flux[k]) / theirs.flux[0]);
        verdicts.push(specimen.verdict(
            &format!("fluxes after {look} steps, of what enters"),
            &off,
            FLUX,
        ));
    }
    Ok(verdicts)
}
