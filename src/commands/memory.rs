//! Does a run fit into the memory that there is?

use dempfv::scene::Plan;
use dempfv::simulation::{Estimate, Specimen};
use dempfv::{Error, InputError};
use dempfv_report::format::bytes;
use dempfv_report::memory::{Room, room};

/// Estimates are right within this factor.
const UNCERTAINTY: f64 = 2.0;
/// From this share of what there is on, it is tight.
const TIGHT: f64 = 0.8;

/// What a user should know of the memory that a plan takes, before it takes any.
///
/// # Errors
/// [`Error::Input`] where even half of the estimate does not fit.
pub fn check(plan: &Plan, specimen: &Specimen) -> Result<Option<String>, Error> {
    let Some(room) = room() else { return Ok(None) };
    let estimate = Estimate::of(plan, specimen)?.memory;
    if estimate > UNCERTAINTY * room.bytes {
        let remedy = "take fewer spheres, or a machine or a limit with more memory";
        return Err(InputError::new(words(estimate, room), remedy).into());
    }
    Ok(tight(estimate, room))
}

/// A warning where an estimate comes close to what there is, or where a run would be refused.
pub fn tight(estimate: f64, room: Room) -> Option<String> {
    let consequence = if estimate > UNCERTAINTY * room.bytes {
        "it is refused here"
    } else if estimate > TIGHT * room.bytes {
        "it may run out of memory"
    } else {
        return None;
    };
    Some(format!("{}: {consequence}", words(estimate, room)))
}

fn words(estimate: f64, Room { bytes: left, bound }: Room) -> String {
    format!("the run takes about {} of memory, and {} are {bound}", bytes(estimate), bytes(left))
}
