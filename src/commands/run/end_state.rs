//! The state that a finished run leaves: a packing, its contacts, a checkpoint.

use std::fmt::Write;
use std::path::Path;

use dempfv::Result;
use dempfv::dem::{Dem, Partner};
use dempfv::io::{atomic, checkpoint};
use dempfv::simulation::Simulation;
use dempfv_report::format::three_digits;
use dempfv_report::outputs::tables::CONTACTS;

use super::super::pack::write_spheres;

/// The spheres at the end. (Not `packing.txt`, which is a file of `pack`.)
pub const PACKING: &str = "final-packing.txt";
const CONTACT_TABLE: &str = "contacts.csv";

/// Writes it.
///
/// # Errors
/// When a file cannot be written.
pub fn write(folder: &Path, simulation: &Simulation) -> Result<()> {
    let dem = simulation.coupled().dem();
    let comment = format!(
        "{}: after {} steps, {} s (dempfv {}); metres",
        simulation.plan().title.replace(['\n', '\r'], " "),
        simulation.step(),
        three_digits(simulation.time()),
        env!("CARGO_PKG_VERSION")
    );
    write_spheres(&folder.join(PACKING), dem, &comment)?;
    if simulation.plan().output.contacts {
        atomic::write(&folder.join(CONTACT_TABLE), contact_table(dem).as_bytes())?;
    }
    Ok(checkpoint::save(&folder.join(super::CHECKPOINT), &simulation.state())?)
}

fn contact_table(dem: &Dem) -> String {
    let names: Vec<&str> = CONTACTS.iter().map(|column| column.name).collect();
    let mut text = names.join(",") + "\n";
    for contact in dem.contacts() {
        let partner = match contact.partner {
            Partner::Sphere(number) => number.to_string(),
            Partner::Wall(wall) => wall.name().to_owned(),
        };
        let [n, s] = [contact.normal, contact.shear];
        let numbers =
            [contact.overlap, contact.normal_force, s.norm(), n.x, n.y, n.z, s.x, s.y, s.z];
        // Writing to a string cannot fail.
        let _ = write!(text, "{},{partner}", contact.i);
        for x in numbers {
            // -0 would help no reader.
            let _ = write!(text, ",{:?}", x + 0.0);
        }
        text.push('\n');
    }
    text
}
