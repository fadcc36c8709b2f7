//! Arrays that lie in the memory of a simulation.
//!
//! The base of each is a [`Memory`], which keeps that memory. What Python gets is a `dempfv.View`
//! (dempfv/_views.py), which asks its `Memory` before each use whether it still means anything.

use std::sync::Arc;

use numpy::ndarray::{ArrayView, Dim, Dimension};
use numpy::{Element, PyArray, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use crate::errors::{refused, stale};
use crate::shared::{Lease, Shared};

/// What an array is of.
#[derive(Clone)]
pub enum Source {
    /// Spheres in the order of this number.
    Spheres(u64),
    /// A network.
    Network(Arc<Lease>),
}

/// The memory under an array, and whether what is there is still what the array was asked for.
#[pyclass(frozen, module = "dempfv._dempfv")]
pub struct Memory {
    shared: Arc<Shared>,
    source: Source,
    address: usize,
    bytes: usize,
    /// Hooks may write here.
    writable: bool,
}

/// Where an array lies: first entry, rows and, of one with two dimensions, columns.
pub struct Place<T> {
    first: *const T,
    rows: usize,
    columns: Option<usize>,
}

impl<T> Place<T> {
    /// A number each.
    pub fn of_numbers(values: &[T]) -> Place<T> {
        Place { first: values.as_ptr(), rows: values.len(), columns: None }
    }

    /// So many numbers each.
    pub fn of_rows<const N: usize>(values: &[[T; N]]) -> Place<T> {
        Place { first: values.as_ptr().cast(), rows: values.len(), columns: Some(N) }
    }
}

impl Place<f64> {
    /// A vector each.
    pub fn of_vectors(values: &[dempfv::Vec3]) -> Place<f64> {
        // Three numbers one after the other, as nalgebra promises.
        Place { first: values.as_ptr().cast(), rows: values.len(), columns: Some(3) }
    }
}

/// An array in the memory of a simulation, for Python.
pub fn view<'py, T: Element>(
    py: Python<'py>,
    (shared, source): (Arc<Shared>, Source),
    place: Place<T>,
    writable: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let Place { first, rows, columns } = place;
    let bytes = rows * columns.unwrap_or(1) * size_of::<T>();
    let memory = Memory { shared, source, address: first as usize, bytes, writable };
    let memory = Bound::new(py, memory)?;
    let array = match columns {
        None => borrow(&memory, first, Dim(rows)),
        Some(columns) => borrow(&memory, first, Dim([rows, columns])),
    };
    static WRAP: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    WRAP.import(py, "dempfv._views", "wrap")?.call1((array?, memory))
}

/// An array that nobody writes to.
fn borrow<'py, T: Element, D: Dimension>(
    memory: &Bound<'py, Memory>,
    first: *const T,
    shape: D,
) -> PyResult<Bound<'py, PyAny>> {
    // SAFETY: so many values lie there. The base of the array is `memory`, which keeps them: the
    // simulation does not move its arrays, nor those of a network with a lease.
    let array = unsafe {
        let there = ArrayView::from_shape_ptr(shape, first);
        PyArray::borrow_from_array(&there, memory.as_any().clone())
    };
    array.try_readwrite()?.make_nonwriteable();
    Ok(array.into_any())
}

#[pymethods]
impl Memory {
    /// Refuses a use that would not see what the array was asked for.
    fn check(&self, py: Python<'_>) -> PyResult<()> {
        self.shared.check_access(py)?;
        if self.shared.is_replaced() {
            return Err(stale(
                py,
                "the simulation has been restored to another state; take the array anew",
            ));
        }
        match &self.source {
            Source::Spheres(order) => {
                let now = self.shared.look(py, |s| s.coupled().dem().storage_order())?;
                let message = "the spheres have been put in another order; take the array anew";
                if now == *order { Ok(()) } else { Err(stale(py, message)) }
            }
            Source::Network(lease) if lease.is_gone() => {
                Err(stale(py, "the network of this array has been replaced; take the array anew"))
            }
            Source::Network(_) => Ok(()),
        }
    }

    /// Whether an address is in the array's memory.
    fn covers(&self, address: usize) -> bool {
        (self.address..self.address + self.bytes.max(1)).contains(&address)
    }

    /// The memory and its address, to be written to, in hooks.
    fn writable<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, usize)> {
        let (py, memory) = (slf.py(), slf.get());
        memory.check(py)?;
        if !memory.writable {
            let message = "the array is read-only; of spheres, velocity and spin can be changed";
            return Err(refused(py, message));
        }
        if !memory.shared.is_in_hook() {
            let message = "the array is read-only outside of hooks; change it in a callback of run";
            return Err(refused(py, message));
        }
        let bytes = memory.address as *const u8;
        // SAFETY: as in `borrow`. Nothing computes while a hook runs.
        let array: Bound<'py, PyArray1<u8>> = unsafe {
            let there = ArrayView::from_shape_ptr(Dim(memory.bytes), bytes);
            PyArray::borrow_from_array(&there, slf.as_any().clone())
        };
        Ok((array.into_any(), memory.address))
    }
}
