//! Values of the library as numpy arrays of their own, and back.

use dempfv::{Aabb, Vec3};
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

/// An array of numbers.
pub fn numbers<T: Element>(py: Python<'_>, values: Vec<T>) -> Bound<'_, PyArray1<T>> {
    values.into_pyarray(py)
}

/// An array with a row per vector.
pub fn vectors<'py>(py: Python<'py>, values: &[Vec3]) -> Bound<'py, PyArray2<f64>> {
    rows(py, &values.iter().map(|v| [v.x, v.y, v.z]).collect::<Vec<_>>())
}

/// An array of so many numbers in each row.
pub fn rows<'py, T: Element + Copy, const N: usize>(
    py: Python<'py>,
    values: &[[T; N]],
) -> Bound<'py, PyArray2<T>> {
    let flat = values.as_flattened().to_vec().into_pyarray(py);
    // As many numbers as rows and columns take.
    let shaped = flat.reshape([values.len(), N]);
    shaped.unwrap_or_else(|_| PyArray2::zeros(py, [0, N], false))
}

/// Numbers of any array, converted by numpy, with its shape.
pub fn read(values: &Bound<'_, PyAny>) -> PyResult<(Vec<f64>, Vec<usize>)> {
    static CONVERT: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let convert = CONVERT.import(values.py(), "dempfv._arrays", "numbers")?;
    let array: PyReadonlyArrayDyn<'_, f64> = convert.call1((values,))?.extract()?;
    let view = array.as_array();
    Ok((view.iter().copied().collect(), view.shape().to_vec()))
}

/// Points of an array with three columns; `None` for another shape.
pub fn read_vectors(values: &Bound<'_, PyAny>) -> PyResult<Option<Vec<Vec3>>> {
    let (values, shape) = read(values)?;
    let vectors = || values.chunks_exact(3).map(|x| Vec3::new(x[0], x[1], x[2])).collect();
    Ok(matches!(shape[..], [_, 3]).then(vectors))
}

/// The corners of a box, as an array of shape (2, 3).
pub fn corners<'py>(py: Python<'py>, bounds: &Aabb) -> Bound<'py, PyArray2<f64>> {
    vectors(py, &[bounds.min, bounds.max])
}
