//! What the user does in each step: forces on spheres, pressures.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use dempfv::coupling::{NetworkBuilder, StandardBuilder};
use dempfv::dem::{BodyForce, BodyLoad, SphereState};
use dempfv::simulation::Simulation;
use dempfv::{Vec3, WallId};
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyString, PyTuple};

use crate::errors::wrong;
use crate::remesh_hook::{HookedBuilder, RemeshHook};

/// Force and torque on each sphere, by the user's numbers: what a function said last.
///
/// The bits of numbers, so that the steps read what Python has written without a lock.
pub struct Loads {
    of_sphere: Box<[[AtomicU64; 6]]>,
}

impl Loads {
    fn new(spheres: usize) -> Loads {
        Loads { of_sphere: (0..spheres).map(|_| Default::default()).collect() }
    }

    /// Takes values that are in the order in which the simulation stores spheres.
    fn set(&self, numbers: &[u32], first: usize, values: &[f64]) {
        for (number, value) in numbers.iter().zip(values.chunks_exact(3)) {
            if let Some(load) = self.of_sphere.get(*number as usize) {
                for (entry, x) in load[first..first + 3].iter().zip(value) {
                    entry.store(x.to_bits(), Ordering::Relaxed);
                }
            }
        }
    }

    fn clear(&self) {
        for entry in self.of_sphere.iter().flatten() {
            entry.store(0, Ordering::Relaxed);
        }
    }
}

/// The same as a force of the library's.
struct LoadsOf {
    name: String,
    loads: Arc<Loads>,
}

impl BodyForce for LoadsOf {
    fn name(&self) -> &str {
        &self.name
    }

    fn load(&self, sphere: &SphereState, _time: f64) -> BodyLoad {
        let Some(load) = self.loads.of_sphere.get(sphere.number as usize) else {
            return BodyLoad::default();
        };
        let x = |k: usize| f64::from_bits(load[k].load(Ordering::Relaxed));
        BodyLoad { force: Vec3::new(x(0), x(1), x(2)), torque: Vec3::new(x(3), x(4), x(5)) }
    }
}

/// A force of the user's.
pub struct ForceHook {
    pub function: Py<PyAny>,
    name: String,
    loads: Arc<Loads>,
}

impl ForceHook {
    pub fn new(function: &Bound<'_, PyAny>, spheres: usize) -> ForceHook {
        let name = function.getattr("__qualname__").and_then(|name| name.extract::<String>());
        let name = name.unwrap_or_else(|_| "a force".to_owned());
        let loads = Arc::new(Loads::new(spheres));
        ForceHook { function: function.clone().unbind(), name, loads }
    }

    /// Lets it act on the spheres of a simulation.
    pub fn act_on(&self, simulation: &mut Simulation) {
        let force = LoadsOf { name: self.name.clone(), loads: Arc::clone(&self.loads) };
        simulation.controls().add_body_force(Box::new(force));
    }

    pub fn clone_ref(&self, py: Python<'_>) -> ForceHook {
        let (name, loads) = (self.name.clone(), Arc::clone(&self.loads));
        ForceHook { function: self.function.clone_ref(py), name, loads }
    }

    /// Takes what the function has returned: a force, a force and a torque, or nothing.
    pub fn take(&self, returned: &Bound<'_, PyAny>, numbers: &[u32]) -> PyResult<()> {
        let py = returned.py();
        self.loads.clear();
        if returned.is_none() {
            return Ok(());
        }
        let pair = returned.cast::<PyTuple>().ok().filter(|tuple| tuple.len() == 2);
        let parts = match pair {
            Some(pair) => vec![pair.get_item(0)?, pair.get_item(1)?],
            None => vec![returned.clone()],
        };
        for (k, part) in parts.iter().enumerate().filter(|(_, part)| !part.is_none()) {
            let values = as_vectors(part)?;
            if values.shape() != [numbers.len(), 3] {
                let what = format!(
                    "`{}` returned an array of shape {:?} for {} spheres",
                    self.name,
                    values.shape(),
                    numbers.len()
                );
                let remedy = "return a force of shape (n, 3), or a tuple of force and torque";
                return Err(wrong(py, what, remedy));
            }
            self.loads.set(numbers, 3 * k, values.as_slice()?);
        }
        Ok(())
    }
}

