//! What the pores store: the part of their balance that goes with the change of their pressures.
//!
//! A pore of capacity S (m³/Pa) takes up S (p − p') / Δt in a step of length Δt that it begins at the
//! pressure p': S/Δt on the diagonal of `G`, S p'/Δt on the right-hand side.

use super::pore_growth::Grown;
use super::{NONE, Network, PoreConditions, SealedPores};
use crate::parallel::{for_each, max_norm, parts};

/// Time steps within this of each other are the same but for round-off.
const SAME_STEP: f64 = 1e-12;

/// What terms need that store fluid.
#[derive(Clone, Debug)]
pub(super) struct Storage {
    /// Of each pore (m³/Pa).
    capacity: Vec<f64>,
    /// The same over the time step (m³/(Pa·s)).
    rate: Vec<f64>,
    /// Volume of fluid in each pore (m³).
    pub void: Vec<f64>,
    /// Time step (s).
    time_step: f64,
    /// Pressure of each pore when the step began (Pa): at which it holds what it does by its capacity
    /// of now.
    previous: Vec<f64>,
    /// The capacities before the last change (m³/Pa); empty where none has come since a step began.
    before: Vec<f64>,
    /// The sum of the rates (m³/(Pa·s)).
    whole_rate: f64,
    /// Unknowns of pores without a path to an imposed pressure, group by group.
    pub closed: Vec<Vec<u32>>,
    /// The volumes of the pores as far as their growth is taken.
    pub grown: Grown,
}

impl Storage {
    /// Pores with these void volumes (m³) and capacities (m³/Pa), in steps of this length (s).
    pub fn new(void: Vec<f64>, capacity: Vec<f64>, time_step: f64) -> Storage {
        let zeros = vec![0.0; capacity.len()];
        let mut storage = Storage {
            rate: zeros.clone(),
            previous: zeros,
            before: vec![],
            capacity,
            void,
            time_step,
            whole_rate: 0.0,
            closed: vec![],
            grown: Grown::default(),
        };
        storage.set_time_step(time_step);
        storage
    }

    /// Takes the groups that need not be pinned, because their pores store fluid.
    pub fn claim(&mut self, sealed: &mut SealedPores) -> Vec<Vec<u32>> {
        let stores = |group: &Vec<u32>| group.iter().any(|&i| self.capacity[i as usize] > 0.0);
        let (closed, sealed_for_good) =
            std::mem::take(&mut sealed.groups).into_iter().partition(stores);
        sealed.groups = sealed_for_good;
        closed
    }

    /// Numbers the claimed groups by unknowns.
    pub fn close(&mut self, groups: Vec<Vec<u32>>, unknown_of: &[u32]) {
        let unknowns = |group: Vec<u32>| {
            group.into_iter().map(|i| unknown_of[i as usize]).filter(|&u| u != NONE).collect()
        };
        self.closed = groups.into_iter().map(unknowns).collect();
    }

    pub fn time_step(&self) -> f64 {
        self.time_step
    }

    /// Whether a time step (s) is the present one.
    pub fn is_step(&self, time_step: f64) -> bool {
        (time_step - self.time_step).abs() <= SAME_STEP * self.time_step
    }

    pub fn set_time_step(&mut self, time_step: f64) {
        self.time_step = time_step;
        for (rate, capacity) in self.rate.iter_mut().zip(&self.capacity) {
            *rate = capacity / time_step;
        }
        self.whole_rate = self.rate.iter().sum();
    }

    /// What the pores would take up if they were filled in one step, at most (m³/s): the round-off of
    /// pressures makes so much of what they take up round-off.
    pub fn refill(&self, pressure: &[f64]) -> f64 {
        self.whole_rate * max_norm(pressure)
    }

    /// Evaluates the capacities anew, from the void volumes.
    pub fn update(&mut self, write: impl FnOnce(&[f64], &mut [f64])) {
        self.before.clone_from(&self.capacity);
        self.capacity.fill(0.0);
        write(&self.void, &mut self.capacity);
        self.set_time_step(self.time_step);
    }

    /// A step begins at these pressures (Pa). What a pore stores above the level (Pa) stays in it where
    /// its capacity has changed: its pressure goes the other way.
    pub fn begin(&mut self, pressure: &[f64], level: f64) {
        self.previous.copy_from_slice(pressure);
        let capacities = self.before.iter().zip(&self.capacity);
        for (previous, (before, now)) in self.previous.iter_mut().zip(capacities) {
            if *now > 0.0 {
                *previous = level + (*previous - level) * (before / now);
            }
        }
        self.before.clear();
    }

    /// What a pore takes up at this pressure (m³/s).
    #[inline(always)]
    pub fn uptake(&self, pore: usize, pressure: f64) -> f64 {
        self.rate[pore] * (pressure - self.previous[pore])
    }

    /// What a pore takes up per unit of its pressure (m³/(Pa·s)).
    #[inline(always)]
    pub fn rate(&self, pore: usize) -> f64 {
        self.rate[pore]
    }

    /// Adds what all pores take up at these pressures (m³/s).
    pub fn add_uptake(&self, pressure: &[f64], uptake: &mut [f64]) {
        for_each(uptake, &|i, sum| *sum += self.uptake(i, pressure[i]));
    }

    /// What all pores store at these pressures (m³).
    pub fn content(&self, pressure: &[f64]) -> f64 {
        // Of chunks, so that the sum has the same bits for any number of threads.
        let products: Vec<f64> = self.capacity.iter().zip(pressure).map(|(s, p)| s * p).collect();
        parts(&products, |part| part.iter().sum(), 0.0, |a: f64, b| a + b)
    }

    /// What all pores store per unit of pressure (m³/Pa).
    pub fn whole_capacity(&self) -> f64 {
        parts(&self.capacity, |part| part.iter().sum(), 0.0, |a: f64, b| a + b)
    }

    /// What the unknowns among the pores store per unit of pressure (m³/Pa).
    pub fn free_capacity(&self, pore_of: &[u32]) -> f64 {
        pore_of.iter().map(|&i| self.capacity[i as usize]).sum()
    }
}

/// Groups that stay sealed and those that storage has claimed, of a network under these
/// conditions.
pub(super) fn sealed_and_closed(
    network: &Network,
    conditions: &PoreConditions,
    storage: Option<&mut Storage>,
) -> (SealedPores, Vec<Vec<u32>>) {
    let mut sealed = SealedPores::of(network, conditions);
    let closed = storage.map_or_else(Vec::new, |storage| storage.claim(&mut sealed));
    (sealed, closed)
}
