//! Columns of walls, of the periodic cell, and of places that are watched.

use super::column::{Column, Group, column, numbered, once, servo_walls};
use crate::WallId;

fn six() -> Vec<String> {
    WallId::ALL.map(|wall| wall.name().to_owned()).to_vec()
}

const ALWAYS: &str = "always; walls are x_min to z_max";

/// A group for each quantity, so that its six columns stand side by side.
const fn of_walls(columns: &'static [Column]) -> Group {
    Group { when: ALWAYS, columns, placeholder: Some("{wall}"), labels: |_| six() }
}

pub(super) static WALLS: &[Group] = &[
    of_walls(&[column(
        "contact_stress_{wall}_pa",
        "Pa",
        "Normal stress of the contacts on this wall, over its area; positive in compression.",
        |s, w| s.now.contact_stress[w].into(),
    )]),
    of_walls(&[column(
        "fluid_stress_{wall}_pa",
        "Pa",
        "Normal stress of the fluid on it, by excess pressures; positive where it presses \
         outwards. Both together are the total stress.",
        |s, w| s.now.fluid_stress[w].into(),
    )]),
    of_walls(&[column(
        "wall_displacement_{wall}_m",
        "m",
        "How far it has moved since the simulation began, positive towards larger coordinates.",
        |s, w| s.now.wall_displacement[w].into(),
    )]),
    of_walls(&[column(
        "flux_{wall}_m3_s",
        "m³/s",
        "Flow of fluid through it, positive into the box.",
        |s, w| s.now.flux[w].into(),
    )]),
];

pub(super) static WATCHED: &[Group] = &[
    Group {
        when: "`probes` in [output], numbered from 1 in their order",
        columns: &[column(
            "probe_{k}_pressure_pa",
            "Pa",
            "Excess pressure of the pore that contains the point, found anew with each \
         network; NaN while no flow is simulated, and where a wall has passed over the \
         point.",
            |s, k| s.simulation.coupled().probe_pressures().nth(k).unwrap_or(f64::NAN).into(),
        )],
        placeholder: Some("{k}"),
        labels: |plan| numbered(plan.output.probes.len()),
    },
    Group {
        when: "`probes` in [output], with a `density` in [fluid]",
        columns: &[column(
            "probe_{k}_total_pressure_pa",
            "Pa",
            "The same with the hydrostatic pressure at the point.",
            |s, k| s.simulation.coupled().probe_total_pressures().nth(k).unwrap_or(f64::NAN).into(),
        )],
        placeholder: Some("{k}"),
        labels: |plan| {
            let heavy = plan.fluid.as_ref().is_some_and(|fluid| fluid.effects.density.is_some());
            numbered(if heavy { plan.output.probes.len() } else { 0 })
        },
    },
    Group {
        when: "a servo holds this wall in some stage",
        columns: &[
            column(
                "lowest_stress_{wall}_pa",
                "Pa",
                "Lowest total stress on it of any step since the row before.",
                |s, k| s.simulation.stress_extremes()[s.servos[k]][0].into(),
            ),
            column("highest_stress_{wall}_pa", "Pa", "Highest.", |s, k| {
                s.simulation.stress_extremes()[s.servos[k]][1].into()
            }),
        ],
        placeholder: Some("{wall}"),
        labels: |plan| servo_walls(plan).iter().map(|wall| wall.name().to_owned()).collect(),
    },
];

const IN_CELL: &str = "[cell]";

pub(super) static CELL: &[Group] = &[
    Group {
        when: IN_CELL,
        columns: &[column(
            "cell_{edge}_m",
            "m",
            "Length of the edge a, b or c of the cell.",
            |s, k| s.now.cell.map_or(f64::NAN, |cell| cell.lengths[k]).into(),
        )],
        placeholder: Some("{edge}"),
        labels: |plan| in_cell(plan.cell.is_some(), &["a", "b", "c"]),
    },
    Group {
        when: IN_CELL,
        columns: &[column(
            "cell_{angle}_deg",
            "°",
            "Angle between two edges: alpha of b and c, beta of c and a, gamma of a and b.",
            |s, k| s.now.cell.map_or(f64::NAN, |cell| cell.angles[k].to_degrees()).into(),
        )],
        placeholder: Some("{angle}"),
        labels: |plan| in_cell(plan.cell.is_some(), &["alpha", "beta", "gamma"]),
    },
    Group {
        when: IN_CELL,
        columns: &[column(
            "cell_strain_{component}",
            "1",
            "∫ L dt since the simulation began, L_ab = ∂v_a/∂x_b, nine components xx to zz; \
         positive in extension.",
            |s, k| s.now.cell.map_or(f64::NAN, |cell| cell.strain[(k / 3, k % 3)]).into(),
        )],
        placeholder: Some("{component}"),
        labels: |plan| in_cell(plan.cell.is_some(), &COMPONENTS),
    },
    Group {
        when: IN_CELL,
        columns: &[column(
            "cell_stress_{component}_pa",
            "Pa",
            "Stress of contacts and motion, (Σ F ⊗ l + Σ m c ⊗ c) / V; positive in compression.",
            |s, k| s.now.cell.map_or(f64::NAN, |cell| cell.stress[(k / 3, k % 3)]).into(),
        )],
        placeholder: Some("{component}"),
        labels: |plan| in_cell(plan.cell.is_some(), &COMPONENTS),
    },
    Group {
        when: "[cell] with [fluid]",
        columns: &[column(
            "cell_fluid_velocity_{axis}_m_s",
            "m/s",
            "Mean velocity of the fluid in the cell, by volume of the cell: the flux per area.",
            |s, k| s.now.cell.map_or(f64::NAN, |cell| cell.fluid_velocity[k]).into(),
        )],
        placeholder: Some("{axis}"),
        labels: |plan| in_cell(plan.cell.is_some() && plan.fluid.is_some(), &["x", "y", "z"]),
    },
];

/// Components of a tensor, by rows.
const COMPONENTS: [&str; 9] = ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"];

fn in_cell(is_there: bool, labels: &[&str]) -> Vec<String> {
    once(is_there).iter().flat_map(|_| labels.iter().map(|&label| label.to_owned())).collect()
}
