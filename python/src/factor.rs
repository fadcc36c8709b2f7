//! `dempfv.Factor`.

use std::sync::Mutex;

use dempfv::InputError;
use dempfv::solver::{Backend, Factor, SolverKind, SymmetricCsc};
use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use crate::arrays::read;
use crate::errors::{raised, wrong};
use crate::shared::lock;

/// Lower triangle by columns: number of columns, and the three arrays.
type Lower<'py> =
    (usize, PyReadonlyArray1<'py, i64>, PyReadonlyArray1<'py, i64>, PyReadonlyArray1<'py, f64>);

/// A factored sparse symmetric positive definite matrix.
///
/// Parameters
/// ----------
/// a : sparse array or matrix of scipy, or array of shape (n, n)
///     Symmetric and positive definite; both triangles are given.
/// solver : {"auto", "cholmod", "frontal"}
///     As in scenes: ``auto`` takes CHOLMOD for small systems, and for large ones the frontal solver where
///     no entry off the diagonal is positive.
///
/// Raises
/// ------
/// InputError
///     For what is no such matrix, and where scipy is not installed.
/// SimulationError
///     Where the factorization fails, with the unknown: not positive definite, singular, too large for the
///     memory.
///
/// Examples
/// --------
/// >>> import dempfv as dp, numpy as np, scipy.sparse as sparse
/// >>> a = sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(5, 5))
/// >>> factor = dp.Factor(a)
/// >>> x = factor.solve(np.ones(5))
/// >>> bool(abs(a @ x - 1.0).max() < 1e-14)
/// True
/// >>> factor.solve(np.ones((5, 3))).shape
/// (5, 3)
#[pyclass(frozen, module = "dempfv", name = "Factor")]
pub struct PyFactor {
    n: usize,
    nnz: usize,
    factor: Mutex<Box<dyn Factor>>,
}

#[pymethods]
impl PyFactor {
    #[new]
    #[pyo3(signature = (a, solver="auto"))]
    fn new(a: &Bound<'_, PyAny>, solver: &str) -> PyResult<PyFactor> {
        static LOWER: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        let py = a.py();
        let solver: SolverKind =
            solver.parse().map_err(|e| raised(py, InputError::new(format!("{e}"), "")))?;
        let lower = LOWER.import(py, "dempfv._sparse", "lower_triangle")?.call1((a,))?;
        let (n, col_ptr, row_idx, values): Lower<'_> = lower.extract()?;
        let a = SymmetricCsc {
            n,
            col_ptr: col_ptr.as_slice()?.to_vec(),
            row_idx: row_idx.as_slice()?.to_vec(),
            values: values.as_slice()?.to_vec(),
        };
        crate::threads::start(py)?;
        let factored = py.detach(|| {
            rayon::scope(|_| {
                a.validate()?;
                solver.analyze(&a, None)?.factor(&a)
            })
        });
        let factor = Mutex::new(factored.map_err(|e| raised(py, e))?);
        Ok(PyFactor { n, nnz: a.nnz(), factor })
    }

    /// Solves A x = b.
    ///
    /// Parameters
    /// ----------
    /// b : array of shape (n,) or (n, k)
    ///     A right-hand side, or one in each of k columns. Each has the same bits as alone.
    ///
    /// Returns
    /// -------
    /// array of the same shape
    ///
    /// Raises
    /// ------
    /// InputError
    ///     For another shape.
    /// SimulationError
    ///     For an entry that is not finite.
    fn solve<'py>(&self, py: Python<'py>, b: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        // Column after column in memory: that of the transpose, row after row.
        let (b, shape) = read(&b.getattr("T")?)?;
        let columns = match shape[..] {
            [n] if n == self.n => 1,
            [columns, n] if n == self.n => columns,
            _ => {
                let shape: Vec<usize> = shape.into_iter().rev().collect();
                let what = format!("a right-hand side of shape {shape:?} for {} unknowns", self.n);
                return Err(wrong(py, what, "give shape (n,) or (n, k)"));
            }
        };
        let mut x = vec![0.0; b.len()];
        let solved = py.detach(|| {
            rayon::scope(|_| match columns {
                1 => lock(&self.factor).solve(&b, &mut x),
                _ => lock(&self.factor).solve_many(&b, &mut x, columns),
            })
        });
        solved.map_err(|e| raised(py, e))?;
        let x: Bound<'_, PyArray1<f64>> = x.into_pyarray(py);
        match shape.len() {
            1 => Ok(x.into_any()),
            _ => x.reshape([columns, self.n])?.into_any().getattr("T"),
        }
    }

    /// The factor as a ``scipy.sparse.linalg.LinearOperator``, for ``M`` of scipy's iterative solvers.
    ///
    /// Raises
    /// ------
    /// InputError
    ///     Where scipy is not installed.
    ///
    /// Examples
    /// --------
    /// >>> import dempfv as dp, numpy as np, scipy.sparse as sparse
    /// >>> from scipy.sparse.linalg import cg
    /// >>> a = sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(50, 50))
    /// >>> near = (a + 0.01 * sparse.eye_array(50)).tocsc()
    /// >>> x, info = cg(a, np.ones(50), M=dp.Factor(near).aspreconditioner())
    /// >>> info
    /// 0
    fn aspreconditioner<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        static OPERATOR: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
        OPERATOR.import(slf.py(), "dempfv._sparse", "operator")?.call1((slf,))
    }

    /// Rows and columns of the matrix.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.n, self.n)
    }

    /// Entries of the factor.
    #[getter]
    fn nnz(&self) -> u64 {
        lock(&self.factor).analysis().nnz_l
    }

    /// Memory that the factor holds (bytes).
    #[getter]
    fn memory_bytes(&self) -> usize {
        lock(&self.factor).memory_bytes()
    }

    /// Name of the solver that made it.
    #[getter]
    fn solver(&self) -> &'static str {
        lock(&self.factor).solver()
    }

    fn __repr__(&self) -> String {
        let factor = lock(&self.factor);
        let (solver, nnz) = (factor.solver(), factor.analysis().nnz_l);
        format!(
            "<dempfv.Factor: {} unknowns, {} entries in a triangle, {nnz} in the factor, by {solver}>",
            self.n, self.nnz
        )
    }
}
