//! A run: steps without the interpreter, and between them what needs it.

use std::path::Path;
use std::time::{Duration, Instant};

use dempfv::io::checkpoint;
use dempfv::simulation::{Simulation, SimulationState};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use crate::errors::raised;
use crate::handle::PySimulation;
use crate::hooks::Hooks;
use crate::shared::{Run, lock};

/// The interpreter is asked for signals this often.
const SIGNALS: Duration = Duration::from_millis(20);
/// A run of less shows no bar; then the bar is drawn this often.
const BAR_FROM: Duration = Duration::from_millis(500);
const BAR: Duration = Duration::from_millis(200);
/// A state to fall back on is kept this often, where checkpoints are.
const SNAPSHOT: Duration = Duration::from_secs(30);

/// What a run is asked for.
pub struct Request<'py> {
    /// Step at which it ends.
    pub last: Option<u64>,
    /// Model time from which on it ends (s).
    pub until: Option<f64>,
    pub callback: Option<Bound<'py, PyAny>>,
    /// Steps from one call to the next.
    pub every: u64,
    /// Whether to show a bar; `None`: where there is a terminal or a notebook.
    pub progress: Option<bool>,
    /// Folder for a checkpoint of what fails.
    pub out: Option<&'py Path>,
}

/// What a stretch of steps ends by.
struct Stretch {
    last: Option<u64>,
    until: Option<f64>,
    deadline: Instant,
}

impl Stretch {
    /// Steps, and returns whether there is more to do.
    fn advance(&self, simulation: &mut Simulation) -> dempfv::Result<bool> {
        loop {
            if !simulation.advance()? {
                return Ok(false);
            }
            if reached(simulation, self.last, self.until) || Instant::now() >= self.deadline {
                return Ok(true);
            }
        }
    }
}

fn reached(simulation: &Simulation, last: Option<u64>, until: Option<f64>) -> bool {
    last.is_some_and(|last| simulation.step() >= last)
        || until.is_some_and(|until| simulation.time() >= until)
}

/// Runs a simulation in this thread. Returns the steps done.
pub fn drive(simulation: &Bound<'_, PySimulation>, request: Request<'_>) -> PyResult<u64> {
    let (py, handle) = (simulation.py(), simulation.get());
    let shared = handle.shared();
    let run = shared.run(py)?;
    let hooks = lock(&handle.hooks).clone_ref(py);
    let request = Request { out: handle.out.as_deref(), ..request };
    let under_way = Drive { simulation, run, hooks, request, bar: None, kept: None, spoilt: false };
    under_way.carry_out()
}

/// A run under way.
struct Drive<'a, 'py> {
    simulation: &'a Bound<'py, PySimulation>,
    run: Run<'a>,
    hooks: Hooks,
    request: Request<'a>,
    bar: Option<Bound<'py, PyAny>>,
    /// A sound state.
    kept: Option<(SimulationState, Instant)>,
    /// The last step has spoilt the simulation's state.
    spoilt: bool,
}

impl<'a, 'py> Drive<'a, 'py> {
    /// Steps until what was asked for is reached. Returns the steps done.
    fn carry_out(mut self) -> PyResult<u64> {
        let py = self.simulation.py();
        let first = self.run.look(py, Simulation::step);
        let ended = self.steps(first);
        if let Some(bar) = self.bar.take() {
            // A bar that cannot be drawn is no reason to lose a result.
            let _ = bar.call_method0("close");
        }
        match ended {
            Ok(()) => Ok(self.run.look(py, Simulation::step) - first),
            Err(error) => {
                self.keep_checkpoint(py, &error);
                Err(error)
            }
        }
    }

