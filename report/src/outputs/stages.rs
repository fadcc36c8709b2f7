//! Keys of `summary.json` for what each kind of stage has found out.

use super::{Entry, entry};

pub(super) static KEYS: &[Entry] = &[
    entry(
        "stages[].compact.stress_pa",
        "Pa",
        "Mean stress of the six walls, or of the cell; positive in compression.",
    ),
    entry("stages[].compact.unbalanced_force", "1", "Unbalanced force, as in the history."),
    entry("stages[].compact.porosity", "1", "Porosity."),
    entry("stages[].compact.coordination_number", "1", "Contacts per sphere, walls included."),
    entry("stages[].cycle.wall", "", "The wall that was loaded."),
    entry(
        "stages[].cycle.modulus_pa",
        "Pa",
        "Secant modulus of the last loading, Δσ/Δε: the oedometric modulus.",
    ),
    entry("stages[].cycle.unloading_modulus_pa", "Pa", "Of the last unloading."),
    entry(
        "stages[].cycle.strain[]",
        "1",
        "Logarithmic strain at the end of each half cycle; positive in compression.",
    ),
    entry("stages[].cycle.stress_pa[]", "Pa", "Stress on the wall there."),
    entry(
        "stages[].cycle.wall_layer_settlement[]",
        "1",
        "Share of the last loading's settlement in the pores at the lower and the upper wall of the axis; \
         null without a fluid.",
    ),
    entry("stages[].permeability.axis", "", "`x`, `y` or `z`."),
    entry(
        "stages[].permeability.slip_walls",
        "",
        "Whether the fluid slips along the four walls beside the flow in it; null in a periodic cell, as the next three.",
    ),
    entry("stages[].permeability.slip_permeability_m2", "m²", "k where it slips."),
    entry("stages[].permeability.no_slip_permeability_m2", "m²", "k where it does not."),
    entry(
        "stages[].permeability.core_permeability_m2",
        "m²",
        "k farther than a Sauter diameter from every wall, without the looser layers \
         there: flux per area through nine planes over the slope of the pressures; null \
         where nothing is so far.",
    ),
    entry(
        "stages[].permeability.kozeny_carman_constant",
        "1",
        "The 180 in it, 36 · 5 (Carman 1937).",
    ),
    entry("stages[].permeability.sauter_diameter_m", "m", "d in it, Σ d³ / Σ d²."),
    entry(
        "stages[].permeability.permeability_m2",
        "m²",
        "k = μ Q L / (A Δp) of the whole box, with the scene's `slip_walls`.",
    ),
    entry(
        "stages[].permeability.flux_m3_s",
        "m³/s",
        "Flow Q at Δp = 1 Pa across the box, positive towards larger coordinates.",
    ),
    entry("stages[].permeability.imbalance", "1", "What enters less what leaves, over Q."),
    entry(
        "stages[].permeability.kozeny_carman_m2",
        "m²",
        "n³ d² / (180 (1 − n)²), d Sauter's diameter Σ d³ / Σ d².",
    ),
    entry("stages[].permeability.porosity", "1", "Porosity n of the box."),
    entry("stages[].permeability.pores", "1", "Pores of the network."),
    entry("stages[].permeability.unknowns", "1", "Unknown pressures."),
    entry("stages[].permeability.residual", "1", "Residual of the solve."),
    entry(
        "stages[].permeability.tensor_m2[][]",
        "m²",
        "The whole tensor of a periodic cell, by rows; null between walls.",
    ),
    entry("stages[].flow.flux_m3_s[]", "m³/s", "Flux into the box through each of the six walls."),
    entry("stages[].flow.imposed_flux_m3_s[]", "m³/s", "And from the pores of each `imposed`."),
    entry("stages[].flow.mean_pressure_pa", "Pa", "Mean excess pressure of the pores, by volume."),
    entry("stages[].flow.force_n[]", "N", "Force of the fluid on all spheres together."),
    entry("stages[].flow.wall_force_n[][]", "N", "And on each of the six walls."),
    entry(
        "stages[].flow.imbalance",
        "1",
        "What enters less what leaves or is stored, over the flux.",
    ),
    entry("stages[].flow.pores", "1", "Pores of the network."),
    entry("stages[].flow.unknowns", "1", "Unknown pressures."),
    entry("stages[].consolidate.wall", "", "The loaded wall."),
    entry("stages[].consolidate.load_pa", "Pa", "Stress that was added."),
    entry("stages[].consolidate.height_m", "m", "Height H of the layer at the start."),
    entry("stages[].consolidate.drained_walls[]", "", "Walls that drain, the loaded one first."),
    entry("stages[].consolidate.drainage_path_m", "m", "The longest way out d: H, or half of it."),
    entry("stages[].consolidate.modulus_pa", "Pa", "Oedometric modulus E measured before."),
    entry("stages[].consolidate.permeability_m2", "m²", "Permeability k measured before."),
    entry("stages[].consolidate.c_v_m2_s", "m²/s", "Coefficient of consolidation k E / μ."),
    entry("stages[].consolidate.final_settlement_m", "m", "H (1 − exp(−Δσ/E))."),
    entry(
        "stages[].consolidate.drained_share",
        "1",
        "Share of the height in pores at a drained wall, whose pressure is imposed.",
    ),
    entry(
        "stages[].consolidate.sealed_share",
        "1",
        "Share of the height in pores at a sealed end; 0 where both ends drain.",
    ),
    entry(
        "stages[].consolidate.drained_settlement",
        "1",
        "Share of the settlement in the pores at a drained wall, by the load cycles.",
    ),
    entry("stages[].consolidate.sealed_settlement", "1", "The same at a sealed end."),
    entry("stages[].consolidate.samples[].time_factor", "1", "T_v = c_v t / d²."),
    entry("stages[].consolidate.samples[].settlement_m", "m", "Settlement, positive inwards."),
    entry("stages[].consolidate.samples[].degree", "1", "Settlement over the final one."),
    entry(
        "stages[].consolidate.samples[].base_pressure",
        "1",
        "Excess pressure farthest from where fluid leaves, over the load.",
    ),
    entry("stages[].consolidate.profiles[].time_factor", "1", "T_v of a profile."),
    entry(
        "stages[].consolidate.profiles[].depth[]",
        "1",
        "Distance of a slab's middle from the drained wall over H.",
    ),
    entry(
        "stages[].consolidate.profiles[].pressure[]",
        "1",
        "Its mean excess pressure over the load.",
    ),
    entry(
        "stages[].run.strain[]",
        "1",
        "Logarithmic strain since the stage's start along x, y, z; positive in \
         compression.",
    ),
    entry(
        "stages[].run.cell.strain[][]",
        "1",
        "∫ L dt since then, by rows; positive in extension. `cell` is null between walls.",
    ),
    entry(
        "stages[].run.cell.stress_pa[][]",
        "Pa",
        "Stress of the cell, by rows; positive in compression.",
    ),
    entry("stages[].run.cell.porosity", "1", "Porosity of the cell."),
    entry(
        "stages[].run.wall_stress_pa[]",
        "Pa",
        "Total stress on each wall at the end, x_min to z_max; positive in compression.",
    ),
    entry("stages[].run.unbalanced_force", "1", "Unbalanced force at the end."),
    entry("stages[].run.samples[].time_s", "s", "Time since the stage's start."),
    entry("stages[].run.samples[].strain[]", "1", "Strain, as above."),
    entry(
        "stages[].run.samples[].stress_pa[]",
        "Pa",
        "Total stress along x, y, z: mean of two walls, or of the cell.",
    ),
    entry(
        "stages[].run.samples[].mean_pressure_pa",
        "Pa",
        "Mean excess pore pressure by volume; 0 where no flow is simulated.",
    ),
    entry("stages[].run.samples[].cell.strain[][]", "1", "As above."),
    entry("stages[].run.samples[].cell.stress_pa[][]", "Pa", "As above."),
    entry("stages[].run.samples[].cell.porosity", "1", "As above."),
];
