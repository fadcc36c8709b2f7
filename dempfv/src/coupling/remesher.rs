//! The networks of a simulation: the one in use, and the one that comes next.
//!
//! At once: a network is built when it is due. Ahead and in the background
//! (Algorithm 1 of Caulk 2020): positions are taken when half the interval, or
//! half the strain, has gone by, and their network comes into use when the
//! whole has. Where the strain passes its limit before any positions were
//! taken, or while the new network exceeds it already, one is built of the
//! positions of the moment: no pore ever strains by more than the limit.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::active_network::{ActiveNetwork, PRESSURE_ERROR};
use super::background::{Answer, Ticket};
use super::counts::{IntervalTrail, RemeshCounts};
use super::edges::{EdgeForces, Films};
use super::error::{CouplingError, Result};
use super::fluid_state::{FluidState, Place, Snapshot};
use super::gpu_use::GpuUse;
use super::network_builder::NetworkBuilder;
use super::network_change::Comparison;
use super::network_source::{NetworkSource, RemeshContext};
use super::new_network::{edges_of, load, volume_change};
use super::options::{Acceleration, OnFailure, RemeshMode, Swap, Update};
use super::phases::{Phase, Phases};
use super::remesh_due::Due;
use super::saturation::RemeshRule;
use super::viscous_bound::FastestMode;
use crate::PerWall;
use crate::pfv::{Extrapolation, Flow, RetiredNetwork, TransferSource, check_tolerance};

/// The network in use and the one that comes next.
pub(super) struct Remesher {
    acceleration: Acceleration,
    /// What a solve may leave ([`Flow::set_tolerance`]); `None`: the flow's own.
    tolerance: Option<f64>,
    source: NetworkSource,
    pub current: Option<ActiveNetwork>,
    /// A network that made room for its successor.
    retired: Option<Retired>,
    /// What somebody still looks at of one that went out of use.
    kept: Option<RetiredNetwork>,
    pending: Option<Pending>,
    /// The next step has its network.
    prepared: bool,
    pub counts: RemeshCounts,
    pub gpu: GpuUse,
    /// Of each network with the one that it replaces.
    pub comparison: Comparison,
}

