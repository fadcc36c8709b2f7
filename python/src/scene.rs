//! What Python gives for scenes and their checkpoints.

use std::path::{Path, PathBuf};

use dempfv::InputError;
use dempfv::io::checkpoint;
use dempfv::scene::Plan;
use dempfv::simulation::SimulationState;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;

use crate::errors::{raised, wrong};

/// A plan from what Python gives for a scene.
pub fn plan(scene: &Bound<'_, PyAny>) -> PyResult<Plan> {
    let py = scene.py();
    if let Ok(tables) = scene.cast::<PyDict>() {
        static TO_TOML: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        let text = TO_TOML.import(py, "dempfv._scene", "to_toml")?.call1((tables,))?;
        let read = Plan::from_toml(&text.extract::<String>()?, None);
        // Lines are those of a text that nobody has seen.
        return read.map_err(|e| raised(py, InputError { line: None, ..e }));
    }
    let path: PathBuf = scene.extract().map_err(|_| {
        let found = scene.get_type().name().map_or(String::new(), |name| name.to_string());
        wrong(
            py,
            format!("a scene of the type {found}"),
            "give the path of a scene file, or a dict",
        )
    })?;
    Plan::load(path).map_err(|e| raised(py, e))
}

/// The state in a checkpoint.
pub fn load_state(py: Python<'_>, path: &Path) -> PyResult<SimulationState> {
    checkpoint::load(path).map_err(|e| raised(py, e))
}
