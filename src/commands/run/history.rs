//! The columns of `history.csv`.

use dempfv::WallId;
use dempfv::coupling::TimeStepBounds;
use dempfv::dem::{EnergyBalance, WallControl};
use dempfv::io::history::Value;
use dempfv::scene::{Plan, StageKind};
use dempfv::simulation::Simulation;

/// Names of the columns, with units; six per-wall columns follow each of the
/// per-wall quantities, then energy by cause where it is tracked, then one for each of the plan's
/// probes, then the lowest and the highest stress on each of the `servos` of any step since the row
/// before, then those of a periodic cell and of bonds, where there are any.
pub fn columns(plan: &Plan, servos: &[WallId]) -> Vec<String> {
    let output = &plan.output;
    let mut names: Vec<String> = [
        "step",
        "time_s",
        "stage",
        "dt_s",
        "dt_contact_s",
        "dt_viscous_s",
        "dt_viscous_estimate_s",
        "size_x_m",
        "size_y_m",
        "size_z_m",
        "porosity",
        "contacts",
        "coordination_number",
        "unbalanced_force",
        "kinetic_energy_j",
        "elastic_energy_j",
        "largest_pressure_pa",
        "mean_pressure_pa",
        "network_age",
        "remeshes",
        "failed_remeshes",
        "remesh_interval",
        "background_s",
        "steps_per_s",
    ]
    .map(str::to_owned)
    .to_vec();
    for (quantity, unit) in [
        ("contact_stress", "pa"),
        ("fluid_stress", "pa"),
        ("wall_displacement", "m"),
        ("flux", "m3_s"),
    ] {
        names.extend(WallId::ALL.map(|w| format!("{quantity}_{w}_{unit}")));
    }
    if output.energy {
        names.extend(ENERGY.map(|(name, _)| name.to_owned()));
        if has_films(plan) {
            names.extend(FILMS.map(|(name, _)| name.to_owned()));
        }
    }
    names.extend((1..=output.probes.len()).map(|k| format!("probe_{k}_pressure_pa")));
    names.extend(
        servos
            .iter()
            .flat_map(|wall| ["lowest", "highest"].map(|end| format!("{end}_stress_{wall}_pa"))),
    );
    if plan.cell.is_some() {
        names.extend(["a", "b", "c"].map(|edge| format!("cell_{edge}_m")));
        names.extend(["alpha", "beta", "gamma"].map(|angle| format!("cell_{angle}_deg")));
        names.extend(COMPONENTS.map(|of| format!("cell_strain_{of}")));
        names.extend(COMPONENTS.map(|of| format!("cell_stress_{of}_pa")));
        if plan.fluid.is_some() {
            names.extend(["x", "y", "z"].map(|axis| format!("cell_fluid_velocity_{axis}_m_s")));
        }
    }
    if plan.output.energy && !plan.motions.is_empty() {
        names.push("motion_work_j".to_owned());
    }
    if plan.bonds.is_some() {
        names.extend(["intact_bonds", "broken_bonds"].map(str::to_owned));
    }
    names
}

/// A term of the energy balance (J).
type EnergyTerm = fn(&EnergyBalance) -> f64;

/// Energy by cause, beside the kinetic and the elastic energy.
const ENERGY: [(&str, EnergyTerm); 11] = [
    ("gravity_energy_j", |b| b.gravity),
    ("friction_loss_j", |b| b.friction),
    ("contact_damping_loss_j", |b| b.contact_damping),
    ("rolling_loss_j", |b| b.rolling),
    ("breakage_loss_j", |b| b.breakage),
    ("touch_change_loss_j", |b| b.touch_change),
    ("local_damping_loss_j", |b| b.local_damping),
    ("fluid_work_j", |b| b.fluid_work),
    ("wall_work_j", |b| b.wall_work),
    ("cell_work_j", |b| b.cell_work),
    ("energy_residual_j", |b| b.residual),
];

/// What the fluid between neighbours took, where it acts on them.
const FILMS: [(&str, EnergyTerm); 6] = [
    ("viscous_shear_loss_j", |b| b.viscous_shear),
    ("normal_lubrication_loss_j", |b| b.normal_lubrication),
    ("shear_lubrication_loss_j", |b| b.shear_lubrication),
    ("pump_torque_loss_j", |b| b.pump_torque),
    ("twist_torque_loss_j", |b| b.twist_torque),
    ("film_energy_j", |b| b.film_elastic),
];

