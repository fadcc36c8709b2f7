//! `sim.throats`.

use pyo3::prelude::*;

use crate::handle::PySimulation;
use crate::pores::network_view;
use crate::views::Place;

/// The throats between the pores of the network in use, a row each: views, as those of :class:`Pores`.
///
/// Examples
/// --------
/// >>> import dempfv as dp
/// >>> sim = dp.Simulation({
/// ...     "box": {"min": [0, 0, 0], "max": [1, 1, 1]},
/// ...     "particles": {"cloud": {"count": 30, "porosity": 0.8}},
/// ...     "dem": {},
/// ...     "fluid": {"viscosity": 1e-3, "pressure": {"y_max": 0.0}},
/// ...     "stage": [{"kind": "run", "steps": 5}],
/// ... })
/// >>> sim.step()
/// True
/// >>> sim.throats.pores.shape == (len(sim.throats), 2)
/// True
/// >>> bool((sim.throats.conductance >= 0.0).all())
/// True
#[pyclass(frozen, module = "dempfv")]
pub struct Throats {
    pub simulation: Py<PySimulation>,
}

#[pymethods]
impl Throats {
    /// The two pores of each, the smaller row first, shape (n, 2).
    #[getter]
    fn pores<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        network_view(&self.simulation, py, |flow| Place::of_rows(&flow.network().throats.pores))
    }

    /// Conductances (m³/(Pa s)), shape (n,).
    #[getter]
    fn conductance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        network_view(&self.simulation, py, |flow| {
            Place::of_numbers(&flow.network().throats.conductance)
        })
    }

    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        let count = |flow: &dempfv::pfv::Flow| flow.network().throats.pores.len();
        self.simulation.get().look(py, |s| s.coupled().storage_flow().map_or(0, count))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("<dempfv.Throats: {}>", self.__len__(py)?))
    }
}
