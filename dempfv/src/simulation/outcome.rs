//! What the stages find out.

use serde::{Deserialize, Serialize};

use crate::WallId;
use crate::theory::WallLayers;

/// A finished stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageOutcome {
    /// The stage's name in the scene.
    pub name: String,
    /// Steps it took.
    pub steps: u64,
    /// Model time it took (s).
    pub model_time_s: f64,
    /// What it found out.
    pub outcome: Outcome,
}

/// What a stage found out, by its kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Of a `compact` stage.
    Compact(Compaction),
    /// Of a `cycle` stage.
    Cycle(LoadCycles),
    /// Of a `permeability` stage.
    Permeability(PermeabilityTest),
    /// Of a `flow` stage.
    Flow(Box<FlowTest>),
    /// Of a `consolidate` stage.
    Consolidate(Consolidation),
    /// Of a `run` stage.
    Run(StressPath),
}

/// A packing that grew to a stress.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Compaction {
    /// Mean stress on the six walls, or in the periodic cell (Pa).
    pub stress_pa: f64,
    /// Mean resultant force over mean contact force (1).
    pub unbalanced_force: f64,
    /// Porosity of the box or the cell (1).
    pub porosity: f64,
    /// Contacts per sphere, walls included (1).
    pub coordination_number: f64,
}

/// Load and unload cycles between two stresses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoadCycles {
    /// The wall that was loaded.
    pub wall: WallId,
    /// Secant modulus of the last loading (Pa): the oedometric modulus.
    pub modulus_pa: f64,
    /// Secant modulus of the last unloading (Pa).
    pub unloading_modulus_pa: f64,
    /// Logarithmic strain of the box along the loaded axis at the end of each
    /// half cycle, from the first hold at the lower stress on (1, compression
    /// positive).
    pub strain: Vec<f64>,
    /// Stress on the wall at these ends (Pa).
    pub stress_pa: Vec<f64>,
    /// Share of the last loading's settlement in the pores that touch the lower and the upper wall of
    /// the axis (1); `None` in a scene without fluid.
    pub wall_layer_settlement: Option<[f64; 2]>,
}

/// A static flow through the packing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PermeabilityTest {
    /// `x`, `y` or `z`.
    pub axis: String,
    /// Intrinsic permeability of the box (m²), with the walls of the scene.
    pub permeability_m2: f64,
    /// Whether the fluid slips along the four walls beside the flow there; `None` in a periodic cell.
    pub slip_walls: Option<bool>,
    /// The same where it slips (m²).
    pub slip_permeability_m2: Option<f64>,
    /// And where it does not (m²).
    pub no_slip_permeability_m2: Option<f64>,
    /// Of the part of the box that is a Sauter diameter away from all walls (m²), without their loose
    /// layers; `None` where the box is too small to have one, and in a periodic cell.
    pub core_permeability_m2: Option<f64>,
    /// Flux at 1 Pa across the box (m³/s); of a periodic cell, that of a cube of its volume.
    pub flux_m3_s: f64,
    /// What enters less what leaves, relative to the flux (1).
    pub imbalance: f64,
    /// Kozeny-Carman's estimate for the same porosity and Sauter diameter (m²).
    pub kozeny_carman_m2: f64,
    /// The constant in it (1).
    pub kozeny_carman_constant: f64,
    /// Sauter's mean diameter, Σ d³ / Σ d² (m).
    pub sauter_diameter_m: f64,
    /// Porosity (1).
    pub porosity: f64,
    /// Pores of the network.
    pub pores: u64,
    /// Unknown pressures of it.
    pub unknowns: u64,
    /// Residual of the solve (1).
    pub residual: f64,
    /// Of a periodic cell the whole tensor (m²), by rows; `None` between walls.
    pub tensor_m2: Option<[[f64; 3]; 3]>,
}

/// The flow through spheres at rest at the end of its stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlowTest {
    /// Flux through each wall, positive into the box (m³/s).
    pub flux_m3_s: [f64; 6],
    /// Flux from the pores of each entry of `imposed`, positive into the box (m³/s).
    pub imposed_flux_m3_s: Vec<f64>,
    /// Mean pressure by volume (Pa).
    pub mean_pressure_pa: f64,
    /// The fluid's force on all spheres together (N).
    pub force_n: [f64; 3],
    /// The fluid's force on each wall (N).
    pub wall_force_n: [[f64; 3]; 6],
    /// What enters less what leaves or is stored, relative to the flux (1).
    pub imbalance: f64,
    /// Pores of the network.
    pub pores: u64,
    /// Unknown pressures of it.
    pub unknowns: u64,
}

