//! `sim.spheres`.

use dempfv::simulation::Simulation;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arrays::{numbers, vectors};
use crate::errors::wrong;
use crate::handle::{PySimulation, spheres_of};
use crate::views::{Place, view};

/// The spheres of a simulation, a row each.
///
/// Rows are in the order in which the spheres lie in memory, in all arrays the same one. ``number`` has
/// the user's number of each row: its place in the packing file, from 0. ``row`` is the inverse.
///
/// ``position``, ``velocity``, ``spin``, ``radius``, ``mass``, ``force``, ``torque`` and ``number`` are
/// views (:class:`View`): nothing is copied, and after a step they show its values.
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
/// >>> len(sim.spheres)
/// 10
/// >>> bool((sim.spheres.number[sim.spheres.row] == range(10)).all())
/// True
#[pyclass(frozen, module = "dempfv")]
pub struct Spheres {
    pub simulation: Py<PySimulation>,
}

impl Spheres {
    fn view<'py, T: numpy::Element>(
        &self,
        py: Python<'py>,
        place: impl FnOnce(&Simulation) -> Place<T>,
        writable: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (shared, source) = spheres_of(&self.simulation, py)?;
        let place = shared.look(py, place)?;
        view(py, (shared, source), place, writable)
    }
}

#[pymethods]
impl Spheres {
    /// Centres (m), shape (n, 3).
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.view(py, |s| Place::of_vectors(&s.coupled().dem().storage().position), false)
    }

    /// Velocities (m/s), shape (n, 3), half a time step behind the positions. Hooks may change them.
    #[getter]
    fn velocity<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.view(py, |s| Place::of_vectors(&s.coupled().dem().storage().velocity), true)
    }

    /// Angular velocities (rad/s), shape (n, 3), likewise.
    #[getter]
    fn spin<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.view(py, |s| Place::of_vectors(&s.coupled().dem().storage().spin), true)
    }

    /// Radii (m), shape (n,).
    #[getter]
    fn radius<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.view(py, |s| Place::of_numbers(&s.coupled().dem().storage().radius), false)
    }

    /// Masses (kg), shape (n,).
    #[getter]
    fn mass<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.view(py, |s| Place::of_numbers(&s.coupled().dem().storage().mass), false)
    }

    /// Forces of the contacts on the spheres (N), shape (n, 3), as the last step found them.
    #[getter]
    fn force<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.view(py, |s| Place::of_vectors(s.coupled().dem().storage_forces()), false)
    }

    /// Torques of the contacts on the spheres (N m), shape (n, 3), likewise.
    #[getter]
    fn torque<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.view(py, |s| Place::of_vectors(s.coupled().dem().storage_torques()), false)
    }

    /// The user's number of each row, shape (n,).
    #[getter]
    fn number<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.view(py, |s| Place::of_numbers(&s.coupled().dem().storage().id), false)
    }

    /// The row of each of the user's numbers, shape (n,); a copy.
    #[getter]
    fn row<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<u32>>> {
        let row = self.simulation.get().look(py, |s| {
            let dem = s.coupled().dem();
            (0..dem.len()).map(|number| dem.storage_index(number) as u32).collect::<Vec<_>>()
        })?;
        Ok(numbers(py, row))
    }

    /// Index of each sphere's material in the scene, shape (n,); a copy.
    #[getter]
    fn group<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<u16>>> {
        let group = self.simulation.get().look(py, |s| {
            let spheres = s.coupled().dem().storage();
            match spheres.material.is_empty() {
                true => vec![0; spheres.len()],
                false => spheres.material.clone(),
            }
        })?;
        Ok(numbers(py, group))
    }

    /// Forces of the fluid on the spheres (N), shape (n, 3), in the last step; zero where the pores are
    /// empty; a copy.
    #[getter]
    fn fluid_force<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let force = self.simulation.get().look(py, |s| {
            let none = || vec![dempfv::Vec3::zeros(); s.coupled().dem().len()];
            s.coupled().storage_fluid_force().map_or_else(none, <[_]>::to_vec)
        })?;
        Ok(vectors(py, &force))
    }

    /// Values of all spheres in the order of the user's numbers: a copy of ``values[sim.spheres.row]``.
    ///
    /// Parameters
    /// ----------
    /// values : array
    ///     With a row per sphere.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     For another number of rows.
    fn by_number<'py>(
        &self,
        py: Python<'py>,
        values: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (rows, spheres) = (values.len()?, self.__len__(py)?);
        if rows != spheres {
            let what = format!("{rows} rows for {spheres} spheres");
            return Err(wrong(py, what, "give an array with a row per sphere"));
        }
        values.get_item(self.row(py)?)
    }

    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.simulation.get().look(py, |s| s.coupled().dem().len())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("<dempfv.Spheres: {}>", self.__len__(py)?))
    }
}
