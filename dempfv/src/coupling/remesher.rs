//! The networks of a simulation: the one in use, and the one that comes next.
//!
//! At once: a network is built when it is due. Ahead and in the background
//! (Algorithm 1 of Caulk 2020): positions are taken when half the interval, or
//! half the strain, has gone by, and their network comes into use when the
//! whole has. Where the strain passes its limit before any positions were
//! taken, or while the new network exceeds it already, one is built of the
//! positions of the moment: no pore ever strains by more than the limit.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use super::active_network::ActiveNetwork;
use super::auto_interval::AutoInterval;
use super::background::{
    Answer, NetworkBuilder, Order, StandardBuilder, Ticket, Worker, complete, guarded,
};
use super::coupled::Saturation;
use super::gpu_use::GpuUse;
use super::options::{Acceleration, OnFailure, RemeshMode, Swap};
use super::phases::{Phase, Phases};
use super::remesh::{FluidState, IntervalTrail, RemeshCounts, RemeshRule, Snapshot};
use super::viscous_bound::FastestMode;
use crate::dem::{Dem, Particles};
use crate::pfv::{Extrapolation, Flow, Spare, TransferSource};
use crate::{Error, Result};

/// The network in use and the one that comes next.
pub(super) struct Remesher {
    acceleration: Acceleration,
    /// What a solve may leave ([`Flow::set_tolerance`]); `None`: the flow's own.
    tolerance: Option<f64>,
    builder: Arc<dyn NetworkBuilder>,
    pub current: Option<ActiveNetwork>,
    /// Of a network that made room for its successor.
    legacy: Option<Legacy>,
    spare: Option<Spare>,
    pending: Option<Pending>,
    worker: Option<Worker>,
    auto: AutoInterval,
    /// The next step has its network.
    prepared: bool,
    pub counts: RemeshCounts,
    pub gpu: GpuUse,
}

/// What is left of a network that made room.
struct Legacy {
    pressures: TransferSource,
    state: FluidState,
}

/// Positions whose network comes next.
struct Pending {
    snapshot: Snapshot,
    /// Where the background works at it.
    ticket: Option<Ticket>,
    /// Its answer, once it was found to be there.
    answer: Option<Answer>,
}

/// What networks are built for, in a step.
#[derive(Clone, Copy)]
pub(super) struct Site<'a> {
    pub dem: &'a Dem,
    pub saturation: &'a Saturation,
    /// Steps done.
    pub step: u64,
}

/// What is due at a network's age.
struct Due {
    /// Half of the interval or of the strain has gone by.
    half: bool,
    /// The whole of one has.
    whole: bool,
    /// The whole of the strain has.
    strained: bool,
}

impl Due {
    fn of(wet: &ActiveNetwork, rule: &RemeshRule, interval: Option<u64>) -> Due {
        let since = wet.state.since;
        // An interval of no steps would be one of every step.
        let old = |halves: u64| interval.is_some_and(|n| since >= n.max(1) * halves / 2);
        let strain = wet.strain(rule);
        let strained = strain > 1.0 || wet.state.worn;
        Due { half: old(1) || strain > 0.5 || strained, whole: old(2) || strained, strained }
    }
}

impl Remesher {
    pub fn new() -> Remesher {
        Remesher {
            acceleration: Acceleration::default(),
            tolerance: None,
            builder: Arc::new(StandardBuilder),
            current: None,
            legacy: None,
            spare: None,
            pending: None,
            worker: None,
            auto: AutoInterval::default(),
            prepared: false,
            counts: RemeshCounts::default(),
            gpu: GpuUse::default(),
        }
    }

    /// Changes how networks are renewed. The one in use stays.
    pub fn accelerate(&mut self, acceleration: Acceleration) {
        if acceleration.update != self.acceleration.update {
            self.outdate();
        } else if acceleration != self.acceleration {
            self.forget_pending();
        }
        self.acceleration = acceleration;
    }

    pub fn set_tolerance(&mut self, tolerance: f64) {
        self.tolerance = Some(tolerance);
        if let Some(wet) = &mut self.current {
            wet.flow.set_tolerance(tolerance);
        }
    }

    /// Puts a network into use.
    fn put_to_use(&mut self, mut flow: Flow, state: FluidState) {
        if let Some(tolerance) = self.tolerance {
            flow.set_tolerance(tolerance);
        }
        self.current = Some(ActiveNetwork::new(flow, state));
    }

