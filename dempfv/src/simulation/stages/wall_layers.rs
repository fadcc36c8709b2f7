//! The layers of pores at the two walls of an axis: what share of the height and of a settlement is
//! theirs.

use serde::{Deserialize, Serialize};

use crate::coupling::Coupled;
use crate::pfv::{Boundary, Flow, Fluid, Network, Operators};
use crate::{Aabb, Axis, Result, Vec3, WallId};

/// Where spheres and walls are at rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Rest {
    position: Vec<Vec3>,
    bounds: Aabb,
}

impl Rest {
    pub fn of(coupled: &Coupled) -> Rest {
        Rest { position: coupled.dem().positions(), bounds: coupled.dem().box_() }
    }
}

/// Shares of the volume that all pores lose from one rest to the next in those that touch the lower and
/// the upper wall of an axis.
pub(super) fn settlement(
    [from, to]: [&Rest; 2],
    coupled: &Coupled,
    fluid: &Fluid,
    axis: Axis,
) -> Result<[f64; 2]> {
    let radius = coupled.dem().radii();
    let (network, derivatives) = Network::new(&from.position, &radius, from.bounds, fluid)?;
    let operators = Operators::new(&network, derivatives, Boundary::default())?;
    let displacement: Vec<Vec3> =
        to.position.iter().zip(&from.position).map(|(to, from)| to - from).collect();
    let of_walls = WallId::ALL.map(|wall| to.bounds.wall(wall) - from.bounds.wall(wall));
    let mut change = vec![0.0; network.pores()];
    // Volume rates are linear in the velocities: of displacements they are changes of volume.
    operators.volume_rate(&displacement, &of_walls, &mut change)?;
    let whole: f64 = change.iter().sum();
    let at = |wall| at_wall(&network, wall).map(|pore| change[pore]).sum::<f64>();
    Ok(ends(axis).map(|wall| at(wall) / whole))
}

/// Share of the height that the pores at a wall fill.
pub(super) fn height(flow: &Flow, wall: WallId) -> f64 {
    let network = flow.network();
    let volume: f64 = at_wall(network, wall).map(|pore| network.volume[pore]).sum();
    volume / network.bounds.wall_area(wall) / network.bounds.size()[wall.axis()]
}

/// The lower and the upper wall of an axis.
fn ends(axis: Axis) -> [WallId; 2] {
    [0, 1].map(|end| WallId::ALL[2 * axis.index() + end])
}

/// The pores that touch a wall.
pub(super) fn at_wall(network: &Network, wall: WallId) -> impl Iterator<Item = usize> + '_ {
    let vertex = (network.tessellation.spheres + wall.index()) as u32;
    let cells = network.tessellation.cells.iter().enumerate();
    cells.filter(move |(_, cell)| cell.contains(&vertex)).map(|(pore, _)| pore)
}
