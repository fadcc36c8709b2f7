//! What there is to measure, in what order, and how long it takes.

use std::io::{IsTerminal, Write};
use std::time::Instant;

use dempfv::scene::Plan;
use dempfv::simulation::Estimate;
use dempfv_report::format::{bytes, duration};

use super::figures::Figure;
use super::machine::Machine;
use super::remesh;
use super::specimens::Specimen;
use super::timing::{self, Mode};
use super::{built, factored, gpu};
use crate::Error;
use crate::bench::Bench;

/// A run without any acceleration is made where it takes no longer than this (s); else its
/// total is composed.
const AFFORDABLE: f64 = 3600.0;

/// One point of a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Job {
    Remesh(remesh::Run),
    Built {
        specimen: Specimen,
        threads: usize,
    },
    Factored(Specimen),
    Run {
        specimen: Specimen,
        mode: Mode,
    },
    /// On the machine's GPU, and beside it on its cores.
    OnGpu(Specimen),
}

/// A point with what it can be expected to need.
struct Planned {
    job: Job,
    need: Need,
}

/// What a point can be expected to need.
#[derive(Clone, Copy)]
struct Need {
    /// Time (s).
    time: f64,
    /// Memory (bytes).
    memory: f64,
}

/// Points that are to be measured, small specimens first.
pub struct Jobs {
    list: Vec<Planned>,
    /// Points that this machine has no memory for.
    pub left_out: Vec<String>,
}

impl Jobs {
    /// What these figures need of these specimens.
    ///
    /// # Errors
    /// The project's packings are not there.
    pub fn new(
        figures: &[Figure],
        specimens: &[Specimen],
        machine: &Machine,
    ) -> Result<Jobs, Error> {
        let mut jobs = Jobs { list: vec![], left_out: vec![] };
        if figures.contains(&Figure::Remesh) {
            for run in remesh::Run::all() {
                jobs.add(Job::Remesh(run), machine)?;
            }
        }
        for &specimen in specimens {
            if figures.contains(&Figure::Build) && specimen.is_cube() {
                for threads in [1, machine.threads].into_iter().take(machine.threads) {
                    jobs.add(Job::Built { specimen, threads }, machine)?;
                }
            }
            if figures.contains(&Figure::Factor) && specimen.is_cube() && machine.threads > 1 {
                jobs.add(Job::Factored(specimen), machine)?;
            }
            let needed = |mode: &Mode| figures.iter().any(|f| f.modes(&specimen).contains(mode));
            for mode in Mode::ALL.into_iter().filter(needed) {
                jobs.add(Job::Run { specimen, mode }, machine)?;
            }
        }
        Ok(jobs)
    }

    /// What the rows of this machine's GPU need, by cubes.
    ///
    /// # Errors
    /// The project's packings are not there.
    pub fn with_gpu(specimens: &[Specimen], machine: &Machine) -> Result<Jobs, Error> {
        let mut jobs = Jobs { list: vec![], left_out: vec![] };
        for &specimen in specimens.iter().filter(|specimen| specimen.is_cube()) {
            jobs.add(Job::OnGpu(specimen), machine)?;
        }
        Ok(jobs)
    }

    fn add(&mut self, job: Job, machine: &Machine) -> Result<(), Error> {
        let need = job.need()?;
        let composed = matches!(job, Job::Run { mode: Mode::Plain, .. }) && need.time > AFFORDABLE;
        if composed {
            return Ok(());
        }
        if let Some(memory) = machine.memory.filter(|&memory| need.memory > memory) {
            let (need, have) = (bytes(need.memory), bytes(memory));
            let point = job.point();
            self.left_out.push(format!("{point} (needs about {need} of {have})"));
        } else {
            self.list.push(Planned { job, need });
        }
        Ok(())
    }

    /// Makes all of it unknown.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn forget(&self, bench: &Bench) -> Result<(), Error> {
        self.list.iter().try_for_each(|p| match p.job {
            Job::OnGpu(specimen) => gpu::forget(bench, &specimen),
            _ => bench.forget(&format!("{}.json", p.job.point())),
        })
    }

    /// Measures what is not known yet; says on a terminal how long all of it takes.
    ///
    /// # Errors
    /// The first that fails; all before it are kept.
    pub fn carry_out(&mut self, bench: &Bench, threads: usize) -> Result<(), Error> {
        let (mut done, mut spent) = (0.0, 0.0);
        for (i, Planned { job, need }) in self.list.iter().enumerate() {
            let left: f64 = self.list[i..].iter().map(|p| p.need.time).sum();
            // The machine at hand is as fast as it has been so far.
            let pace = if done > 0.0 { spent / done } else { 1.0 };
            let (k, all, left) = (i + 1, self.list.len(), duration(pace * left));
            note(&format!("{k} of {all}, about {left} left: {}", job.point()));
            let start = Instant::now();
            if let Some(reason) = job.carry_out(bench, threads)? {
                self.left_out.push(format!("{} ({reason})", job.point()));
            }
            let time = start.elapsed().as_secs_f64();
            // Points that were known take no time and tell nothing about the machine.
            if time > 0.1 {
                (done, spent) = (done + need.time, spent + time);
            }
        }
        Ok(())
    }
}

impl Job {
    /// Measures it, or returns why there is nothing to be measured.
    fn carry_out(&self, bench: &Bench, threads: usize) -> Result<Option<String>, Error> {
        match *self {
            Job::Remesh(run) => drop(remesh::measure(bench, run, threads)?),
            Job::Built { specimen, threads } => drop(built::measure(bench, &specimen, threads)?),
            Job::Factored(specimen) => drop(factored::measure(bench, &specimen, threads)?),
            Job::Run { specimen, mode } => {
                drop(timing::measure(bench, &specimen, mode, mode.threads(threads))?);
            }
            Job::OnGpu(specimen) => return gpu::measure(bench, &specimen, threads),
        }
        Ok(None)
    }

