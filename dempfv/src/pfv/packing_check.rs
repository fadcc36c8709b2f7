//! Refuses what no network can be built of or follow, before anything is computed.

use super::{Fluid, PfvError};
use crate::{Aabb, Cell, Vec3};

/// Distance of neighbouring coordinates over the smallest radius up to which a network has digits
/// enough: pores are a tenth of a radius wide and less.
const SPACING_PER_RADIUS: f64 = 1e-4;

/// Radius over the longest edge of the box up to which a sphere makes sense: the smallest one that
/// leaves no pore anywhere is below 1.
const RADIUS_PER_EDGE: f64 = 1e3;

/// Conductances (m³/(Pa·s)) that can be multiplied with each other's roots and with pressures.
const CONDUCTANCES: std::ops::RangeInclusive<f64> = 1e-230..=1e230;

/// Edges (m) whose sixth powers, as products of volumes have them, are numbers in double precision.
const EDGES: std::ops::RangeInclusive<f64> = 1e-50..=1e50;

/// Longest edge of a box over its shortest, up to which the walls of the triangulation have digits
/// enough for the thickness of the box.
const FLATTEST: f64 = 1e7;

/// Checks sphere centres, radii, the box and the fluid.
pub(super) fn check_packing(
    position: &[Vec3],
    radius: &[f64],
    bounds: &Aabb,
    fluid: &Fluid,
) -> Result<(), PfvError> {
    check_box(bounds)?;
    require_length("radius", radius.len(), position.len(), "positions")?;
    if let Some(index) = position.iter().position(|x| !bounds.contains(x)) {
        let [x, y, z] = position[index].into();
        let problem = format!("({x}, {y}, {z}) does not lie in the box");
        return Err(PfvError::invalid("position", index, problem));
    }
    if let Some(index) = radius.iter().position(|r| !is_positive(*r)) {
        let problem = format!("{} is not a positive length", radius[index]);
        return Err(PfvError::invalid("radius", index, problem));
    }
    check_scale(radius, bounds)?;
    check_fluid(fluid)?;
    let smallest = radius.iter().copied().fold(f64::INFINITY, f64::min);
    check_conductances(smallest, bounds.size().max(), fluid.viscosity)
}

/// Checks sphere centres, radii, a periodic cell and the fluid.
pub(super) fn check_packing_in_cell(
    position: &[Vec3],
    radius: &[f64],
    cell: &Cell,
    fluid: &Fluid,
) -> Result<(), PfvError> {
    let bounds = cell.bounds();
    check_box(&bounds)?;
    require_length("radius", radius.len(), position.len(), "positions")?;
    require_finite("position", position)?;
    if position.is_empty() {
        return Err(PfvError::NoSpheres);
    }
    if let Some(index) = radius.iter().position(|r| !is_positive(*r)) {
        let problem = format!("{} is not a positive length", radius[index]);
        return Err(PfvError::invalid("radius", index, problem));
    }
    check_scale(radius, &bounds)?;
    let lost = |x: &Vec3, r: &f64| x.amax() * f64::EPSILON > SPACING_PER_RADIUS * r;
    if let Some(index) = position.iter().zip(radius).position(|(x, r)| lost(x, r)) {
        let [x, y, z] = position[index].into();
        let problem = format!(
            "({x:e}, {y:e}, {z:e}) is so far from the cell that double precision has no digits left for the \
             pores; give a copy that is nearer"
        );
        return Err(PfvError::invalid("position", index, problem));
    }
    check_fluid(fluid)?;
    if let Some((wall, _)) = fluid.boundary.pressure.iter().find(|(_, p)| p.is_some()) {
        let problem = "there are no walls in a periodic cell; impose a pressure gradient";
        return Err(PfvError::invalid("fluid.boundary.pressure", wall.index(), problem));
    }
    let smallest = radius.iter().copied().fold(f64::INFINITY, f64::min);
    check_conductances(smallest, bounds.size().max(), fluid.viscosity)
}

