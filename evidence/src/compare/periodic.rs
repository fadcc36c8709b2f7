//! The part `periodic` of the comparison: the flow through a periodic cube of spheres at rest.

use std::path::{Path, PathBuf};

use dempfv::pfv::{Boundary, Clamp, Flow, Fluid, SealedPoreRule};
use dempfv::scene::Plan;
use dempfv::simulation::Simulation;
use dempfv::solver::SolverKind;
use dempfv::{Cell, InputError, PerWall, Vec3};
use serde::{Deserialize, Serialize};

use super::peer::Bench;
use super::verdict::Verdict;
use crate::Error;
use crate::bench::sample::{Sample, worst};

const SCRIPT: &str = include_str!("scripts/periodic.py");
/// The cube that YADE wants, its spheres, and the flow.
const EDGE: f64 = 0.1;
const SPHERES: usize = 500;
const VISCOSITY: f64 = 1e-3;
/// Pa/m.
const GRADIENT: f64 = 1.0;
/// What the permeability may differ by, of its largest component; and forces, of their mean.
const PERMEABILITY: f64 = 1e-11;
const FORCE: f64 = 1e-9;

#[derive(Serialize)]
struct Job {
    spheres: Vec<[f64; 4]>,
    edge: f64,
    viscosity: f64,
    gradient: f64,
}

#[derive(Deserialize)]
struct Found {
    pores: usize,
    velocity: Vec3,
    force: Vec<Vec3>,
}

/// What was measured.
#[derive(Serialize, Deserialize)]
pub struct Part {
    pores: [usize; 2],
    /// K_xx, K_yx, K_zx (m²), ours and YADE's.
    permeability: [[f64; 3]; 2],
    /// Differences of the forces on spheres, of their mean.
    forces: Sample,
    /// Sum of the forces over −G V, less 1, ours and YADE's.
    sum: [f64; 2],
}

impl super::Part for Part {
    const NAME: &'static str = "periodic";

    fn measure(bench: &Bench, _: &[PathBuf]) -> Result<Part, Error> {
        let (job, cell) = settled(bench)?;
        let theirs = bench.yade::<Found>(Self::NAME, SCRIPT, 1, &job)?.result;
        let flow = flow(&job, &cell).map_err(dempfv::Error::from)?;
        let ours = flow.mean_velocity().unwrap_or_default();
        let permeability = [ours, theirs.velocity].map(|u| (-VISCOSITY / GRADIENT * u).into());
        let size = theirs.force.iter().map(Vec3::norm).sum::<f64>() / theirs.force.len() as f64;
        let pairs = flow.force().iter().zip(&theirs.force);
        let sum = |force: &[Vec3]| {
            let all = -GRADIENT * cell.volume();
            force.iter().map(|f| f.x).sum::<f64>() / all - 1.0
        };
        Ok(Part {
            pores: [flow.network().pores(), theirs.pores],
            permeability,
            forces: pairs.map(|(a, b)| (a - b).norm() / size).collect(),
            sum: [sum(flow.force()), sum(&theirs.force)],
        })
    }

    fn verdicts(&self) -> Vec<Verdict> {
        let [ours, theirs] = self.permeability;
        let apart = ours.iter().zip(theirs).map(|(a, b)| (a - b) / theirs[0]);
        let verdict = |quantity: &str, largest: f64, bound: f64| Verdict {
            on: format!("{SPHERES} spheres in a cube"),
            quantity: quantity.to_owned(),
            largest,
            median: None,
            bound,
            explanation: None,
        };
        let [pores, others] = self.pores.map(|n| n as f64);
        vec![
            verdict("number of pores", (pores - others).abs(), 0.0),
            verdict("permeability, of K_xx", worst(apart), PERMEABILITY),
            Verdict {
                median: Some(self.forces.median()),
                ..verdict("forces on spheres, of their mean", worst(self.forces.0.clone()), FORCE)
            },
            verdict("ours, sum of the forces and G V", self.sum[0].abs(), PERMEABILITY),
            verdict("YADE, the same", self.sum[1].abs(), PERMEABILITY),
        ]
    }

    fn section(&self, _: &Path) -> Result<String, Error> {
        let mut text = INTRODUCTION.to_owned();
        let [ours, theirs] = self.permeability;
        for (name, (a, b)) in ["xx", "yx", "zx"].iter().zip(ours.iter().zip(theirs)) {
            text += &format!("| K_{name} (m²) | {a:.12e} | {b:.12e} |\n");
        }
        let [a, b] = self.pores;
        text += &format!("| pores | {a} | {b} |\n\n");
        Ok(text + &Verdict::table(&self.verdicts()))
    }
}

const INTRODUCTION: &str = "\
## A periodic cell

500 spheres, radii within 30 % of their mean, that ours has settled at 1 kPa in a periodic cube of 0.1 m;
spheres held, 1 mPa·s, a mean gradient of pressure of 1 Pa/m along x. YADE's `PeriodicFlowEngine`, which wants
a cube, with bounds of its clamp that let every conductance pass. K = −μ U/G with the mean velocity U. On a
simple cubic lattice YADE gives no number, since centres of pores coincide
([evidence](evidence/2026-11-30-periodic-flow.md)).

| | dempfv | YADE |
|:--|--:|--:|
";

/// Spheres at rest in the cube, with their centres in it.
fn settled(bench: &Bench) -> Result<(Job, Cell), Error> {
    let scene = format!(
        "[cell]\nsize = [{EDGE}, {EDGE}, {EDGE}]\n\
         [particles]\ncloud = {{ count = {SPHERES}, spread = 0.3, porosity = 0.8 }}\nyoung = 1.0e7\n\
         [dem]\n[[stage]]\nkind = \"compact\"\nstress = 1.0e3\nfriction_angle = 10.0\n"
    );
    let mut simulation = Simulation::new(Plan::from_toml(&scene, None)?)?;
    bench.step("settled-cell", || {
        while simulation.advance()? {}
        Ok::<(), Error>(())
    })?;
    let dem = simulation.coupled().dem();
    let cell = Cell::of_size(Vec3::repeat(EDGE))
        .map_err(|e| InputError::new(e.to_string(), "a cube with a positive edge"))?;
    let inside = |x: Vec3| x.map(|x| x.rem_euclid(EDGE));
    let spheres = dem.positions().into_iter().map(inside).zip(dem.radii());
    let spheres = spheres.map(|(x, r)| [x.x, x.y, x.z, r]).collect();
    Ok((Job { spheres, edge: EDGE, viscosity: VISCOSITY, gradient: GRADIENT }, cell))
}

fn flow(job: &Job, cell: &Cell) -> Result<Flow, dempfv::pfv::PfvError> {
    let (position, radius): (Vec<Vec3>, Vec<f64>) =
        job.spheres.iter().map(|&[x, y, z, r]| (Vec3::new(x, y, z), r)).unzip();
    let boundary = Boundary { pressure: PerWall([None; 6]), sealed_pores: SealedPoreRule::Closed };
    let fluid = Fluid { viscosity: VISCOSITY, slip_walls: true, clamp: Clamp::None, boundary };
    let mut flow = Flow::in_cell(&position, &radius, cell, &fluid, SolverKind::default())?;
    flow.set_tolerance(1e-14)?;
    flow.set_pressure_gradient(Vec3::new(GRADIENT, 0.0, 0.0))?;
    flow.solve_static()?;
    Ok(flow)
}
