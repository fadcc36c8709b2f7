//! Networks built beside the time loop: one thread that takes requests and gives
//! back whole networks.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, Sender, TryRecvError, unbounded};

use super::error::{CouplingError, Result};
use super::network_builder::{NetworkBuilder, NetworkRequest};
use crate::pfv::Flow;
use crate::{Effect, EffectKey, Family};

/// What this effect says of itself.
pub const EFFECT: Effect = Effect {
    name: "background remesh",
    family: Family::Numerics,
    equation: "the next network is built and factored from a snapshot while the steps go on",
    source: "R. Caulk et al.: Comput. Phys. Commun. 248 (2020), section 3",
    keys: &[EffectKey { key: "remesh in [fluid]", unit: "", default: "\"at once\"" }],
    needs: "pore flow",
    test: "dempfv/tests/coupling_background.rs",
};

/// Names a request.
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
    request: NetworkRequest,
    cancelled: Arc<AtomicBool>,
}

/// The thread and its two channels. Neither ever blocks a sender, so whoever
/// waits for an answer or for the thread's end waits for one network at most.
///
/// The thread has a pool of its own: what it shares out takes no thread of the
/// time loop's, and the time loop may wait for it from within its own pool.
pub(super) struct Worker {
    /// `None` once the thread is to end.
    requests: Option<Sender<Message>>,
    answers: Receiver<Answer>,
    thread: Option<JoinHandle<()>>,
    /// Of the last request.
    cancelled: Arc<AtomicBool>,
    last: u64,
}

/// Stack of the worker's threads (bytes): that of a main thread, on which the
/// same libraries run in the foreground.
const WORKER_STACK_BYTES: usize = 8 << 20;

impl Worker {
    /// Starts the thread, with as many helpers as the time loop has threads.
    pub fn start(builder: Arc<dyn NetworkBuilder>) -> Result<Worker> {
        let not_started =
            |e: &dyn std::fmt::Display| CouplingError::WorkerNotStarted { what: e.to_string() };
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(rayon::current_num_threads())
            .stack_size(WORKER_STACK_BYTES)
            .thread_name(|k| format!("remesh-{k}"))
            .build()
            .map_err(|e| not_started(&e))?;
        let (requests, inbox) = unbounded();
        let (outbox, answers) = unbounded();
        let thread = thread::Builder::new()
            .name("remesh".to_owned())
            .spawn(move || serve(&*builder, &pool, &inbox, &outbox))
            .map_err(|e| not_started(&e))?;
        Ok(Worker {
            requests: Some(requests),
            answers,
            thread: Some(thread),
            cancelled: Arc::default(),
            last: 0,
        })
    }

    /// Asks for a network. One that was asked for before is cancelled.
    pub fn submit(&mut self, request: NetworkRequest) -> Ticket {
        self.cancel();
        self.cancelled = Arc::default();
        self.last += 1;
        let ticket = Ticket(self.last);
        let message = Message { ticket, request, cancelled: Arc::clone(&self.cancelled) };
        if let Some(requests) = &self.requests {
            // A thread that is gone is noticed when its answer is waited for.
            let _ = requests.send(message);
        }
        ticket
    }

    /// Drops what was asked for last, finished or not.
    pub fn cancel(&mut self) {
        self.cancelled.store(true, Ordering::Relaxed);
        while self.answers.try_recv().is_ok() {}
    }

    /// The answer to a request if it is there.
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

    /// Waits for the answer to the last request.
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
        let error = CouplingError::WorkerPanicked { what };
        Answer { ticket, flow: Err(error), took: Duration::ZERO }
    }
}

impl Drop for Worker {
    /// Waits until the thread has come to the end of its current phase: the
    /// process must not end under a native library at work.
    fn drop(&mut self) {
        self.cancel();
        self.requests = None;
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
    for Message { ticket, request, cancelled } in inbox {
        let start = Instant::now();
        let built = guarded(|| pool.install(|| builder.build(request, &cancelled)));
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
        Err(CouplingError::WorkerPanicked { what })
    })
}

/// The network of a builder that nobody has told to stop.
pub(super) fn complete(built: Option<Flow>) -> Result<Flow> {
    built.ok_or(CouplingError::NoNetwork)
}

/// The words of a panic.
fn said(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}