    /// Name of what it measures.
    fn point(&self) -> String {
        match *self {
            Job::Remesh(run) => run.name(),
            Job::Built { specimen, threads } => built::name(&specimen, threads),
            Job::Factored(specimen) => factored::name(&specimen),
            Job::Run { specimen, mode } => timing::name(&specimen, mode),
            Job::OnGpu(specimen) => timing::name(&specimen, Mode::Gpu),
        }
    }

    fn need(&self) -> Result<Need, Error> {
        match *self {
            Job::Remesh(run) => {
                let e = expected(&remesh::SPECIMEN, Mode::AllCores)?;
                let time = remesh::STEPS as f64 * (e.step + e.remesh / run.interval() as f64);
                Ok(Need { time, memory: e.memory })
            }
            // A network without its factor takes little of either.
            Job::Built { specimen, .. } => {
                let time = (NETWORK * f64::from(specimen.spheres)).max(1.0);
                Ok(Need { time, memory: 0.0 })
            }
            Job::Factored(specimen) => {
                let e = expected(&specimen, Mode::Cholmod)?;
                Ok(Need { time: e.remesh, memory: e.memory })
            }
            // The CPU takes most of the time, once for each way to use it.
            Job::OnGpu(specimen) => {
                let e = expected(&specimen, Mode::Cholmod)?;
                let steps = specimen.steps as f64 * specimen.repeats as f64;
                Ok(Need { time: 7.0 * e.remesh + 2.0 * steps * e.step, memory: e.memory })
            }
            Job::Run { specimen, mode } => {
                let e = expected(&specimen, mode)?;
                let (steps, interval) = (mode.steps(&specimen), mode.interval(&specimen));
                let remeshes = steps.div_ceil(interval) as f64;
                let once = steps as f64 * e.step + remeshes * e.remesh;
                let runs = match (mode, mode.repeats(&specimen)) {
                    // By turns with those that have none.
                    (Mode::Tasks, n) => 2 * n - 1,
                    (_, n) => n,
                };
                let time = runs as f64 * once;
                Ok(Need { time, memory: e.memory })
            }
        }
    }
}

/// Time to build a network (s per sphere): 3 µs for each of six pores, on one core.
const NETWORK: f64 = 18e-6;

/// What a run consists of.
struct Expected {
    /// Time of a step between two remeshes (s).
    step: f64,
    /// Time of a remesh (s).
    remesh: f64,
    /// Memory (bytes).
    memory: f64,
}

fn expected(specimen: &Specimen, mode: Mode) -> Result<Expected, Error> {
    let plan = Plan::from_toml(&timing::scene(&specimen.base()?, specimen, mode), None)?;
    let spheres = dempfv::simulation::Specimen {
        spheres: specimen.spheres as usize,
        ..dempfv::simulation::Specimen::default()
    };
    let e = Estimate::of(&plan, &spheres).map_err(dempfv::Error::from)?;
    let remesh = e.remesh.unwrap_or(0.0);
    // The estimate has the remeshes' share of a step in it, but for those in the background.
    let share = match mode {
        _ if mode.is_in_background() => 0.0,
        _ => remesh / mode.interval(specimen) as f64,
    };
    Ok(Expected { step: e.coupled_step.unwrap_or(0.0) - share, remesh, memory: e.memory })
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

    /// Specimens are found from a checkout's root; cargo runs these tests one folder below.
    fn enter_checkout() {
        std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).unwrap();
    }

    fn all_jobs() -> Jobs {
        enter_checkout();
        Jobs::new(&Figure::ALL, &SPECIMENS, &Machine::with(2, 24.0 * 1024.0_f64.powi(3))).unwrap()
    }

    /// 2 cores and 24 GiB are the machine that the series is made for.
    #[test]
    fn the_series_fits_two_cores_and_24_gib_and_six_hours() {
        let jobs = all_jobs();
        assert_eq!(jobs.left_out, Vec::<String>::new());
        let total: f64 = jobs.list.iter().map(|p| p.need.time).sum();
        assert!(total < 6.0 * 3600.0, "{total} s");
    }

    /// One size at a time, small ones first; a run without acceleration where it takes under
    /// an hour, which the smaller sizes do.
    #[test]
    fn what_is_quick_comes_first() {
        let jobs = all_jobs();
        let spheres: Vec<u32> = jobs
            .list
            .iter()
            .filter_map(|p| match p.job {
                Job::Run { specimen, .. } => Some(specimen.spheres),
                _ => None,
            })
            .collect();
        assert!(spheres.is_sorted());
        let plain = |p: &&Planned| matches!(p.job, Job::Run { mode: Mode::Plain, .. });
        assert!(jobs.list.iter().filter(plain).all(|p| p.need.time <= AFFORDABLE));
        assert!(jobs.list.iter().filter(plain).count() >= 3, "20,000 spheres take minutes");
    }

    #[test]
    fn what_does_not_fit_the_memory_is_left_out_and_named() {
        enter_checkout();
        let small = Machine::with(2, 1e9);
        let jobs = Jobs::new(&[Figure::Parts], &SPECIMENS, &small).unwrap();
        assert!(jobs.left_out.iter().any(|what| what.contains("run-343000-")));
        assert!(!jobs.left_out.iter().any(|what| what.contains("run-1000-")));
    }
}
