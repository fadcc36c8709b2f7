//! What is out of the ordinary in a network.

use serde::{Deserialize, Serialize};

/// Share of all throats that is few.
const FEW: f64 = 0.02;

/// What a user should know of a network, though nothing is wrong with it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct NetworkRemarks {
    /// Throats in all.
    pub throats: u32,
    /// Throats that spheres close: they conduct nothing.
    pub closed_throats: u32,
    /// Throats between spheres that overlap so much that the formulas leave less than half of
    /// what is open.
    pub overlapped_throats: u32,
    /// Throats that conduct no more than a tube around them, since little drags in them.
    pub tube_throats: u32,
    /// Pores without volume: their four spheres have their centres in one plane.
    pub flat_pores: u32,
    /// Pores that are inside out.
    pub inverted_pores: u32,
    /// Pores without a path to an imposed pressure ([`SealedPores`](super::SealedPores)).
    pub sealed_pores: u32,
    /// Those of them that are held at a pressure all the same.
    pub drained_pores: u32,
    /// Pores that spheres fill.
    pub filled_pores: u32,
    /// Pores that touch walls of different pressures.
    pub contested_pores: u32,
}

impl NetworkRemarks {
    /// The larger of both counts, each.
    #[must_use]
    pub fn or_more(self, other: NetworkRemarks) -> NetworkRemarks {
        NetworkRemarks {
            throats: self.throats.max(other.throats),
            closed_throats: self.closed_throats.max(other.closed_throats),
            overlapped_throats: self.overlapped_throats.max(other.overlapped_throats),
            tube_throats: self.tube_throats.max(other.tube_throats),
            flat_pores: self.flat_pores.max(other.flat_pores),
            inverted_pores: self.inverted_pores.max(other.inverted_pores),
            sealed_pores: self.sealed_pores.max(other.sealed_pores),
            drained_pores: self.drained_pores.max(other.drained_pores),
            filled_pores: self.filled_pores.max(other.filled_pores),
            contested_pores: self.contested_pores.max(other.contested_pores),
        }
    }

    /// In words, one sentence each. Flat pores, which any lattice has, are not worth one, nor are
    /// limits to a few throats, as dense packings have them.
    pub fn warnings(&self) -> Vec<String> {
        let many = |n: u32| if f64::from(n) > FEW * f64::from(self.throats) { n } else { 0 };
        let of = |n: u32| format!("{n} of {} throats", self.throats);
        let sentences = [
            (
                self.closed_throats,
                format!(
                    "{} are closed: spheres overlap so much that they leave nothing open",
                    of(self.closed_throats)
                ),
            ),
            (
                many(self.overlapped_throats),
                format!(
                    "{} lie between spheres that overlap so much that the formulas leave less than half of what \
                     is open; geometry limits these",
                    of(self.overlapped_throats)
                ),
            ),
            (
                many(self.tube_throats),
                format!(
                    "{} conduct no more than a tube around them: hardly anything drags there, as among loose \
                     fine particles, and the formulas are those of dense packings",
                    of(self.tube_throats)
                ),
            ),
            (self.inverted_pores, format!("{} pores are inside out", self.inverted_pores)),
            (
                self.sealed_pores,
                format!(
                    "{} pores are sealed: no path leads to an imposed pressure",
                    self.sealed_pores
                ),
            ),
            (
                self.drained_pores,
                format!(
                    "{} of them are held at the mean of the imposed pressures: what they swallow or give off \
                     comes from nowhere",
                    self.drained_pores
                ),
            ),
            (
                self.filled_pores,
                format!("spheres fill {} pores: there is no fluid in them", self.filled_pores),
            ),
            (
                self.contested_pores,
                format!(
                    "{} pores touch walls of different pressures: each has that of the last of its walls, in the \
                     order x_min, x_max, y_min, y_max, z_min, z_max",
                    self.contested_pores
                ),
            ),
        ];
        sentences.into_iter().filter(|(count, _)| *count > 0).map(|(_, text)| text).collect()
    }
}