/// Refuses a box that is none.
pub(super) fn check_box(bounds: &Aabb) -> Result<(), PfvError> {
    for axis in 0..3 {
        let (min, max) = (bounds.min[axis], bounds.max[axis]);
        if !is_positive(max - min) {
            let problem = format!("from {min} to {max} is not a box: the larger end comes last");
            return Err(PfvError::invalid("bounds", axis, problem));
        }
        if !EDGES.contains(&(max - min)) {
            let problem = format!(
                "an edge of {:e} m: its volumes are beyond double precision; choose another unit of length",
                max - min
            );
            return Err(PfvError::invalid("bounds", axis, problem));
        }
    }
    let (axis, shortest) = bounds.size().argmin();
    if bounds.size().max() > FLATTEST * shortest {
        let problem = format!(
            "{shortest:e} m beside an edge of {:e} m: in a box so flat the triangulation has no digits \
             for what lies between its walls; take one whose edges are less than 1e7 times each other",
            bounds.size().max()
        );
        return Err(PfvError::invalid("bounds", axis, problem));
    }
    Ok(())
}

/// Refuses spheres that have no digits in this box, or are too large for it.
fn check_scale(radius: &[f64], bounds: &Aabb) -> Result<(), PfvError> {
    let (spacing, edge) = (bounds.spacing(), bounds.size().max());
    if let Some(index) = radius.iter().position(|r| spacing > SPACING_PER_RADIUS * r) {
        let problem = format!(
            "{:e} m, but in this box neighbouring coordinates are {spacing:.1e} m apart in \
             double precision: the pores would have lost their digits; move the box to the origin, or \
             take a smaller box",
            radius[index]
        );
        return Err(PfvError::invalid("radius", index, problem));
    }
    if let Some(index) = radius.iter().position(|r| *r > RADIUS_PER_EDGE * edge) {
        let problem = format!(
            "{:e} m, {:.0e} times the box; give radii in the box's unit of length",
            radius[index],
            radius[index] / edge
        );
        return Err(PfvError::invalid("radius", index, problem));
    }
    Ok(())
}

/// Refuses a viscosity that leaves conductances, from r³/μ of the smallest sphere to that of the
/// box, no room in double precision.
fn check_conductances(radius: f64, edge: f64, viscosity: f64) -> Result<(), PfvError> {
    let (least, most) = (radius.powi(3) / viscosity, edge.powi(3) / viscosity);
    if radius.is_infinite() || (least >= *CONDUCTANCES.start() && most <= *CONDUCTANCES.end()) {
        return Ok(());
    }
    let problem = format!(
        "{viscosity:e} Pa·s makes conductances of {least:.0e} to {most:.0e} m³/(Pa·s), beyond what double \
         precision can solve with; choose other units"
    );
    Err(PfvError::InvalidInput { argument: "fluid.viscosity", index: None, problem })
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

/// Refuses an array that has not one entry for each of `expected` things.
pub(super) fn require_length(
    argument: &'static str,
    found: usize,
    expected: usize,
    things: &str,
) -> Result<(), PfvError> {
    if found == expected {
        return Ok(());
    }
    let problem = format!("has {found} entries for {expected} {things}");
    Err(PfvError::InvalidInput { argument, index: None, problem })
}

/// Refuses a vector that is not finite.
pub(super) fn require_finite(argument: &'static str, vectors: &[Vec3]) -> Result<(), PfvError> {
    match vectors.iter().position(|v| !v.iter().all(|c| c.is_finite())) {
        None => Ok(()),
        Some(index) => Err(PfvError::invalid(argument, index, "is not finite")),
    }
}

/// Refuses a tolerance that nothing or anything would meet.
pub(crate) fn check_tolerance(tolerance: f64) -> Result<(), PfvError> {
    if tolerance > 0.0 && tolerance < 1.0 {
        return Ok(());
    }
    let problem = format!("{tolerance} is no tolerance: it must be above 0 and below 1");
    Err(PfvError::InvalidInput { argument: "tolerance", index: None, problem })
}

fn is_positive(x: f64) -> bool {
    x > 0.0 && x.is_finite()
}

/// Refuses a time step (s) that is none.
pub(super) fn check_time_step(time_step: f64) -> Result<(), PfvError> {
    if time_step > 0.0 && time_step.is_finite() {
        return Ok(());
    }
    let problem = format!("{time_step} s; it must be positive and finite");
    Err(PfvError::InvalidInput { argument: "time_step", index: None, problem })
}