    pub fn acceleration(&self) -> &Acceleration {
        &self.acceleration
    }

    /// Changes who builds networks.
    pub fn build_with(&mut self, builder: Arc<dyn NetworkBuilder>) {
        self.forget_pending();
        self.worker = None;
        self.builder = builder;
    }

    /// Frees every network, and cancels the one that is being built.
    pub fn clear(&mut self) {
        self.forget_pending();
        self.current = None;
        self.legacy = None;
        self.spare = None;
    }

    /// The fluid has become another: all that may serve again is the analysis.
    pub fn outdate(&mut self) {
        self.forget_pending();
        self.legacy = None;
        if let Some(wet) = self.current.take() {
            self.spare = wet.flow.retire().1;
        }
    }

    fn forget_pending(&mut self) {
        self.prepared = false;
        self.pending = None;
        if let Some(worker) = &mut self.worker {
            worker.cancel();
        }
    }

    /// True when the next step needs neither a new network nor positions for
    /// one, or has them.
    pub fn is_idle(&mut self, rule: &RemeshRule) -> bool {
        if self.prepared {
            return true;
        }
        let interval = self.interval(rule);
        let Some(wet) = &self.current else { return false };
        let due = Due::of(wet, rule, interval);
        match (self.acceleration.remesh, &self.pending) {
            (RemeshMode::AtOnce, _) => !due.whole,
            (_, None) => !due.half,
            (_, Some(_)) => !self.must_swap(&due) && !self.is_ready_to_swap(),
        }
    }

    /// Sees to it that the next step has its network. Until that step begins,
    /// a second call does nothing: what follows from the network, such as a
    /// time step, holds for the step, however fast the background is.
    ///
    /// # Errors
    /// Why there is none.
    pub fn prepare(&mut self, site: Site, phases: &mut Phases) -> Result<()> {
        if !self.prepared {
            self.renew(site, phases)?;
            self.prepared = true;
        }
        Ok(())
    }

    /// A step begins: the one after it may need another network.
    pub fn begin_step(&mut self) {
        self.prepared = false;
    }

    /// Takes into use, and orders, what is due.
    fn renew(&mut self, site: Site, phases: &mut Phases) -> Result<()> {
        // Positions without a network in use are those of a remesh that failed
        // after the old one had made room.
        if self.current.is_none() && !(self.pending.is_some() && self.swap(site, phases)?) {
            self.build_here(site, phases)?;
        }
        if self.acceleration.remesh != RemeshMode::AtOnce {
            return self.prepare_ahead(site, phases);
        }
        let rule = &site.saturation.remesh;
        let interval = self.interval(rule);
        match &self.current {
            Some(wet) if Due::of(wet, rule, interval).whole => self.build_here(site, phases),
            _ => Ok(()),
        }
    }

    /// Takes positions when they are due, and their network into use.
    fn prepare_ahead(&mut self, site: Site, phases: &mut Phases) -> Result<()> {
        let rule = &site.saturation.remesh;
        let mut swapped = false;
        loop {
            let interval = self.interval(rule);
            let Some(wet) = &self.current else { return Ok(()) };
            let due = Due::of(wet, rule, interval);
            if self.pending.is_none() {
                if !due.half {
                    return Ok(());
                }
                self.pending = Some(Pending::new(Snapshot::of(site.dem, site.step)));
                self.submit(site)?;
            }
            // Once a step at most, however fast the background is.
            let ready = !swapped && self.is_ready_to_swap();
            if !(ready || self.must_swap(&due)) || !self.swap(site, phases)? {
                return Ok(());
            }
            swapped = true;
        }
    }

    /// Hands the pending positions to the background, if there is one.
    fn submit(&mut self, site: Site) -> Result<()> {
        let Some(mut pending) = self.pending.take() else { return Ok(()) };
        if self.acceleration.remesh == RemeshMode::Background {
            let order = self.order(&pending.snapshot, site);
            let worker = match &mut self.worker {
                Some(worker) => worker,
                none => none.insert(Worker::start(Arc::clone(&self.builder))?),
            };
            pending.ticket = Some(worker.submit(order));
        }
        self.pending = Some(pending);
        Ok(())
    }

    /// True when the network in use must not serve another step.
    fn must_swap(&self, due: &Due) -> bool {
        due.strained || due.whole && self.acceleration.swap == Swap::WhenDue
    }

