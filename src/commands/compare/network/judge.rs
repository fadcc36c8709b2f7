//! What has to agree, how well, and why something may not.

use super::Compared;
use super::difference::Difference;
use super::evidence::{Distance, Evidence};
use super::stat::{Stat, number};
use crate::commands::compare::verdict::Verdict;

/// So near must ours be to the second evaluation for a difference to be YADE's.
const OURS_EXACT: f64 = 1e-9;

/// What the two programs have in common, per flow.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Conductances between pores without walls.
    Inside,
    /// Conductances of throats without walls at a pore with a wall.
    Beside,
    /// Conductances of throats with walls.
    AtWalls,
    /// Pressures.
    Pressure,
    /// Forces on spheres, without those of corner pores.
    Force,
    /// Forces on the spheres of corner pores, less what YADE leaves out.
    CornerForce,
    /// Fluxes and permeability.
    Flux,
}

impl Quantity {
    /// All of them.
    pub const ALL: [Quantity; 7] = [
        Quantity::Inside,
        Quantity::Beside,
        Quantity::AtWalls,
        Quantity::Pressure,
        Quantity::Force,
        Quantity::CornerForce,
        Quantity::Flux,
    ];

    /// The quantity, and what its difference is relative to.
    pub const fn name(self) -> &'static str {
        match self {
            Quantity::Inside => "conductances between pores without walls",
            Quantity::Beside => "conductances without walls, at a pore with a wall",
            Quantity::AtWalls => "conductances of throats with walls",
            Quantity::Pressure => "pressures / imposed difference",
            Quantity::Force => "forces on spheres / their mean",
            Quantity::CornerForce => "forces on spheres of corner pores, less the push, / mean",
            Quantity::Flux => "wall fluxes, permeability",
        }
    }

    /// What the difference may be.
    pub const fn bound(self) -> f64 {
        match self {
            // Half a unit of the sixth digit.
            Quantity::Inside | Quantity::Beside => 5e-7,
            Quantity::AtWalls | Quantity::Force | Quantity::CornerForce => 1e-4,
            Quantity::Pressure | Quantity::Flux => 1e-5,
        }
    }

    /// Ours against YADE's.
    pub fn stat(self, flow: &Difference) -> Stat {
        match self {
            Quantity::Inside => flow.conductance.inside,
            Quantity::Beside => flow.conductance.beside,
            Quantity::AtWalls => flow.conductance.at_walls,
            Quantity::Pressure => flow.pressure,
            Quantity::Force => flow.force,
            Quantity::CornerForce => flow.corner_force_less_push,
            Quantity::Flux => flow.flux,
        }
    }

    /// The largest difference between two evaluations.
    pub fn largest(self, distance: &Distance) -> f64 {
        match self {
            Quantity::Inside => distance.conductance.inside.largest,
            Quantity::Beside => distance.conductance.beside.largest,
            Quantity::AtWalls => distance.conductance.at_walls.largest,
            Quantity::Pressure => distance.pressure.largest,
            Quantity::Force | Quantity::CornerForce => distance.force.largest,
            Quantity::Flux => distance.flux,
        }
    }
}

/// One row for each quantity, with YADE's clamp and without: the packing where it is
/// furthest off, those first that nothing explains.
pub fn verdicts(packings: &[Compared]) -> Vec<Verdict> {
    let mut rows: Vec<Verdict> =
        GEOMETRY.iter().filter_map(|judge| worst(packings.iter().map(judge))).collect();
    for clamp in [false, true] {
        for quantity in Quantity::ALL {
            let flows = packings.iter().flat_map(|p| p.flows.iter().map(move |f| (p, f)));
            let chosen = flows.filter(|(_, flow)| flow.case.clamp == clamp);
            rows.extend(worst(chosen.map(|(p, flow)| of_flow(p, flow, quantity))));
        }
    }
    rows
}

fn worst(verdicts: impl Iterator<Item = Verdict>) -> Option<Verdict> {
    verdicts.max_by(|a, b| a.fails().cmp(&b.fails()).then(a.largest.total_cmp(&b.largest)))
}

/// What does not depend on the fluid.
const GEOMETRY: [fn(&Compared) -> Verdict; 3] = [pores, centers, volumes];

