//! The methods of `dempfv.Simulation`.

use std::path::PathBuf;

use dempfv::Error;
use dempfv::io::checkpoint;
use dempfv::simulation::Simulation;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pyo3::{PyTraverseError, PyVisit};

use crate::contacts::Contacts;
use crate::drive::{Request, drive};
use crate::errors::{raised, refused, wrong};
use crate::handle::PySimulation;
use crate::hooks::{ForceHook, Pressure, PressureHook, Where};
use crate::packing::PyPacking;
use crate::pores::Pores;
use crate::remesh_hook::RemeshHook;
use crate::scene::{load_state, plan};
use crate::shared::lock;
use crate::spheres::Spheres;
use crate::summary;
use crate::threads;
use crate::throats::Throats;
use crate::walls::Walls;

#[pymethods]
impl PySimulation {
    #[new]
    #[pyo3(signature = (scene, *, out=None))]
    fn new(scene: &Bound<'_, PyAny>, out: Option<PathBuf>) -> PyResult<PySimulation> {
        let py = scene.py();
        let plan = plan(scene)?;
        threads::start(py)?;
        let simulation = py.detach(|| Simulation::new(plan)).map_err(|e| raised(py, e))?;
        Ok(PySimulation::of(simulation, out))
    }

    /// Steps until the scene is done, or until what is asked for comes first.
    ///
    /// Other Python threads go on meanwhile, but cannot use this simulation. Ctrl-C ends a run between
    /// two steps with ``KeyboardInterrupt``; the simulation can go on from there.
    ///
    /// Parameters
    /// ----------
    /// steps : int, optional
    ///     Ends after so many steps.
    /// until : float, optional
    ///     Ends with the step that reaches this model time (s).
    /// callback : callable, optional
    ///     ``callback(sim)`` is called after every so many steps. It may look at everything, and change
    ///     ``sim.spheres.velocity`` and ``spin`` in place. Where it returns True, the run ends. What it
    ///     raises ends the run too, and comes out of this call.
    /// every : int, default 1
    ///     Steps from one call to the next.
    /// progress : bool, optional
    ///     Whether to show a bar. If not given: where tqdm is installed and there is a terminal or a
    ///     notebook, and the run takes longer than half a second.
    ///
    /// Returns
    /// -------
    /// int
    ///     Steps done.
    ///
    /// Raises
    /// ------
    /// SimulationError
    ///     Where the simulation cannot go on: ``step``, ``sphere`` and ``pore`` say where. Also while
    ///     it is running already.
    /// InputError
    ///     For an argument that makes no sense.
    ///
    /// Examples
    /// --------
    /// >>> import dempfv as dp
    /// >>> sim = dp.Simulation({
    /// ...     "box": {"min": [0, 0, 0], "max": [1, 1, 1]},
    /// ...     "particles": {"cloud": {"count": 10, "porosity": 0.9}},
    /// ...     "dem": {"gravity": [0, -9.81, 0]},
    /// ...     "stage": [{"kind": "run", "steps": 100}],
    /// ... })
    /// >>> heights = []
    /// >>> sim.run(callback=lambda sim: heights.append(sim.spheres.position[:, 1].mean()), every=10)
    /// 100
    /// >>> len(heights), bool(heights[-1] < heights[0])
    /// (10, True)
    #[pyo3(signature = (*, steps=None, until=None, callback=None, every=1, progress=None))]
    fn run<'py>(
        slf: &Bound<'py, Self>,
        steps: Option<u64>,
        until: Option<f64>,
        callback: Option<Bound<'py, PyAny>>,
        every: u64,
        progress: Option<bool>,
    ) -> PyResult<u64> {
        let py = slf.py();
        if every == 0 {
            return Err(wrong(
                py,
                "every = 0",
                "give the number of steps from one call to the next, from 1",
            ));
        }
        if until.is_some_and(f64::is_nan) {
            return Err(wrong(py, "until is not a number", "give a model time in s"));
        }
        if callback.as_ref().is_some_and(|callback| !callback.is_callable()) {
            return Err(wrong(
                py,
                "the callback cannot be called",
                "give a function of the simulation",
            ));
        }
        let last = match steps {
            Some(steps) => Some(slf.get().look(py, Simulation::step)?.saturating_add(steps)),
            None => None,
        };
        drive(slf, Request { last, until, callback, every, progress, out: None })
    }

    /// Does one step, or the whole of a stage that has no steps.
    ///
    /// Returns
    /// -------
    /// bool
    ///     Whether there is more to do.
    ///
    /// Raises
    /// ------
    /// SimulationError
    ///     As :meth:`run`.
    fn step(slf: &Bound<'_, Self>) -> PyResult<bool> {
        let py = slf.py();
        let last = Some(slf.get().look(py, Simulation::step)?.saturating_add(1));
        let (until, callback, progress) = (None, None, Some(false));
        drive(slf, Request { last, until, callback, every: 1, progress, out: None })?;
        slf.get().look(py, |s| s.stage().is_some())
    }

    /// Writes a checkpoint, which :func:`restore` and ``dempfv run --restart`` go on from.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     A file; one that is there is replaced once the new one is complete.
    ///
    /// Raises
    /// ------
    /// SimulationError
    ///     Where it cannot be written.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let state = self.look(py, Simulation::state)?;
        let saved = py.detach(|| checkpoint::save(&path, &state).map_err(Error::from));
        saved.map_err(|e| raised(py, e))
    }

    /// Goes back, or on, to a checkpoint of this scene. Arrays that were taken before are of a state that
    /// is gone, and raise :class:`StaleViewError`; forces and pressures of yours act on.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     A checkpoint of :meth:`save` or of the program.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     For a file that is no checkpoint of this scene; the simulation stays as it is.
    fn restore(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let before = self.shared();
        // Of one that has failed, too: its plan is whole.
        let run = before.claim(py)?;
        let plan = run.look(py, |s| s.plan().clone());
        let state = load_state(py, &path)?;
        let builder = lock(&self.hooks).builder();
        let restarted = py.detach(|| Simulation::restart_with(plan, state, builder));
        let failed = lock(&self.hooks).remesh.as_ref().and_then(|hook| hook.take_raised());
        if let Some(error) = failed {
            return Err(error);
        }
        let mut simulation = restarted.map_err(|e| raised(py, e))?;
        let acted = lock(&self.hooks).act_on(&mut simulation);
        acted.map_err(|e| raised(py, e))?;
        self.replace(simulation);
        Ok(())
    }

    /// Lets a force of yours act on the spheres from the next step on.
    ///
    /// Parameters
    /// ----------
    /// function : callable
    ///     ``function(sim)`` is called before each step. It returns the force on each sphere, an array of
    ///     shape (n, 3) in N with the rows of ``sim.spheres``; or a tuple of force and torque (N m);
    ///     or None for no force. Its work is in ``sim.energy``. It may return the same array each time.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     For what cannot be called; in the run, for arrays of another shape.
    ///
    /// Examples
    /// --------
    /// >>> import dempfv as dp
    /// >>> sim = dp.Simulation({
    /// ...     "box": {"min": [0, 0, 0], "max": [1, 1, 1]},
    /// ...     "particles": {"cloud": {"count": 10, "porosity": 0.9}},
    /// ...     "dem": {},
    /// ...     "stage": [{"kind": "run", "steps": 100}],
    /// ... })
    /// >>> sim.add_force(lambda sim: 0.1 * (0.5 - sim.spheres.position))
    /// >>> before = abs(sim.spheres.position - 0.5).mean()
    /// >>> sim.run()
    /// 100
    /// >>> bool(abs(sim.spheres.position - 0.5).mean() < before)
    /// True
    fn add_force(&self, py: Python<'_>, function: &Bound<'_, PyAny>) -> PyResult<()> {
        if !function.is_callable() {
            return Err(wrong(
                py,
                "the force cannot be called",
                "give a function of the simulation",
            ));
        }
        let spheres = self.look(py, |s| s.coupled().dem().len())?;
        let hook = ForceHook::new(function, spheres);
        self.shared().change(py, |s| hook.act_on(s))?;
        let mut hooks = lock(&self.hooks);
        hooks.version += 1;
        hooks.forces.push(hook);
        Ok(())
    }

    /// Changes a pressure that the scene imposes, from the next step on, through remeshes and stages.
    ///
    /// Parameters
    /// ----------
    /// place : str or int
    ///     A wall, ``"x_min"`` to ``"z_max"``, or the place of a region in ``imposed`` of the scene's
    ///     ``[fluid]``, from 0. The scene must impose a pressure there.
    /// pressure : float or callable
    ///     In Pa; or ``pressure(sim)``, which is called before each step.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     For a place that is none, and a pressure that is no finite number.
    /// SimulationError
    ///     In the run, where nothing imposes a pressure there.
    fn set_pressure(
        &self,
        py: Python<'_>,
        place: &Bound<'_, PyAny>,
        pressure: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let place = Where::of(place)?;
        if pressure.is_callable() {
            let pressure = Pressure::Function(pressure.clone().unbind());
            self.add_pressure(PressureHook { place, pressure });
            return Ok(());
        }
        let value = pressure.extract::<f64>().ok().filter(|p| p.is_finite()).ok_or_else(|| {
            wrong(
                py,
                "the pressure is no finite number",
                "give Pa, or a function of the simulation",
            )
        })?;
        self.shared().change(py, |s| place.set(s, value))?.map_err(|e| raised(py, e))?;
        self.add_pressure(PressureHook { place, pressure: Pressure::Constant(value) });
        Ok(())
    }

    /// Lets a function of yours choose how the pores of each new network conduct.
    ///
    /// Parameters
    /// ----------
    /// function : callable or None
    ///     ``function(pores)`` is called for each network that is built, from the next one on, with an
    ///     object that has the arrays ``center``, ``centroid``, ``volume`` and ``vertices`` (as those of
    ///     ``sim.pores``; ``centroid`` is the middle of a pore's volume). It returns a factor for each
    ///     pore, shape (n,): the half of a throat on the pore's side conducts so much better or worse; 0
    ///     blocks the pore. Or None for no change. With ``remesh = "background"`` it is called in
    ///     another thread, and cannot use this simulation. None ends it.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     For what cannot be called; in the run, for factors that are none.
    /// SimulationError
    ///     While the simulation is running.
    ///
    /// Notes
    /// -----
    /// It takes a triangulation more for each network.
    ///
    /// Examples
    /// --------
    /// >>> import dempfv as dp
    /// >>> sim = dp.Simulation({
    /// ...     "box": {"min": [0, 0, 0], "max": [1, 1, 1]},
    /// ...     "particles": {"cloud": {"count": 30, "porosity": 0.8}},
    /// ...     "dem": {},
    /// ...     "fluid": {"viscosity": 1e-3, "pressure": {"y_min": 1.0, "y_max": 0.0}},
    /// ...     "stage": [{"kind": "run", "steps": 5}],
    /// ... })
    /// >>> sim.set_conductance(lambda pores: (pores.centroid[:, 0] < 0.5).astype(float))
    /// >>> sim.step()
    /// True
    /// >>> bool((sim.throats.conductance == 0.0).any())
    /// True
    fn set_conductance(&self, py: Python<'_>, function: &Bound<'_, PyAny>) -> PyResult<()> {
        let hook = match function.is_none() {
            true => None,
            false if function.is_callable() => Some(RemeshHook::new(function)),
            false => {
                let what = "the choice of conductances cannot be called";
                return Err(wrong(py, what, "give a function of the pores"));
            }
        };
        self.set_remesh_hook(py, hook)
    }

    /// Ends all forces of :meth:`add_force`, the function of :meth:`set_conductance`, and all that
    /// :meth:`set_pressure` was told: pressures stay as they are until the scene changes them.
    fn remove_hooks(&self, py: Python<'_>) -> PyResult<()> {
        if lock(&self.hooks).remesh.is_some() {
            self.set_remesh_hook(py, None)?;
        }
        self.shared().change(py, |s| s.controls().take_body_forces())?;
        self.clear_hooks();
        Ok(())
    }

    /// The spheres, as arrays. See :class:`Spheres`.
    #[getter]
    fn spheres(slf: &Bound<'_, Self>) -> Spheres {
        Spheres { simulation: slf.clone().unbind() }
    }

    /// The contacts of the moment, as arrays; a copy. See :class:`Contacts`.
    #[getter]
    fn contacts(&self, py: Python<'_>) -> PyResult<Contacts> {
        self.look(py, Contacts::of)
    }

    /// The six walls of the moment, as arrays; a copy. See :class:`Walls`.
    #[getter]
    fn walls(&self, py: Python<'_>) -> PyResult<Walls> {
        self.look(py, Walls::of)
    }

    /// The pores of the network in use, as arrays. See :class:`Pores`.
    #[getter]
    fn pores(slf: &Bound<'_, Self>) -> Pores {
        Pores { simulation: slf.clone().unbind() }
    }

    /// The throats between them, as arrays. See :class:`Throats`.
    #[getter]
    fn throats(slf: &Bound<'_, Self>) -> Throats {
        Throats { simulation: slf.clone().unbind() }
    }

    /// The spheres with their box, as a :class:`Packing`; a copy, in the order of the user's numbers.
    fn packing(&self, py: Python<'_>) -> PyResult<PyPacking> {
        let packing = self.look(py, PyPacking::of_simulation)?;
        packing.ok_or_else(|| {
            refused(
                py,
                "the spheres are in a periodic cell, which no Packing holds; save a checkpoint",
            )
        })
    }

    /// Model time (s).
    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        self.look(py, Simulation::time)
    }

    /// Length of the last step (s); 0 before the first.
    #[getter]
    fn dt(&self, py: Python<'_>) -> PyResult<f64> {
        self.look(py, Simulation::dt)
    }

    /// Steps done in all stages, those before a restart included.
    #[getter]
    fn steps(&self, py: Python<'_>) -> PyResult<u64> {
        self.look(py, Simulation::step)
    }

    /// Name of the stage that the next step belongs to; None when all are done.
    #[getter]
    fn stage(&self, py: Python<'_>) -> PyResult<Option<String>> {
        self.look(py, |s| s.stage().map(|stage| stage.name.clone()))
    }

    /// Whether all stages are done.
    #[getter]
    fn finished(&self, py: Python<'_>) -> PyResult<bool> {
        self.look(py, |s| s.stage().is_none())
    }

    /// Networks built so far.
    #[getter]
    fn remeshes(&self, py: Python<'_>) -> PyResult<u64> {
        self.look(py, Simulation::remeshes)
    }

    /// A hash of the bits of positions, velocities and pressures: that of ``summary.json`` of the program.
    #[getter]
    fn state_hash(&self, py: Python<'_>) -> PyResult<String> {
        self.look(py, Simulation::state_hash)
    }

    /// Energy by cause (J), a dict with the keys of ``energy`` in ``summary.json``; None where it is not
    /// tracked: before the first step, and in stages that grow spheres.
    #[getter]
    fn energy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let energy = self.look(py, |s| s.coupled().dem().energy_balance())?;
        summary::to_python(py, &energy)
    }

    /// Names of the effects that the scene has.
    #[getter]
    fn effects(&self, py: Python<'_>) -> PyResult<Vec<&'static str>> {
        self.look(py, |s| s.plan().effects_on())
    }

    /// What a user should know of the run so far, a sentence each.
    #[getter]
    fn warnings(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.look(py, Simulation::warnings)
    }

    /// The scene as TOML, with every default written out.
    #[getter]
    fn scene(&self, py: Python<'_>) -> PyResult<String> {
        self.look(py, |s| s.plan().to_toml())
    }

    /// The columns of ``history.csv`` at this moment: a dict of name, with its unit, and value.
    ///
    /// Examples
    /// --------
    /// >>> import dempfv as dp
    /// >>> sim = dp.Simulation({
    /// ...     "box": {"min": [0, 0, 0], "max": [1, 1, 1]},
    /// ...     "particles": {"cloud": {"count": 10, "porosity": 0.9}},
    /// ...     "dem": {},
    /// ...     "stage": [{"kind": "run", "steps": 1}],
    /// ... })
    /// >>> round(sim.observe()["porosity"], 6)
    /// 0.9
    fn observe<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        summary::observe(py, &self.shared())
    }

    /// What the run has come to: a dict with keys of the program's ``summary.json``, among them
    /// ``particles``, ``pores``, ``contacts``, ``steps``, ``model_time_s``, ``effects``, ``warnings``,
    /// ``energy``, ``state_hash`` and, for each stage that is done, ``stages``.
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let summary = self.look(py, summary::Summary::of)?;
        summary::to_python(py, &summary)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let said = self.look(py, |s| format!("<dempfv.Simulation {}>", summary::line(s)));
        said.unwrap_or_else(|_| "<dempfv.Simulation that is running>".to_owned())
    }

    fn _repr_html_(&self, py: Python<'_>) -> PyResult<String> {
        self.look(py, summary::html)
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        match self.hooks.try_lock() {
            Ok(hooks) => hooks.functions().try_for_each(|function| visit.call(function)),
            Err(_) => Ok(()),
        }
    }

    fn __clear__(&self) {
        self.clear_hooks();
    }
}