    /// True when the background has answered and that is all it takes.
    fn is_ready_to_swap(&mut self) -> bool {
        if self.acceleration.swap == Swap::WhenDue {
            return false;
        }
        let (Some(pending), Some(worker)) = (&mut self.pending, &mut self.worker) else {
            return false;
        };
        if let Some(ticket) = pending.ticket.filter(|_| pending.answer.is_none()) {
            pending.answer = worker.try_take(ticket);
        }
        pending.answer.is_some()
    }

    /// Takes the network of the pending positions into use. False when it could
    /// not be built and the old one stays.
    fn swap(&mut self, site: Site, phases: &mut Phases) -> Result<bool> {
        let Some(pending) = self.pending.take() else { return Ok(false) };
        let Pending { snapshot, ticket, answer } = pending;
        let built = match (answer, ticket, &mut self.worker) {
            (Some(answer), ..) => self.unpack(answer),
            (None, Some(ticket), Some(_)) => {
                let answer = self.wait(ticket, phases);
                self.unpack(answer)
            }
            _ => {
                if self.acceleration.on_failure == OnFailure::Stop {
                    self.make_room(site.step);
                }
                self.build(&snapshot, site, phases)
            }
        };
        match built {
            Ok(flow) => {
                self.install(flow, snapshot, site, phases);
                Ok(true)
            }
            Err(_) if self.acceleration.on_failure == OnFailure::Retry => {
                self.counts.failures += 1;
                if let Some(wet) = &mut self.current {
                    wet.state.since = 0;
                    wet.state.worn = false;
                }
                Ok(false)
            }
            Err(error) => {
                let step = snapshot.step;
                // For a checkpoint: a restart tries the same again.
                self.pending = Some(Pending::new(snapshot));
                let source = Box::new(with_users_numbers(error, site.dem.storage()));
                Err(if step == site.step { *source } else { Error::Snapshot { step, source } })
            }
        }
    }

    /// Waits for the background, and counts if it was not ready.
    fn wait(&mut self, ticket: Ticket, phases: &mut Phases) -> Answer {
        let Some(worker) = &mut self.worker else { return Answer::lost(ticket) };
        if let Some(answer) = worker.try_take(ticket) {
            return answer;
        }
        let start = Instant::now();
        let answer = worker.take(ticket);
        let waited = start.elapsed();
        phases.add(Phase::Wait, waited);
        self.counts.waits += 1;
        self.counts.waited += waited;
        answer
    }

    /// Books what the background did.
    fn unpack(&mut self, answer: Answer) -> Result<Flow> {
        self.auto.built(answer.took);
        let flow = answer.flow?;
        self.counts.background += flow.build_times();
        Ok(flow)
    }

    /// Frees the network in use but for what its successor needs.
    fn make_room(&mut self, step: u64) {
        if let Some(wet) = self.current.take() {
            let state = wet.saved(step);
            let (pressures, spare) = wet.flow.retire();
            self.legacy = Some(Legacy { pressures, state });
            self.spare = spare;
        }
    }

    fn order(&mut self, snapshot: &Snapshot, site: Site) -> Order {
        Order {
            position: snapshot.position.clone(),
            radius: site.dem.storage().radius.clone(),
            bounds: snapshot.bounds,
            fluid: site.saturation.fluid,
            solver: site.saturation.solver,
            spare: self.spare.take(),
        }
    }

    /// Builds a network while the time loop waits.
    fn build(&mut self, snapshot: &Snapshot, site: Site, phases: &mut Phases) -> Result<Flow> {
        let order = self.order(snapshot, site);
        let never = AtomicBool::new(false);
        let flow = guarded(|| self.builder.build(order, &never)).and_then(complete)?;
        let times = flow.build_times();
        self.auto.built(times.total());
        phases.book_build(times);
        Ok(flow)
    }

    /// Builds the network of the moment in the place of the one in use.
    fn build_here(&mut self, site: Site, phases: &mut Phases) -> Result<()> {
        self.make_room(site.step);
        let snapshot = Snapshot::of(site.dem, site.step);
        let flow = self
            .build(&snapshot, site, phases)
            .map_err(|e| with_users_numbers(e, site.dem.storage()))?;
        self.install(flow, snapshot, site, phases);
        Ok(())
    }

