//! The part `coupled` of the comparison: a saturated packing is loaded by a servo wall.

mod oedometer;
mod specimen;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use self::oedometer::Oedometer;
use self::specimen::Specimen;
use super::dry;
use super::loading::Gap;
use super::peer::Bench;
use super::verdict::Verdict;
use super::{figures, loading};
use crate::Error;

/// What the two programs may differ by, of the load or of the last settlement.
const BOUND: f64 = 1e-2;
/// Heights of the probes, of the box, on the vertical through its middle.
const HEIGHTS: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

/// What was measured.
#[derive(Serialize, Deserialize)]
pub struct Part {
    specimens: Vec<Specimen>,
    oedometer: Oedometer,
}

impl super::Part for Part {
    const NAME: &'static str = "coupled";

    fn measure(bench: &Bench, packings: &[PathBuf]) -> Result<Part, Error> {
        let mut specimens = Vec::new();
        for packing in dry::chosen(packings)? {
            for clamp in [true, false] {
                specimens.push(Specimen::measure(bench, &packing, clamp)?);
            }
        }
        Ok(Part { specimens, oedometer: Oedometer::measure(bench)? })
    }

    fn verdicts(&self) -> Vec<Verdict> {
        let specimens = self.specimens.iter().flat_map(|s| verdicts(&s.name(), &s.gap()));
        specimens.chain(self.oedometer.verdicts()).collect()
    }

    fn section(&self, folder: &Path) -> Result<String, Error> {
        let mut text = specimen::INTRODUCTION.to_owned();
        match self.specimens.is_empty() {
            true => text += "None of the packings has settled at 1 kPa and up to 6,000 spheres.\n",
            false => text += HEADER,
        }
        for specimen in &self.specimens {
            text += &row(&specimen.name(), &specimen.gap());
        }
        text += "\n";
        for specimen in &self.specimens {
            text += &specimen.show(folder)?;
        }
        text += &self.oedometer.section(folder)?;
        Ok(text)
    }
}

/// What is asked of two courses.
fn verdicts(on: &str, gap: &Gap) -> Vec<Verdict> {
    let verdict = |quantity: &str, apart: loading::Apart| Verdict {
        on: on.to_owned(),
        quantity: quantity.to_owned(),
        largest: apart.largest,
        median: Some(apart.median),
        bound: BOUND,
        explanation: None,
    };
    vec![
        verdict("pore pressure at five points, of the load", gap.pressure),
        verdict("stress on the six walls, of the load", gap.stress),
        verdict("settlement, of the last", gap.settlement),
    ]
}

/// Head of a table of differences.
const HEADER: &str = "| compared | pore pressure, of the load | wall stress, of the load | \
                      settlement, of the last |\n|---|---|---|---|\n";

/// A line of it.
fn row(name: &str, gap: &Gap) -> String {
    format!(
        "| {name} | {:.3} % | {:.3} % | {:.4} % |\n",
        100.0 * gap.pressure.largest,
        100.0 * gap.stress.largest,
        100.0 * gap.settlement.largest
    )
}
