//! YADE's oedometer: a packing of 1 m and a viscous fluid, to T_v = 1.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::loading::{Change, Course, Gap, Loading, Packing, Wet, samples};
use super::{HEADER, HEIGHTS, figures, row, verdicts};
use crate::commands::Error;
use crate::commands::compare::loading::{Material, settled};
use crate::commands::compare::peer::Bench;
use crate::commands::compare::verdict::Verdict;

/// Number of spheres.
const SPHERES: usize = 1000;
/// Stress before and after the load (Pa).
const BEFORE: f64 = 1e4;
const AFTER: f64 = 1.1e4;
/// Viscosity (Pa·s).
const VISCOSITY: f64 = 10.0;
/// Share of T_v = 1 that the runs for understanding take.
const BEGINNING: f64 = 0.1;

/// The oedometer, loaded in both programs.
#[derive(Serialize, Deserialize)]
pub struct Oedometer {
    loading: Loading,
    /// Oedometric modulus (Pa) and permeability (m²), measured by ours.
    modulus: f64,
    permeability: f64,
    yade: Course,
    ours: Course,
    /// The beginning, in YADE with the equations that ours follows.
    aligned: Course,
    /// The beginning with half the time step: YADE, ours.
    refined: [Course; 2],
}

impl Oedometer {
    /// Makes the packing and loads it in both programs.
    ///
    /// # Errors
    /// What failed.
    pub fn measure(bench: &Bench) -> Result<Oedometer, Error> {
        let packing = settled(bench, SPHERES)?;
        let (modulus, permeability) = properties(bench, &packing)?;
        let duration = VISCOSITY * packing.size().y.powi(2) / (permeability * modulus);
        let loading = loading(&packing, duration);
        let beginning = loading.until((BEGINNING * loading.steps() as f64) as u64);
        let fine = beginning.refined(2);
        let step = "oedometer";
        Ok(Oedometer {
            modulus,
            permeability,
            yade: loading.yade(bench, step, &packing, Change::default())?,
            ours: loading.ours(bench, step, &packing)?,
            aligned: beginning.yade(bench, "oedometer-aligned", &packing, Change::ALIGNED)?,
            refined: [
                fine.yade(bench, "oedometer-fine", &packing, Change::default())?,
                fine.ours(bench, "oedometer-fine", &packing)?,
            ],
            loading,
        })
    }

    fn load(&self) -> f64 {
        AFTER - BEFORE
    }

    /// What was asked: the two programs over the whole time.
    pub fn verdicts(&self) -> Vec<Verdict> {
        verdicts("oedometer", &Gap::between(&self.ours, &self.yade, self.load()))
    }

    /// Its section of the report.
    ///
    /// # Errors
    /// When the figure cannot be written.
    pub fn section(&self, folder: &Path) -> Result<String, Error> {
        let consolidation = self.permeability * self.modulus / VISCOSITY;
        let factor: Vec<f64> =
            self.yade.step.iter().map(|&s| consolidation * s as f64 * self.loading.dt).collect();
        let caption = format!(
            "{SPHERES} spheres, 10 kPa to 11 kPa, *c*_{{v}} = {consolidation:.3} m²/s; lines: YADE, \
             dots: dempfv"
        );
        figures::course(
            "Consolidation in the oedometer",
            &caption,
            ("Time factor *T*_{v}", &factor),
            [&self.yade, &self.ours],
            (&HEIGHTS, 1e3, "Settlement (mm)"),
        )
        .save(folder, "oedometer")?;
        let mut text = format!(
            "### YADE's oedometer\n\nA packing of {SPHERES} spheres in a cube of 1 m, grown to 10 kPa \
             by dempfv without friction: a packing file has no room for shear forces, so this one is at \
             rest in both programs. E = 1 MPa, 30° of friction from then on, viscosity 10 Pa·s, Δt = 10⁻⁴ s, \
             YADE's clamp, remeshed every {}. The servo on the drained wall goes from 10 to 11 kPa. E_oed = \
             {:.1} kPa and k = {:.3e} m² (measured by dempfv) make T_v = 1 of {} steps; dempfv took \
             {:.1} s for them, YADE {:.1} s, one thread each.\n\n![Oedometer](oedometer.png)\n\n",
            self.loading.wet.map_or(0, |w| w.remesh_interval),
            1e-3 * self.modulus,
            self.permeability,
            self.loading.steps(),
            self.ours.seconds,
            self.yade.seconds
        );
        text += HEADER;
        text += &self.rows();
        text += EXPLANATION;
        Ok(text)
    }

