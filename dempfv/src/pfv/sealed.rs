//! Pores without a path to an imposed pressure.

use serde::Serialize;

use super::{NONE, Network, PfvError, PoreConditions, SealedPoreRule};

/// Part of what a sealed group swallows and gives off that is round-off.
const BALANCED: f64 = 1e-9;

/// Pores that no throat joins to an imposed pressure: in a box without one, or shut in by
/// spheres that overlap.
///
/// The pressures of a group are known but for a constant, and only where its pores together
/// keep their volume. One pore of each is pinned at the mean of the imposed pressures (0 where
/// there are none), and a solve is refused where the group would have to swallow fluid. Pores
/// that the spheres fill have no fluid, and nothing flows to those that are blocked: they are pinned,
/// too, and may change as they like, and so are and may all pores of a group under
/// [`SealedPoreRule::Drained`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SealedPores {
    /// Pores that throats join to each other and to nothing else; the first of each group is
    /// pinned, or all are.
    pub groups: Vec<Vec<u32>>,
    /// Pores that the spheres fill.
    pub filled: Vec<u32>,
    /// Pores that are blocked.
    pub blocked: Vec<u32>,
    /// Whether groups are closed.
    rule: SealedPoreRule,
}

impl SealedPores {
    /// The sealed pores of a network under these conditions.
    pub(super) fn of(network: &Network, conditions: &PoreConditions) -> SealedPores {
        let mut reached: Vec<bool> =
            (0..network.pores()).map(|pore| conditions.set_of(pore).is_some()).collect();
        let imposed = (0u32..).zip(&reached).filter(|(_, imposed)| **imposed).map(|(i, _)| i);
        let mut todo: Vec<u32> = imposed.collect();
        spread(network, &mut todo, &mut reached, |_| ());
        let mut sealed = SealedPores { rule: conditions.sealed_pores(), ..SealedPores::default() };
        for pore in 0..network.pores() {
            if reached[pore] {
                continue;
            }
            if network.is_blocked(pore) {
                sealed.blocked.push(pore as u32);
                continue;
            }
            if network.is_filled(pore) {
                sealed.filled.push(pore as u32);
                continue;
            }
            reached[pore] = true;
            todo.push(pore as u32);
            let mut group = vec![];
            spread(network, &mut todo, &mut reached, |pore| group.push(pore));
            group.sort_unstable();
            sealed.groups.push(group);
        }
        sealed
    }

    /// True when every pore has a path to an imposed pressure.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty() && self.filled.is_empty() && self.blocked.is_empty()
    }

    /// Number of pores in all groups; those that are filled do not count.
    pub fn in_groups(&self) -> usize {
        self.groups.iter().map(Vec::len).sum()
    }

    /// Number of pores in all groups but the largest.
    pub(super) fn beside_largest(&self) -> usize {
        self.in_groups() - self.groups.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// Number of pores of groups that are drained.
    pub fn drained(&self) -> usize {
        if self.rule == SealedPoreRule::Drained { self.in_groups() } else { 0 }
    }

    /// The pores whose pressure is pinned.
    pub(super) fn pinned(&self) -> impl Iterator<Item = u32> + '_ {
        let all = self.rule == SealedPoreRule::Drained;
        let count = move |group: &Vec<u32>| if all { group.len() } else { 1 };
        let of_groups = self.groups.iter().flat_map(move |group| group.iter().take(count(group)));
        of_groups.chain(&self.filled).chain(&self.blocked).copied()
    }

    /// Refuses what a group of sealed pores cannot swallow (m³/s), measured by no less than a flow of
    /// `least` (m³/s).
    ///
    /// # Errors
    /// [`PfvError::SealedPores`] names the group.
    pub(super) fn check(
        &self,
        network: &Network,
        demand: &[f64],
        least: f64,
    ) -> Result<(), PfvError> {
        let closed = self.groups.iter().filter(|_| self.rule == SealedPoreRule::Closed);
        for group in closed {
            let rates = || group.iter().map(|&pore| demand[pore as usize]);
            let (net, moved) = (rates().sum::<f64>(), rates().map(f64::abs).sum::<f64>());
            if net.abs() > BALANCED * moved.max(least) {
                if network.periodic().is_some() && 2 * group.len() > network.pores() {
                    return Err(PfvError::ClosedCell { rate: net });
                }
                let pore = group[0];
                let vertices = network.tessellation.vertices_of(pore);
                return Err(PfvError::SealedPores {
                    pore,
                    vertices,
                    pores: group.len(),
                    rate: net,
                });
            }
        }
        Ok(())
    }
}

/// Marks all that throats join to the pores in `todo`, which are marked.
fn spread(
    network: &Network,
    todo: &mut Vec<u32>,
    reached: &mut [bool],
    mut visit: impl FnMut(u32),
) {
    while let Some(i) = todo.pop() {
        visit(i);
        let around = network.tessellation.neighbors[i as usize];
        for (j, g) in around.into_iter().zip(network.conductances_of(i as usize)) {
            if j != NONE && g > 0.0 && !reached[j as usize] {
                reached[j as usize] = true;
                todo.push(j);
            }
        }
    }
}
