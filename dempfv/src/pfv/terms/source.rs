//! Sources and sinks of fluid: Q in `G p = -V̇ + Q` (eq. 6 of Caulk 2020).

use serde::{Deserialize, Serialize};

use super::FluidTerm;
use crate::Vec3;
use crate::pfv::packing_check::require_length;
use crate::pfv::{Network, PfvError, PoreConditions, PoreSelection};
use crate::{Effect, EffectKey, Family};

/// What this effect says of itself.
pub const EFFECT: Effect = Effect {
    name: Sources::NAME,
    family: Family::Fluid,
    equation: "sum_j g_ij (p_j - p_i) = dV_i/dt - Q_i",
    source: "Caulk et al. 2020, eq. 6",
    keys: &[EffectKey { key: "sources in [fluid]", unit: "m³/s", default: "none" }],
    needs: "",
    test: "dempfv/tests/pfv_sources.rs",
};

/// A rate at which fluid enters pores of choice, as from the tip of an injection tube.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoreSource {
    /// Into which pores.
    pub pores: PoreSelection,
    /// How much enters all of them together (m³/s), shared out evenly; negative for a sink.
    pub rate: f64,
}

/// Sources of fluid, pore by pore.
#[derive(Clone, Debug, PartialEq)]
pub struct Sources {
    /// Pores and what enters each (m³/s).
    rates: Vec<(u32, f64)>,
}

impl Sources {
    /// The name of this term.
    pub const NAME: &'static str = "fluid sources";

    /// Sources in the pores of a network with these conditions. `position` has the sphere centres
    /// (m) that the network was built of. Several sources of one pore add up.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] where a rate is not finite, no pore is selected, a pore has no
    /// such number, or has an imposed pressure: a source there would change nothing. Further where
    /// the positions are not one per sphere, or the conditions are those of another network.
    pub fn new(
        network: &Network,
        conditions: &PoreConditions,
        position: &[Vec3],
        sources: &[PoreSource],
    ) -> Result<Sources, PfvError> {
        require_length("conditions", conditions.pores(), network.pores(), "pores")?;
        let mut rates = vec![];
        for (k, PoreSource { pores, rate }) in sources.iter().enumerate() {
            let wrong = |problem: String| Err(PfvError::invalid("sources", k, problem));
            if !rate.is_finite() {
                return wrong(format!("a rate of {rate} m³/s; it must be finite"));
            }
            let selected = pores.select(network, position)?;
            if selected.is_empty() {
                return wrong("selects no pore; choose other pores or a larger radius".to_owned());
            }
            let share = rate / selected.len() as f64;
            for &pore in &selected {
                if pore as usize >= network.pores() {
                    return wrong(format!("pore {pore} of a network of {}", network.pores()));
                }
                if conditions.set_of(pore as usize).is_some() {
                    return wrong(format!(
                        "pore {pore} has an imposed pressure; put the source into a free one"
                    ));
                }
                rates.push((pore, share));
            }
        }
        Ok(Sources { rates })
    }

    /// True when there is no source.
    pub fn is_empty(&self) -> bool {
        self.rates.is_empty()
    }

    /// What enters all pores together (m³/s).
    pub fn total(&self) -> f64 {
        self.rates.iter().map(|(_, rate)| rate).sum()
    }
}

impl FluidTerm for Sources {
    fn name(&self) -> &'static str {
        Sources::NAME
    }

    fn add_uptake(&self, uptake: &mut [f64]) {
        for &(pore, rate) in &self.rates {
            if let Some(uptake) = uptake.get_mut(pore as usize) {
                *uptake -= rate;
            }
        }
    }
}