    /// Takes a network into use: it goes on from the pressures of the old one,
    /// which is freed.
    fn install(&mut self, mut flow: Flow, snapshot: Snapshot, site: Site, phases: &mut Phases) {
        let start = Instant::now();
        self.count(&flow);
        let beside = self.current.as_ref().map(|wet| wet.flow.has_pattern_of(&flow));
        self.make_room(site.step);
        // Two networks at once take enough memory. Only where the one after
        // next may be expected to have the old pattern too is a factor kept.
        if beside == Some(false) {
            self.spare = None;
        }
        let mut fastest = FastestMode::default();
        if let Some(Legacy { pressures, state }) = self.legacy.take() {
            fastest = state.fastest.outdated();
            flow.carry_over(&pressures);
            self.counts.replaced(site.step - state.snapshot.step);
        }
        let volume_change = match site.saturation.remesh.strain {
            None => vec![],
            Some(_) if snapshot.step == site.step => vec![0.0; flow.network.pores()],
            Some(_) => {
                let now = flow.network.volumes_at(&site.dem.storage().position, &site.dem.box_());
                now.iter().zip(&flow.network.volume).map(|(now, then)| now - then).collect()
            }
        };
        let state = FluidState {
            step: site.step,
            snapshot,
            since: 0,
            volume_change,
            resistance: [None; 6],
            worn: false,
            extrapolation: Extrapolation::default(),
            pending: None,
            fastest,
        };
        self.put_to_use(flow, state);
        self.auto.swapped();
        phases.add(Phase::Swap, start.elapsed());
    }

    fn count(&mut self, flow: &Flow) {
        self.counts.networks += 1;
        self.counts.analyses += u64::from(!flow.analysis_reused() && flow.nnz_l() > 0);
        self.gpu.book(flow.placement());
    }

    /// The interval in force.
    fn interval(&self, rule: &RemeshRule) -> Option<u64> {
        if self.acceleration.auto_interval { self.auto.interval() } else { rule.interval }
    }

    /// The interval in force, and what it follows from.
    pub fn trail(&self, rule: &RemeshRule) -> IntervalTrail {
        let interval = self.interval(rule);
        if !self.acceleration.auto_interval {
            return IntervalTrail { interval, ..IntervalTrail::default() };
        }
        let background_s = self.auto.background_s();
        let steps_per_s = self.auto.steps_per_s().unwrap_or(0.0);
        IntervalTrail { interval, background_s, steps_per_s }
    }

    /// Books the time of a step without its remesh.
    pub fn stepped(&mut self, took: Duration) {
        self.auto.stepped(took);
    }

    /// What a checkpoint needs after so many steps.
    pub fn state(&self, step: u64) -> Option<FluidState> {
        let kept = self.legacy.as_ref().map(|legacy| legacy.state.clone());
        let state = self.current.as_ref().map(|wet| wet.saved(step)).or(kept)?;
        let pending = self.pending.as_ref().map(|pending| pending.snapshot.clone());
        Some(FluidState { pending, ..state })
    }

    /// Builds the network of a checkpoint again, bit for bit, and sets the
    /// background to work on the next one if it was.
    ///
    /// # Errors
    /// As a remesh.
    pub fn restore(
        &mut self,
        mut state: FluidState,
        site: Site,
        phases: &mut Phases,
    ) -> Result<()> {
        self.clear();
        let pending = state.pending.take();
        let mut flow = self
            .build(&state.snapshot, site, phases)
            .map_err(|e| with_users_numbers(e, site.dem.storage()))?;
        self.counts.analyses += u64::from(flow.nnz_l() > 0);
        self.gpu.book(flow.placement());
        flow.resume(&state.extrapolation);
        if site.saturation.remesh.strain.is_some() && state.volume_change.is_empty() {
            state.volume_change = vec![0.0; flow.network.pores()];
        }
        self.put_to_use(flow, state);
        if self.acceleration.remesh != RemeshMode::AtOnce {
            self.pending = pending.map(Pending::new);
            self.submit(site)?;
        }
        Ok(())
    }
}

impl Pending {
    fn new(snapshot: Snapshot) -> Pending {
        Pending { snapshot, ticket: None, answer: None }
    }
}

/// An error of the pore network with the user's numbers of the spheres, which
/// the mechanics keeps in another order.
pub(crate) fn with_users_numbers(error: Error, particles: &Particles) -> Error {
    match error {
        Error::Pfv(error) => Error::Pfv(error.with_numbers(&particles.id)),
        other => other,
    }
}
