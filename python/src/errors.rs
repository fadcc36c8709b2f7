//! Errors of the library as Python's exceptions, with what they are about as attributes.

use dempfv::{Error, InputError};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The module that the classes are in.
const MODULE: &str = "dempfv._errors";

/// What an exception says beside its message.
#[derive(Default)]
struct About {
    file: Option<String>,
    line: Option<usize>,
    remedy: Option<String>,
    step: Option<u64>,
    sphere: Option<u32>,
    pore: Option<u32>,
}

/// The exception for an error of the library.
pub fn raised(py: Python<'_>, error: impl Into<Error>) -> PyErr {
    let error = error.into();
    let message = error.to_string();
    match &error {
        Error::Input(input) => {
            let file = input.file.as_ref().map(|file| file.to_string_lossy().into_owned());
            let remedy = Some(input.remedy.clone()).filter(|remedy| !remedy.is_empty());
            let about = About { file, line: input.line, remedy, ..About::default() };
            exception(py, "InputError", &message, about)
        }
        _ => {
            let (step, sphere, pore) = (error.step(), error.sphere(), error.pore());
            let about = About { step, sphere, pore, ..About::default() };
            exception(py, "SimulationError", &message, about)
        }
    }
}

/// What a caller gave is wrong.
pub fn wrong(py: Python<'_>, what: impl Into<String>, remedy: impl Into<String>) -> PyErr {
    raised(py, InputError::new(what, remedy))
}

/// What was asked for cannot be done as things stand.
pub fn refused(py: Python<'_>, message: &str) -> PyErr {
    exception(py, "SimulationError", message, About::default())
}

/// An array is of a state that is gone.
pub fn stale(py: Python<'_>, message: &str) -> PyErr {
    exception(py, "StaleViewError", message, About::default())
}

fn exception(py: Python<'_>, class: &str, message: &str, about: About) -> PyErr {
    let made = || -> PyResult<PyErr> {
        let class = py.import(MODULE)?.getattr(class)?;
        let keys = PyDict::new(py);
        keys.set_item("file", about.file)?;
        keys.set_item("line", about.line)?;
        keys.set_item("remedy", about.remedy)?;
        keys.set_item("step", about.step)?;
        keys.set_item("sphere", about.sphere)?;
        keys.set_item("pore", about.pore)?;
        Ok(PyErr::from_value(class.call((message,), Some(&keys))?))
    };
    // Where the package is not whole, at least the message arrives.
    made().unwrap_or_else(|_| PyRuntimeError::new_err(message.to_owned()))
}