    fn steps(&mut self, first: u64) -> PyResult<()> {
        let py = self.simulation.py();
        let every = self.request.every;
        let mut next_call = self.request.callback.as_ref().map(|_| first.saturating_add(every));
        let mut signals = Instant::now();
        let begun = Instant::now();
        let mut drawn = begun;
        let (last, until) = (self.request.last, self.request.until);
        if self.run.look(py, |s| s.stage().is_none() || reached(s, last, until)) {
            return Ok(());
        }
        loop {
            self.keep_state(py);
            self.call_hooks(py)?;
            let step = self.run.look(py, Simulation::step);
            let one = self.hooks.act().then_some(step + 1);
            let ends = [last, next_call, one];
            let stretch = Stretch {
                last: ends.into_iter().flatten().min(),
                until,
                deadline: Instant::now() + SIGNALS,
            };
            let advanced = self.run.compute(py, |simulation| stretch.advance(simulation));
            // A step that was broken off leaves nothing to be saved.
            let advanced = advanced.inspect_err(|_| self.spoilt = true)?;
            if let Some(error) = self.hooks.remesh.as_ref().and_then(|hook| hook.take_raised()) {
                return Err(error);
            }
            let more = advanced.map_err(|error| {
                self.spoilt = error.spoils_state();
                raised(py, error)
            })?;
            let (step, over) = self.run.look(py, |s| (s.step(), reached(s, last, until)));
            if next_call.is_some_and(|call| step >= call) {
                next_call = Some(step.saturating_add(every));
                if self.call_back()? {
                    return Ok(());
                }
            }
            if !more || over {
                return Ok(());
            }
            let now = Instant::now();
            if now.duration_since(signals) >= SIGNALS {
                signals = now;
                py.check_signals()?;
                if now - begun >= BAR_FROM && now - drawn >= BAR {
                    drawn = now;
                    self.draw(py, first)?;
                }
            }
        }
    }

    /// Asks the user's functions for forces and pressures of the step to come.
    fn call_hooks(&mut self, py: Python<'_>) -> PyResult<()> {
        let Drive { simulation, run, hooks, .. } = self;
        if let Some(changed) = simulation.get().hooks_since(py, hooks.version) {
            *hooks = changed;
        }
        if !hooks.act() {
            return Ok(());
        }
        if !hooks.forces.is_empty() {
            let numbers = run.look(py, |s| s.coupled().dem().storage().id.clone());
            for hook in &hooks.forces {
                let returned = run.in_hook(|| hook.function.bind(py).call1((&**simulation,)))?;
                hook.take(&returned, &numbers)?;
            }
        }
        for hook in &hooks.pressures {
            let Some(function) = hook.function() else { continue };
            let returned = run.in_hook(|| function.bind(py).call1((&**simulation,)))?;
            let pressure = returned.extract::<f64>()?;
            run.change(py, |s| hook.place.set(s, pressure)).map_err(|e| raised(py, e))?;
        }
        Ok(())
    }

    /// Returns whether the callback wants the run to end.
    fn call_back(&mut self) -> PyResult<bool> {
        let Some(callback) = &self.request.callback else { return Ok(false) };
        let simulation = self.simulation;
        let returned = self.run.in_hook(|| callback.call1((simulation,)))?;
        Ok(returned.extract::<bool>().unwrap_or(false))
    }

    fn draw(&mut self, py: Python<'py>, first: u64) -> PyResult<()> {
        if self.request.progress == Some(false) {
            return Ok(());
        }
        static BAR_OF: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        if self.bar.is_none() {
            let new = BAR_OF.import(py, "dempfv._progress", "bar")?;
            let total = self.request.last.map(|last| last - first);
            let bar = new.call1((total, self.request.progress == Some(true)))?;
            if bar.is_none() {
                self.request.progress = Some(false);
                return Ok(());
            }
            self.bar = Some(bar);
        }
        let stage = self.run.look(py, |s| s.stage().map(|stage| stage.name.clone()));
        let (step, share) = self.run.look(py, |s| (s.step(), s.stage_progress()));
        if let Some(bar) = &self.bar {
            bar.call_method1("show", (step - first, stage, share))?;
        }
        Ok(())
    }

    /// Keeps a sound state, where a checkpoint of a failure is wanted.
    fn keep_state(&mut self, py: Python<'_>) {
        let outdated = self.kept.as_ref().is_none_or(|(_, when)| when.elapsed() > SNAPSHOT);
        if self.request.out.is_some() && outdated {
            self.kept = Some((self.run.look(py, Simulation::state), Instant::now()));
        }
    }

    /// Writes the state of a failure, or the last sound one before it.
    fn keep_checkpoint(&mut self, py: Python<'_>, error: &PyErr) {
        let Some(folder) = self.request.out else { return };
        let state = match (self.spoilt, self.kept.take()) {
            (true, Some((state, _))) => state,
            _ => self.run.look(py, Simulation::state),
        };
        let written = std::fs::create_dir_all(folder)
            .map_err(|e| dempfv::Error::io(folder, e))
            .and_then(|()| Ok(checkpoint::save(&folder.join("checkpoint.dempfv"), &state)?));
        if let Err(failure) = written {
            let note = format!("no checkpoint was kept: {failure}");
            let _ = error.value(py).call_method1("add_note", (note,));
        }
    }
}
