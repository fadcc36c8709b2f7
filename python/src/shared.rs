//! A simulation that several Python objects look at, and who may do so at the moment.
//!
//! All of this is called with the interpreter attached, by one thread at a time. While a run computes it
//! is detached: then the simulation is the run's alone, and every other call is refused.

use std::any::Any;
use std::cell::UnsafeCell;
use std::mem::ManuallyDrop;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak};
use std::thread::{self, ThreadId};

use dempfv::pfv::RetiredNetwork;
use dempfv::simulation::Simulation;
use pyo3::prelude::*;

use crate::errors::refused;
use crate::threads;

/// The lock of a mutex whose value no panic leaves half changed.
pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What a thread is doing with a simulation.
#[derive(Clone, Copy)]
enum Use {
    /// None does anything.
    Idle,
    /// A run computes, or calls a function of the user's.
    Running { thread: ThreadId, in_hook: bool },
}

/// A simulation and its memory, which stays as long as anybody has an array of it.
pub struct Shared {
    simulation: ManuallyDrop<UnsafeCell<Simulation>>,
    current: Mutex<Use>,
    /// The state of another moment has been put in its place.
    replaced: AtomicBool,
    /// A step panicked.
    broken: AtomicBool,
    /// Of the network in use, where anybody has an array of it.
    lease: Mutex<Weak<Lease>>,
}

// SAFETY: all access to the simulation is through `look`, `change` and `Run`. The first two need an
// attached interpreter, of which there is one thread at a time, run no Python code while they
// have the reference, and are refused while a `Run` computes; there is one `Run` at a time.
unsafe impl Sync for Shared {}
unsafe impl Send for Shared {}

/// The arrays of one network, for as long as anybody has one.
pub struct Lease {
    /// Address of its cells, which no other network has while they are kept.
    address: usize,
    gone: AtomicBool,
    /// The arrays, once the simulation has let go of them.
    retired: OnceLock<RetiredNetwork>,
}

impl Lease {
    /// Whether another network is in use, or none.
    pub fn is_gone(&self) -> bool {
        self.gone.load(Ordering::Relaxed)
    }
}

/// Address of what tells a simulation's network from all others that are kept.
fn network_address(simulation: &Simulation) -> Option<usize> {
    let flow = simulation.coupled().storage_flow()?;
    Some(flow.network().tessellation.cells.as_ptr() as usize)
}

impl Shared {
    pub fn new(simulation: Simulation) -> Arc<Shared> {
        Arc::new(Shared {
            simulation: ManuallyDrop::new(UnsafeCell::new(simulation)),
            current: Mutex::new(Use::Idle),
            replaced: AtomicBool::new(false),
            broken: AtomicBool::new(false),
            lease: Mutex::new(Weak::new()),
        })
    }

    /// Refuses a look while a run computes, or in another thread than the run's.
    pub fn check_access(&self, py: Python<'_>) -> PyResult<()> {
        if self.broken.load(Ordering::Relaxed) {
            let message =
                "a step of this simulation has failed by a fault of dempfv's; restore a checkpoint";
            return Err(refused(py, message));
        }
        // Messages are made by Python, which may run another thread: no lock is held then.
        let current = *lock(&self.current);
        match current {
            Use::Running { thread, in_hook } if thread != thread::current().id() || !in_hook => {
                let message =
                    "the simulation is running in another thread; wait for its run to end";
                Err(refused(py, message))
            }
            _ => Ok(()),
        }
    }

    /// Looks at the simulation between two steps. No Python in `look`: it might run another thread.
    pub fn look<T>(&self, py: Python<'_>, look: impl FnOnce(&Simulation) -> T) -> PyResult<T> {
        self.check_access(py)?;
        // SAFETY: see `Sync`.
        Ok(look(unsafe { &*self.simulation.get() }))
    }

    /// Changes something between two steps, likewise.
    pub fn change<T>(
        &self,
        py: Python<'_>,
        change: impl FnOnce(&mut Simulation) -> T,
    ) -> PyResult<T> {
        self.check_access(py)?;
        // SAFETY: see `Sync`.
        Ok(change(unsafe { &mut *self.simulation.get() }))
    }

    /// Whether a function of the user's is being called within a run.
    pub fn is_in_hook(&self) -> bool {
        matches!(*lock(&self.current), Use::Running { in_hook: true, .. })
    }

    /// Says that another state has been put in the place of this one.
    pub fn replace(&self) {
        self.replaced.store(true, Ordering::Relaxed);
    }

    pub fn is_replaced(&self) -> bool {
        self.replaced.load(Ordering::Relaxed)
    }

