//! `sim.walls`.

use dempfv::simulation::Simulation;
use dempfv::{Vec3, WallId};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arrays::{numbers, vectors};

/// The six walls at one moment, in the order ``x_min``, ``x_max``, ``y_min``, ``y_max``, ``z_min``,
/// ``z_max``. All arrays are copies.
///
/// Examples
/// --------
/// >>> import dempfv as dp
/// >>> sim = dp.Simulation({
/// ...     "box": {"min": [0, 0, 0], "max": [1, 2, 1]},
/// ...     "particles": {"cloud": {"count": 10, "porosity": 0.9}},
/// ...     "dem": {},
/// ...     "stage": [{"kind": "run", "steps": 1}],
/// ... })
/// >>> dict(zip(sim.walls.names, sim.walls.position.tolist()))["y_max"]
/// 2.0
#[pyclass(frozen, module = "dempfv")]
pub struct Walls {
    position: [f64; 6],
    velocity: [f64; 6],
    displacement: [f64; 6],
    force: [Vec3; 6],
    stress: [f64; 6],
    fluid_stress: [f64; 6],
}

impl Walls {
    pub fn of(simulation: &Simulation) -> Walls {
        let (seen, dem) = (simulation.observe(), simulation.coupled().dem());
        Walls {
            position: dem.walls().map(|wall| wall.position).0,
            velocity: dem.walls().map(|wall| wall.velocity).0,
            displacement: seen.wall_displacement,
            force: dem.wall_force().0,
            stress: WallId::ALL.map(|wall| simulation.coupled().wall_stress(wall)),
            fluid_stress: seen.fluid_stress,
        }
    }
}

#[pymethods]
impl Walls {
    /// Their names.
    #[getter]
    fn names(&self) -> [&'static str; 6] {
        WallId::ALL.map(WallId::name)
    }

    /// Coordinate of each along its axis (m), shape (6,).
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        numbers(py, self.position.to_vec())
    }

    /// Velocity along the axis in the last step (m/s), shape (6,).
    #[getter]
    fn velocity<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        numbers(py, self.velocity.to_vec())
    }

    /// Way along the axis since the box was made (m), shape (6,).
    #[getter]
    fn displacement<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        numbers(py, self.displacement.to_vec())
    }

    /// Force of the contacts on each (N), shape (6, 3).
    #[getter]
    fn force<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        vectors(py, &self.force)
    }

    /// Normal stress by contacts and fluid (Pa, positive in compression), shape (6,).
    #[getter]
    fn stress<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        numbers(py, self.stress.to_vec())
    }

    /// The fluid's part of it (Pa), shape (6,).
    #[getter]
    fn fluid_stress<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        numbers(py, self.fluid_stress.to_vec())
    }

    fn __len__(&self) -> usize {
        WallId::ALL.len()
    }

    fn __repr__(&self) -> String {
        let each = WallId::ALL.map(|wall| format!("{wall} at {}", self.position[wall.index()]));
        format!("<dempfv.Walls: {}>", each.join(", "))
    }
}
