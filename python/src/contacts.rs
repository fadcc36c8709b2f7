//! `sim.contacts`.

use dempfv::Vec3;
use dempfv::dem::Partner;
use dempfv::simulation::Simulation;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arrays::{numbers, rows, vectors};

/// The contacts at one moment, a row each: those between spheres first, then those with walls.
///
/// All arrays are copies: the steps keep contacts in another form.
///
/// Examples
/// --------
/// >>> import dempfv as dp
/// >>> sim = dp.Simulation({
/// ...     "box": {"min": [0, 0, 0], "max": [1, 1, 1]},
/// ...     "particles": {"cloud": {"count": 10, "porosity": 0.9}},
/// ...     "dem": {},
/// ...     "stage": [{"kind": "compact", "stress": 1e4}],
/// ... })
/// >>> _ = sim.run()
/// >>> contacts = sim.contacts
/// >>> between_spheres = contacts.pairs[:, 1] < len(sim.spheres)
/// >>> bool((contacts.normal_force[between_spheres] > 0.0).all())
/// True
#[pyclass(frozen, module = "dempfv")]
pub struct Contacts {
    pairs: Vec<[u32; 2]>,
    normal: Vec<Vec3>,
    overlap: Vec<f64>,
    normal_force: Vec<f64>,
    shear_force: Vec<Vec3>,
    force: Vec<Vec3>,
}

impl Contacts {
    pub fn of(simulation: &Simulation) -> Contacts {
        let dem = simulation.coupled().dem();
        let row = |number: u32| dem.storage_index(number as usize) as u32;
        let (mut pairs, mut normal, mut overlap) = (vec![], vec![], vec![]);
        let (mut normal_force, mut shear_force, mut force) = (vec![], vec![], vec![]);
        for contact in dem.contacts() {
            let partner = match contact.partner {
                Partner::Sphere(number) => row(number),
                Partner::Wall(wall) => (dem.len() + wall.index()) as u32,
            };
            pairs.push([row(contact.i), partner]);
            normal.push(contact.normal);
            overlap.push(contact.overlap);
            normal_force.push(contact.normal_force);
            shear_force.push(contact.shear);
            force.push(contact.force());
        }
        Contacts { pairs, normal, overlap, normal_force, shear_force, force }
    }
}

#[pymethods]
impl Contacts {
    /// Rows of the two spheres in ``sim.spheres``, shape (m, 2). A second one of n + k, with n spheres,
    /// is the wall k of ``sim.walls``.
    #[getter]
    fn pairs<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        rows(py, &self.pairs)
    }

    /// Unit normals from the first to the second, shape (m, 3).
    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        vectors(py, &self.normal)
    }

    /// Depths by which the two overlap (m), shape (m,).
    #[getter]
    fn overlap<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        numbers(py, self.overlap.clone())
    }

    /// Normal forces (N, positive in compression), shape (m,).
    #[getter]
    fn normal_force<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        numbers(py, self.normal_force.clone())
    }

    /// Shear forces on the second (N), shape (m, 3).
    #[getter]
    fn shear_force<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        vectors(py, &self.shear_force)
    }

    /// Forces on the second (N), shape (m, 3); the first gets the opposite.
    #[getter]
    fn force<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        vectors(py, &self.force)
    }

    fn __len__(&self) -> usize {
        self.pairs.len()
    }

    fn __repr__(&self) -> String {
        format!("<dempfv.Contacts: {}>", self.pairs.len())
    }
}
