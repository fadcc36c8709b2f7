//! The state of the material: strains, effective stress, pore pressure, fabric, parts of the box.

use super::column::{Column, Group, Seen, column, numbered, once};
use crate::io::history::Value;
use crate::{Axis, Tensor, deviatoric_stress, mean_stress};

const STATE: &str = "`state = true` in [output]";

pub(super) static GROUPS: &[Group] = &[
    Group {
        when: STATE,
        columns: COLUMNS,
        placeholder: None,
        labels: |plan| once(plan.output.state),
    },
    Group {
        when: STATE,
        columns: &[column(
            "effective_stress_{component}_pa",
            "Pa",
            "σ' = Σ F ⊗ l / V over all contacts, F the force on the partner, l the way to it, \
         V the box or the cell; components xx, yy, zz, xy, xz, yz, of the mean of σ'_ab \
         and σ'_ba; positive in compression.",
            |s, k| component(s.fabric.map(|f| f.stress), k),
        )],
        placeholder: Some("{component}"),
        labels: symmetric,
    },
    Group {
        when: STATE,
        columns: &[column(
            "fabric_{component}",
            "1",
            "Σ n ⊗ n / N_c over the contacts of two spheres, n their unit normals; its trace \
         is 1, and 1/3 each where they point anywhere.",
            |s, k| component(s.fabric.map(|f| f.fabric), k),
        )],
        placeholder: Some("{component}"),
        labels: symmetric,
    },
    Group {
        when: "`regions` in [output], numbered from 1 in their order",
        columns: &[
            column(
                "region_{k}_porosity",
                "1",
                "Share of the region that no sphere fills, spheres cut at its faces, of the part \
         that lies between the walls; overlaps count twice as solid.",
                |s, k| {
                    s.simulation
                        .coupled()
                        .dem()
                        .porosity_within(&s.simulation.plan().output.regions[k])
                        .into()
                },
            ),
            column(
                "region_{k}_pressure_pa",
                "Pa",
                "Mean excess pressure by volume of the pores whose centroid lies in it; NaN while \
         no flow is simulated.",
                |s, k| {
                    s.simulation
                        .coupled()
                        .mean_pressure_within(&s.simulation.plan().output.regions[k])
                        .into()
                },
            ),
        ],
        placeholder: Some("{k}"),
        labels: |plan| numbered(plan.output.regions.len()),
    },
];

static COLUMNS: &[Column] = &[
    column(
        "strain_x",
        "1",
        "ln(L₀/L) along x since the simulation began, L the length of the box; −∫ L_xx dt \
         of a periodic cell; positive in compression. Strains of a stage are differences \
         to its first row.",
        |s, _| strain(s, Axis::X).into(),
    ),
    column("strain_y", "1", "Along y.", |s, _| strain(s, Axis::Y).into()),
    column("strain_z", "1", "Along z.", |s, _| strain(s, Axis::Z).into()),
    column(
        "volumetric_strain",
        "1",
        "ε_v, the sum of the three: ln(V₀/V); positive where the volume shrinks.",
        |s, _| [Axis::X, Axis::Y, Axis::Z].map(|axis| strain(s, axis)).iter().sum::<f64>().into(),
    ),
    column(
        "p_effective_pa",
        "Pa",
        "p' = tr σ' / 3, mean effective stress; positive in compression.",
        |s, _| s.fabric.map_or(f64::NAN, |f| mean_stress(&f.stress)).into(),
    ),
    column(
        "q_pa",
        "Pa",
        "q = √(3/2 s:s), s the deviator of σ'; |σ₁ − σ₃| in a triaxial test; never \
         negative.",
        |s, _| s.fabric.map_or(f64::NAN, |f| deviatoric_stress(&f.stress)).into(),
    ),
    column(
        "smallest_pressure_pa",
        "Pa",
        "Smallest excess pore pressure of all pores; 0 where no flow is simulated.",
        |s, _| s.simulation.coupled().smallest_pressure().into(),
    ),
    column(
        "coordination_number_spheres",
        "1",
        "2 N_c / N: without walls, rattlers counted.",
        |s, _| s.fabric.map_or(f64::NAN, |f| f.without_walls).into(),
    ),
    column(
        "coordination_number_mechanical",
        "1",
        "(2 N_c + N_w − N₁) / (N − N₀ − N₁), N₀ and N₁ spheres with no contact and with \
         one: of spheres that carry (Thornton 2000).",
        |s, _| s.fabric.map_or(f64::NAN, |f| f.mechanical).into(),
    ),
    column("rattlers", "1", "N₀ + N₁.", |s, _| {
        s.fabric.map_or(0, |f| f.rattlers as u64).into()
    }),
];

fn strain(seen: &Seen, axis: Axis) -> f64 {
    let k = axis.index();
    if let Some(cell) = seen.now.cell {
        return -cell.strain[(k, k)];
    }
    let (size, moved) = (seen.now.size[k], seen.now.wall_displacement);
    let before = size - (moved[2 * k + 1] - moved[2 * k]);
    (before / size).ln()
}

fn symmetric(plan: &crate::scene::Plan) -> Vec<String> {
    let names = ["xx", "yy", "zz", "xy", "xz", "yz"].map(str::to_owned);
    if plan.output.state { names.to_vec() } else { vec![] }
}

fn component(tensor: Option<Tensor>, k: usize) -> Value<'static> {
    let (a, b) = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)][k];
    tensor.map_or(f64::NAN, |t| 0.5 * (t[(a, b)] + t[(b, a)])).into()
}
