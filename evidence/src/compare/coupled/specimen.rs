//! The paper's specimen: 600 steps under a load that the packing has not settled at.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::loading::{Change, Course, Gap, Loading, Packing, Wet, samples};
use super::{HEIGHTS, figures};
use crate::Error;
use crate::compare::loading::Material;
use crate::compare::peer::Bench;

/// Stress that the shipped packings have settled at (Pa).
const BEFORE: f64 = 1e3;

/// A specimen that was loaded.
#[derive(Serialize, Deserialize)]
pub struct Specimen {
    packing: String,
    spheres: usize,
    clamp: bool,
    loading: Loading,
    yade: Course,
    ours: Course,
}

impl Specimen {
    /// Loads it in both programs.
    ///
    /// # Errors
    /// What failed.
    pub fn measure(bench: &Bench, packing: &Packing, clamp: bool) -> Result<Specimen, Error> {
        let loading = loading(packing, clamp);
        let step = format!("specimen-{}{}", packing.name(), if clamp { "-clamp" } else { "" });
        Ok(Specimen {
            packing: packing.name(),
            spheres: packing.spheres.len(),
            clamp,
            yade: loading.yade(bench, &step, packing, Change::default())?,
            ours: loading.ours(bench, &step, packing)?,
            loading,
        })
    }

    /// How it is called in tables.
    pub fn name(&self) -> String {
        let clamp = if self.clamp { "YADE's clamp" } else { "no clamp" };
        format!("specimen {}, {clamp}", self.packing)
    }

    /// How far the programs are apart.
    pub fn gap(&self) -> Gap {
        Gap::between(&self.ours, &self.yade, self.loading.stress - BEFORE)
    }

    /// Draws both; says what the figure shows.
    ///
    /// # Errors
    /// When the figure cannot be written.
    pub fn show(&self, folder: &Path) -> Result<String, Error> {
        let time: Vec<f64> =
            self.yade.step.iter().map(|&s| 1e6 * s as f64 * self.loading.dt).collect();
        let name = format!("specimen-{}{}", self.packing, if self.clamp { "-clamp" } else { "" });
        let caption =
            format!("{}, {} spheres; lines: YADE, dots: dempfv", self.name(), self.spheres);
        figures::course(
            "Coupled loading of the specimen",
            &caption,
            ("Time (µs)", &time),
            [&self.yade, &self.ours],
            (&HEIGHTS, 1e6, "Settlement (µm)"),
        )
        .save(folder, &name)?;
        Ok(format!(
            "![{0}]({name}.png)\n\n{0}: {1} steps took dempfv {2:.2} s and YADE {3:.1} s, one thread \
             each.\n\n",
            self.name(),
            self.loading.steps,
            self.ours.seconds,
            self.yade.seconds
        ))
    }
}

/// The loading: 600 steps of 1 µs, remeshed every 200.
pub fn loading(packing: &Packing, clamp: bool) -> Loading {
    Loading {
        material: Material::default(),
        dt: 1e-6,
        stress: 2.0 * BEFORE,
        // The wall has its load after a tenth of the steps.
        max_velocity: 5.0 * packing.size().y,
        wet: Some(Wet { viscosity: 1e-3, remesh_interval: 200, clamp }),
        probes: packing.vertical(HEIGHTS),
        steps: 600,
        samples: samples(10, 20, 600),
    }
}

pub const INTRODUCTION: &str = "\
## Coupled loading

### The specimen of the paper

The specimen of Caulk et al. (2020): spheres of 1.15 mm, E = 1 MPa, water, Δt = 10⁻⁶ s, 600 steps,
remeshed every 200, drained at the loaded wall `y_max`, nothing flows elsewhere, slip walls. The packing
has settled at 1 kPa, so the servo goes to 2 kPa: otherwise nothing would move. The interaction
range is 1 in both (no bonds across gaps). Five probes of the pore pressure stand on the vertical
through the middle of the box, at 0.1, 0.3, 0.5, 0.7 and 0.9 of its height.

";
