//! Where networks come from: a builder, called at once or in the background,
//! with what of an earlier network may serve again.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use super::auto_interval::AutoInterval;
use super::background::{Answer, Ticket, Worker, complete, guarded};
use super::counts::RemeshCounts;
use super::error::Result;
use super::fluid_effects::FluidEffects;
use super::fluid_state::Snapshot;
use super::given_pressures::{Conditions, GivenPressures};
use super::network_builder::{NetworkBuilder, NetworkRequest, StandardBuilder};
use super::phases::{Phase, Phases};
use super::saturation::Saturation;
use crate::dem::Dem;
use crate::pfv::{Flow, ReusableAnalysis};

/// What networks are built for, in a step.
#[derive(Clone, Copy)]
pub(super) struct RemeshContext<'a> {
    pub dem: &'a Dem,
    pub saturation: &'a Saturation,
    pub effects: &'a FluidEffects,
    pub given: &'a GivenPressures,
    /// Steps done.
    pub step: u64,
    /// Length of the step to come, as far as it is known (s).
    pub time_step: f64,
    /// Model time (s).
    pub time: f64,
}

impl RemeshContext<'_> {
    /// What is imposed on the flow of the moment.
    pub fn conditions(&self) -> Conditions<'_> {
        Conditions { effects: self.effects, given: self.given, time: self.time }
    }
}

/// Builds networks, here or in the background.
pub(super) struct NetworkSource {
    builder: Arc<dyn NetworkBuilder>,
    worker: Option<Worker>,
    /// The analysis of a network that made room.
    reusable: Option<ReusableAnalysis>,
    /// Learns how long networks take.
    pub auto_interval: AutoInterval,
}

impl NetworkSource {
    pub fn new() -> NetworkSource {
        NetworkSource {
            builder: Arc::new(StandardBuilder),
            worker: None,
            reusable: None,
            auto_interval: AutoInterval::default(),
        }
    }

    /// Changes who builds networks.
    pub fn build_with(&mut self, builder: Arc<dyn NetworkBuilder>) {
        self.worker = None;
        self.builder = builder;
    }

    /// Keeps what may serve the next network, or frees it.
    pub fn keep(&mut self, reusable: Option<ReusableAnalysis>) {
        self.reusable = reusable;
    }

    fn request(&mut self, snapshot: &Snapshot, context: RemeshContext) -> NetworkRequest {
        NetworkRequest {
            position: snapshot.position.clone(),
            radius: context.dem.storage().radius.clone(),
            bounds: snapshot.bounds,
            cell: snapshot.cell,
            fluid: context.saturation.fluid,
            effects: context.effects.clone(),
            time_step: snapshot.time_step,
            solver: context.saturation.solver,
            reusable: self.reusable.take(),
        }
    }

    /// Builds a network while the time loop waits.
    pub fn build(
        &mut self,
        snapshot: &Snapshot,
        context: RemeshContext,
        phases: &mut Phases,
    ) -> Result<Flow> {
        let request = self.request(snapshot, context);
        let never = AtomicBool::new(false);
        let flow = guarded(|| self.builder.build(request, &never)).and_then(complete)?;
        let times = flow.build_times();
        self.auto_interval.built(times.total());
        phases.book_build(times);
        Ok(flow)
    }

    /// Asks the background for a network.
    pub fn submit(&mut self, snapshot: &Snapshot, context: RemeshContext) -> Result<Ticket> {
        let request = self.request(snapshot, context);
        let worker = match &mut self.worker {
            Some(worker) => worker,
            none => none.insert(Worker::start(Arc::clone(&self.builder))?),
        };
        Ok(worker.submit(request))
    }

    /// Drops what the background was asked for.
    pub fn cancel(&mut self) {
        if let Some(worker) = &mut self.worker {
            worker.cancel();
        }
    }

    /// The background's answer, if it is there.
    pub fn try_take(&mut self, ticket: Ticket) -> Option<Answer> {
        self.worker.as_mut()?.try_take(ticket)
    }

    /// Waits for the background, and counts if it was not ready.
    pub fn wait(
        &mut self,
        ticket: Ticket,
        counts: &mut RemeshCounts,
        phases: &mut Phases,
    ) -> Answer {
        let Some(worker) = &mut self.worker else { return Answer::lost(ticket) };
        if let Some(answer) = worker.try_take(ticket) {
            return answer;
        }
        let start = Instant::now();
        let answer = worker.take(ticket);
        let waited = start.elapsed();
        phases.add(Phase::Wait, waited);
        counts.waits += 1;
        counts.waited += waited;
        answer
    }

    /// Books what the background did.
    pub fn unpack(&mut self, answer: Answer, counts: &mut RemeshCounts) -> Result<Flow> {
        self.auto_interval.built(answer.took);
        let flow = answer.flow?;
        counts.background += flow.build_times();
        Ok(flow)
    }
}
