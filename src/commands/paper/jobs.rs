//! What there is to measure, in what order, and how long it takes.

use std::io::{IsTerminal, Write};
use std::time::Instant;

use dempfv::scene::{self, Estimate, Plan};

use super::figures::Figure;
use super::machine::Machine;
use super::remesh;
use super::specimens::Specimen;
use super::timing::{self, Mode};
use super::built;
use crate::commands::Error;
use crate::commands::bench::Bench;
use crate::commands::format::duration;

/// A run without any acceleration is made where it takes no longer than this (s); else its
/// total is composed.
const AFFORDABLE: f64 = 60.0;

/// One point of a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Job {
    Remesh(remesh::Run),
    Built { specimen: Specimen, threads: usize },
    Run { specimen: Specimen, mode: Mode },
}

/// Points that are to be measured, small specimens first.
pub struct Jobs {
    list: Vec<Job>,
    /// Points that this machine has no memory for.
    pub left_out: Vec<String>,
}

impl Jobs {
    /// What these figures need of these specimens.
    pub fn new(figures: &[Figure], specimens: &[Specimen], machine: &Machine) -> Jobs {
        let mut jobs = Jobs { list: vec![], left_out: vec![] };
        if figures.contains(&Figure::Remesh) {
            jobs.list.extend(remesh::Run::all().map(Job::Remesh));
        }
        for &specimen in specimens {
            if figures.contains(&Figure::Build) {
                jobs.list.push(Job::Built { specimen, threads: 1 });
                if machine.threads > 1 {
                    jobs.list.push(Job::Built { specimen, threads: machine.threads });
                }
            }
            for mode in Mode::ALL {
                let needed = figures.iter().any(|figure| figure.modes().contains(&mode));
                let job = Job::Run { specimen, mode };
                if needed && (mode != Mode::Plain || job.seconds() <= AFFORDABLE) {
                    jobs.add(job, machine);
                }
            }
        }
        jobs
    }

    fn add(&mut self, job: Job, machine: &Machine) {
        let memory = job.memory();
        if machine.memory > 0.0 && memory > machine.memory {
            let (need, have) = (memory * 1e-9, machine.memory * 1e-9);
            let point = job.point();
            self.left_out.push(format!("{point} (needs about {need:.0} GB of {have:.0} GB)"));
        } else {
            self.list.push(job);
        }
    }

    /// Makes all of it unknown.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn forget(&self, bench: &Bench) -> Result<(), Error> {
        self.list.iter().try_for_each(|job| bench.forget(&format!("{}.json", job.point())))
    }

    /// Measures what is not known yet; says on a terminal how long all of it takes.
    ///
    /// # Errors
    /// The first that fails; all before it are kept.
    pub fn carry_out(&self, bench: &Bench, threads: usize) -> Result<(), Error> {
        let (mut done, mut spent) = (0.0, 0.0);
        for (i, job) in self.list.iter().enumerate() {
            let left: f64 = self.list[i..].iter().map(Job::seconds).sum();
            // The machine at hand is as fast as it has been so far.
            let pace = if done > 0.0 { spent / done } else { 1.0 };
            let (k, all, left) = (i + 1, self.list.len(), duration(pace * left));
            note(&format!("{k} of {all}, about {left} left: {}", job.point()));
            let start = Instant::now();
            job.carry_out(bench, threads)?;
            let time = start.elapsed().as_secs_f64();
            // Points that were known take no time and tell nothing about the machine.
            if time > 0.1 {
                (done, spent) = (done + job.seconds(), spent + time);
            }
        }
        Ok(())
    }
}

impl Job {
    fn carry_out(&self, bench: &Bench, threads: usize) -> Result<(), Error> {
        match *self {
            Job::Remesh(run) => remesh::measure(bench, run, threads).map(drop),
            Job::Built { specimen, threads } => built::measure(bench, &specimen, threads).map(drop),
            Job::Run { specimen, mode } => {
                timing::measure(bench, &specimen, mode, mode.threads(threads)).map(drop)
            }
        }
    }

    /// Name of what it measures.
    fn point(&self) -> String {
        match *self {
            Job::Remesh(run) => run.name(),
            Job::Built { specimen, threads } => built::name(&specimen, threads),
            Job::Run { specimen, mode } => timing::name(&specimen, mode),
        }
    }

