//! Energy by cause, and what became of bonds.

use super::column::{Column, Group, Seen, column, once};
use crate::dem::EnergyBalance;
use crate::io::history::Value;
use crate::scene::Plan;

pub(super) static GROUPS: &[Group] = &[
    Group {
        when: "`energy = true` in [output], as by default; since the end of the last stage that grew spheres",
        columns: COLUMNS,
        placeholder: None,
        labels: |plan| once(plan.output.energy),
    },
    Group {
        when: "energy is tracked, with forces between neighbours in [fluid]",
        columns: FILMS,
        placeholder: None,
        labels: |plan| once(plan.output.energy && has_films(plan)),
    },
];

pub(super) static MOTIONS: &[Group] = &[Group {
    when: "energy is tracked, with [[motion]]",
    columns: &[column(
        "motion_work_j",
        "J",
        "Work of given motions on the other spheres.",
        |s, _| term(s, |b| b.motion_work),
    )],
    placeholder: None,
    labels: |plan| once(plan.output.energy && !plan.motions.is_empty()),
}];

/// Whether the fluid of a plan acts between neighbours.
fn has_films(plan: &Plan) -> bool {
    plan.fluid.as_ref().is_some_and(|fluid| fluid.effects.edges.any())
}

pub(super) static BONDS: &[Group] = &[Group {
    when: "[bonds]",
    columns: BONDED,
    placeholder: None,
    labels: |plan| once(plan.bonds.is_some()),
}];

/// NaN while it is not tracked.
fn term(seen: &Seen, of: fn(&EnergyBalance) -> f64) -> Value<'static> {
    seen.energy.as_ref().map_or(f64::NAN, of).into()
}

static COLUMNS: &[Column] = &[
    column("gravity_energy_j", "J", "−Σ m g·x: 0 at the origin.", |s, _| {
        term(s, |b| b.gravity)
    }),
    column("friction_loss_j", "J", "What slip against friction has dissipated.", |s, _| {
        term(s, |b| b.friction)
    }),
    column("contact_damping_loss_j", "J", "What dashpots in contacts have dissipated.", |s, _| {
        term(s, |b| b.contact_damping)
    }),
    column(
        "rolling_loss_j",
        "J",
        "What rolling and twisting resistance have dissipated.",
        |s, _| term(s, |b| b.rolling),
    ),
    column("breakage_loss_j", "J", "What was stored in bonds that broke.", |s, _| {
        term(s, |b| b.breakage)
    }),
    column(
        "touch_change_loss_j",
        "J",
        "Lost by steps across which bodies begin or cease to touch; negative where made.",
        |s, _| term(s, |b| b.touch_change),
    ),
    column(
        "turning_loss_j",
        "J",
        "Lost by steps in which contacts turn, since springs follow the directions after each step and \
         forces act along those before it, too; negative where made. 0 without `energy_turning`.",
        |s, _| term(s, |b| b.turning),
    ),
    column(
        "step_change_loss_j",
        "J",
        "Lost where a time step is shorter than the one before, made where it is longer.",
        |s, _| term(s, |b| b.step_change),
    ),
    column("local_damping_loss_j", "J", "What local damping has dissipated.", |s, _| {
        term(s, |b| b.local_damping)
    }),
    column("fluid_work_j", "J", "Work of the fluid's forces on the spheres.", |s, _| {
        term(s, |b| b.fluid_work)
    }),
    column("wall_work_j", "J", "Work of the walls on the spheres.", |s, _| {
        term(s, |b| b.wall_work)
    }),
    column("cell_work_j", "J", "Work of the motion of a periodic cell on the spheres.", |s, _| {
        term(s, |b| b.cell_work)
    }),
    column(
        "energy_residual_j",
        "J",
        "Energy without a cause: made by time integration, lost where negative.",
        |s, _| term(s, |b| b.residual),
    ),
];

static FILMS: &[Column] = &[
    column(
        "viscous_shear_loss_j",
        "J",
        "What viscous shear between neighbours has dissipated.",
        |s, _| term(s, |b| b.viscous_shear),
    ),
    column("normal_lubrication_loss_j", "J", "What normal lubrication has.", |s, _| {
        term(s, |b| b.normal_lubrication)
    }),
    column("shear_lubrication_loss_j", "J", "What shear lubrication has.", |s, _| {
        term(s, |b| b.shear_lubrication)
    }),
    column("pump_torque_loss_j", "J", "What pump torques have.", |s, _| term(s, |b| b.pump_torque)),
    column("twist_torque_loss_j", "J", "What twist torques have.", |s, _| {
        term(s, |b| b.twist_torque)
    }),
    column("film_energy_j", "J", "What the springs in series with films store now.", |s, _| {
        term(s, |b| b.film_elastic)
    }),
];

static BONDED: &[Column] = &[
    column("intact_bonds", "1", "Bonds that hold.", |s, _| {
        s.simulation.coupled().dem().intact_bonds().into()
    }),
    column("broken_bonds", "1", "Bonds that have broken.", |s, _| {
        s.simulation.coupled().dem().broken_bonds().into()
    }),
];
