//! What a contact law declares.

use std::fmt::Debug;

use super::batch::{Batch, History};
use super::geometry::{Geometry, Radii};
use crate::Vec3;
use crate::dem::material::{Material, WallMaterial};

/// What the forces of a law follow from. Each needs the ones before it, too;
/// what is not needed is neither loaded nor computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Needs {
    /// Overlaps alone. Forces are normal, and nothing is remembered.
    Overlap,
    /// Relative velocities and histories.
    Motion,
    /// Spins; the law gives torques. Where rotation is switched off, the law
    /// is evaluated as with [`Needs::Motion`].
    Torques,
}

/// Stiffnesses of a contact (N/m), as the bound of the time step, servo walls
/// and observations take them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stiffness {
    /// Along the normal.
    pub normal: f64,
    /// Across it; 0 where nothing resists slip.
    pub shear: f64,
}

/// The force on the second body of a contact between two steps (N).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactForce {
    /// Along the normal, positive in compression (N).
    pub normal: f64,
    /// Across it (N).
    pub shear: Vec3,
}

/// A contact law: what a contact remembers, what it needs, how stiff it is,
/// what energy it holds, and a kernel that evaluates a batch of contacts.
///
/// A law is written once, for any [`Geometry`], and compiled for contacts of
/// spheres with spheres and with walls; give it to
/// [`Dem::with_law`](crate::dem::Dem::with_law). The law itself holds its own
/// constants only; what depends on the materials is in
/// [`ContactLaw::Parameters`]. [`Linear`](super::Linear) is the first law.
///
/// Batches of one block of particles are evaluated in a fixed order, and
/// contacts in different lanes must not depend on each other: then results
/// do not depend on the number of threads.
pub trait ContactLaw: Clone + Debug + Send + Sync + 'static {
    /// What a contact remembers: `[f64; N]`, zero when it begins. `[f64; 0]`
    /// for a law without memory; [`UpTo`](super::UpTo) where its length depends on the law's
    /// constants.
    type History: History;

    /// The constants of a contact that follow from its two materials.
    type Parameters: Copy + Debug + Send + Sync + 'static;

    /// Lanes for what one loop of the kernel leaves to the next; `()` for a
    /// kernel of one loop. Holds leftovers when a kernel begins.
    type Scratch: Default;

    /// Whether only the most general kernels are compiled: for several materials, with velocities.
    /// For a law of many loops, beside which what that costs is little and the time to compile it
    /// is much.
    const GENERAL_KERNELS: bool = false;

    /// The law's name. A checkpoint keeps it, so that no other law takes up
    /// its histories.
    fn name(&self) -> &'static str;

    /// Numbers of the history that are stored for each contact.
    #[inline(always)]
    fn history_length(&self) -> usize {
        Self::History::LENGTH
    }

    /// Constants of a contact of two spheres.
    fn between_spheres(&self, first: &Material, second: &Material) -> Self::Parameters;

    /// Constants of a contact of a sphere and a wall.
    fn on_wall(&self, sphere: &Material, wall: &WallMaterial) -> Self::Parameters;

    /// What the forces follow from with these constants.
    fn needs(&self, parameters: &Self::Parameters) -> Needs;

    /// Gap between two surfaces up to which they act on each other (m): 0
    /// where they must touch. A pair that is farther apart loses its history.
    fn cut_off(&self) -> f64 {
        0.0
    }

    /// Takes the cut-off that contacts with these constants need, of spheres up to this radius (m):
    /// before a list of neighbours is built. For a law whose reach grows with the spheres.
    fn fit_cut_off<'p>(
        &mut self,
        _parameters: impl Iterator<Item = &'p Self::Parameters>,
        _largest_radius: f64,
    ) {
    }

    /// Whether two bodies within the cut-off act on each other.
    fn acts(&self, _overlap: f64, _history: &Self::History) -> bool {
        true
    }

    /// Whether the stiffness grows with the overlap.
    fn stiffens(&self) -> bool {
        false
    }

    /// The overlap (m) at which the stiffness of a contact is taken that does not exist yet, in
    /// which an energy of approach (J) may be stored; `usual` unless that is more. Only where the
    /// law stiffens.
    fn expected_overlap(
        &self,
        _parameters: &Self::Parameters,
        _radii: impl Radii,
        _energy: f64,
        usual: f64,
    ) -> f64 {
        usual
    }

    /// Stiffnesses at an `overlap` (m), for the bound of the time step. A law
    /// whose damping asks for a shorter step says so by a larger stiffness.
    fn stiffness(
        &self,
        parameters: &Self::Parameters,
        radii: impl Radii,
        overlap: f64,
    ) -> Stiffness;

    /// Coefficient (N s/m) of the dashpot along the normal at an `overlap` (m), for walls that a servo
    /// moves: it resists their shift by as much over the time step.
    fn dashpot(&self, _parameters: &Self::Parameters, _radii: impl Radii, _overlap: f64) -> f64 {
        0.0
    }

    /// The force that an observer sees between two steps, from the overlap (m)
    /// and the history. What velocities add is seen only where the history
    /// keeps it.
    fn force(
        &self,
        parameters: &Self::Parameters,
        radii: impl Radii,
        overlap: f64,
        history: &Self::History,
    ) -> ContactForce;

    /// Elastic energy (J) at an overlap (m).
    fn elastic_energy(
        &self,
        parameters: &Self::Parameters,
        radii: impl Radii,
        overlap: f64,
        history: &Self::History,
    ) -> f64;

    /// Force of the dashpots on the second body (N) that a law keeps, where energy is tracked, to book
    /// what they do in the second half of the step. None for a law without dashpots.
    fn viscous_force(&self, _history: &Self::History) -> Vec3 {
        Vec3::zeros()
    }

    /// Bonds two spheres with this overlap and these radii (m) for good, if they are near enough;
    /// tells whether. Never for a law without bonds.
    fn bond(&self, _overlap: f64, _radii: [f64; 2], _history: &mut [f64]) -> bool {
        false
    }

    /// Whether an intact bond holds a contact.
    fn is_bonded(&self, _history: &Self::History) -> bool {
        false
    }

    /// The history when the two bodies change places: a force on the second
    /// body changes its sign. Needed when spheres are renumbered.
    fn reversed(&self, history: Self::History) -> Self::History;

    /// Evaluates a batch: sets `force`, with `TORQUES` also `torque`, and with
    /// `MOTION` takes `history` through the step of length `batch.dt`, if that
    /// is not 0. Without `MOTION` there are no velocities and no histories.
    ///
    /// Where `batch.tracks_energy` is set, the law also books what it dissipates in the step
    /// ([`Batch::book`]), such that with the elastic energy of [`ContactLaw::elastic_energy`] the
    /// work of the force, ½ (F₀ + F₁) · slip, is accounted for.
    ///
    /// `parameters` gives the constants of contact `l`. Mark the function
    /// `#[inline(always)]`: it is compiled once per processor generation.
    fn evaluate<G: Geometry, const MOTION: bool, const TORQUES: bool>(
        &self,
        batch: &mut Batch<G, Self::History>,
        scratch: &mut Self::Scratch,
        parameters: impl Fn(usize) -> Self::Parameters + Copy,
    );
}