    /// About how long it takes (s).
    fn seconds(&self) -> f64 {
        match *self {
            Job::Remesh(run) => {
                let e = estimate(&remesh::SPECIMEN, Mode::AllCores);
                remesh::STEPS as f64 * (e.step + e.remesh / run.interval() as f64)
            }
            Job::Built { specimen, threads } => {
                let all = 3e-6 * f64::from(specimen.spheres) * 6.0;
                if threads == 1 { 1.5 * all } else { all }.max(1.0)
            }
            Job::Run { specimen, mode } => {
                let e = estimate(&specimen, mode);
                let (steps, interval) = (mode.steps(&specimen), mode.interval(&specimen));
                steps as f64 * e.step + steps.div_ceil(interval) as f64 * e.remesh
            }
        }
    }

    /// About how much memory it needs (bytes).
    fn memory(&self) -> f64 {
        match *self {
            Job::Run { specimen, mode } => estimate(&specimen, mode).memory,
            Job::Remesh(_) | Job::Built { .. } => 0.0,
        }
    }
}

/// What a run can be expected to need.
struct Need {
    /// Time of a step between two remeshes (s).
    step: f64,
    /// Time of a remesh (s).
    remesh: f64,
    /// Memory (bytes).
    memory: f64,
}

fn estimate(specimen: &Specimen, mode: Mode) -> Need {
    let scene = timing::scene("packing".as_ref(), specimen, mode);
    let spheres =
        scene::Specimen { spheres: specimen.spheres as usize, ..scene::Specimen::default() };
    // The scene is ours and right: without a plan there would be nothing to measure either.
    let Ok(plan) = Plan::from_toml(&scene, None) else {
        return Need { step: 0.0, remesh: 0.0, memory: 0.0 };
    };
    let e = Estimate::of(&plan, &spheres);
    let remesh = e.remesh.unwrap_or(0.0);
    let share = remesh / mode.interval(specimen) as f64;
    Need { step: e.coupled_step.unwrap_or(0.0) - share, remesh, memory: e.memory }
}

/// A line on stderr for whoever waits at a terminal.
fn note(line: &str) {
    let mut stderr = std::io::stderr();
    if stderr.is_terminal() {
        // A closed terminal must not end the measurements.
        let _ = writeln!(stderr, "{line}");
    }
}

#[cfg(test)]
mod tests {
    use super::super::specimens::SPECIMENS;
    use super::*;

    fn machine() -> Machine {
        Machine { processor: String::new(), memory: 24.0 * 1024.0_f64.powi(3), threads: 2 }
    }

    /// 2 cores and 24 GiB are the machine that the series is made for.
    #[test]
    fn the_series_fits_two_cores_and_24_gib_and_90_minutes() {
        let jobs = Jobs::new(&Figure::ALL, &SPECIMENS, &machine());
        assert_eq!(jobs.left_out, Vec::<String>::new());
        let total: f64 = jobs.list.iter().map(Job::seconds).sum();
        assert!(total < 90.0 * 60.0, "{total} s");
    }

    /// One size at a time, small ones first; no run without acceleration that takes long.
    #[test]
    fn what_is_quick_comes_first() {
        let jobs = Jobs::new(&Figure::ALL, &SPECIMENS, &machine());
        let spheres: Vec<u32> = jobs
            .list
            .iter()
            .filter_map(|job| match job {
                Job::Run { specimen, .. } => Some(specimen.spheres),
                _ => None,
            })
            .collect();
        assert!(spheres.is_sorted());
        let plain = |job: &&Job| matches!(job, Job::Run { mode: Mode::Plain, .. });
        assert!(jobs.list.iter().filter(plain).all(|job| job.seconds() <= AFFORDABLE));
        assert!(jobs.list.iter().any(|job| plain(&job)));
    }

    #[test]
    fn what_does_not_fit_the_memory_is_left_out_and_named() {
        let small = Machine { memory: 1e9, ..machine() };
        let jobs = Jobs::new(&[Figure::Parts], &SPECIMENS, &small);
        assert!(jobs.left_out.iter().any(|what| what.contains("run-343000-")));
        assert!(!jobs.left_out.iter().any(|what| what.contains("run-1000-")));
    }
}
