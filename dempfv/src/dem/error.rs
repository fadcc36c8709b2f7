//! What can go wrong in the mechanics.

use crate::excerpt::Brief;
use crate::{CellError, WallId};

/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

/// The mechanics cannot go on, or was given something it cannot work with.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DemError {
    /// A position, velocity or force is not finite.
    #[error("particle {particle}: {quantity} is not finite")]
    NotFinite {
        /// The user's number of the particle.
        particle: u32,
        /// What is not finite.
        quantity: &'static str,
    },
    /// A force of a user's own is not finite.
    #[error("particle {particle}: the force or torque of `{name}` is not finite")]
    BodyForce {
        /// The force's name.
        name: String,
        /// The user's number of the particle.
        particle: u32,
    },
    /// A parameter has a value that makes no sense.
    #[error("{name} = {}; it must be {expected}", Brief(*value))]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// The value it was given.
        value: f64,
        /// What would be right.
        expected: &'static str,
    },
    /// A radius or a mass that is not a positive number.
    #[error("particle {particle}: {quantity} = {}; it must be positive and finite", Brief(*value))]
    BadParticle {
        /// The user's number of the particle.
        particle: u32,
        /// `radius` or `mass`.
        quantity: &'static str,
        /// The value it was given.
        value: f64,
    },
    /// A sphere of a material that is not in the list.
    #[error(
        "particle {particle}: it is of material {index}, of {count} that there are, counted from 0"
    )]
    NoSuchMaterial {
        /// The user's number of the particle.
        particle: u32,
        /// The material that it was given.
        index: u16,
        /// Materials in the list.
        count: usize,
    },
    /// No material, or more than there are indices for.
    #[error("{found} materials; give from 1 to {}", u16::MAX)]
    NumberOfMaterials {
        /// Materials given.
        found: usize,
    },
    /// Two arrays that describe the same particles differ in length.
    #[error("{what}: {found} entries for {expected} particles")]
    Length {
        /// Which array.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The number of particles.
        expected: usize,
    },
    /// The numbers of the particles are not each of 0, 1, 2, ... once.
    #[error(
        "`id` holds {number} twice or beyond the {count} particles; it must hold each number from 0 on once"
    )]
    Numbers {
        /// The number that is wrong.
        number: u32,
        /// The number of particles.
        count: usize,
    },
    /// A number that no sphere has.
    #[error("there is no sphere {number}: their numbers begin at 0, and there are {count}")]
    NoSuchSphere {
        /// The number.
        number: u32,
        /// How many spheres there are.
        count: usize,
    },
    /// A motion that cannot be given.
    #[error("the {what} of a motion {problem}; {remedy}")]
    Motion {
        /// Which part of it.
        what: &'static str,
        /// What is wrong with it.
        problem: &'static str,
        /// What would be right.
        remedy: &'static str,
    },
    /// A clump that cannot be.
    #[error("clump {clump} {reason}")]
    Clump {
        /// Its place among the clumps, from 0.
        clump: usize,
        /// Why not, and what would be right.
        reason: &'static str,
    },
    /// Effects of a contact law that do not go together.
    #[error("{reason}")]
    Effects {
        /// Why not.
        reason: &'static str,
    },
    /// A state of another contact law.
    #[error("the state is of the contact law `{found}`, not of `{expected}`; give it to that law")]
    Law {
        /// The law that the state is of.
        found: String,
        /// The law that was to go on from it.
        expected: &'static str,
    },
    /// A state whose histories have another length than the law's.
    #[error("contact history: {found} numbers for {contacts} contacts of {length} each")]
    History {
        /// Numbers found.
        found: usize,
        /// Contacts in the state.
        contacts: usize,
        /// Numbers that the law remembers per contact.
        length: usize,
    },
    /// The box lies so far from the origin that the contacts of a particle have no digits.
    #[error(
        "particle {particle}: its radius is {radius:e} m, but in this box neighbouring coordinates are \
         {spacing:.1e} m apart in double precision: its contacts would have lost their digits; move \
         the box to the origin, or take a smaller box"
    )]
    LostDigits {
        /// The user's number of the particle.
        particle: u32,
        /// Its radius (m).
        radius: f64,
        /// Distance between neighbouring numbers at the largest coordinate of the box (m).
        spacing: f64,
    },
    /// The centre of a particle lies beyond a wall.
    #[error("particle {particle}: its centre lies beyond the wall {wall}")]
    OutsideBox {
        /// The user's number of the particle.
        particle: u32,
        /// The wall.
        wall: WallId,
    },
    /// The centre of a particle has gone through a wall.
    #[error(
        "particle {particle} has gone through the wall {wall}, at {speed:.3e} m/s towards each other, {radii:.2} of \
         its radii in the last step{}",
        likely(cause)
    )]
    LeftBox {
        /// The user's number of the particle.
        particle: u32,
        /// The wall.
        wall: WallId,
        /// Its speed against the wall (m/s).
        speed: f64,
        /// How far that took it in the last step, in radii.
        radii: f64,
        /// Why, most likely; `None` where another cause is told beside it.
        cause: Option<Leaving>,
    },
    /// Two particles share one centre: their contact has no direction.
    #[error("particles {first} and {second} have the same centre")]
    Coincident {
        /// The user's number of one particle.
        first: u32,
        /// The user's number of the other.
        second: u32,
    },
    /// A fixed time step is larger than the contacts allow.
    #[error(
        "the time step of {dt:e} s is not stable: the contacts of the spheres, as large as they are \
         now, allow {limit:.3e} s; take less, or the automatic one (`dt = \"auto\"`)"
    )]
    TimeStepTooLarge {
        /// The time step (s).
        dt: f64,
        /// The largest stable one (s).
        limit: f64,
    },
    /// Two opposite walls have met.
    #[error("the walls {lower} and {upper} have met: the box has no volume")]
    WallsMet {
        /// The wall at the lower end of the axis.
        lower: WallId,
        /// The wall at the upper end.
        upper: WallId,
    },
    /// Edges that are no periodic cell, or what a step has left of one.
    #[error(transparent)]
    Cell(#[from] CellError),
    /// A periodic cell so small that two spheres might meet twice.
    #[error(
        "the periodic cell is {height:.4e} m high between two of its faces, and spheres of up to \
         {largest:.4e} m in radius with the skin of the neighbour list need {least:.4e} m, so that none \
         meets another twice; take more spheres, or smaller ones"
    )]
    CellTooSmall {
        /// Distance between two opposite faces (m).
        height: f64,
        /// The least that is allowed (m).
        least: f64,
        /// Largest radius (m).
        largest: f64,
    },
    /// A periodic cell that deforms too much in a step.
    #[error(
        "the cell's velocity gradient L_{a}{b} = {rate:e} /s makes a strain of {strain:.3e} in one time step of \
         {dt:.3e} s; at most {most} leaves contacts time to act: give a smaller rate, or a smaller time step",
        a = AXES[*first], b = AXES[*second]
    )]
    CellStrainPerStep {
        /// The component's two axes.
        first: usize,
        /// See above.
        second: usize,
        /// Its value (1/s).
        rate: f64,
        /// Length of the step (s).
        dt: f64,
        /// Their product (1).
        strain: f64,
        /// What is allowed (1).
        most: f64,
    },
    /// A shear stress is prescribed by both its components.
    #[error(
        "the stress on the cell is given for {a}{b} and for {b}{a}: it is symmetric; give one, and a rate \
         for the other, which says how the cell turns",
        a = AXES[*first], b = AXES[*second]
    )]
    StressTwice {
        /// The smaller of the two axes.
        first: usize,
        /// The larger one.
        second: usize,
    },
    /// What asks for a periodic cell, without one.
    #[error("there is no periodic cell, but walls; make the spheres in a cell")]
    NoCell,
    /// What makes no sense in a periodic cell.
    #[error("{what} in a periodic cell: {remedy}")]
    InCell {
        /// What it is.
        what: &'static str,
        /// Why not, and what would be right.
        remedy: &'static str,
    },
    /// The random cloud has no room for another sphere.
    #[error(
        "placed {placed} of {count} spheres at porosity {porosity:.3} and found no room for the \
         next; ask for a higher porosity, a smaller radius or fewer spheres"
    )]
    CloudFull {
        /// Spheres that found a place.
        placed: usize,
        /// Spheres that were asked for.
        count: usize,
        /// Porosity the cloud would have had.
        porosity: f64,
    },
    /// The compaction did not come to rest at its goal in the steps it had.
    #[error(
        "compaction not at rest after {steps} steps: stress {stress:.6e} Pa of {goal:.6e} Pa, \
         unbalanced force {unbalanced:.2e}"
    )]
    NotSettled {
        /// Steps done.
        steps: u64,
        /// Mean stress of the six walls (Pa).
        stress: f64,
        /// Stress asked for (Pa).
        goal: f64,
        /// Unbalanced force ratio.
        unbalanced: f64,
    },
}

