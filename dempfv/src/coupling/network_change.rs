//! Two networks under the same motion: what the older one had come to.

/// Pressures at the spheres that the network which made room gives the step to come (Pa), in storage
/// order.
#[derive(Clone, Debug, Default)]
pub(super) struct Comparison {
    /// Whether networks are compared.
    pub is_on: bool,
    pub before: Option<Vec<f64>>,
    pub change: Option<NetworkChange>,
}

/// Two networks under the same motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NetworkChange {
    /// Root of the mean square of the difference of their pressures at the spheres (Pa).
    pub difference: f64,
    /// Root of the mean square of the new ones (Pa).
    pub pressure: f64,
}
