//! `dempfv run`: carries out a scene.

mod accuracy;
mod end_state;
mod frames;
mod grading;
mod pictures;
mod recorder;
mod remesh;
mod restart;
mod results;
mod stress_path;
mod summary;

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use dempfv::Result;
use dempfv::io::checkpoint;
use dempfv::scene::{Plan, StageKind};
use dempfv::simulation::{Simulation, SimulationState, Specimen};
use dempfv_report::format::si;
use dempfv_report::json;
use dempfv_report::output::{OutputArgs, lock_folder, make_folder};
use dempfv_report::progress::Progress;

use self::recorder::Recorder;
use self::restart::Restart;
pub use self::summary::Report;
use super::{Context, kernels, memory};

/// File that marks a result.
const SUMMARY: &str = "summary.json";
/// The latest state that a run can go on from.
const CHECKPOINT: &str = "checkpoint.dempfv";
/// A state to fall back on is kept this often.
const SNAPSHOT: Duration = Duration::from_secs(30);

/// What `run` takes.
#[derive(clap::Args)]
pub struct Args {
    /// Scene file (TOML)
    pub scene: PathBuf,
    #[command(flatten)]
    output: OutputArgs,
    /// Go on from this checkpoint; its history is continued if it is in the output folder
    #[arg(long, value_name = "CHECKPOINT")]
    restart: Option<PathBuf>,
    /// Stop after so many steps, with a checkpoint to go on from
    #[arg(long, value_name = "N")]
    steps: Option<u64>,
}

/// Carries out a scene and writes its results.
///
/// # Errors
/// [`Error::Input`] when something that the user wrote is wrong; otherwise why
/// the simulation cannot go on, after its checkpoint and results were kept.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let plan = Plan::load(&args.scene)?;
    // A packing file has no more spheres than fit; a cloud has as many as the scene says.
    Specimen::of_cloud(&plan).map(|cloud| memory::check(&plan, &cloud)).transpose()?;
    let folder = folder(args)?;
    if let Some(fluid) = &plan.fluid {
        kernels::announce(fluid.solver);
    }
    let interrupted = context.interruption()?;
    let restarted_at =
        args.restart.as_ref().map(|path| checkpoint::load::<SimulationState>(path)).transpose()?;
    let from = restarted_at.as_ref().map(|s| (s.step(), s.time()));
    let mut simulation = match restarted_at {
        Some(state) => Simulation::restart(plan, state)?,
        None => Simulation::new(plan)?,
    };
    let radii = &simulation.coupled().dem().storage().radius;
    let tight = memory::check(simulation.plan(), &Specimen::of_radii(radii))?;
    if let Some(warning) = &tight {
        // A closed stderr must not end the work.
        let _ = writeln!(io::stderr(), "warning: {warning}");
    }
    make_folder(&folder)?;
    let _lock = lock_folder(&folder)?;
    if args.restart.is_none() {
        results::remove(&folder)?;
    }
    let recorder = Recorder::new(&folder, &simulation, from)?;
    let restart = Restart::of(&simulation, args.restart.as_deref());
    restart.iter().for_each(Restart::announce);
    let mut session = Session {
        folder,
        recorder,
        restart,
        progress: context.progress(),
        start: Instant::now(),
        first: simulation.step(),
        profiles_seen: simulation.consolidation().map_or(0, |c| c.profiles.len()),
        tight,
    };
    let last = args.steps.map(|n| simulation.step() + n);
    let stop = |s: &Simulation| {
        interrupted.load(Ordering::Relaxed) || last.is_some_and(|last| s.step() >= last)
    };
    let ended = session.carry_out(&mut simulation, stop);
    session.close(simulation, context, ended, interrupted.load(Ordering::Relaxed))
}

