//! How far the two programs are apart on one packing.

use dempfv::Vec3;
use dempfv::pfv::{Derivatives, Flow, Network};
use serde::{Deserialize, Serialize};

use super::case::{Case, Packing};
use super::stat::Stat;
use super::theirs::{Match, TheirFlow, Theirs};

/// Differences that do not depend on the fluid.
#[derive(Clone, Serialize, Deserialize)]
pub struct Geometry {
    /// Centres of pores without walls, over the longest edge of the box.
    pub center: Stat,
    /// Volumes of pores without walls, relative.
    pub volume: Stat,
    /// Centres of pores at walls, over the longest edge.
    pub center_at_walls: Stat,
    /// Volumes of pores at walls, relative.
    pub volume_at_walls: Stat,
    /// Pores of which YADE does not tell the volume.
    pub volume_unknown: usize,
    /// Pores whose pressure only one of the two imposes.
    pub imposed: usize,
}

/// Differences of one flow.
#[derive(Clone, Serialize, Deserialize)]
pub struct Difference {
    /// Settings.
    pub case: Case,
    /// Relative differences of conductances, by the throat's place.
    pub conductance: ByPlace,
    /// Pressures over the imposed difference.
    pub pressure: Stat,
    /// Forces on spheres, without those of corner pores, over their mean.
    pub force: Stat,
    /// Forces on spheres of corner pores over the mean.
    pub corner_force: Stat,
    /// The same less the push that YADE leaves out.
    pub corner_force_less_push: Stat,
    /// Fluxes through the two walls, relative; the permeability is one of them.
    pub flux: Stat,
    /// Our flux into the box at the bottom (m³/s).
    pub our_flux: f64,
    /// YADE's.
    pub their_flux: f64,
    /// All forces, against the pressure on the walls.
    pub balance: Balance,
    /// YADE's porosity, as Python prints it.
    pub their_porosity: String,
}

/// A figure for throats at different places.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub struct ByPlace {
    /// Between pores without walls.
    pub inside: Stat,
    /// Without walls, at a pore with a wall.
    pub beside: Stat,
    /// With one or two walls.
    pub at_walls: Stat,
}

/// All forces of the fluid along the flow, over area times pressure difference.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub struct Balance {
    /// Ours on spheres and walls.
    pub ours: f64,
    /// YADE's on spheres, ours on walls.
    pub theirs: f64,
    /// The same with the push that YADE leaves out.
    pub theirs_with_push: f64,
}

/// Where a throat is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Between pores without walls.
    Inside,
    /// Without walls, at a pore with a wall.
    Beside,
    /// With one or two walls.
    AtWalls,
}

/// Places of all throats.
pub fn places(network: &Network) -> Vec<Place> {
    let t = &network.tessellation;
    let of = |&[i, j]: &[u32; 2]| {
        let (a, b) = (t.cells[i as usize], t.cells[j as usize]);
        let is_wall = |v: &u32| t.wall(*v).is_some();
        if a.iter().any(|v| is_wall(v) && b.contains(v)) {
            Place::AtWalls
        } else if a.iter().chain(&b).any(is_wall) {
            Place::Beside
        } else {
            Place::Inside
        }
    };
    network.throats.pores.iter().map(of).collect()
}

impl ByPlace {
    /// Relative differences of two rows of conductances; throats that either lacks do not
    /// count.
    pub fn relative(
        places: &[Place],
        a: impl IntoIterator<Item = Option<f64>>,
        b: impl IntoIterator<Item = Option<f64>>,
    ) -> ByPlace {
        let pairs: Vec<(Place, f64, f64)> = (places.iter().zip(a).zip(b))
            .filter_map(|((&place, a), b)| Some((place, a?, b?)))
            .filter(|(_, a, b)| (*a, *b) != (0.0, 0.0))
            .collect();
        let of =
            |at: Place| Stat::relative(pairs.iter().filter(|p| p.0 == at).map(|&(_, a, b)| (a, b)));
        ByPlace {
            inside: of(Place::Inside),
            beside: of(Place::Beside),
            at_walls: of(Place::AtWalls),
        }
    }
}

