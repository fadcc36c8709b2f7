//! A step of dry spheres: YADE, LAMMPS and ours by turns.

use std::f64::consts::PI;

use dempfv::io::packing::Packing;
use serde::{Deserialize, Serialize};

use super::Contest;
use super::job::{Contacts, Dry, Job, Material, Stepped};
use super::lammps::{self, Input};
use super::others::Lammps;
use super::sizes::Placed;
use crate::Error;
use crate::bench::sample::Sample;

/// The script that YADE runs.
const YADE: &str = include_str!("../scripts/step.py");
/// The input of LAMMPS.
const LAMMPS: &str = include_str!("../../../peers/dry_step.lmp");
/// Steps that LAMMPS's input does before those that are timed; the others do as many.
const BEFORE: u64 = 100;
/// Distance of spheres beyond contact that LAMMPS keeps in its lists, in mean radii.
const SKIN: f64 = 0.1;

/// One packing in all programs.
#[derive(Serialize, Deserialize)]
pub struct Case {
    pub spheres: usize,
    pub steps: u64,
    pub ours: Side,
    pub yade: Side,
    pub lammps: Option<Side>,
}

/// One program.
#[derive(Default, Serialize, Deserialize)]
pub struct Side {
    /// s.
    pub step_s: Sample,
    /// Between spheres, at the end.
    pub contacts: f64,
}

impl Side {
    fn add(&mut self, run: Stepped) {
        self.step_s.0.push(run.step_s);
        self.contacts = run.contacts;
    }
}

/// Runs the programs by turns.
///
/// # Errors
/// One of them fails.
pub fn measure(contest: &Contest, placed: &Placed) -> Result<Case, Error> {
    let steps = contest.scaled(20_000_000 / placed.spheres as u64).clamp(50, 2000);
    let mut case = Case {
        spheres: placed.spheres,
        steps,
        ours: Side::default(),
        yade: Side::default(),
        lammps: contest.others.lammps.as_ref().map(|_| Side::default()),
    };
    for run in 0..contest.runs {
        let job = |steps: u64| Dry {
            packing: placed.path.clone(),
            bounds: [placed.bounds.min.into(), placed.bounds.max.into()],
            material: Material::default(),
            contacts: Contacts::default(),
            before: BEFORE,
            steps,
            run,
        };
        let name = format!("dry-{}-run{run}", placed.spheres);
        let bench = contest.bench;
        let slow = job((steps / 8).max(20));
        let yade = format!("{name}-yade");
        case.yade.add(bench.remembered(&yade, &slow, || {
            Ok(bench.yade::<Stepped>(&yade, YADE, contest.threads, &slow)?.result)
        })?);
        let job = job(steps);
        if let (Some(lammps), Some(side)) = (&contest.others.lammps, &mut case.lammps) {
            let name = format!("{name}-lammps");
            side.add(bench.remembered(&name, &(&job, &lammps.version), || {
                run_lammps(contest, lammps, &name, (&job, placed))
            })?);
        }
        let ours = format!("{name}-ours");
        case.ours.add(bench.remembered(&ours, &job, || {
            bench.job(&ours, &Job::Dry(job.clone()), contest.threads)
        })?);
    }
    Ok(case)
}

/// LAMMPS with one process for each thread of the others.
fn run_lammps(
    contest: &Contest,
    lammps: &Lammps,
    name: &str,
    (job, placed): (&Dry, &Placed),
) -> Result<Stepped, Error> {
    let packing = Packing::read(&job.packing).map_err(dempfv::Error::from)?;
    let mean = packing.radius.iter().sum::<f64>() / packing.len().max(1) as f64;
    let Material { young, stiffness_ratio, density, damping, dt, .. } = job.material;
    // The others' stiffness of two mean spheres, E r: LAMMPS has one for all pairs.
    let stiffness = young * mean;
    // Local damping takes as much of a cycle as this share of critical viscous damping of
    // such a pair.
    let mass = density * 4.0 / 3.0 * PI * mean.powi(3);
    let gamma = 2.0 * damping / PI * (stiffness / (0.5 * mass)).sqrt();
    let numbers = [
        ("kn", stiffness),
        ("kt", stiffness_ratio * stiffness),
        ("gamma", gamma),
        ("skin", SKIN * mean),
        ("dt", dt),
        ("steps", job.steps as f64),
    ];
    let variables = numbers.map(|(name, value)| (name, value.to_string()));
    let data = lammps::data(&packing, &placed.bounds, density);
    let input = Input { commands: LAMMPS, data, variables: &variables };
    lammps::time(contest, (lammps, contest.threads), name, &input, job.steps)
}
