//! The arrays of a network that has gone out of use, for whoever still looks at them.

use std::mem;

use super::pore_pressures::PorePressures;
use super::{Flow, Network};

/// A network that has gone out of use, with its last pressures. Its arrays lie where they lay
/// when it was in use.
pub struct RetiredNetwork {
    network: Network,
    pressures: PorePressures,
}

impl RetiredNetwork {
    /// The network.
    pub fn network(&self) -> &Network {
        &self.network
    }

    /// Pressure of each pore at the end (Pa).
    pub fn pressure(&self) -> &[f64] {
        self.pressures.absolute()
    }
}

impl Flow {
    /// Takes the arrays out of a flow that is to go, which goes on with copies of them.
    pub(crate) fn set_aside(&mut self) -> RetiredNetwork {
        let (network, pressures) = (self.network.clone(), self.pressures.clone());
        RetiredNetwork {
            network: mem::replace(&mut self.network, network),
            pressures: mem::replace(&mut self.pressures, pressures),
        }
    }
}