/// One-dimensional consolidation under a stress put on at once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Consolidation {
    /// The loaded wall.
    pub wall: WallId,
    /// Stress added (Pa).
    pub load_pa: f64,
    /// Height of the layer at the start (m).
    pub height_m: f64,
    /// The walls that drain: an end of the loaded axis or both, the loaded wall first.
    pub drained_walls: Vec<WallId>,
    /// The longest way out: the height, or half of it where both ends drain (m).
    pub drainage_path_m: f64,
    /// Oedometric modulus measured before (Pa).
    pub modulus_pa: f64,
    /// Permeability measured before (m²).
    pub permeability_m2: f64,
    /// Coefficient of consolidation `c_v = k E_oed / μ` (m²/s).
    pub c_v_m2_s: f64,
    /// Settlement that the modulus predicts, `H (1 - exp(-Δσ / E_oed))` (m).
    pub final_settlement_m: f64,
    /// Share of the height in pores that touch a drained wall (1): their
    /// pressure is imposed, so they are drained from the start.
    pub drained_share: f64,
    /// The same of the pores at a sealed wall (1): in them the pressure is nearly the same all over. 0
    /// where both ends drain.
    pub sealed_share: f64,
    /// Share of the settlement in the pores at drained walls (1), measured by the load cycles.
    pub drained_settlement: f64,
    /// The same at a sealed wall (1).
    pub sealed_settlement: f64,
    /// The course of the consolidation.
    pub samples: Vec<ConsolidationSample>,
    /// Pressure profiles at the T_v asked for.
    pub profiles: Vec<Profile>,
}

/// A moment of a consolidation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConsolidationSample {
    /// Time factor `T_v = c_v t / d²` with the drainage path d (1).
    pub time_factor: f64,
    /// Settlement of the wall (m).
    pub settlement_m: f64,
    /// Settlement over the final settlement (1).
    pub degree: f64,
    /// Mean pressure of the pores at the wall opposite the drained one, over
    /// the added stress (1); where both ends drain, of those in the tenth of the
    /// height at its middle.
    pub base_pressure: f64,
}

/// Mean pore pressure by depth at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// Time factor (1).
    pub time_factor: f64,
    /// Distance of each slab's middle from the drained wall, the loaded one where both are,
    /// over the height (1).
    pub depth: Vec<f64>,
    /// Mean pressure of each slab, by pore volume, over the added stress (1).
    pub pressure: Vec<f64>,
}

/// A run stage's end, and how stress and strain went there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StressPath {
    /// Logarithmic strain of the box since the stage's start, along x, y, z
    /// (1, compression positive).
    pub strain: [f64; 3],
    /// The periodic cell at the end; `None` between walls.
    pub cell: Option<Box<CellState>>,
    /// Stress on each wall at the end, contacts and fluid (Pa).
    pub wall_stress_pa: [f64; 6],
    /// Unbalanced force at the end (1).
    pub unbalanced_force: f64,
    /// The course of the stage, some 200 moments of it.
    pub samples: Vec<StressPathSample>,
}

/// A moment of a run stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StressPathSample {
    /// Model time since the stage's start (s).
    pub time_s: f64,
    /// Logarithmic strain since the stage's start along x, y, z (1).
    pub strain: [f64; 3],
    /// Mean stress of the two walls of each axis, contacts and fluid, or in the cell (Pa).
    pub stress_pa: [f64; 3],
    /// Mean pore pressure by volume (Pa); 0 where the pores are empty.
    pub mean_pressure_pa: f64,
    /// The periodic cell; `None` between walls.
    pub cell: Option<CellState>,
}

/// A periodic cell at a moment of a run stage; tensors by rows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellState {
    /// ∫ L dt since the stage's start (1), positive in extension.
    pub strain: [[f64; 3]; 3],
    /// Stress by contacts and motion (Pa), positive in compression.
    pub stress_pa: [[f64; 3]; 3],
    /// Porosity (1).
    pub porosity: f64,
}

impl Outcome {
    /// The kind of the stage, as scenes name it.
    pub const fn kind(&self) -> &'static str {
        match self {
            Outcome::Compact(_) => "compact",
            Outcome::Cycle(_) => "cycle",
            Outcome::Permeability(_) => "permeability",
            Outcome::Flow(_) => "flow",
            Outcome::Consolidate(_) => "consolidate",
            Outcome::Run(_) => "run",
        }
    }
}

impl Consolidation {
    /// Largest distance of the measured degree of consolidation from
    /// Terzaghi's with the layers at the walls counted, for `T_v` in a range; 0 where there is no
    /// sample in it.
    pub fn largest_error(&self, from: f64, to: f64) -> f64 {
        let theory = self.wall_layers();
        let within = self.samples.iter().filter(|s| (from..=to).contains(&s.time_factor));
        within.map(|s| (s.degree - theory.degree(s.time_factor)).abs()).fold(0.0, f64::max)
    }

    /// Whether fluid leaves at both ends of the layer.
    pub fn drains_at_both_ends(&self) -> bool {
        self.drained_walls.len() > 1
    }

    /// Terzaghi's theory with the layers at the walls counted: what the samples are held against.
    pub fn wall_layers(&self) -> WallLayers {
        WallLayers::new(self.drained_settlement, self.sealed_settlement)
    }
}
