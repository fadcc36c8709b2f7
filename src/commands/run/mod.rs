//! `dempfv run`: carries out a scene.

mod history;
mod pictures;
mod recorder;
mod remesh;
mod results;
mod summary;

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use dempfv::io::checkpoint;
use dempfv::scene::{Plan, StageKind};
use dempfv::simulation::{Simulation, SimulationState};
use dempfv::{Error, Result};
use dempfv_report::format::si;
use dempfv_report::json;
use dempfv_report::output::{OutputArgs, lock_folder, make_folder};
use dempfv_report::progress::Progress;

use self::recorder::Recorder;
pub use self::summary::Report;
use super::{Context, kernels};

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
    make_folder(&folder)?;
    let _lock = lock_folder(&folder)?;
    if args.restart.is_none() {
        results::remove(&folder)?;
    }
    let recorder = Recorder::new(&folder, &simulation, from)?;
    let mut session = Session {
        folder,
        recorder,
        progress: context.progress(),
        start: Instant::now(),
        first: simulation.step(),
        profiles_seen: simulation.consolidation().map_or(0, |c| c.profiles.len()),
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
    progress: Progress,
    start: Instant,
    /// Step that this session began at.
    first: u64,
    /// Pressure profiles that the current consolidation had at the last look.
    profiles_seen: usize,
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
            let done = simulation.outcomes().len();
            if let Err(error) = simulation.advance() {
                let state = match error.spoils_state() {
                    true => kept.0,
                    false => {
                        // The step may be complete, and the stage the failure.
                        self.keep_on_failure(simulation, |s, now| s.recorder.after_step(now))?;
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
                if finished_stage { session.end_stage(now) } else { Ok(()) }
            })?;
            if !finished_stage {
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
    /// fails too.
    fn keep(&mut self, state: &SimulationState) {
        let _ = self.recorder.flush();
        let _ = checkpoint::save(&self.folder.join(CHECKPOINT), state);
    }

    /// Writes results; a failure leaves a checkpoint behind.
    fn keep_on_failure(
        &mut self,
        simulation: &mut Simulation,
        write: impl FnOnce(&mut Session, &mut Simulation) -> Result<()>,
    ) -> Result<()> {
        let written = write(self, simulation);
        if written.is_err() {
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
        let before = std::mem::replace(&mut self.profiles_seen, c.profiles.len());
        let chosen = plan
            .profiles
            .iter()
            .position(|&t| t >= 0.1)
            .unwrap_or(plan.profiles.len().saturating_sub(1));
        match c.profiles.get(chosen) {
            Some(profile) if chosen >= before => pictures::section(
                &self.folder,
                simulation,
                &format!("at *T*_{{v}} = {:.2}", profile.time_factor),
            ),
            _ => Ok(()),
        }
    }

    fn begin_stage(&mut self, simulation: &Simulation) {
        if let Some(stage) = simulation.stage() {
            let bounded = matches!(stage.kind, StageKind::Run(_) | StageKind::Consolidate(_));
            self.progress.begin(&stage.name, simulation.step(), bounded);
        }
    }

    fn end_stage(&mut self, simulation: &Simulation) -> Result<()> {
        self.profiles_seen = 0;
        if let Some(outcome) = simulation.outcomes().last() {
            self.progress.end(simulation.step(), &summary::headline(&outcome.outcome));
            if simulation.plan().output.pictures {
                pictures::of_stage(&self.folder, simulation, outcome)?;
            }
        }
        self.begin_stage(simulation);
        Ok(())
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
        self.keep_on_failure(&mut simulation, |s, now| s.recorder.close(now, finished))?;
        if ended.is_ok() && !finished {
            checkpoint::save(&self.folder.join(CHECKPOINT), &simulation.state())?;
        }
        let error = ended.as_ref().err().map(|e| e.to_string());
        let status = summary::Status { finished, interrupted, error };
        let steps = simulation.step() - self.first;
        let report = Report::new(
            &simulation,
            context.threads,
            self.start.elapsed(),
            steps,
            status,
            &self.folder,
        );
        self.keep_on_failure(&mut simulation, |s, _| {
            json::write(&s.folder.join(SUMMARY), &report)
        })?;
        match ended {
            Ok(()) => Ok(report),
            Err(Error::Input(error)) => Err(Error::Input(error)),
            Err(error) => Err(error),
        }
    }
}

/// What the progress line shows beside the rate.
fn value_of_interest(simulation: &Simulation) -> String {
    let coupled = simulation.coupled();
    match simulation.stage().map(|s| &s.kind) {
        Some(StageKind::Compact(_)) => format!("σ {}", si(coupled.dem().mean_wall_stress(), "Pa")),
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