impl DemError {
    /// The user's number of the particle that the error is about, where it is about one; the first of
    /// two.
    pub fn particle(&self) -> Option<u32> {
        match self {
            DemError::NotFinite { particle, .. }
            | DemError::BodyForce { particle, .. }
            | DemError::BadParticle { particle, .. }
            | DemError::NoSuchMaterial { particle, .. }
            | DemError::LostDigits { particle, .. }
            | DemError::OutsideBox { particle, .. }
            | DemError::LeftBox { particle, .. }
            | DemError::Coincident { first: particle, .. } => Some(*particle),
            _ => None,
        }
    }
}

/// Why a sphere goes through a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leaving {
    /// The sphere moves too far in a step.
    FastSphere,
    /// The wall does.
    FastWall,
    /// The wall does, and a servo moves it.
    FastServo,
    /// Neither does: forces are too large for the stiffness, or a wall leaves no room.
    Pressed,
}

/// The end of a sentence that says why a sphere has left its box.
fn likely(cause: &Option<Leaving>) -> String {
    cause.map_or_else(String::new, |cause| format!("; the likely cause: {cause}"))
}

impl std::fmt::Display for Leaving {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Leaving::FastSphere => {
                "it goes too far in a step for a contact to stop it; take a smaller time step, or look \
                 for what makes it so fast"
            }
            Leaving::FastWall => {
                "the wall goes too far in a step for a contact to move it along; take a smaller time step, \
                 or a slower wall"
            }
            Leaving::FastServo => {
                "the servo moves the wall too far in a step for a contact to move it along; give a lower \
                 max_velocity, or a smaller time step"
            }
            Leaving::Pressed => {
                "it is pressed through; the stiffness is too low for what acts on it, or walls leave no \
                 room"
            }
        })
    }
}

/// Refuses an array that has not one entry per particle.
pub(super) fn require_length(
    what: &'static str,
    found: usize,
    expected: usize,
) -> Result<(), DemError> {
    if found == expected { Ok(()) } else { Err(DemError::Length { what, found, expected }) }
}
