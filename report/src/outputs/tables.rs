//! Columns of the tables beside the history.

use super::{Entry, entry};

/// `contacts.csv`.
pub static CONTACTS: [Entry; 11] = [
    entry("sphere", "", "Number of the sphere in the packing, from 0."),
    entry("partner", "", "Number of the other sphere, or the wall's name."),
    entry(
        "overlap_m",
        "m",
        "Depth by which surfaces overlap; negative across a gap that the law bridges.",
    ),
    entry("normal_force_n", "N", "Normal force, positive where they press on each other."),
    entry("shear_force_n", "N", "Magnitude of the shear force."),
    entry("normal_x", "1", "Unit normal from the sphere to its partner."),
    entry("normal_y", "1", "Along y."),
    entry("normal_z", "1", "Along z."),
    entry("shear_x_n", "N", "Shear force on the partner."),
    entry("shear_y_n", "N", "Along y."),
    entry("shear_z_n", "N", "Along z."),
];

/// `consolidation.csv`.
pub static CONSOLIDATION: [Entry; 6] = [
    entry("time_factor", "1", "T_v = c_v t / d², d the longest way out."),
    entry("settlement_m", "m", "How far the loaded wall has come in since the load."),
    entry("degree", "1", "Settlement over the final one that the measured modulus predicts."),
    entry(
        "terzaghi_top_drained",
        "1",
        "Terzaghi's degree, the layers at the walls counted (docs/oedometer.md).",
    ),
    entry("terzaghi", "1", "Terzaghi's degree of the whole layer."),
    entry(
        "base_pressure",
        "1",
        "Mean excess pressure of the pores farthest from where fluid leaves, over the \
         load.",
    ),
];