fn pores(packing: &Compared) -> Verdict {
    let differing = &packing.differing;
    Verdict {
        on: packing.name.clone(),
        quantity: "pores that only one program has".to_owned(),
        largest: differing.count as f64,
        median: None,
        bound: 0.0,
        explanation: differing.explanation(),
    }
}

fn centers(packing: &Compared) -> Verdict {
    let quantity = "centres of pores without walls / box edge";
    geometric(packing, quantity, packing.geometry.center)
}

fn volumes(packing: &Compared) -> Verdict {
    geometric(packing, "volumes of pores without walls", packing.geometry.volume)
}

fn geometric(packing: &Compared, quantity: &str, stat: Stat) -> Verdict {
    Verdict {
        on: packing.name.clone(),
        quantity: quantity.to_owned(),
        largest: stat.largest,
        median: Some(stat.median),
        bound: 1e-9,
        explanation: None,
    }
}

fn of_flow(packing: &Compared, flow: &Difference, quantity: Quantity) -> Verdict {
    let stat = quantity.stat(flow);
    let within = stat.largest <= quantity.bound();
    Verdict {
        on: format!("{}, {}", packing.name, flow.case.name()),
        quantity: quantity.name().to_owned(),
        largest: stat.largest,
        median: Some(stat.median),
        bound: quantity.bound(),
        explanation: if within { None } else { explanation(packing, flow, quantity) },
    }
}

/// Why a difference is larger than its bound, where the second evaluation shows that it is
/// YADE's.
fn explanation(packing: &Compared, flow: &Difference, quantity: Quantity) -> Option<String> {
    if quantity == Quantity::Inside {
        return clamped(packing, flow);
    }
    let evidence = packing.evidence_for(flow)?;
    if quantity.largest(&evidence.ours_planes) > OURS_EXACT {
        return None;
    }
    let off = |distance| number(quantity.largest(distance));
    let ours = off(&evidence.ours_planes);
    let theirs = off(&evidence.theirs_planes);
    let model = off(&evidence.spheres_planes);
    let rest = off(&evidence.theirs_spheres);
    let double = off(&evidence.double_spheres);
    Some(format!(
        "YADE's walls are huge spheres, not planes, and it computes a pore's centre relative to \
         the pore's first vertex, which may be one of these: an evaluation at 50 digits is {ours} from \
         ours and {theirs} from YADE's; of that the spheres are {model}, the rest is round-off \
         ({rest}; the same formulas in double precision lose {double})"
    ))
}

/// Throats on YADE's clamp are as far apart as the means that it is taken from.
fn clamped(packing: &Compared, flow: &Difference) -> Option<String> {
    let free = packing.flows.iter().find(|f| f.case.slip == flow.case.slip && !f.case.clamp)?;
    let off = free.conductance.inside.largest;
    let shown = flow.case.clamp && off <= Quantity::Inside.bound();
    shown.then(|| {
        format!(
            "the clamp is a multiple of means over all throats, those at YADE's walls included; \
             without it the same conductances are {} apart",
            number(off)
        )
    })
}

impl Compared {
    /// The second evaluation of a flow; in larger packings that without a clamp.
    pub(super) fn evidence_for(&self, flow: &Difference) -> Option<&Evidence> {
        let of = |clamp| {
            let mut all = self.evidence.iter();
            all.find(|e| e.case.slip == flow.case.slip && e.case.clamp == clamp)
        };
        of(flow.case.clamp).or_else(|| of(false))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(largest: f64, explained: bool) -> Verdict {
        Verdict {
            on: String::new(),
            quantity: String::new(),
            largest,
            median: None,
            bound: 1.0,
            explanation: explained.then(String::new),
        }
    }

    #[test]
    fn what_nothing_explains_is_not_hidden_behind_what_is_explained() {
        let shown = worst([row(9.0, true), row(2.0, false), row(0.5, false)].into_iter());
        assert_eq!(shown.map(|v| v.largest), Some(2.0));
        let shown = worst([row(9.0, true), row(0.5, false)].into_iter());
        assert_eq!(shown.map(|v| v.largest), Some(9.0));
    }
}