/// The folder for the results. An unfinished run that is gone on with in its
/// own folder replaces nothing.
fn folder(args: &Args) -> Result<PathBuf> {
    let place = args.output.place(&args.scene);
    let same = |a: &Path, b: &Path| {
        a.canonicalize().ok().is_some_and(|a| b.canonicalize().ok() == Some(a))
    };
    let continued = args.restart.as_ref().is_some_and(|from| same(from, &place.join(CHECKPOINT)));
    if continued && is_unfinished(&place.join(SUMMARY)) {
        return Ok(place);
    }
    Ok(args.output.folder(&args.scene, SUMMARY)?)
}

fn is_unfinished(summary: &Path) -> bool {
    let text = std::fs::read_to_string(summary).unwrap_or_default();
    let summary: Option<serde_json::Value> = serde_json::from_str(&text).ok();
    summary.is_some_and(|s| s["finished"] == false)
}

/// A run from its first step to its summary.
struct Session {
    folder: PathBuf,
    recorder: Recorder,
    restart: Option<Restart>,
    progress: Progress,
    start: Instant,
    /// Step that this session began at.
    first: u64,
    /// Pressure profiles that the current consolidation had at the last look.
    profiles_seen: usize,
    /// What was said of the memory before the run began.
    tight: Option<String>,
}

impl Session {
    /// Steps until the scene is done or `stop` says so. A failure leaves a
    /// checkpoint behind.
    fn carry_out(
        &mut self,
        simulation: &mut Simulation,
        stop: impl Fn(&Simulation) -> bool,
    ) -> Result<()> {
        let mut kept = (simulation.state(), Instant::now());
        self.begin_stage(simulation);
        while simulation.stage().is_some() && !stop(simulation) {
            let (step, done) = (simulation.step(), simulation.outcomes().len());
            if let Err(error) = simulation.advance() {
                let state = match error.spoils_state() {
                    true => kept.0,
                    false => {
                        // The step may be complete, and the stage the failure.
                        if simulation.step() > step {
                            self.keep_on_failure(simulation, |s, now| s.recorder.after_step(now))?;
                        }
                        simulation.state()
                    }
                };
                self.keep(&state);
                return Err(error);
            }
            let finished_stage = simulation.outcomes().len() > done;
            self.keep_on_failure(simulation, |session, now| {
                session.recorder.after_step(now)?;
                session.draw_section(now)?;
                if finished_stage {
                    session.draw_stage(now)?;
                }
                session.recorder.checkpoint(now)
            })?;
            if finished_stage {
                self.end_stage(simulation);
            } else {
                self.progress.update(simulation.step(), simulation.stage_progress(), || {
                    value_of_interest(simulation)
                });
            }
            if simulation.step().is_multiple_of(64) && kept.1.elapsed() > SNAPSHOT {
                kept = (simulation.state(), Instant::now());
            }
        }
        Ok(())
    }

    /// Keeps a state to go on from, beside a failure: nothing is lost on top of it if this one
    /// fails too. A checkpoint that is there stays where the rows before the state cannot be
    /// written: a restart from the state would leave them out.
    fn keep(&mut self, state: &SimulationState) {
        let path = self.folder.join(CHECKPOINT);
        if self.recorder.flush().is_ok() || !path.exists() {
            let _ = checkpoint::save(&path, state);
        }
    }

    /// Writes results; a failure leaves a checkpoint behind. One that comes after these results is
    /// left only where a second attempt writes them, or there is no other.
    fn keep_on_failure(
        &mut self,
        simulation: &mut Simulation,
        write: impl Fn(&mut Session, &mut Simulation) -> Result<()>,
    ) -> Result<()> {
        let written = write(self, simulation);
        if written.is_err()
            && (write(self, simulation).is_ok() || !self.folder.join(CHECKPOINT).exists())
        {
            self.keep(&simulation.state());
        }
        written
    }

