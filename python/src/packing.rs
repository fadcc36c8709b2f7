//! `dempfv.Packing`.

use std::path::PathBuf;

use dempfv::io::packing;
use dempfv::scene::{load_packing, validate_packing};
use dempfv::simulation::Simulation;
use dempfv::{Aabb, Vec3};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arrays::{corners, numbers, read, read_vectors, vectors};
use crate::errors::{raised, wrong};

/// Spheres in a box.
///
/// Parameters
/// ----------
/// positions : array of shape (n, 3)
///     Centres (m), inside the box or on its surface.
/// radii : array of shape (n,)
///     Radii (m).
/// box : array of shape (2, 3), optional
///     Its lower and its upper corner (m). If not given, the tight box of the spheres.
///
/// Raises
/// ------
/// InputError
///     Names the sphere that is wrong.
///
/// Examples
/// --------
/// >>> import dempfv as dp
/// >>> packing = dp.Packing([[0.3, 0.5, 0.5], [0.7, 0.5, 0.5]], [0.2, 0.2], [[0, 0, 0], [1, 1, 1]])
/// >>> packing
/// <dempfv.Packing: 2 spheres in a box of 1 m x 1 m x 1 m>
/// >>> round(packing.porosity, 4)
/// 0.933
#[pyclass(frozen, module = "dempfv", name = "Packing")]
pub struct PyPacking {
    pub position: Vec<Vec3>,
    pub radius: Vec<f64>,
    pub bounds: Aabb,
}

impl PyPacking {
    /// The spheres of a simulation, in the user's order; `None` in a periodic cell.
    pub fn of_simulation(simulation: &Simulation) -> Option<PyPacking> {
        let dem = simulation.coupled().dem();
        let (position, radius, bounds) = (dem.positions(), dem.radii(), dem.box_());
        dem.cell().is_none().then_some(PyPacking { position, radius, bounds })
    }
}

#[pymethods]
impl PyPacking {
    #[new]
    #[pyo3(signature = (positions, radii, r#box=None))]
    fn new(
        positions: &Bound<'_, PyAny>,
        radii: &Bound<'_, PyAny>,
        r#box: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyPacking> {
        let py = positions.py();
        let position = read_vectors(positions)?
            .ok_or_else(|| wrong(py, "positions are no rows of x, y, z", "give shape (n, 3)"))?;
        let (radius, shape) = read(radii)?;
        if shape != [position.len()] {
            let what = format!("radii of shape {shape:?} for {} positions", position.len());
            return Err(wrong(py, what, "give one radius per position"));
        }
        if let Some(k) = radius.iter().position(|r| !(*r > 0.0 && r.is_finite())) {
            let what = format!("sphere {k} has the radius {}", radius[k]);
            return Err(wrong(py, what, "radii are positive"));
        }
        let bounds = match r#box {
            None => Aabb::of_spheres(&position, &radius)
                .ok_or_else(|| wrong(py, "no finite sphere", "give one or more"))?,
            Some(corners) => match read_vectors(corners)?.as_deref() {
                Some(&[min, max]) => Aabb { min, max },
                _ => {
                    let remedy = "give its lower and its upper corner, shape (2, 3)";
                    return Err(wrong(py, "the box is no two corners", remedy));
                }
            },
        };
        validate_packing(&position, &radius, None, &bounds, None).map_err(|e| raised(py, e))?;
        Ok(PyPacking { position, radius, bounds })
    }

    /// Reads a packing file, or the spheres of a checkpoint.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    ///     A file with ``x y z r`` on each line, in m; also those that YADE, Woo and LAMMPS write.
    ///
    /// Returns
    /// -------
    /// Packing
    ///
    /// Raises
    /// ------
    /// InputError
    ///     With the line that is wrong.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<PyPacking> {
        let (packing, bounds) = load_packing(&path, None).map_err(|e| raised(py, e))?;
        Ok(PyPacking { position: packing.position, radius: packing.radius, bounds })
    }

    /// Writes a packing file, with all digits.
    ///
    /// Parameters
    /// ----------
    /// path : str or os.PathLike
    /// comment : str, optional
    ///     The first line.
    ///
    /// Raises
    /// ------
    /// SimulationError
    ///     Where it cannot be written.
    ///
    /// Examples
    /// --------
    /// >>> import dempfv as dp, os, tempfile
    /// >>> packing = dp.Packing([[0.5, 0.5, 0.5]], [0.2], [[0, 0, 0], [1, 1, 1]])
    /// >>> with tempfile.TemporaryDirectory() as folder:
    /// ...     packing.save(os.path.join(folder, "one.txt"))
    /// ...     dp.Packing.load(os.path.join(folder, "one.txt"))
    /// <dempfv.Packing: 1 spheres in a box of 1 m x 1 m x 1 m>
    #[pyo3(signature = (path, comment="metres"))]
    fn save(&self, py: Python<'_>, path: PathBuf, comment: &str) -> PyResult<()> {
        let written =
            packing::write(&path, &self.position, &self.radius, Some(&self.bounds), comment);
        written.map_err(|e| raised(py, dempfv::Error::from(e)))
    }

    /// Centres (m), shape (n, 3); a copy.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        vectors(py, &self.position)
    }

    /// Radii (m), shape (n,); a copy.
    #[getter]
    fn radii<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        numbers(py, self.radius.clone())
    }

    /// Lower and upper corner of the box (m), shape (2, 3); a copy.
    #[getter]
    fn r#box<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        corners(py, &self.bounds)
    }

    /// Share of the box that no sphere fills (1); overlaps count twice as solid.
    #[getter]
    pub fn porosity(&self) -> f64 {
        let ball = |r: &f64| 4.0 / 3.0 * std::f64::consts::PI * r.powi(3);
        1.0 - self.radius.iter().map(ball).sum::<f64>() / self.bounds.volume()
    }

    fn __len__(&self) -> usize {
        self.radius.len()
    }

    fn __repr__(&self) -> String {
        let [x, y, z]: [f64; 3] = self.bounds.size().into();
        let count = self.radius.len();
        format!("<dempfv.Packing: {count} spheres in a box of {x} m x {y} m x {z} m>")
    }
}
