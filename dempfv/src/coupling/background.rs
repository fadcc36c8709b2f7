//! Remesher built beside the time loop: one thread that takes orders and gives
//! back whole networks.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, Sender, TryRecvError, unbounded};

use super::CouplingError;
use crate::pfv::{Assembled, Flow, Fluid, ReusableAnalysis};
use crate::solver::SolverKind;
use crate::{Aabb, Result, Vec3};

/// The positions that a network is to be built from, and how.
pub struct Order {
    /// Sphere centres (m).
    pub position: Vec<Vec3>,
    /// Radii (m).
    pub radius: Vec<f64>,
    /// The box (m).
    pub bounds: Aabb,
    /// The fluid and its boundary conditions.
    pub fluid: Fluid,
    /// The linear solver.
    pub solver: SolverKind,
    /// A factor that is no longer needed.
    pub spare: Option<ReusableAnalysis>,
}

/// What builds networks: a place for other ways to build them, and for
/// failures in tests.
pub trait NetworkBuilder: Send + Sync {
    /// Builds a network; `None` when `cancelled` became true on the way, to
    /// be looked up between two phases.
    ///
    /// # Errors
    /// Why there is no such network.
    fn build(&self, order: Order, cancelled: &AtomicBool) -> Result<Option<Flow>>;
}

/// Builds networks by triangulating, analyzing and factoring.
#[derive(Clone, Copy, Debug, Default)]
pub struct StandardBuilder;

impl NetworkBuilder for StandardBuilder {
    fn build(&self, order: Order, cancelled: &AtomicBool) -> Result<Option<Flow>> {
        let stop = || cancelled.load(Ordering::Relaxed);
        let Order { position, radius, bounds, fluid, solver, spare } = order;
        if stop() {
            return Ok(None);
        }
        let assembled = Assembled::new(&position, &radius, bounds, &fluid)?;
        drop((position, radius));
        if stop() {
            return Ok(None);
        }
        let analyzed = assembled.analyze(solver, spare)?;
        if stop() { Ok(None) } else { Ok(Some(analyzed.factor()?)) }
    }
}

/// Names an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Ticket(u64);

/// A network from the background, and how long it took.
pub(super) struct Answer {
    ticket: Ticket,
    pub flow: Result<Flow>,
    pub took: Duration,
}

struct Message {
    ticket: Ticket,
    order: Order,
    cancelled: Arc<AtomicBool>,
}

/// The thread and its two channels. Neither ever blocks a sender, so whoever
/// waits for an answer or for the thread's end waits for one network at most.
///
/// The thread has a pool of its own: what it shares out takes no thread of the
/// time loop's, and the time loop may wait for it from within its own pool.
pub(super) struct Worker {
    /// `None` once the thread is to end.
    orders: Option<Sender<Message>>,
    answers: Receiver<Answer>,
    thread: Option<JoinHandle<()>>,
    /// Of the last order.
    cancelled: Arc<AtomicBool>,
    last: u64,
}

/// Stack of the worker's threads: that of a main thread, on which the same
/// libraries run in the foreground.
const STACK: usize = 8 << 20;

impl Worker {
    /// Starts the thread, with as many helpers as the time loop has threads.
    pub fn start(builder: Arc<dyn NetworkBuilder>) -> Result<Worker, CouplingError> {
        let not_started =
            |e: &dyn std::fmt::Display| CouplingError::WorkerNotStarted { what: e.to_string() };
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(rayon::current_num_threads())
            .stack_size(STACK)
            .thread_name(|k| format!("remesh-{k}"))
            .build()
            .map_err(|e| not_started(&e))?;
        let (orders, inbox) = unbounded();
        let (outbox, answers) = unbounded();
        let thread = thread::Builder::new()
            .name("remesh".to_owned())
            .spawn(move || serve(&*builder, &pool, &inbox, &outbox))
            .map_err(|e| not_started(&e))?;
        Ok(Worker {
            orders: Some(orders),
            answers,
            thread: Some(thread),
            cancelled: Arc::default(),
            last: 0,
        })
    }

    /// Orders a network. One that was ordered before is cancelled.
    pub fn submit(&mut self, order: Order) -> Ticket {
        self.cancel();
        self.cancelled = Arc::default();
        self.last += 1;
        let ticket = Ticket(self.last);
        let message = Message { ticket, order, cancelled: Arc::clone(&self.cancelled) };
        if let Some(orders) = &self.orders {
            // A thread that is gone is noticed when its answer is waited for.
            let _ = orders.send(message);
        }
        ticket
    }

    /// Drops what was ordered last, finished or not.
    pub fn cancel(&mut self) {
        self.cancelled.store(true, Ordering::Relaxed);
        while self.answers.try_recv().is_ok() {}
    }

    /// The answer to an order if it is there.
    pub fn try_take(&mut self, ticket: Ticket) -> Option<Answer> {
        loop {
            match self.answers.try_recv() {
                Ok(answer) if answer.ticket == ticket => return Some(answer),
                Ok(_) => {}
                Err(TryRecvError::Empty) => return None,
                Err(TryRecvError::Disconnected) => return Some(Answer::lost(ticket)),
            }
        }
    }

    /// Waits for the answer to the last order.
    pub fn take(&mut self, ticket: Ticket) -> Answer {
        loop {
            match self.answers.recv() {
                Ok(answer) if answer.ticket == ticket => return answer,
                Ok(_) => {}
                Err(_) => return Answer::lost(ticket),
            }
        }
    }
}

impl Answer {
    /// The thread is gone.
    pub fn lost(ticket: Ticket) -> Answer {
        let what = "the thread has ended".to_owned();
        let error = CouplingError::WorkerPanicked { what }.into();
        Answer { ticket, flow: Err(error), took: Duration::ZERO }
    }
}

impl Drop for Worker {
    /// Waits until the thread has come to the end of its current phase: the
    /// process must not end under a native library at work.
    fn drop(&mut self) {
        self.cancel();
        self.orders = None;
        if let Some(thread) = self.thread.take() {
            // It catches panics; nothing is to be learned from its end.
            let _ = thread.join();
        }
    }
}

fn serve(
    builder: &dyn NetworkBuilder,
    pool: &rayon::ThreadPool,
    inbox: &Receiver<Message>,
    outbox: &Sender<Answer>,
) {
    for Message { ticket, order, cancelled } in inbox {
        let start = Instant::now();
        let built = guarded(|| pool.install(|| builder.build(order, &cancelled)));
        if cancelled.load(Ordering::Relaxed) {
            // Dropped here, it does not wait in the channel.
            continue;
        }
        let flow = built.and_then(complete);
        if outbox.send(Answer { ticket, flow, took: start.elapsed() }).is_err() {
            return;
        }
    }
}

/// Builds a network, and turns a panic of the builder's into an error: what it
/// worked on is gone with it.
pub(super) fn guarded(work: impl FnOnce() -> Result<Option<Flow>>) -> Result<Option<Flow>> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let what = said(&*panic).to_owned();
        Err(CouplingError::WorkerPanicked { what }.into())
    })
}

/// The network of a builder that nobody has told to stop.
pub(super) fn complete(built: Option<Flow>) -> Result<Flow> {
    built.ok_or_else(|| CouplingError::NoNetwork.into())
}

/// The words of a panic.
fn said(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}
