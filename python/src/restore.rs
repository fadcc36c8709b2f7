//! `dempfv.restore`.

use std::path::PathBuf;

use dempfv::scene::Plan;
use dempfv::simulation::Simulation;
use pyo3::prelude::*;

use crate::errors::raised;
use crate::handle::PySimulation;
use crate::scene::{load_state, plan};
use crate::threads;

/// Goes on from a checkpoint, with the same bits as if the run had not stopped.
///
/// Parameters
/// ----------
/// path : str or os.PathLike
///     A checkpoint of :meth:`Simulation.save` or of the program.
/// scene : str, os.PathLike or dict, optional
///     The scene to go on with; what it changes holds from the next step on. Without it, the scene
///     that the checkpoint was made with.
/// out : str or os.PathLike, optional
///     As for :class:`Simulation`.
///
/// Returns
/// -------
/// Simulation
///
/// Raises
/// ------
/// InputError
///     For a file that is no checkpoint, and for what no restart can change.
///
/// Examples
/// --------
/// >>> import dempfv as dp, os, tempfile
/// >>> scene = {
/// ...     "box": {"min": [0, 0, 0], "max": [1, 1, 1]},
/// ...     "particles": {"cloud": {"count": 10, "porosity": 0.9}},
/// ...     "dem": {"gravity": [0, -9.81, 0]},
/// ...     "stage": [{"kind": "run", "steps": 100}],
/// ... }
/// >>> sim = dp.Simulation(scene)
/// >>> sim.run(steps=30)
/// 30
/// >>> with tempfile.TemporaryDirectory() as folder:
/// ...     sim.save(os.path.join(folder, "half.dempfv"))
/// ...     again = dp.restore(os.path.join(folder, "half.dempfv"))
/// >>> sim.run(), again.run()
/// (70, 70)
/// >>> sim.state_hash == again.state_hash
/// True
#[pyfunction]
#[pyo3(signature = (path, scene=None, *, out=None))]
pub fn restore(
    py: Python<'_>,
    path: PathBuf,
    scene: Option<&Bound<'_, PyAny>>,
    out: Option<PathBuf>,
) -> PyResult<PySimulation> {
    let state = load_state(py, &path)?;
    let plan = match scene {
        Some(scene) => plan(scene)?,
        None => Plan::from_toml(state.scene(), None).map_err(|e| raised(py, e))?,
    };
    threads::start(py)?;
    let simulation = py.detach(|| Simulation::restart(plan, state)).map_err(|e| raised(py, e))?;
    Ok(PySimulation::of(simulation, out))
}
