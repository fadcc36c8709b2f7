//! `sim.pores`.

use dempfv::pfv::Flow;
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::arrays::numbers;
use crate::handle::{PySimulation, network_of};
use crate::views::{Place, view};

/// The pores of the network in use, a row each.
///
/// ``pressure``, ``center``, ``volume``, ``vertices`` and ``neighbors`` are views (:class:`View`):
/// nothing is copied. They are of one network, and raise :class:`StaleViewError` once a remesh has
/// put another in its place.
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
/// >>> sim.run(steps=1)
/// 1
/// >>> bool(0.0 <= sim.pores.pressure.min() and sim.pores.pressure.max() <= 1.0)
/// True
/// >>> round(float(sim.pores.volume.sum()), 12)
/// 1.0
#[pyclass(frozen, module = "dempfv")]
pub struct Pores {
    pub simulation: Py<PySimulation>,
}

/// An array in the memory of a simulation's network.
pub fn network_view<'py, T: numpy::Element>(
    simulation: &Py<PySimulation>,
    py: Python<'py>,
    place: impl FnOnce(&Flow) -> Place<T>,
) -> PyResult<Bound<'py, PyAny>> {
    let (shared, source) = network_of(simulation, py)?;
    let nothing = || Place::of_numbers(&[]);
    let place = shared.look(py, |s| s.coupled().storage_flow().map_or_else(nothing, place))?;
    view(py, (shared, source), place, false)
}

impl Pores {
    fn look<T>(&self, py: Python<'_>, look: impl FnOnce(&Flow) -> T) -> PyResult<Option<T>> {
        self.simulation.get().look(py, |s| s.coupled().storage_flow().map(look))
    }
}

#[pymethods]
impl Pores {
    /// Pressures (Pa), shape (n,), as the last step found them; beyond the hydrostatic one.
    #[getter]
    fn pressure<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        network_view(&self.simulation, py, |flow| Place::of_numbers(flow.pressure()))
    }

    /// Power centres (m), shape (n, 3): the points of equal power to the four vertices, where conductances
    /// are measured from. They may lie outside of their pores.
    #[getter]
    fn center<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        network_view(&self.simulation, py, |flow| Place::of_vectors(&flow.network().center))
    }

    /// Signed volumes (m³), solids included, shape (n,).
    #[getter]
    fn volume<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        network_view(&self.simulation, py, |flow| Place::of_numbers(&flow.network().volume))
    }

    /// The four vertices of each, shape (n, 4): rows of ``sim.spheres``; a number of m + k, with m
    /// spheres, is the wall k of ``sim.walls``.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        network_view(&self.simulation, py, |flow| {
            Place::of_rows(&flow.network().tessellation.cells)
        })
    }

    /// The pore across the facet opposite each vertex, shape (n, 4); ``dempfv.NONE`` where there is none.
    #[getter]
    fn neighbors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        network_view(&self.simulation, py, |flow| {
            Place::of_rows(&flow.network().tessellation.neighbors)
        })
    }

    /// Whether each has an imposed pressure, shape (n,); a copy.
    #[getter]
    fn imposed<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let imposed = self.look(py, |flow| {
            let pores = 0..flow.network().pores();
            pores.map(|pore| flow.operators().imposed(pore).is_some()).collect::<Vec<_>>()
        })?;
        Ok(numbers(py, imposed.unwrap_or_default()))
    }

    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.look(py, |flow| flow.network().pores())?.unwrap_or(0))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("<dempfv.Pores: {}>", self.__len__(py)?))
    }
}
