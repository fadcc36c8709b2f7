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
    /// Of each source (m³/s).
    rate: Vec<f64>,
    /// Pores, the source of each, and its share of what that brings (1).
    pores: Vec<(u32, u32, f64)>,
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
        let mut shares = vec![];
        for (k, PoreSource { pores, rate }) in sources.iter().enumerate() {
            let wrong = |problem: String| Err(PfvError::invalid("sources", k, problem));
            if !rate.is_finite() {
                return wrong(format!("a rate of {rate} m³/s; it must be finite"));
            }
            let selected = pores.select(network, position)?;
            if selected.is_empty() {
                return wrong("selects no pore; choose other pores or a larger radius".to_owned());
            }
            let share = 1.0 / selected.len() as f64;
            for &pore in &selected {
                if pore as usize >= network.pores() {
                    return wrong(format!("pore {pore} of a network of {}", network.pores()));
                }
                if conditions.set_of(pore as usize).is_some() {
                    return wrong(format!(
                        "pore {pore} has an imposed pressure; put the source into a free one"
                    ));
                }
                shares.push((pore, k as u32, share));
            }
        }
        Ok(Sources { rate: sources.iter().map(|source| source.rate).collect(), pores: shares })
    }

    /// True when there is no source.
    pub fn is_empty(&self) -> bool {
        self.rate.is_empty()
    }

    /// What enters all pores together (m³/s).
    pub fn total(&self) -> f64 {
        self.rate.iter().sum()
    }

    /// Changes what one source brings (m³/s). False where there is none of this number.
    pub(in crate::pfv) fn set_rate(&mut self, number: usize, rate: f64) -> bool {
        self.rate.get_mut(number).map(|old| *old = rate).is_some()
    }
}

impl FluidTerm for Sources {
    fn name(&self) -> &'static str {
        Sources::NAME
    }

    fn add_uptake(&self, uptake: &mut [f64]) {
        for &(pore, source, share) in &self.pores {
            if let Some(uptake) = uptake.get_mut(pore as usize) {
                *uptake -= share * self.rate[source as usize];
            }
        }
    }
}
