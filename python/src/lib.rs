//! dempfv as a Python package: the module `dempfv._dempfv`, which `dempfv/__init__.py` hands on.

mod arrays;
mod contacts;
mod drive;
mod errors;
mod factor;
mod handle;
mod hooks;
mod network;
mod packing;
mod pores;
mod remesh_hook;
mod restore;
mod scene;
mod shared;
mod simulation;
mod spheres;
mod summary;
mod threads;
mod throats;
mod views;
mod walls;

use pyo3::prelude::*;

/// The part of dempfv that computes.
// One thread at a time uses it, as the interpreter's lock has it.
#[pymodule(gil_used = true)]
fn _dempfv(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("NONE", dempfv::pfv::NONE)?;
    module.add_class::<contacts::Contacts>()?;
    module.add_class::<factor::PyFactor>()?;
    module.add_class::<network::PyNetwork>()?;
    module.add_class::<packing::PyPacking>()?;
    module.add_class::<pores::Pores>()?;
    module.add_class::<handle::PySimulation>()?;
    module.add_class::<spheres::Spheres>()?;
    module.add_class::<throats::Throats>()?;
    module.add_class::<views::Memory>()?;
    module.add_class::<walls::Walls>()?;
    module.add_function(wrap_pyfunction!(restore::restore, module)?)?;
    module.add_function(wrap_pyfunction!(threads::set_threads, module)?)
}
