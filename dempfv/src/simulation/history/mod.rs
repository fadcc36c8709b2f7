//! The history of a simulation: what its columns are, and their values between two steps.
//!
//! A new column is an entry in one of the groups, with its unit and its definition;
//! `docs/outputs.md` is written from them.

mod boundaries;
mod column;
mod energy;
mod error_control;
mod general;
mod material;

pub use column::{Column, Group};

use column::Seen;

use super::run::Simulation;
use crate::io::history::Value;
use crate::scene::Plan;

/// All columns that a history may have, in their order.
pub fn groups() -> impl Iterator<Item = &'static Group> {
    let parts = [general::GROUPS, boundaries::WALLS, energy::GROUPS];
    let more = [boundaries::WATCHED, boundaries::CELL, energy::MOTIONS, energy::BONDS];
    let last = [material::GROUPS, error_control::GROUPS];
    parts.into_iter().chain(more).chain(last).flatten()
}

/// Names of the columns that the history of a scene has.
pub fn columns(plan: &Plan) -> Vec<String> {
    groups().flat_map(|group| group.names(plan)).collect()
}

/// A row with the values of these columns, in the place of what `values` held before.
pub fn row<'a>(simulation: &'a Simulation, values: &mut Vec<Value<'a>>) {
    let seen = Seen::new(simulation);
    values.clear();
    for group in groups() {
        for k in 0..(group.labels)(simulation.plan()).len() {
            values.extend(group.columns.iter().map(|column| (column.of)(&seen, k)));
        }
    }
    for value in values {
        if let Value::Float(x) = value {
            // Sums of nothing are -0, which helps no reader.
            *x += 0.0;
        }
    }
}