/// Numbers in rows, one after the other in memory; copied where they are not that.
fn as_vectors<'py>(values: &Bound<'py, PyAny>) -> PyResult<PyReadonlyArray2<'py, f64>> {
    static CONVERT: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let py = values.py();
    let convert = CONVERT.import(py, "dempfv._arrays", "vectors")?;
    convert.call1((values,))?.extract()
}

/// What a pressure is imposed on.
#[derive(Clone, Copy, PartialEq)]
pub enum Where {
    Wall(WallId),
    /// The region with this place in `imposed` of the scene's fluid.
    Region(usize),
}

impl Where {
    /// What Python names: a wall, or the number of a region.
    pub fn of(place: &Bound<'_, PyAny>) -> PyResult<Where> {
        let py = place.py();
        if let Ok(name) = place.cast::<PyString>() {
            let wall: Result<WallId, _> = name.to_cow()?.parse();
            return wall.map(Where::Wall).map_err(|e| wrong(py, e.to_string(), ""));
        }
        let number: usize = place.extract().map_err(|_| {
            wrong(
                py,
                "the place of a pressure is no wall and no number",
                "give x_min to z_max, or 0, 1, ...",
            )
        })?;
        Ok(Where::Region(number))
    }

    /// Changes the pressure (Pa) there.
    pub fn set(self, simulation: &mut Simulation, pressure: f64) -> dempfv::Result<()> {
        match self {
            Where::Wall(wall) => simulation.controls().set_wall_pressure(wall, pressure)?,
            Where::Region(number) => {
                simulation.controls().set_imposed_pressure(number, pressure)?
            }
        }
        Ok(())
    }
}

/// A pressure of the user's.
pub struct PressureHook {
    pub place: Where,
    pub pressure: Pressure,
}

/// What it is.
pub enum Pressure {
    /// This (Pa).
    Constant(f64),
    /// What a function says in each step.
    Function(Py<PyAny>),
}

impl PressureHook {
    /// The function, if it is one.
    pub fn function(&self) -> Option<&Py<PyAny>> {
        match &self.pressure {
            Pressure::Constant(_) => None,
            Pressure::Function(function) => Some(function),
        }
    }

    fn clone_ref(&self, py: Python<'_>) -> PressureHook {
        let pressure = match &self.pressure {
            Pressure::Constant(value) => Pressure::Constant(*value),
            Pressure::Function(function) => Pressure::Function(function.clone_ref(py)),
        };
        PressureHook { place: self.place, pressure }
    }
}

/// All that a user has added.
#[derive(Default)]
pub struct Hooks {
    pub forces: Vec<ForceHook>,
    pub pressures: Vec<PressureHook>,
    /// What chooses the conductances of new networks.
    pub remesh: Option<Arc<RemeshHook>>,
    /// Goes up with each change.
    pub version: u64,
}

impl Hooks {
    /// Whether a function is to be called in each step.
    pub fn act(&self) -> bool {
        self.functions_of_steps().next().is_some()
    }

    /// What builds networks.
    pub fn builder(&self) -> Arc<dyn NetworkBuilder> {
        match &self.remesh {
            Some(hook) => Arc::new(HookedBuilder(Arc::clone(hook))),
            None => Arc::new(StandardBuilder),
        }
    }

    /// Puts a simulation that has been made anew under them.
    pub fn act_on(&self, simulation: &mut Simulation) -> dempfv::Result<()> {
        self.forces.iter().for_each(|hook| hook.act_on(simulation));
        self.pressures.iter().try_for_each(|hook| match hook.pressure {
            Pressure::Constant(value) => hook.place.set(simulation, value),
            Pressure::Function(_) => Ok(()),
        })
    }

    /// The same, for a run: they may change while it calls them.
    pub fn clone_ref(&self, py: Python<'_>) -> Hooks {
        Hooks {
            forces: self.forces.iter().map(|hook| hook.clone_ref(py)).collect(),
            pressures: self.pressures.iter().map(|hook| hook.clone_ref(py)).collect(),
            remesh: self.remesh.clone(),
            version: self.version,
        }
    }

    /// All functions, for the garbage collector.
    pub fn functions(&self) -> impl Iterator<Item = &Py<PyAny>> {
        self.functions_of_steps().chain(self.remesh.iter().map(|hook| &hook.function))
    }

    fn functions_of_steps(&self) -> impl Iterator<Item = &Py<PyAny>> {
        let forces = self.forces.iter().map(|hook| &hook.function);
        forces.chain(self.pressures.iter().filter_map(PressureHook::function))
    }
}