impl Geometry {
    /// Compares pores.
    pub fn new(packing: &Packing, flow: &Flow, theirs: &Theirs, matched: &Match) -> Geometry {
        let network = flow.network();
        let edge = packing.bounds.size().max();
        let center = |(i, p): (usize, usize)| (network.center[i] - theirs.center[p]).amax() / edge;
        let volume = |(i, p): (usize, usize)| theirs.volume[p].map(|v| v / network.volume[i] - 1.0);
        let (inner, outer): (Vec<_>, Vec<_>) =
            matched.common().partition(|&(i, _)| walls(network, i) == 0);
        let of = |pores: &[(usize, usize)]| Stat::of(pores.iter().copied().filter_map(volume));
        let imposed =
            |&(i, p): &(usize, usize)| flow.operators().imposed(i).is_some() != theirs.imposed[p];
        Geometry {
            center: Stat::of(inner.iter().copied().map(center)),
            volume: of(&inner),
            center_at_walls: Stat::of(outer.iter().copied().map(center)),
            volume_at_walls: of(&outer),
            volume_unknown: theirs.volume.iter().filter(|v| v.is_none()).count(),
            imposed: matched.common().filter(imposed).count(),
        }
    }
}

impl Difference {
    /// Compares one flow.
    pub fn new(
        packing: &Packing,
        case: Case,
        (flow, derivatives): (&Flow, &Derivatives),
        theirs: &TheirFlow,
        matched: &Match,
    ) -> Difference {
        let push = corner_push(flow, derivatives);
        let network = flow.network();
        let ours = network.throats.conductance.iter().map(|&g| Some(g));
        let conductance = ByPlace::relative(&places(network), matched.conductances(theirs), ours);
        let pressure = flow.pressure();
        let mean =
            flow.force().iter().map(Vec3::norm).sum::<f64>() / flow.force().len().max(1) as f64;
        let off = |i: usize, f: Vec3| (theirs.force[i] - f).norm() / mean;
        let (corner, other): (Vec<_>, Vec<_>) =
            (0..flow.force().len()).partition(|&i| push[i].is_some());
        let flux = flow.flux();
        // YADE counts what leaves the box.
        let fluxes = [2, 3].map(|w| (-theirs.flux[w], flux[w]));
        Difference {
            case,
            conductance,
            pressure: Stat::of(matched.common().map(|(i, p)| theirs.pressure[p] - pressure[i])),
            force: Stat::of(other.iter().map(|&i| off(i, flow.force()[i]))),
            corner_force: Stat::of(corner.iter().map(|&i| off(i, flow.force()[i]))),
            corner_force_less_push: Stat::of(
                corner.iter().map(|&i| off(i, flow.force()[i] - push[i].unwrap_or_default())),
            ),
            flux: Stat::relative(fluxes),
            our_flux: flux[2],
            their_flux: -theirs.flux[2],
            balance: Balance::new(packing, flow, theirs, &push),
            their_porosity: theirs.porosity.clone(),
        }
    }
}

impl Balance {
    fn new(packing: &Packing, flow: &Flow, theirs: &TheirFlow, push: &[Option<Vec3>]) -> Balance {
        let size = packing.bounds.size();
        // The imposed difference is 1 Pa.
        let unit = size.x * size.z;
        let sum = |f: &[Vec3]| f.iter().map(|f| f.y).sum::<f64>() / unit;
        let walls = sum(flow.wall_force());
        let theirs = sum(&theirs.force) + walls;
        let push = push.iter().flatten().map(|f| f.y).sum::<f64>() / unit;
        Balance { ours: sum(flow.force()) + walls, theirs, theirs_with_push: theirs + push }
    }
}

/// For spheres of corner pores, what these push them by; `None` for the others.
pub fn corner_push(flow: &Flow, derivatives: &Derivatives) -> Vec<Option<Vec3>> {
    let (network, pressure) = (flow.network(), flow.pressure());
    let t = &network.tessellation;
    let mut push = vec![None; t.spheres];
    for (i, cell) in t.cells.iter().enumerate().filter(|(i, _)| walls(network, *i) == 3) {
        for (&v, f) in cell.iter().zip(&derivatives.force_coefficient[i]) {
            if let Some(total) = push.get_mut(v as usize) {
                *total = Some(total.unwrap_or_default() + pressure[i] * f);
            }
        }
    }
    push
}

/// Number of walls among a pore's vertices.
pub fn walls(network: &Network, pore: usize) -> usize {
    let t = &network.tessellation;
    t.cells[pore].iter().filter(|&&v| t.wall(v).is_some()).count()
}
