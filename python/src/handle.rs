//! What `dempfv.Simulation` is made of; its methods are in `simulation.rs`.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use dempfv::simulation::Simulation;
use pyo3::prelude::*;

use crate::errors::refused;
use crate::hooks::{Hooks, PressureHook};
use crate::remesh_hook::RemeshHook;
use crate::shared::{Shared, lock};
use crate::views;

/// A scene that is being carried out.
///
/// Parameters
/// ----------
/// scene : str, os.PathLike or dict
///     A scene file (TOML), or its tables as dictionaries: the keys are the same, and so are the
///     messages. Paths in a dictionary start at the current folder.
/// out : str or os.PathLike, optional
///     A folder. Where a run fails, is interrupted, or a function of yours raises, it gets
///     ``checkpoint.dempfv``, which :func:`restore` and ``dempfv run --restart`` go on from.
///
/// Raises
/// ------
/// InputError
///     What is wrong in the scene or its packing, with file and line.
///
/// Notes
/// -----
/// Arrays have a row per sphere in the order in which the spheres lie in memory, all in the same
/// one; ``sim.spheres.number`` has the user's number of each row.
///
/// Examples
/// --------
/// >>> import dempfv as dp
/// >>> sim = dp.Simulation({
/// ...     "title": "ten spheres that fall",
/// ...     "box": {"min": [0, 0, 0], "max": [1, 1, 1]},
/// ...     "particles": {"cloud": {"count": 10, "porosity": 0.9}},
/// ...     "dem": {"gravity": [0, -9.81, 0]},
/// ...     "stage": [{"kind": "run", "steps": 100}],
/// ... })
/// >>> sim.run(steps=20)
/// 20
/// >>> sim.spheres.position.shape
/// (10, 3)
/// >>> sim
/// <dempfv.Simulation 'ten spheres that fall': 10 spheres, dry; step 20, ...; stage 'run', 20 %>
#[pyclass(frozen, weakref, module = "dempfv", name = "Simulation")]
pub struct PySimulation {
    current: Mutex<Arc<Shared>>,
    /// What the user has added.
    pub hooks: Mutex<Hooks>,
    /// Folder for a checkpoint of what fails.
    pub out: Option<PathBuf>,
}

impl PySimulation {
    /// A handle on a simulation.
    pub fn of(simulation: Simulation, out: Option<PathBuf>) -> PySimulation {
        let current = Mutex::new(Shared::new(simulation));
        PySimulation { current, hooks: Mutex::default(), out }
    }

    /// Puts another simulation in the place of this one; what was taken of it is of a state that is gone.
    pub fn replace(&self, simulation: Simulation) {
        let before = std::mem::replace(&mut *lock(&self.current), Shared::new(simulation));
        before.replace();
    }

    /// The simulation of the moment.
    pub fn shared(&self) -> Arc<Shared> {
        Arc::clone(&lock(&self.current))
    }

    /// Looks at the simulation between two steps.
    pub fn look<T>(&self, py: Python<'_>, look: impl FnOnce(&Simulation) -> T) -> PyResult<T> {
        self.shared().look(py, look)
    }

    /// The user's hooks, where they are others than those of this version.
    pub fn hooks_since(&self, py: Python<'_>, version: u64) -> Option<Hooks> {
        let hooks = lock(&self.hooks);
        (hooks.version != version).then(|| hooks.clone_ref(py))
    }

    /// Adds a pressure, in the place of one at the same place.
    pub fn add_pressure(&self, hook: PressureHook) {
        let mut hooks = lock(&self.hooks);
        hooks.version += 1;
        let same = hooks.pressures.iter().position(|other| other.place == hook.place);
        let before = same.map(|k| hooks.pressures.swap_remove(k));
        hooks.pressures.push(hook);
        // What goes may run code of the user's.
        drop(hooks);
        drop(before);
    }

    /// Changes what chooses the conductances of new networks.
    pub fn set_remesh_hook(&self, py: Python<'_>, hook: Option<Arc<RemeshHook>>) -> PyResult<()> {
        let shared = self.shared();
        let mut run = shared.run(py)?;
        let mut hooks = lock(&self.hooks);
        let before = std::mem::replace(&mut hooks.remesh, hook);
        hooks.version += 1;
        let builder = hooks.builder();
        drop(hooks);
        // Without the interpreter: a network under way may wait for it.
        run.compute(py, |simulation| simulation.build_with(builder))?;
        drop(before);
        Ok(())
    }

    /// Forgets all that the user has added.
    pub fn clear_hooks(&self) {
        let mut hooks = lock(&self.hooks);
        let version = hooks.version + 1;
        let before = std::mem::replace(&mut *hooks, Hooks { version, ..Hooks::default() });
        drop(hooks);
        drop(before);
    }
}

/// What is in memory of the simulation's own, for the arrays of its parts.
pub fn spheres_of(
    simulation: &Py<PySimulation>,
    py: Python<'_>,
) -> PyResult<(Arc<Shared>, views::Source)> {
    let shared = simulation.get().shared();
    let order = shared.look(py, |s| s.coupled().dem().storage_order())?;
    Ok((shared, views::Source::Spheres(order)))
}

/// The same of its network.
pub fn network_of(
    simulation: &Py<PySimulation>,
    py: Python<'_>,
) -> PyResult<(Arc<Shared>, views::Source)> {
    let shared = simulation.get().shared();
    match shared.lease(py)? {
        Some(lease) => Ok((shared, views::Source::Network(lease))),
        None => Err(refused(
            py,
            "there is no pore network: the scene has no fluid, or its first coupled step is still to come",
        )),
    }
}