/// What is left of a network that made room.
struct Retired {
    pressures: TransferSource,
    films: Option<Films>,
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

impl Remesher {
    pub fn new() -> Remesher {
        Remesher {
            acceleration: Acceleration::default(),
            tolerance: None,
            source: NetworkSource::new(),
            current: None,
            retired: None,
            kept: None,
            pending: None,
            prepared: false,
            counts: RemeshCounts::default(),
            gpu: GpuUse::default(),
            comparison: Comparison::default(),
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

    pub fn set_tolerance(&mut self, tolerance: f64) -> Result<()> {
        check_tolerance(tolerance)?;
        if let Some(network) = &mut self.current {
            network.flow.set_tolerance(tolerance)?;
        }
        self.tolerance = Some(tolerance);
        Ok(())
    }

    pub fn tolerance(&self) -> Option<f64> {
        self.tolerance
    }

    /// Puts a network into use.
    fn put_to_use(
        &mut self,
        mut flow: Flow,
        edges: Option<EdgeForces>,
        state: FluidState,
    ) -> Result<()> {
        let follows = self.acceleration.update == Update::EveryStep;
        if let Some(tolerance) = self.tolerance.or(follows.then_some(PRESSURE_ERROR)) {
            flow.set_tolerance(tolerance)?;
        }
        self.current = Some(ActiveNetwork::new(flow, edges, state));
        Ok(())
    }

    pub fn acceleration(&self) -> &Acceleration {
        &self.acceleration
    }

    /// Changes who builds networks.
    pub fn build_with(&mut self, builder: Arc<dyn NetworkBuilder>) {
        self.forget_pending();
        self.source.build_with(builder);
    }

    /// Frees every network, and cancels the one that is being built.
    pub fn clear(&mut self) {
        self.forget_pending();
        self.take_current();
        self.retired = None;
        self.source.keep(None);
    }

    /// The fluid has become another, or the spheres are: all that may serve
    /// again is the analysis.
    pub fn outdate(&mut self) {
        self.forget_pending();
        self.retired = None;
        if let Some(network) = self.take_current() {
            self.source.keep(network.flow.retire().1);
        }
    }

    /// Takes the network in use out of it.
    fn take_current(&mut self) -> Option<ActiveNetwork> {
        let mut network = self.current.take()?;
        if network.kept {
            self.kept = Some(network.flow.set_aside());
        }
        Some(network)
    }

    /// What was kept of a network that has gone out of use.
    pub fn take_kept(&mut self) -> Option<RetiredNetwork> {
        self.kept.take()
    }

    fn forget_pending(&mut self) {
        self.prepared = false;
        self.pending = None;
        self.source.cancel();
    }

    /// True when the next step needs neither a new network nor positions for
    /// one, or has them.
    pub fn is_idle(&mut self, rule: &RemeshRule) -> bool {
        if self.prepared {
            return true;
        }
        let interval = self.interval(rule);
        let Some(network) = &self.current else { return false };
        let due = Due::of(network, rule, interval);
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
    pub fn prepare(&mut self, context: RemeshContext, phases: &mut Phases) -> Result<()> {
        if !self.prepared {
            self.renew(context, phases)?;
            self.prepared = true;
        }
        Ok(())
    }

    /// A step begins: the one after it may need another network.
    pub fn begin_step(&mut self) {
        self.prepared = false;
    }

    /// Takes into use, and orders, what is due.
    fn renew(&mut self, context: RemeshContext, phases: &mut Phases) -> Result<()> {
        // Positions without a network in use are those of a remesh that failed
        // after the old one had made room.
        if self.current.is_none() && !(self.pending.is_some() && self.swap(context, phases)?) {
            self.build_here(context, phases)?;
        }
        if self.acceleration.remesh != RemeshMode::AtOnce {
            return self.prepare_ahead(context, phases);
        }
        let rule = &context.saturation.remesh;
        let interval = self.interval(rule);
        match &self.current {
            Some(network) if Due::of(network, rule, interval).whole => {
                self.look_before_swap(&context, phases)?;
                self.build_here(context, phases)
            }
            _ => Ok(()),
        }
    }

    /// Takes positions when they are due, and their network into use.
    fn prepare_ahead(&mut self, context: RemeshContext, phases: &mut Phases) -> Result<()> {
        let rule = &context.saturation.remesh;
        let mut swapped = false;
        loop {
            let interval = self.interval(rule);
            let Some(network) = &self.current else { return Ok(()) };
            let due = Due::of(network, rule, interval);
            if self.pending.is_none() {
                if !due.half {
                    return Ok(());
                }
                self.pending =
                    Some(Pending::new(Snapshot::of(context.dem, context.step, context.time_step)));
                self.submit(context)?;
            }
            // Once a step at most, however fast the background is.
            let ready = !swapped && self.is_ready_to_swap();
            if !(ready || self.must_swap(&due)) {
                return Ok(());
            }
            self.look_before_swap(&context, phases)?;
            if !self.swap(context, phases)? {
                return Ok(());
            }
            swapped = true;
        }
    }

    /// Hands the pending positions to the background, if there is one.
    fn submit(&mut self, context: RemeshContext) -> Result<()> {
        let Some(mut pending) = self.pending.take() else { return Ok(()) };
        if self.acceleration.remesh == RemeshMode::Background {
            pending.ticket = Some(self.source.submit(&pending.snapshot, context)?);
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
        let Some(pending) = &mut self.pending else { return false };
        if let Some(ticket) = pending.ticket.filter(|_| pending.answer.is_none()) {
            pending.answer = self.source.try_take(ticket);
        }
        pending.answer.is_some()
    }

    /// Takes the network of the pending positions into use. False when it could
    /// not be built and the old one stays.
    fn swap(&mut self, context: RemeshContext, phases: &mut Phases) -> Result<bool> {
        let Some(pending) = self.pending.take() else { return Ok(false) };
        let Pending { snapshot, ticket, answer } = pending;
        let built = match (answer, ticket) {
            (Some(answer), _) => self.source.unpack(answer, &mut self.counts),
            (None, Some(ticket)) => {
                let answer = self.source.wait(ticket, &mut self.counts, phases);
                self.source.unpack(answer, &mut self.counts)
            }
            (None, None) => {
                if self.acceleration.on_failure == OnFailure::Stop {
                    self.make_room();
                }
                self.source.build(&snapshot, context, phases)
            }
        };
        match built {
            Ok(flow) => {
                self.install(flow, snapshot, context, phases)?;
                Ok(true)
            }
            Err(_) if self.acceleration.on_failure == OnFailure::Retry => {
                self.counts.failures += 1;
                if let Some(network) = &mut self.current {
                    network.state.since = 0;
                    network.state.exhausted = false;
                }
                Ok(false)
            }
            Err(error) => {
                let step = snapshot.step;
                // For a checkpoint: a restart tries the same again.
                self.pending = Some(Pending::new(snapshot));
                let error = error.with_numbers(&context.dem.storage().id);
                Err(match step == context.step {
                    true => error,
                    false => CouplingError::Snapshot { step, source: Box::new(error) },
                })
            }
        }
    }

    /// Frees the network in use but for what its successor needs.
    fn make_room(&mut self) {
        if let Some(network) = self.take_current() {
            let mut state = network.saved();
            if state.since > 0 {
                state.wall_force_before = Some(*network.flow.wall_force());
            }
            let films = network.edges.map(EdgeForces::retire);
            let (pressures, reusable) = network.flow.retire();
            self.retired = Some(Retired { pressures, films, state });
            self.source.keep(reusable);
        }
    }

    /// Builds the network of the moment in the place of the one in use.
    fn build_here(&mut self, context: RemeshContext, phases: &mut Phases) -> Result<()> {
        self.make_room();
        let snapshot = Snapshot::of(context.dem, context.step, context.time_step);
        let flow = self
            .source
            .build(&snapshot, context, phases)
            .map_err(|e| e.with_numbers(&context.dem.storage().id))?;
        self.install(flow, snapshot, context, phases)
    }

    /// Takes a network into use: it goes on from the pressures of the old one,
    /// which is freed.
    fn install(
        &mut self,
        mut flow: Flow,
        snapshot: Snapshot,
        context: RemeshContext,
        phases: &mut Phases,
    ) -> Result<()> {
        let start = Instant::now();
        self.count(&flow);
        let beside = self.current.as_ref().map(|network| network.flow.has_pattern_of(&flow));
        self.make_room();
        // Two networks at once take enough memory. Only where the one after
        // next may be expected to have the old pattern too is a factor kept.
        if beside == Some(false) {
            self.source.keep(None);
        }
        context.conditions().impose(&mut flow)?;
        load(&mut flow, &context)?;
        let mut fastest = FastestMode::default();
        let mut edges = edges_of(&flow, &snapshot, &context)?;
        let (mut grown_to, mut wall_force_before) = (None, None);
        if let Some(Retired { pressures, films, state }) = self.retired.take() {
            (grown_to, wall_force_before) = (state.grown_to, state.wall_force_before);
            fastest = state.fastest.outdated();
            flow.transfer_pressures(&pressures);
            if let (Some(edges), Some(films)) = (&mut edges, &films) {
                edges.take_over(films);
            }
            self.counts.replaced(context.step.saturating_sub(state.snapshot.step));
        }
        // What the last motion has done to the pores is for this network to take up.
        let grown_to = flow.time_step().map(|_| grown_to.unwrap_or_else(|| Place::of(context.dem)));
        if let Some(place) = &grown_to {
            flow.set_grown_to(place.view())?;
        }
        let volume_change = match context.saturation.remesh.strain {
            None => vec![],
            Some(_) if snapshot.step == context.step => vec![0.0; flow.network().pores()],
            Some(_) => volume_change(&flow, &context)?,
        };
        let state = FluidState {
            snapshot,
            followed: None,
            grown_to,
            since: 0,
            volume_change,
            volume_rate: vec![],
            taken: vec![],
            time_step: None,
            resistance: PerWall::default(),
            persistence: PerWall::default(),
            wall_force_before,
            exhausted: false,
            extrapolation: Extrapolation::default(),
            solved_by: None,
            pending: None,
            edges: None,
            fastest,
        };
        if let Some(edges) = &mut edges {
            edges.join(flow.force());
        }
        self.put_to_use(flow, edges, state)?;
        self.source.auto_interval.swapped();
        phases.add(Phase::Swap, start.elapsed());
        Ok(())
    }

    fn count(&mut self, flow: &Flow) {
        self.counts.networks += 1;
        self.counts.remarks = self.counts.remarks.or_more(flow.remarks());
        self.counts.analyses += u64::from(!flow.analysis_reused() && flow.nnz_l() > 0);
        self.gpu.book(flow.placement());
    }

    /// The interval in force.
    fn interval(&self, rule: &RemeshRule) -> Option<u64> {
        if self.acceleration.auto_interval {
            self.source.auto_interval.interval()
        } else {
            rule.interval
        }
    }

    /// The interval in force, and what it follows from.
    pub fn trail(&self, rule: &RemeshRule) -> IntervalTrail {
        let interval = self.interval(rule);
        if !self.acceleration.auto_interval {
            return IntervalTrail { interval, ..IntervalTrail::default() };
        }
        let background_s = self.source.auto_interval.background_s();
        let steps_per_s = self.source.auto_interval.steps_per_s().unwrap_or(0.0);
        IntervalTrail { interval, background_s, steps_per_s }
    }

    /// Books the time of a step without its remesh.
    pub fn stepped(&mut self, took: Duration) {
        self.source.auto_interval.stepped(took);
    }

    /// What a checkpoint needs.
    pub fn state(&self) -> Option<FluidState> {
        let kept = self.retired.as_ref().map(|retired| retired.state.clone());
        let state = self.current.as_ref().map(ActiveNetwork::saved).or(kept)?;
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
        context: RemeshContext,
        phases: &mut Phases,
    ) -> Result<()> {
        self.clear();
        let pending = state.pending.take();
        let flow = self
            .source
            .build(&state.snapshot, context, phases)
            .map_err(|e| e.with_numbers(&context.dem.storage().id))?;
        self.counts.analyses += u64::from(flow.nnz_l() > 0);
        self.gpu.book(flow.placement());
        if context.saturation.remesh.strain.is_some() && state.volume_change.is_empty() {
            state.volume_change = volume_change(&flow, &context)?;
        }
        if self.acceleration.update != Update::EveryStep {
            // From here on the matrix must be the one that was factored.
            state.followed = None;
        }
        // A fluid that has been made to store.
        let stores = flow.time_step().is_some();
        state.grown_to = state.grown_to.or_else(|| stores.then(|| Place::of(context.dem)));
        let edges = edges_of(&flow, &state.snapshot, &context)?;
        self.put_to_use(flow, edges, state)?;
        if let Some(network) = &mut self.current {
            context.conditions().impose(&mut network.flow)?;
            load(&mut network.flow, &context)?;
            network.resume()?;
        }
        if self.acceleration.remesh != RemeshMode::AtOnce {
            self.pending = pending.map(Pending::new);
            self.submit(context)?;
        }
        Ok(())
    }
}

impl Pending {
    fn new(snapshot: Snapshot) -> Pending {
        Pending { snapshot, ticket: None, answer: None }
    }
}
