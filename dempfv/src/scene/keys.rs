//! Every key that a scene may hold, table by table. The parser refuses all others, and a
//! test holds the reference of keys against these lists.

/// The keys of one table.
pub(super) struct Schema {
    /// How messages name the table.
    pub name: &'static str,
    /// What its keys are: `key`, or `wall` where walls are the keys.
    pub noun: &'static str,
    /// The keys.
    pub keys: &'static [&'static str],
}

const fn table(name: &'static str, keys: &'static [&'static str]) -> Schema {
    Schema { name, noun: "key", keys }
}

const fn by_wall(name: &'static str) -> Schema {
    Schema { name, noun: "wall", keys: &WALLS_BY_NAME }
}

/// The six walls' names.
pub(super) const WALLS_BY_NAME: [&str; 6] = ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"];

pub(super) static ROOT: Schema = table(
    "the scene",
    &["title", "seed", "box", "particles", "walls", "dem", "fluid", "stage", "output"],
);
pub(super) static BOX: Schema = table("[box]", &["min", "max"]);
pub(super) static PARTICLES: Schema = table(
    "[particles]",
    &["packing", "cloud", "density", "young", "stiffness_ratio", "friction_angle"],
);
pub(super) static CLOUD: Schema =
    table("`cloud`", &["count", "porosity", "radius", "spread", "sizes"]);
pub(super) static WALLS: Schema = table("[walls]", &["young", "friction_angle", "max_velocity"]);
pub(super) static DEM: Schema = table("[dem]", &["dt", "safety", "damping", "gravity", "rotation"]);
pub(super) static FLUID: Schema = table(
    "[fluid]",
    &[
        "viscosity",
        "remesh_interval",
        "remesh_strain",
        "remesh",
        "swap",
        "on_failure",
        "update",
        "parallel_tasks",
        "slip_walls",
        "clamp",
        "solver",
        "tolerance",
        "gpu_device",
        "gpu_memory",
        "pressure",
        "no_flow",
    ],
);
pub(super) static PRESSURE: Schema = by_wall("`pressure`");
pub(super) static OUTPUT: Schema =
    table("[output]", &["history_every", "vtk_every", "checkpoint_every", "pictures", "probes"]);

pub(super) static COMPACT: Schema = table(
    "a compact stage",
    &["kind", "name", "stress", "friction_angle", "unbalanced", "tolerance", "max_steps"],
);
pub(super) static CYCLE: Schema = table(
    "a cycle stage",
    &[
        "kind",
        "name",
        "wall",
        "from",
        "to",
        "cycles",
        "unbalanced",
        "tolerance",
        "max_velocity",
        "max_steps",
    ],
);
pub(super) static PERMEABILITY: Schema = table("a permeability stage", &["kind", "name", "axis"]);
pub(super) static CONSOLIDATE: Schema = table(
    "a consolidate stage",
    &["kind", "name", "wall", "stress", "until_tv", "profiles", "max_velocity", "max_steps"],
);
pub(super) static RUN: Schema = table(
    "a run stage",
    &["kind", "name", "steps", "time", "until", "fluid", "walls", "friction_angle"],
);
pub(super) static UNTIL: Schema = table("`until`", &["strain", "axis", "max_steps"]);
pub(super) static RUN_WALLS: Schema = by_wall("`walls`");
pub(super) static CONTROL: Schema =
    table("a wall's control", &["stress", "max_velocity", "velocity"]);

/// All tables, for suggestions across tables and for the reference of keys.
pub(super) static ALL: [&Schema; 17] = [
    &ROOT,
    &BOX,
    &PARTICLES,
    &CLOUD,
    &WALLS,
    &DEM,
    &FLUID,
    &PRESSURE,
    &OUTPUT,
    &COMPACT,
    &CYCLE,
    &PERMEABILITY,
    &CONSOLIDATE,
    &RUN,
    &UNTIL,
    &RUN_WALLS,
    &CONTROL,
];

/// Every key that a scene may hold, table by table: how messages name the table (`[dem]`,
/// `a compact stage`), and its keys.
///
/// ```
/// let (_, keys) = dempfv::scene::known_keys().find(|(table, _)| *table == "[dem]").unwrap();
/// assert!(keys.contains(&"damping"));
/// ```
pub fn known_keys() -> impl Iterator<Item = (&'static str, &'static [&'static str])> {
    ALL.iter().map(|schema| (schema.name, schema.keys))
}
