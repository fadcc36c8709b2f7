//! Contacts gathered a batch at a time, lane by lane.
//!
//! A batch is filled with contacts and evaluated by loops over its lanes,
//! which compilers turn into vector instructions. Loops are best kept short,
//! so that a processor looks ahead over several of their turns and hides the
//! latency of roots and divisions.

use std::fmt::Debug;
use std::ops::Range;

use super::loss::{Loss, Losses};
use super::vector::Vector;

/// Contacts evaluated at a time: enough to fill vector units and to hide
/// latencies, few enough to stay in the first cache.
pub const CONTACTS_PER_BATCH: usize = 32;

/// Numbers in the widest vector register.
const NUMBERS_PER_REGISTER: usize = 8;

/// One number of each contact of a batch.
pub type Lane = [f64; CONTACTS_PER_BATCH];

/// Lanes of zeros.
pub const ZERO_LANE: Lane = [0.0; CONTACTS_PER_BATCH];

/// The vector of contact `l`.
#[inline(always)]
pub fn get(lanes: &[Lane; 3], l: usize) -> Vector {
    [lanes[0][l], lanes[1][l], lanes[2][l]]
}

/// Sets the vector of contact `l`.
#[inline(always)]
pub fn put(lanes: &mut [Lane; 3], l: usize, v: Vector) {
    lanes[0][l] = v[0];
    lanes[1][l] = v[1];
    lanes[2][l] = v[2];
}

/// What a contact remembers from step to step: an array `[f64; N]`, N ≥ 0, or [`UpTo`].
pub trait History: Copy + Debug + Send + Sync + 'static {
    /// Numbers per contact, or the most of them.
    const LENGTH: usize;
    /// The histories of a batch.
    type Lanes: Debug;
    /// Lanes of zeros: the history of contacts that have just begun.
    fn zeros() -> Self::Lanes;
    /// Reads the history of contact `l` from the numbers of the contact.
    fn load(lanes: &mut Self::Lanes, l: usize, from: &[f64]);
    /// Writes the history of contact `l` to the numbers of the contact.
    fn store(lanes: &Self::Lanes, l: usize, to: &mut [f64]);
    /// The history of contact `l`.
    fn of(lanes: &Self::Lanes, l: usize) -> Self;
    /// The history in the numbers of a contact.
    fn read(from: &[f64]) -> Self;
    /// Writes a history to the numbers of a contact.
    fn write(self, to: &mut [f64]);
}

impl<const N: usize> History for [f64; N] {
    const LENGTH: usize = N;
    type Lanes = [Lane; N];

    #[inline(always)]
    fn zeros() -> [Lane; N] {
        [ZERO_LANE; N]
    }

    #[inline(always)]
    fn load(lanes: &mut [Lane; N], l: usize, from: &[f64]) {
        for (lane, x) in lanes.iter_mut().zip(&from[..N]) {
            lane[l] = *x;
        }
    }

    #[inline(always)]
    fn store(lanes: &[Lane; N], l: usize, to: &mut [f64]) {
        for (lane, x) in lanes.iter().zip(&mut to[..N]) {
            *x = lane[l];
        }
    }

    fn of(lanes: &[Lane; N], l: usize) -> [f64; N] {
        std::array::from_fn(|k| lanes[k][l])
    }

    fn read(from: &[f64]) -> [f64; N] {
        std::array::from_fn(|k| from[k])
    }

    fn write(self, to: &mut [f64]) {
        to.copy_from_slice(&self);
    }
}

/// A history of up to `N` numbers: those that the law's
/// [`history_length`](super::ContactLaw::history_length) does not count are neither stored nor
/// loaded, and zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UpTo<const N: usize>(pub [f64; N]);

impl<const N: usize> History for UpTo<N> {
    const LENGTH: usize = N;
    type Lanes = [Lane; N];

    #[inline(always)]
    fn zeros() -> [Lane; N] {
        [ZERO_LANE; N]
    }

    #[inline(always)]
    fn load(lanes: &mut [Lane; N], l: usize, from: &[f64]) {
        for (lane, x) in lanes.iter_mut().zip(from) {
            lane[l] = *x;
        }
    }

    #[inline(always)]
    fn store(lanes: &[Lane; N], l: usize, to: &mut [f64]) {
        for (lane, x) in lanes.iter().zip(to) {
            *x = lane[l];
        }
    }

    fn of(lanes: &[Lane; N], l: usize) -> UpTo<N> {
        UpTo(std::array::from_fn(|k| lanes[k][l]))
    }

    fn read(from: &[f64]) -> UpTo<N> {
        UpTo(std::array::from_fn(|k| from.get(k).copied().unwrap_or(0.0)))
    }

    fn write(self, to: &mut [f64]) {
        to.iter_mut().zip(self.0).for_each(|(to, x)| *to = x);
    }
}

/// A batch of contacts: where two bodies meet, what the contact remembers,
/// and what the law makes of it.
///
/// Lanes beyond the last contact hold leftovers; computing them does no harm.
#[derive(Debug)]
pub struct Batch<G, H: History> {
    /// Contacts in the batch.
    pub(in crate::dem) count: usize,
    /// Place of each contact in the range that it came from.
    pub(in crate::dem) slot: [u32; CONTACTS_PER_BATCH],
    /// Indices of the two bodies.
    pub(in crate::dem) bodies: [[u32; 2]; CONTACTS_PER_BATCH],
    /// Normals, overlaps, relative motion.
    pub geometry: G,
    /// In: the histories before; out: after.
    pub history: H::Lanes,
    /// Out: force on the second body (N); the first gets the opposite.
    pub force: [Lane; 3],
    /// Out, where asked for: torques on the two bodies (N m).
    pub torque: [[Lane; 3]; 2],
    /// Length of the step whose motion the histories follow (s), or 0 if they
    /// have followed it already: not even round-off may change them then.
    pub dt: f64,
    /// Whether the law shall book what its contacts dissipate: [`Batch::book`].
    pub tracks_energy: bool,
    /// Out: what all batches so far have dissipated (J).
    pub(in crate::dem) losses: Losses,
}

impl<G: Default, H: History> Batch<G, H> {
    pub(in crate::dem) fn new(dt: f64, tracks_energy: bool) -> Batch<G, H> {
        Batch {
            count: 0,
            slot: [0; CONTACTS_PER_BATCH],
            bodies: [[0; 2]; CONTACTS_PER_BATCH],
            geometry: G::default(),
            history: H::zeros(),
            force: [ZERO_LANE; 3],
            torque: [[ZERO_LANE; 3]; 2],
            dt,
            tracks_energy,
            losses: Losses::default(),
        }
    }
}

impl<G, H: History> Batch<G, H> {
    /// Books what each contact has dissipated in this step (J) by a cause. Lanes beyond the last
    /// contact are ignored.
    #[inline(always)]
    pub fn book(&mut self, cause: Loss, energy: &Lane) {
        for &energy in &energy[..self.count.min(CONTACTS_PER_BATCH)] {
            self.losses.add(cause, energy);
        }
    }

    /// The lanes to be computed: whole vector registers, so that those beyond
    /// the last contact are among them.
    #[inline(always)]
    pub fn lanes(&self) -> Range<usize> {
        0..self.count.next_multiple_of(NUMBERS_PER_REGISTER).min(CONTACTS_PER_BATCH)
    }
}