    /// Draws the section when the first pressure profile from T_v = 0.1 on is
    /// taken (or the last of all): late enough for a gradient over the whole
    /// height, early enough for a pressure to see.
    fn draw_section(&mut self, simulation: &Simulation) -> Result<()> {
        let (Some(c), Some(stage)) = (simulation.consolidation(), simulation.stage()) else {
            return Ok(());
        };
        let StageKind::Consolidate(plan) = &stage.kind else { return Ok(()) };
        if !simulation.plan().output.pictures || c.profiles.len() == self.profiles_seen {
            return Ok(());
        }
        let before = self.profiles_seen;
        let chosen = plan
            .profiles
            .iter()
            .position(|&t| t >= 0.1)
            .unwrap_or(plan.profiles.len().saturating_sub(1));
        if let Some(profile) = c.profiles.get(chosen).filter(|_| chosen >= before) {
            let when = format!("at *T*_{{v}} = {:.2}", profile.time_factor);
            pictures::section(&self.folder, simulation, &when)?;
        }
        self.profiles_seen = c.profiles.len();
        Ok(())
    }

    fn begin_stage(&mut self, simulation: &Simulation) {
        if let Some(stage) = simulation.stage() {
            let bounded = matches!(
                stage.kind,
                StageKind::Run(_) | StageKind::Consolidate(_) | StageKind::Flow(_)
            );
            self.progress.begin(&stage.name, simulation.step(), bounded);
        }
    }

    fn draw_stage(&self, simulation: &Simulation) -> Result<()> {
        match simulation.outcomes().last().filter(|_| simulation.plan().output.pictures) {
            Some(outcome) => pictures::of_stage(&self.folder, simulation, outcome),
            None => Ok(()),
        }
    }

    fn end_stage(&mut self, simulation: &Simulation) {
        self.profiles_seen = 0;
        if let Some(outcome) = simulation.outcomes().last() {
            self.progress.end(simulation.step(), &summary::headline(&outcome.outcome));
        }
        self.begin_stage(simulation);
    }

    /// Writes what there is: history, summary, and a checkpoint unless all is
    /// done.
    fn close(
        mut self,
        mut simulation: Simulation,
        context: &Context,
        ended: Result<()>,
        interrupted: bool,
    ) -> Result<Report> {
        let finished = ended.is_ok() && simulation.stage().is_none();
        self.keep_on_failure(&mut simulation, |s, now| {
            s.recorder.close(now, finished)?;
            if finished && now.plan().output.pictures {
                grading::draw(&s.folder, now)?;
            }
            Ok(())
        })?;
        if ended.is_ok() && !finished {
            checkpoint::save(&self.folder.join(CHECKPOINT), &simulation.state())?;
        }
        let error = ended.as_ref().err().map(|e| e.to_string());
        let tight = self.tight.take();
        let status = summary::Status { finished, interrupted, error, tight };
        let steps = simulation.step() - self.first;
        let report = Report::new(
            &simulation,
            context.threads,
            self.start.elapsed(),
            steps,
            status,
            (self.restart.clone(), &self.folder),
        );
        // Not tried a second time: a summary would say that the run is done.
        if let Err(error) = json::write(&self.folder.join(SUMMARY), &report) {
            self.keep(&simulation.state());
            return Err(error);
        }
        ended.map(|()| report)
    }
}

/// What the progress line shows beside the rate.
fn value_of_interest(simulation: &Simulation) -> String {
    let coupled = simulation.coupled();
    match simulation.stage().map(|s| &s.kind) {
        Some(StageKind::Compact(_)) => format!("σ {}", si(coupled.dem().mean_stress(), "Pa")),
        Some(StageKind::Cycle(c)) => {
            format!(
                "σ {}  unbalanced {:.1e}",
                si(coupled.wall_stress(c.wall), "Pa"),
                coupled.unbalanced_force()
            )
        }
        Some(StageKind::Consolidate(_)) => {
            let sample = simulation.consolidation().and_then(|c| c.samples.last());
            sample.map_or(String::new(), |s| format!("T_v {:.3}  U {:.3}", s.time_factor, s.degree))
        }
        _ => format!("t {}", si(simulation.time(), "s")),
    }
}
