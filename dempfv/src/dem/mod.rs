//! Discrete elements: spheres, walls, contacts, integration.

/// The mechanics cannot go on.
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
}
