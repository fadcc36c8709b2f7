//! What a run has chosen to keep to an error, and the estimate of it.

use super::column::{Column, Group, Seen, column, once};
use crate::io::history::Value;
use crate::simulation::error_control::ErrorControl;
use crate::simulation::error_estimate::ErrorEstimate;

pub(super) static GROUPS: &[Group] = &[Group {
    when: "[accuracy]; not a number before the first step with fluid",
    columns: COLUMNS,
    placeholder: None,
    labels: |plan| once(plan.accuracy.is_some()),
}];

fn chosen(seen: &Seen, of: fn(&ErrorControl) -> f64) -> Value<'static> {
    let began = seen.simulation.error_control().filter(|control| control.has_begun());
    began.map_or(f64::NAN, of).into()
}

fn estimated(seen: &Seen, of: fn(&ErrorEstimate) -> f64) -> Value<'static> {
    seen.simulation.error_estimate().as_ref().map_or(f64::NAN, of).into()
}

static COLUMNS: &[Column] = &[
    column(
        "time_step_share",
        "1",
        "The time step over the largest stable one, as chosen.",
        |s, _| chosen(s, ErrorControl::share),
    ),
    column(
        "remesh_strain",
        "1",
        "The change of a pore's volume at which the network is renewed, as chosen.",
        |s, _| chosen(s, ErrorControl::strain),
    ),
    column(
        "estimated_error",
        "1",
        "Estimated error of the pore pressures of the run so far: root of the mean square over spheres and \
         time, beside that of the pressures.",
        |s, _| estimated(s, |e| e.total),
    ),
    column("estimated_network_error", "1", "Of that, by the age of networks.", |s, _| {
        estimated(s, |e| e.network)
    }),
    column("estimated_time_step_error", "1", "Of that, by the length of the steps.", |s, _| {
        estimated(s, |e| e.time_step)
    }),
];