    /// What keeps the arrays of the network in use; `None` where the pores are empty.
    pub fn lease(&self, py: Python<'_>) -> PyResult<Option<Arc<Lease>>> {
        let Some(address) = self.look(py, network_address)? else { return Ok(None) };
        let mut lease = lock(&self.lease);
        if let Some(lease) = lease.upgrade().filter(|lease| lease.address == address) {
            return Ok(Some(lease));
        }
        let (gone, retired) = (AtomicBool::new(false), OnceLock::new());
        let new = Arc::new(Lease { address, gone, retired });
        *lease = Arc::downgrade(&new);
        Ok(Some(new))
    }

    /// Begins a run in this thread.
    pub fn run(&self, py: Python<'_>) -> PyResult<Run<'_>> {
        self.check_access(py)?;
        threads::start(py)?;
        self.claim(py)
    }

    /// Keeps all others from a simulation, which may have failed: as a run does.
    pub fn claim(&self, py: Python<'_>) -> PyResult<Run<'_>> {
        let mut current = lock(&self.current);
        if let Use::Running { .. } = *current {
            drop(current);
            let message =
                "the simulation is running; neither a hook nor another thread can do this";
            return Err(refused(py, message));
        }
        *current = Use::Running { thread: thread::current().id(), in_hook: false };
        Ok(Run { shared: self })
    }
}

impl Drop for Shared {
    /// Without the interpreter: a simulation waits for a network under way, and that may wait for the
    /// interpreter, to ask a function of the user's.
    fn drop(&mut self) {
        // SAFETY: nobody takes it out but this function, which is called once.
        let simulation = unsafe { ManuallyDrop::take(&mut self.simulation) }.into_inner();
        Python::try_attach(|py| py.detach(move || drop(simulation)));
    }
}

/// A run that has begun. Whatever ends it, others may look again.
pub struct Run<'a> {
    shared: &'a Shared,
}

/// Carries an address to where it is used, by the one thread that may.
struct Exclusive(*mut Simulation);

// SAFETY: a simulation may be moved to another thread, as this line asks; see `Run::compute`.
unsafe impl Send for Exclusive where Simulation: Send {}

impl Exclusive {
    fn get(self) -> *mut Simulation {
        self.0
    }
}

impl Run<'_> {
    /// Computes without the interpreter, so that other Python threads go on. A panic is an error.
    pub fn compute<T: Send>(
        &mut self,
        py: Python<'_>,
        work: impl FnOnce(&mut Simulation) -> T + Send,
    ) -> PyResult<T> {
        let keep = lock(&self.shared.lease).strong_count() > 0;
        let address = Exclusive(self.shared.simulation.get());
        let done = py.detach(move || {
            let work = move || {
                // SAFETY: this run is the only one, and all else is refused until it is in a hook.
                let simulation = unsafe { &mut *address.get() };
                simulation.keep_network_arrays(keep);
                work(simulation)
            };
            rayon::scope(move |_| catch_unwind(AssertUnwindSafe(work)))
        });
        self.settle();
        done.map_err(|panic| {
            self.shared.broken.store(true, Ordering::Relaxed);
            let message = format!("a fault of dempfv's, please report it: {}", said(&*panic));
            refused(py, &message)
        })
    }

    /// Takes over the arrays of a network that has gone out of use, for those who have one.
    fn settle(&mut self) {
        // SAFETY: nothing computes now, and no Python runs here.
        let simulation = unsafe { &mut *self.shared.simulation.get() };
        let retired = simulation.take_retired_network();
        let lease = lock(&self.shared.lease).upgrade();
        let gone = lease.filter(|lease| network_address(simulation) != Some(lease.address));
        if let Some(lease) = gone {
            lease.gone.store(true, Ordering::Relaxed);
            // There is one at most: networks after it were not to be kept.
            if let Some(network) = retired {
                lease.retired.get_or_init(|| network);
            }
        }
    }

    /// Looks at the simulation between two steps.
    pub fn look<T>(&self, _py: Python<'_>, look: impl FnOnce(&Simulation) -> T) -> T {
        // SAFETY: nothing computes now.
        look(unsafe { &*self.shared.simulation.get() })
    }

    /// Changes something between two steps.
    pub fn change<T>(&mut self, _py: Python<'_>, change: impl FnOnce(&mut Simulation) -> T) -> T {
        // SAFETY: nothing computes now.
        change(unsafe { &mut *self.shared.simulation.get() })
    }

    /// Calls functions of the user's, who may look and change what hooks may.
    pub fn in_hook<T>(&mut self, call: impl FnOnce() -> T) -> T {
        self.set_hook(true);
        let result = call();
        self.set_hook(false);
        result
    }

    fn set_hook(&self, now: bool) {
        if let Use::Running { in_hook, .. } = &mut *lock(&self.shared.current) {
            *in_hook = now;
        }
    }
}

impl Drop for Run<'_> {
    fn drop(&mut self) {
        *lock(&self.shared.current) = Use::Idle;
    }
}

/// The words of a panic.
fn said(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}
