//! Columns that every history has.

use super::column::{Column, Group, Seen, column, once};
use crate::coupling::TimeStepBounds;

pub(super) static GROUPS: &[Group] =
    &[Group { when: "always", columns: COLUMNS, placeholder: None, labels: |_| once(true) }];

fn bound(seen: &Seen, pick: fn(TimeStepBounds) -> Option<f64>) -> f64 {
    seen.simulation.time_step_bounds().and_then(pick).unwrap_or(f64::NAN)
}

static COLUMNS: &[Column] = &[
    column(
        "step",
        "1",
        "Steps since the simulation began, those before a restart included.",
        |s, _| s.simulation.step().into(),
    ),
    column(
        "time_s",
        "s",
        "Model time since then. Positions are of this time, and what is counted or summed over \
         contacts with them; stresses on walls and pressures are those of the last step, which began dt \
         before; velocities are of dt/2 before.",
        |s, _| s.simulation.time().into(),
    ),
    column("stage", "", "Name of the stage that did the last step.", |s, _| {
        s.simulation.last_stage().into()
    }),
    column("dt_s", "s", "Length of the last step.", |s, _| s.simulation.dt().into()),
    column(
        "dt_contact_s",
        "s",
        "Bound by the contacts' stiffness that an automatic time step was last chosen by; \
         NaN with a fixed one.",
        |s, _| bound(s, |b| Some(b.contact)).into(),
    ),
    column(
        "dt_viscous_s",
        "s",
        "Bound by the fluid's viscosity, from the fastest viscous mode of the network; \
         NaN without a fluid.",
        |s, _| bound(s, |b| b.viscous).into(),
    ),
    column("dt_viscous_estimate_s", "s", "The same by eq. A.11 of Caulk et al. (2020).", |s, _| {
        bound(s, |b| b.viscous_estimate).into()
    }),
    column(
        "size_x_m",
        "m",
        "Length of the box along x, from wall to wall; of the box around a periodic cell.",
        |s, _| s.now.size[0].into(),
    ),
    column("size_y_m", "m", "Along y.", |s, _| s.now.size[1].into()),
    column("size_z_m", "m", "Along z.", |s, _| s.now.size[2].into()),
    column(
        "porosity",
        "1",
        "1 − Σ 4/3 π r³ / V, V the box or the cell; overlaps count twice as solid.",
        |s, _| s.now.porosity.into(),
    ),
    column(
        "contacts",
        "1",
        "Contacts that carry force, N_c of two spheres and N_w of spheres with walls.",
        |s, _| (s.now.contacts as u64).into(),
    ),
    column(
        "coordination_number",
        "1",
        "(2 N_c + N_w) / N, N spheres: walls and rattlers counted.",
        |s, _| s.now.coordination_number.into(),
    ),
    column(
        "unbalanced_force",
        "1",
        "Mean magnitude of what contacts, gravity and fluid leave on a sphere, over the \
         mean magnitude of a contact force; 0 without contacts.",
        |s, _| s.now.unbalanced_force.into(),
    ),
    column(
        "kinetic_energy_j",
        "J",
        "Σ ½ m v² + ½ I ω²; in a periodic cell of velocities relative to its mean field.",
        |s, _| s.now.kinetic_energy.into(),
    ),
    column("elastic_energy_j", "J", "Energy that the contacts store, by their law.", |s, _| {
        s.now.elastic_energy.into()
    }),
    column(
        "largest_pressure_pa",
        "Pa",
        "Largest excess pore pressure of all pores; 0 where no flow is simulated.",
        |s, _| s.now.largest_pressure.into(),
    ),
    column(
        "mean_pressure_pa",
        "Pa",
        "Mean excess pore pressure, pores weighted by their volumes, solids included.",
        |s, _| s.now.mean_pressure.into(),
    ),
    column(
        "network_age",
        "1",
        "Steps since the positions that the pore network was built from.",
        |s, _| s.simulation.coupled().network_age().into(),
    ),
    column("remeshes", "1", "Networks that came into use since the simulation began.", |s, _| {
        s.simulation.remeshes().into()
    }),
    column(
        "failed_remeshes",
        "1",
        "Networks that could not be built, where the old one stayed; since the last \
         restart.",
        |s, _| s.simulation.coupled().remesh_counts().failures.into(),
    ),
    column(
        "remesh_interval",
        "1",
        "Steps from one network to the next; 0 where there is no interval.",
        |s, _| s.simulation.coupled().interval_trail().interval.unwrap_or(0).into(),
    ),
    column(
        "background_s",
        "s",
        "Time that the last network took in the background; 0 unless the interval follows \
         from it.",
        |s, _| s.simulation.coupled().interval_trail().background_s.into(),
    ),
    column("steps_per_s", "1/s", "Steps in a second of the clock, likewise.", |s, _| {
        s.simulation.coupled().interval_trail().steps_per_s.into()
    }),
];
