//! Pore-scale finite volumes: the pore network of a packing and its flow.

/// The pore network cannot be built or used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PfvError {
    /// The triangulation failed.
    #[error("triangulation: {0}")]
    Triangulation(String),
}