/// Whether the fluid of a plan acts between neighbours.
fn has_films(plan: &Plan) -> bool {
    plan.fluid.as_ref().is_some_and(|fluid| fluid.effects.edges.any())
}

/// Components of a tensor, by rows.
const COMPONENTS: [&str; 9] = ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"];

/// The walls that a servo holds in any stage of a plan.
pub fn servo_walls(plan: &Plan) -> Vec<WallId> {
    let held = |wall: WallId| {
        plan.stages.iter().any(|stage| match &stage.kind {
            StageKind::Run(run) => matches!(run.walls[wall], WallControl::Servo { .. }),
            StageKind::Consolidate(stage) => stage.wall == wall,
            StageKind::Cycle(stage) => stage.wall == wall,
            StageKind::Compact(_) | StageKind::Permeability(_) | StageKind::Flow(_) => false,
        })
    };
    WallId::ALL.into_iter().filter(|&wall| held(wall)).collect()
}

/// One row: the state between two steps.
pub fn row<'a>(simulation: &'a Simulation, servos: &[WallId], values: &mut Vec<Value<'a>>) {
    let seen = simulation.observe();
    values.clear();
    values.push(simulation.step().into());
    values.push(simulation.time().into());
    values.push(simulation.last_stage().into());
    values.push(simulation.dt().into());
    let bounds = simulation.time_step_bounds();
    let bound = |pick: fn(TimeStepBounds) -> Option<f64>| bounds.and_then(pick).unwrap_or(f64::NAN);
    values.push(bound(|b| Some(b.contact)).into());
    values.push(bound(|b| b.viscous).into());
    values.push(bound(|b| b.viscous_estimate).into());
    values.extend(seen.size.map(Value::from));
    values.push(seen.porosity.into());
    values.push((seen.contacts as u64).into());
    values.extend(
        [seen.coordination_number, seen.unbalanced_force, seen.kinetic_energy, seen.elastic_energy]
            .map(Value::from),
    );
    values.extend([seen.largest_pressure, seen.mean_pressure].map(Value::from));
    values.push(simulation.coupled().network_age().into());
    values.push(simulation.remeshes().into());
    values.push(simulation.coupled().remesh_counts().failures.into());
    // What an automatic interval follows from; the times are 0 for a given one.
    let trail = simulation.coupled().interval_trail();
    values.push(trail.interval.unwrap_or(0).into());
    values.extend([trail.background_s, trail.steps_per_s].map(Value::from));
    for six in [seen.contact_stress, seen.fluid_stress, seen.wall_displacement, seen.flux] {
        values.extend(six.map(Value::from));
    }
    if simulation.plan().output.energy {
        let balance = simulation.coupled().dem().energy_balance();
        let term = |of: EnergyTerm| balance.as_ref().map_or(f64::NAN, of);
        values.extend(ENERGY.map(|(_, of)| Value::from(term(of))));
        if has_films(simulation.plan()) {
            values.extend(FILMS.map(|(_, of)| Value::from(term(of))));
        }
    }
    values.extend(simulation.coupled().probe_pressures().map(Value::from));
    let extremes = simulation.stress_extremes();
    values.extend(servos.iter().flat_map(|&wall| extremes[wall].map(Value::from)));
    if let Some(cell) = seen.cell {
        values.extend(cell.lengths.map(Value::from));
        values.extend(cell.angles.map(|angle| Value::from(angle.to_degrees())));
        for tensor in [cell.strain, cell.stress] {
            values.extend(tensor.transpose().iter().map(|&x| Value::from(x)));
        }
        if simulation.plan().fluid.is_some() {
            values.extend(cell.fluid_velocity.iter().map(|&u| Value::from(u)));
        }
    }
    if simulation.plan().output.energy && !simulation.plan().motions.is_empty() {
        let balance = simulation.coupled().dem().energy_balance();
        values.push(balance.map_or(f64::NAN, |b| b.motion_work).into());
    }
    if simulation.plan().bonds.is_some() {
        let dem = simulation.coupled().dem();
        values.extend([dem.intact_bonds(), dem.broken_bonds()].map(Value::from));
    }
    for value in values {
        if let Value::Float(x) = value {
            // Sums of nothing are -0, which helps no reader.
            *x += 0.0;
        }
    }
}
