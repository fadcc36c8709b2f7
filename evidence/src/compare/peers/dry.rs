//! A step of dry spheres: YADE, LAMMPS and ours by turns.

use std::f64::consts::PI;
use std::process::Command;

use dempfv::io::packing::Packing;
use serde::{Deserialize, Serialize};

use super::Contest;
use super::job::{Dry, Job, Material, Stepped};
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
                run_lammps(contest, lammps, &name, &job)
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
fn run_lammps(contest: &Contest, lammps: &Lammps, name: &str, job: &Dry) -> Result<Stepped, Error> {
    let packing = Packing::read(&job.packing).map_err(dempfv::Error::from)?;
    let data = contest.bench.write(&format!("jobs/{name}.data"), &data(&packing, job))?;
    let input = contest.bench.write(&format!("jobs/{name}.in"), LAMMPS)?;
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
    let mut command = Command::new(&lammps.starter);
    // Some containers have root alone, which Open MPI refuses unless it is told twice.
    command.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
    command.env("OMP_NUM_THREADS", "1");
    command.args(["-np", &contest.threads.to_string()]).arg(&lammps.program);
    command.args(["-log", "none", "-in"]).arg(&input).args(["-var", "data"]).arg(&data);
    for (name, value) in numbers {
        command.args(["-var", name, &value.to_string()]);
    }
    let log = contest.bench.run_logged(name, "LAMMPS", &mut command)?;
    let text = std::fs::read_to_string(&log).map_err(|e| dempfv::Error::io(&log, e))?;
    read_log(&text, job.steps).ok_or_else(|| Error::Peer {
        step: name.to_owned(),
        what: "LAMMPS printed neither its time nor its contacts".to_owned(),
        log: Some(log),
    })
}

/// The packing as LAMMPS reads it.
fn data(packing: &Packing, job: &Dry) -> String {
    let mut text = format!("spheres\n\n{} atoms\n1 atom types\n\n", packing.len());
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let [low, high] = job.bounds.map(|corner| corner[axis]);
        text += &format!("{low:e} {high:e} {name}lo {name}hi\n");
    }
    text += "\nAtoms # sphere\n\n";
    for (i, (x, r)) in packing.position.iter().zip(&packing.radius).enumerate() {
        let (diameter, density) = (2.0 * r, job.material.density);
        text += &format!("{} 1 {diameter:e} {density:e} {:e} {:e} {:e}\n", i + 1, x.x, x.y, x.z);
    }
    text
}

/// Time per step and contacts from what LAMMPS prints: the run of so many steps, and the
/// last number of contacts of a sphere.
fn read_log(text: &str, steps: u64) -> Option<Stepped> {
    let (mut time, mut contacts, mut in_table) = (None, None, false);
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        if let ["Loop", "time", "of", seconds, "on", _, "procs", "for", count, ..] = words[..] {
            in_table = false;
            if count.parse() == Ok(steps) {
                time = seconds.parse::<f64>().ok();
            }
        }
        if let (true, [_, spheres, _, each]) = (in_table, &words[..]) {
            let (spheres, each): (Option<f64>, Option<f64>) =
                (spheres.parse().ok(), each.parse().ok());
            // Each of two spheres counts a contact.
            contacts = spheres.zip(each).map(|(n, each)| 0.5 * n * each);
        }
        in_table |= words == ["Step", "Atoms", "KinEng", "c_mean"];
    }
    Some(Stepped { step_s: time? / steps as f64, contacts: contacts? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_log_of_lammps_is_read() {
        let text = "Step Atoms KinEng c_mean \n 0 5 0 3.2 \n 100 5 0 5.0 \n\
                    Loop time of 9 on 2 procs for 100 steps with 5 atoms\n\
                    Step Atoms KinEng c_mean \n 100 5 0 5.0 \n 600 5 1e-9 5.6 \n\
                    Loop time of 1.5 on 2 procs for 500 steps with 5 atoms\n 1 2 3 4\n";
        let read = read_log(text, 500).unwrap();
        assert_eq!((read.step_s, read.contacts), (0.003, 14.0));
        assert!(read_log(text, 600).is_none());
        assert!(read_log("Loop time of 1.5 on 2 procs for 500 steps", 500).is_none());
    }
}
