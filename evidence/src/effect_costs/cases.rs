//! The scenes of `effect-costs`: each is another with a few keys changed.

use std::path::Path;

use dempfv::Vec3;

/// In the place of a value: the size of the packing's box.
const BOX: &str = "box";

/// A scene, and what it prices.
pub struct Case {
    pub name: &'static str,
    /// The scene that it changes; the first of all has none.
    pub over: Option<&'static str>,
    /// Effects that it adds to that scene, as these name themselves.
    pub effects: &'static [&'static str],
    /// Table, key and value; a key without a value is taken away.
    changes: &'static [(&'static str, &'static str, &'static str)],
}

const HERTZ: (&str, &str, &str) = ("contacts", "law", "\"hertz-mindlin\"");

pub const CASES: &[Case] = &[
    Case {
        name: "frictionless springs",
        over: None,
        effects: &["contacts"],
        changes: &[
            ("particles", "friction_angle", "0.0"),
            ("dem", "dt", "1.0e-6"),
            ("dem", "damping", "0.0"),
            ("dem", "rotation", "false"),
            ("stage", "walls", "{ y_max = { velocity = -0.005 } }"),
            ("output", "energy", "false"),
        ],
    },
    Case {
        name: "local damping",
        over: Some("frictionless springs"),
        effects: &["local damping"],
        changes: &[("dem", "damping", "0.2")],
    },
    Case {
        name: "gravity",
        over: Some("frictionless springs"),
        effects: &["gravity"],
        changes: &[("dem", "gravity", "[0.0, -9.81, 0.0]")],
    },
    Case {
        name: "friction and rotation",
        over: Some("frictionless springs"),
        effects: &["friction", "rotation"],
        changes: &[("particles", "friction_angle", "30.0"), ("dem", "rotation", "true")],
    },
    Case {
        name: "energy by cause",
        over: Some("friction and rotation"),
        effects: &["energy by cause"],
        changes: &[("output", "energy", "true")],
    },
    Case {
        name: "turning as a cause",
        over: Some("energy by cause"),
        effects: &[],
        changes: &[("output", "energy_turning", "true")],
    },
    Case {
        name: "automatic time step",
        over: Some("friction and rotation"),
        effects: &[],
        changes: &[("dem", "dt", "\"auto\"")],
    },
    Case {
        name: "servo wall",
        over: Some("friction and rotation"),
        effects: &["servo walls"],
        changes: &[("stage", "walls", "{ y_max = { stress = 1.0e3 } }")],
    },
    Case {
        name: "wall friction",
        over: Some("friction and rotation"),
        effects: &["wall friction"],
        changes: &[("walls", "friction_angle", "20.0")],
    },
    Case {
        name: "several materials",
        over: Some("friction and rotation"),
        effects: &["several materials"],
        changes: &[
            ("material", "name", "\"half\""),
            ("material", "min", "[0.0, 0.0, 0.0]"),
            ("material", "max", "[1.0, 0.03, 1.0]"),
            ("material", "young", "2.0e6"),
        ],
    },
    Case {
        name: "prescribed motion",
        over: Some("friction and rotation"),
        effects: &["prescribed motion"],
        changes: &[("motion", "min", "[0.0, 0.0, 0.0]"), ("motion", "max", "[1.0, 0.003, 1.0]")],
    },
    Case {
        name: "periodic cell",
        over: Some("friction and rotation"),
        effects: &["periodic cell"],
        changes: &[("cell", "size", BOX), ("stage", "walls", "")],
    },
    Case {
        name: "servo cell",
        over: Some("periodic cell"),
        effects: &["servo cell"],
        changes: &[("stage", "cell_stress", "{ yy = 1.0e3 }")],
    },
    Case {
        name: "Hertz-Mindlin contacts",
        over: Some("friction and rotation"),
        effects: &["Hertz-Mindlin contacts"],
        changes: &[HERTZ],
    },
    Case {
        name: "DMT adhesion",
        over: Some("Hertz-Mindlin contacts"),
        effects: &["DMT adhesion"],
        changes: &[("contacts", "adhesion", "\"dmt\""), ("contacts", "work_of_adhesion", "1.0e-6")],
    },
    Case {
        name: "JKR adhesion",
        over: Some("Hertz-Mindlin contacts"),
        effects: &["JKR adhesion"],
        changes: &[("contacts", "adhesion", "\"jkr\""), ("contacts", "work_of_adhesion", "1.0e-6")],
    },
    Case {
        name: "restitution",
        over: Some("friction and rotation"),
        effects: &["viscous contact damping"],
        changes: &[("contacts", "restitution", "0.5")],
    },
    Case {
        name: "rolling resistance",
        over: Some("friction and rotation"),
        effects: &["rolling resistance"],
        changes: &[("contacts", "rolling_friction", "0.1")],
    },
    Case {
        name: "twisting resistance",
        over: Some("friction and rotation"),
        effects: &["twisting resistance"],
        changes: &[("contacts", "twisting_friction", "0.1")],
    },
    Case {
        name: "constant cohesion",
        over: Some("friction and rotation"),
        effects: &["constant cohesion"],
        changes: &[
            ("contacts", "adhesion", "\"constant\""),
            ("contacts", "pull_off_force", "1.0e-4"),
        ],
    },
    Case {
        name: "bonds",
        over: Some("friction and rotation"),
        effects: &["brittle bonds"],
        changes: &[("bonds", "tension", "1.0e5"), ("bonds", "cohesion", "1.0e5")],
    },
    Case {
        name: "pore flow",
        over: Some("friction and rotation"),
        effects: &["pore flow", "fluid forces on spheres"],
        changes: &[
            ("fluid", "viscosity", "1.0e-3"),
            ("fluid", "pressure", "{ y_max = 0.0 }"),
            ("fluid", "remesh_interval", "200"),
        ],
    },
    Case {
        name: "fluid compressibility",
        over: Some("pore flow"),
        effects: &["fluid compressibility"],
        changes: &[("fluid", "bulk_modulus", "2.2e9")],
    },
    Case {
        name: "buoyancy",
        over: Some("pore flow"),
        effects: &["buoyancy"],
        changes: &[("fluid", "density", "1000.0"), ("dem", "gravity", "[0.0, -9.81, 0.0]")],
    },
    Case {
        name: "background remesh",
        over: Some("pore flow"),
        effects: &["background remesh"],
        changes: &[("fluid", "remesh", "\"background\"")],
    },
    Case {
        name: "network at every step",
        over: Some("pore flow"),
        effects: &["network at every step"],
        changes: &[("fluid", "update", "\"every step\"")],
    },
    Case {
        name: "parallel tasks",
        over: Some("pore flow"),
        effects: &["parallel tasks"],
        changes: &[("fluid", "parallel_tasks", "true")],
    },
    Case {
        name: "one-way coupling",
        over: Some("pore flow"),
        effects: &["one-way coupling"],
        changes: &[("fluid", "coupling", "\"one-way\"")],
    },
    Case {
        name: "conditions in time",
        over: Some("pore flow"),
        effects: &["conditions in time"],
        changes: &[(
            "fluid",
            "pressure",
            "{ y_max = { mean = 0.0, amplitude = 1.0, frequency = 1000.0 } }",
        )],
    },
    Case {
        name: "pressure profiles",
        over: Some("pore flow"),
        effects: &["pressure profiles"],
        changes: &[(
            "fluid",
            "pressure",
            "{ y_max = { along = \"x\", points = [[0.0, 0.0], [0.05, 1.0]] } }",
        )],
    },
    Case {
        name: "fluid sources",
        over: Some("pore flow"),
        effects: &["fluid sources"],
        changes: &[("fluid", "sources", "[{ points = [[0.01, 0.01, 0.01]], rate = 1.0e-9 }]")],
    },
    Case {
        name: "pressures of regions",
        over: Some("pore flow"),
        effects: &["pressures of regions"],
        changes: &[("fluid", "imposed", "[{ points = [[0.01, 0.01, 0.01]], pressure = 1.0 }]")],
    },
    Case {
        name: "blocked pores",
        over: Some("pore flow"),
        effects: &["blocked pores"],
        changes: &[("fluid", "blocked", "[{ points = [[0.01, 0.01, 0.01]] }]")],
    },
    Case {
        name: "conductance factors",
        over: Some("pore flow"),
        effects: &["conductance factors"],
        changes: &[("fluid", "conductance_factor", "2.0")],
    },
    Case {
        name: "conductance clamp",
        over: Some("pore flow"),
        effects: &["conductance clamp"],
        changes: &[("fluid", "clamp", "\"relative\"")],
    },
    Case {
        name: "Darcy conductances",
        over: Some("pore flow"),
        effects: &["Darcy conductances"],
        changes: &[("fluid", "darcy_permeability", "1.0e-9")],
    },
    Case {
        name: "pressure gradient",
        over: Some("pore flow"),
        effects: &["pressure gradient"],
        changes: &[
            ("cell", "size", BOX),
            ("stage", "walls", ""),
            ("fluid", "pressure", ""),
            ("fluid", "pressure_gradient", "[0.0, 0.0, 10.0]"),
        ],
    },
    Case {
        name: "viscous shear",
        over: Some("pore flow"),
        effects: &["viscous shear"],
        changes: &[("fluid", "viscous_shear", "true")],
    },
    Case {
        name: "normal lubrication",
        over: Some("pore flow"),
        effects: &["normal lubrication"],
        changes: &[("fluid", "normal_lubrication", "true")],
    },
    Case {
        name: "shear lubrication",
        over: Some("viscous shear"),
        effects: &["shear lubrication"],
        changes: &[("fluid", "shear_lubrication", "true")],
    },
    Case {
        name: "pump torque",
        over: Some("viscous shear"),
        effects: &["pump torque"],
        changes: &[("fluid", "pump_torque", "true")],
    },
    Case {
        name: "twist torque",
        over: Some("viscous shear"),
        effects: &["twist torque"],
        changes: &[("fluid", "twist_torque", "true")],
    },
];

