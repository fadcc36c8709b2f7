//! `docs/outputs.md`.

use std::fmt::Write;

use dempfv::simulation::history;

use super::{Entry, frames, summary, tables};

const HEAD: &str = "\
# Outputs

What the files of a run hold, in SI units. Stress, pressure and strain are positive in compression, but for
the strains of a periodic cell, ∫ L dt, which are positive in extension. Flow through a wall is positive into
the box; velocities and displacements are positive towards larger coordinates. This page is written from what
the program itself says of each column, key and array.

## Excess pressure, weight and buoyancy

Every pressure that is imposed or solved for is in excess of the hydrostatic one, p = p_total − ρ_f g h, h the
depth below where the box is highest: water at rest has p = 0 everywhere, whatever its weight. The fluid's
forces on spheres are those of p and of the drag and, where the scene gives the fluid a `density` ρ_f and there
is `gravity`, the buoyancy −ρ_f g V of each; without `density` there is no buoyancy, and a sphere weighs what
it does in air. Forces and stresses on walls are by p alone. Where the fluid has weight, total pressures stand
beside the excess ones: `total_pressure` in the files of pores, `probe_{k}_total_pressure_pa` in the history.
Effective stress is that of the contacts, Σ F ⊗ l / V; the total stress on a wall is that of contacts and
fluid together.

";

/// The page.
pub fn page() -> String {
    let mut page = HEAD.to_owned();
    page += "## history.csv\n\nA row every `history_every` steps, and one at the end. A name in braces \
             stands for each wall, point, region or component.\nNaN stands where there is no value.\n";
    let mut last = "";
    for group in history::groups() {
        if group.when != last {
            last = group.when;
            let _ = write!(page, "\nColumns, {}:\n\n{TABLE_HEAD}", group.when);
        }
        for column in group.columns {
            row(&mut page, column.name, column.unit, column.meaning);
        }
    }
    page += "\n## summary.json\n\nA point leads into a table, `[]` to the items of an array; \
         `*` is any name. What is null has no such keys.\n\n";
    page += TABLE_HEAD;
    summary::keys().for_each(|key| row(&mut page, key.name, key.unit, key.meaning));
    page += "\n## Files for ParaView\n\nSnapshots every `vtk_every` steps and one at the end, as VTK XML unstructured grids: \
             `spheres-000001000.vtu` is of step 1,000, `spheres.pvd` lists all with their times.\n";
    for file in &frames::FILES {
        let _ = write!(page, "\n### {}\n\n{}\n\n{TABLE_HEAD}", file.name, file.what);
        all(&mut page, file.arrays);
    }
    page += "\n## contacts.csv\n\nA line for each contact that carries force at the end, with \
         `contacts = true`.\n\n";
    page += TABLE_HEAD;
    all(&mut page, &tables::CONTACTS);
    page += "\n## consolidation.csv\n\nThe course of a consolidate stage.\n\n";
    page += TABLE_HEAD;
    all(&mut page, &tables::CONSOLIDATION);
    page += FILES;
    page
}

const TABLE_HEAD: &str = "| name | unit | meaning |\n|---|---|---|\n";

const FILES: &str = "
## The state at the end

A finished run leaves `final-packing.txt` (the spheres with their box or cell, to start another scene from) and
`checkpoint.dempfv` (all that a restart needs, to add further stages); `packing` in `[particles]` reads both.
";

fn all(page: &mut String, entries: &[Entry]) {
    entries.iter().for_each(|entry| row(page, entry.name, entry.unit, entry.meaning));
}

fn row(page: &mut String, name: &str, unit: &str, meaning: &str) {
    let meaning = meaning.replace('|', "\\|");
    // Writing to a string cannot fail.
    let _ = writeln!(page, "| `{name}` | {unit} | {meaning} |");
}
