//! What a new network is given before its first step.

use super::edges::EdgeForces;
use super::error::Result;
use super::fluid_state::Snapshot;
use super::network_source::RemeshContext;
use crate::pfv::Flow;

/// Gives a fluid of some density its weight under the gravity of the spheres, and what flows through
/// a periodic cell its mean gradient.
pub(super) fn load(flow: &mut Flow, context: &RemeshContext) -> Result<()> {
    let weight = context.effects.density.zip(context.dem.options().gravity);
    if let Some((density, gravity)) = weight {
        flow.set_weight(density * gravity)?;
    }
    if let Some(gradient) = context.effects.pressure_gradient {
        flow.set_pressure_gradient(gradient)?;
        flow.move_with_spheres(&context.dem.storage().mass)?;
    }
    Ok(())
}

/// The edges of a new network, where they carry forces.
pub(super) fn edges_of(
    flow: &Flow,
    snapshot: &Snapshot,
    context: &RemeshContext,
) -> Result<Option<EdgeForces>> {
    let network = (flow.network(), context.saturation.fluid.slip_walls);
    EdgeForces::new(&context.effects.edges, network, &snapshot.position, context.dem)
}

/// What each pore has grown by since the positions that its network was built of (m³).
pub(super) fn volume_change(flow: &Flow, context: &RemeshContext) -> Result<Vec<f64>> {
    let position = &context.dem.storage().position;
    let now = match context.dem.cell() {
        None => flow.network().volumes_at(position, &context.dem.box_())?,
        Some(cell) => flow.network().volumes_in_cell(position, cell.cell())?,
    };
    Ok(now.iter().zip(&flow.network().volume).map(|(now, then)| now - then).collect())
}