    fn rows(&self) -> String {
        let count = self.aligned.step.len();
        let (yade, ours) = (self.yade.first(count), self.ours.first(count));
        let [fine_yade, fine_ours] = &self.refined;
        let compared = [
            ("dempfv with YADE, to T_v = 1", &self.ours, &self.yade),
            ("the same, to T_v = 0.1", &ours, &yade),
            ("dempfv with YADE, both Δt/2", fine_ours, fine_yade),
            ("YADE, Δt with Δt/2", &yade, fine_yade),
            ("dempfv, Δt with Δt/2", &ours, fine_ours),
            ("dempfv with YADE, same slip and corner pores", &ours, &self.aligned),
        ];
        compared.iter().map(|(name, a, b)| row(name, &Gap::between(a, b, self.load()))).collect()
    }
}

/// The loading, to T_v = 1 after `duration` (s).
fn loading(packing: &Packing, duration: f64) -> Loading {
    let dt = 1e-4;
    // A look every T_v = 0.003, half way between two remeshes.
    let steps = (duration / dt) as u64;
    Loading {
        material: Material::default(),
        dt,
        stress: AFTER,
        max_velocity: 0.1,
        wet: Some(Wet { viscosity: VISCOSITY, remesh_interval: 200, clamp: true }),
        probes: packing.vertical(HEIGHTS),
        samples: samples(50, 100, steps + 100),
    }
}

/// Modulus (Pa) and permeability (m²) of the packing along y.
fn properties(bench: &Bench, packing: &Packing) -> Result<(f64, f64), Error> {
    let scene = format!(
        "[particles]\npacking = {:?}\n[dem]\n\
         [fluid]\nviscosity = {VISCOSITY:?}\nclamp = \"yade\"\npressure = {{ y_max = 0.0 }}\n\
         [[stage]]\nkind = \"permeability\"\naxis = \"y\"\n\
         [[stage]]\nkind = \"cycle\"\nwall = \"y_max\"\nfrom = {BEFORE:?}\nto = {AFTER:?}\n\
         cycles = 1\nmax_velocity = 0.05\n[output]\npictures = false\n",
        packing.path
    );
    let run = bench.ours("oedometer-properties", &scene, 1)?;
    let number = |stage: usize, kind: &str, key: &str| {
        run.summary["stages"][stage][kind][key].as_f64().filter(|x| *x > 0.0)
    };
    let found = (number(1, "cycle", "modulus_pa"), number(0, "permeability", "permeability_m2"));
    match found {
        (Some(modulus), Some(permeability)) => Ok((modulus, permeability)),
        _ => Err(Error::Peer {
            step: "oedometer-properties".to_owned(),
            what: "dempfv's summary names no modulus or permeability".to_owned(),
            log: None,
        }),
    }
}

const EXPLANATION: &str = "
Largest differences at any of the times, over five probes and six walls, of the load of 1 kPa. Halving
the time step in both moves each of them by less than they are apart, so the time step is not the
cause. The last line shows what is: with the plain slip of contacts (see above) and with the push of
the corner pores on their spheres, which YADE leaves out, added to YADE by its own Python, the
difference goes. The push of the corner pores is what makes the stress on the base differ, the slip
what makes the settlement differ. Nothing systematic is left: YADE takes the pores' volumes of the
current positions and their difference over a step for V̇ where ours takes E of the last remesh times the
velocities, its servo does not count the fluid's resistance (none here: the loaded wall is drained), and it
remeshes at the end of a step where ours does at the beginning of the next with the older positions.
After a remesh YADE shows pressures of the new network before it has solved them; the looks at
the runs lie between remeshes.

";
