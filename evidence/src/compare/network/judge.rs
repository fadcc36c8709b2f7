//! What has to agree, how well, and why something may not.

use super::Compared;
use super::difference::Difference;
use super::evidence::{Distance, Evidence};
use super::stat::{Stat, number};
use crate::compare::verdict::Verdict;

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
            rows.extend(worst(chosen.map(|(p, flow)| of_flow(packings, p, flow, quantity))));
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

fn of_flow(all: &[Compared], packing: &Compared, flow: &Difference, quantity: Quantity) -> Verdict {
    let stat = quantity.stat(flow);
    let within = stat.largest <= quantity.bound();
    let reason = if within { None } else { explanation(packing, flow, quantity) };
    Verdict {
        on: format!("{}, {}", packing.name, flow.case.name()),
        quantity: quantity.name().to_owned(),
        largest: stat.largest,
        median: Some(stat.median),
        bound: quantity.bound(),
        explanation: reason.map(|reason| reason.text(all)),
    }
}

/// Why a difference is larger than its bound, where the second evaluation shows that it is
/// YADE's.
fn explanation(packing: &Compared, flow: &Difference, quantity: Quantity) -> Option<Reason> {
    if quantity == Quantity::Inside {
        return clamped(packing, flow).then_some(Reason::Clamp);
    }
    let ours = quantity.largest(&packing.evidence_for(flow)?.ours_planes);
    (ours <= OURS_EXACT).then_some(Reason::Walls)
}

/// What YADE's differences come from.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Reason {
    Walls,
    Clamp,
}

impl Reason {
    /// The reason with its evidence, in a sentence or two: one for all rows.
    fn text(self, packings: &[Compared]) -> String {
        match self {
            Reason::Walls => because_of_walls(packings),
            Reason::Clamp => because_of_clamp(packings),
        }
    }
}

fn because_of_walls(packings: &[Compared]) -> String {
    let all = || packings.iter().flat_map(|p| &p.evidence);
    let off = |quantity: Quantity, of: fn(&Evidence) -> &Distance| {
        number(all().map(|e| quantity.largest(of(e))).fold(0.0, f64::max))
    };
    let at_walls = Quantity::ALL.into_iter().filter(|q| *q != Quantity::Inside);
    let ours = at_walls.flat_map(|q| all().map(move |e| q.largest(&e.ours_planes)));
    format!(
        "YADE's walls are huge spheres where ours are planes, and it computes a pore's centre relative to the \
         pore's first vertex: where that is such a sphere nine digits are lost. An evaluation at 50 digits with \
         planes is at most {} from ours in any of these quantities. With exact spheres its flux is {} from that \
         with planes, and YADE's is {} from it; YADE's pressures are {} from those with exact spheres, and the \
         same formulas in double precision {} (section Walls)",
        number(ours.fold(0.0, f64::max)),
        off(Quantity::Flux, |e| &e.spheres_planes),
        off(Quantity::Flux, |e| &e.theirs_spheres),
        off(Quantity::Pressure, |e| &e.theirs_spheres),
        off(Quantity::Pressure, |e| &e.double_spheres),
    )
}

fn because_of_clamp(packings: &[Compared]) -> String {
    let free = packings.iter().flat_map(|p| &p.flows).filter(|f| !f.case.clamp);
    let off = free.map(|f| f.conductance.inside.largest).fold(0.0, f64::max);
    format!(
        "YADE's clamp is a multiple of means over all throats, those at its walls included; without it the same \
         conductances are {} apart",
        number(off)
    )
}

/// Whether the clamp makes the difference: throats on it are as far apart as the means that
/// it is taken from.
fn clamped(packing: &Compared, flow: &Difference) -> bool {
    let mut free = packing.flows.iter().filter(|f| f.case.slip == flow.case.slip && !f.case.clamp);
    flow.case.clamp && free.all(|f| f.conductance.inside.largest <= Quantity::Inside.bound())
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