impl Case {
    /// The case of this name.
    pub fn named(name: &str) -> Option<&'static Case> {
        CASES.iter().find(|case| case.name == name)
    }

    /// Whether it has a fluid.
    pub fn is_wet(&self) -> bool {
        self.all_changes().iter().any(|(table, ..)| *table == "fluid")
    }

    /// The scene with this packing in a box of this size (m), and so many steps.
    pub fn scene(&self, packing: &Path, size: &Vec3, steps: u64) -> String {
        let mut tables: Vec<(&str, Vec<(&str, &str)>)> = vec![];
        let (packing, steps) = (format!("{packing:?}"), steps.to_string());
        let size = format!("[{:?}, {:?}, {:?}]", size.x, size.y, size.z);
        let given = [
            ("particles", "packing", packing.as_str()),
            ("stage", "kind", "\"run\""),
            ("stage", "steps", &steps),
        ];
        for (table, key, value) in given.into_iter().chain(self.all_changes()) {
            let at = tables.iter().position(|(name, _)| *name == table);
            let at = at.unwrap_or_else(|| {
                tables.push((table, vec![]));
                tables.len() - 1
            });
            let keys = &mut tables[at].1;
            keys.retain(|(there, _)| *there != key);
            if !value.is_empty() {
                keys.push((key, if value == BOX { &size } else { value }));
            }
        }
        let table = |(name, keys): (&str, Vec<(&str, &str)>)| {
            let listed = ["stage", "material", "motion"].contains(&name);
            let head = if listed { format!("[[{name}]]") } else { format!("[{name}]") };
            let keys = keys.into_iter().map(|(key, value)| format!("{key} = {value}\n"));
            format!("{head}\n{}", keys.collect::<String>())
        };
        tables.into_iter().map(table).collect()
    }

    /// Its changes after those of the scene that it changes.
    fn all_changes(&self) -> Vec<(&'static str, &'static str, &'static str)> {
        let below = self.over.and_then(Case::named);
        let mut all = below.map_or(vec![], Case::all_changes);
        all.extend_from_slice(self.changes);
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dempfv::scene::Plan;

    /// Each case stands on one before it, prices effects that there are, and is a scene in which
    /// these are on.
    #[test]
    fn cases_are_scenes_with_their_effects() {
        let packing = Path::new(env!("CARGO_MANIFEST_DIR")).join("../packings/oedometer-1000.txt");
        for (i, case) in CASES.iter().enumerate() {
            let before = |name: &&str| CASES[..i].iter().any(|case| case.name == *name);
            assert!(case.over.is_none_or(|over| before(&over)), "{}", case.name);
            let plan = Plan::from_toml(&case.scene(&packing, &Vec3::repeat(0.01), 10), None)
                .unwrap_or_else(|e| panic!("{}: {e}", case.name));
            let on = plan.effects();
            for effect in case.effects {
                assert!(
                    on.iter().any(|(e, on)| e.name == *effect && *on),
                    "{}: {effect}",
                    case.name
                );
            }
        }
    }
}
