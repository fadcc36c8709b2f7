//! The keys of a table of a scene, and how messages name them.

/// The keys of one table.
pub(super) struct Schema {
    /// How messages name the table.
    pub name: &'static str,
    /// What its keys are: `key`, or `wall` where walls are the keys.
    pub noun: &'static str,
    /// The keys.
    pub keys: &'static [&'static str],
    /// Whether this is the scene itself.
    is_root: bool,
}

/// The six walls' names.
const WALLS_BY_NAME: [&str; 6] = ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"];

impl Schema {
    /// The scene itself.
    pub const fn root(keys: &'static [&'static str]) -> Schema {
        Schema { name: "the scene", noun: "key", keys, is_root: true }
    }

    /// A table in it.
    pub const fn table(name: &'static str, keys: &'static [&'static str]) -> Schema {
        Schema { name, noun: "key", keys, is_root: false }
    }

    /// A table whose keys are walls.
    pub const fn by_wall(name: &'static str) -> Schema {
        Schema { name, noun: "wall", keys: &WALLS_BY_NAME, is_root: false }
    }

    /// A table whose keys are components of a tensor.
    pub const fn by_component(name: &'static str, keys: &'static [&'static str]) -> Schema {
        Schema { name, noun: "component", keys, is_root: false }
    }

    /// Whether this is the scene itself.
    pub fn is_root(&self) -> bool {
        self.is_root
    }

    /// Name of a key in messages: `` `dt` in [dem] ``, and [dem] itself.
    pub fn name_of(&self, key: &str) -> String {
        match key {
            _ if !self.is_root => format!("`{key}` in {}", self.name),
            "title" | "seed" => format!("`{key}`"),
            "stage" | "motion" | "material" | "pair" => format!("[[{key}]]"),
            _ => format!("[{key}]"),
        }
    }
}
