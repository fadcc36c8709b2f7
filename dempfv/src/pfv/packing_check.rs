//! Refuses what no network can be built of, before anything is computed.

use super::{Fluid, PfvError};
use crate::{Aabb, Vec3};

/// Checks sphere centres, radii, the box and the fluid.
pub(super) fn check_packing(
    position: &[Vec3],
    radius: &[f64],
    bounds: &Aabb,
    fluid: &Fluid,
) -> Result<(), PfvError> {
    check_box(bounds)?;
    if radius.len() != position.len() {
        let problem = format!("has {} entries for {} positions", radius.len(), position.len());
        return Err(PfvError::InvalidInput { argument: "radius", index: None, problem });
    }
    if let Some(index) = position.iter().position(|x| !bounds.contains(x)) {
        let [x, y, z] = position[index].into();
        let problem = format!("({x}, {y}, {z}) does not lie in the box");
        return Err(PfvError::invalid("position", index, problem));
    }
    if let Some(index) = radius.iter().position(|r| !is_positive(*r)) {
        let problem = format!("{} is not a positive length", radius[index]);
        return Err(PfvError::invalid("radius", index, problem));
    }
    check_fluid(fluid)
}

fn check_box(bounds: &Aabb) -> Result<(), PfvError> {
    let is_length = |axis: &usize| is_positive(bounds.max[*axis] - bounds.min[*axis]);
    match (0..3).find(|axis| !is_length(axis)) {
        None => Ok(()),
        Some(axis) => {
            let (min, max) = (bounds.min[axis], bounds.max[axis]);
            let problem = format!("from {min} to {max} is not a box: the larger end comes last");
            Err(PfvError::invalid("bounds", axis, problem))
        }
    }
}

fn check_fluid(fluid: &Fluid) -> Result<(), PfvError> {
    if !is_positive(fluid.viscosity) {
        let problem = format!("{} is not a positive viscosity", fluid.viscosity);
        return Err(PfvError::InvalidInput { argument: "fluid.viscosity", index: None, problem });
    }
    for (wall, pressure) in fluid.boundary.pressure.iter() {
        if let Some(p) = pressure.filter(|p| !p.is_finite()) {
            let problem = format!("{p} at {wall} is not a pressure");
            return Err(PfvError::invalid("fluid.boundary.pressure", wall.index(), problem));
        }
    }
    Ok(())
}

fn is_positive(x: f64) -> bool {
    x > 0.0 && x.is_finite()
}
