//! YADE's oedometer: a packing of 1 m and a viscous fluid, to T_v = 1.

use std::path::Path;

use dempfv::WallId;
use serde::{Deserialize, Serialize};

use super::loading::{Change, Course, Gap, Loading, Packing, Wet, samples};
use super::{BOUND, HEADER, HEIGHTS, figures, row, verdicts};
use crate::Error;
use crate::compare::loading::{Material, settled};
use crate::compare::peer::Bench;
use crate::compare::verdict::Verdict;

/// Number of spheres.
const SPHERES: usize = 1000;
/// Stress before and after the load (Pa).
const BEFORE: f64 = 1e4;
const AFTER: f64 = 1.1e4;
/// Viscosity (Pa·s).
const VISCOSITY: f64 = 10.0;
/// T_v at which the runs for understanding end.
const BEGINNING: f64 = 0.05;

/// T_v from which on the specimen is at rest but for its drainage.
const SETTLED: f64 = 0.2;

/// The oedometer, loaded in both programs.
#[derive(Serialize, Deserialize)]
pub struct Oedometer {
    loading: Loading,
    /// Oedometric modulus (Pa) and permeability (m²), measured by ours.
    modulus: f64,
    permeability: f64,
    yade: Course,
    ours: Course,
    /// The beginning, in YADE with the push of corner pores, with the plain slip, with both.
    changed: [Course; 3],
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
        let beginning = loading.until((BEGINNING * loading.steps as f64) as u64);
        let fine = beginning.refined(2);
        let changed = |name: &str, plain_slip, corner_push| {
            let change = Change { perturbation: 0.0, plain_slip, corner_push };
            beginning.yade(bench, &format!("oedometer-{name}"), &packing, change)
        };
        let step = "oedometer";
        Ok(Oedometer {
            modulus,
            permeability,
            yade: loading.yade(bench, step, &packing, Change::default())?,
            ours: loading.ours(bench, step, &packing)?,
            changed: [
                changed("corners", false, true)?,
                changed("plain", true, false)?,
                changed("aligned", true, true)?,
            ],
            refined: [
                fine.yade(bench, "oedometer-fine", &packing, Change::default())?,
                fine.ours(bench, "oedometer-fine", &packing)?,
            ],
            loading,
        })
    }

    /// Largest difference between the loaded wall and the one opposite when the knock is
    /// over, of the load.
    fn imbalance(&self, course: &Course) -> f64 {
        let late = |step: u64| step as f64 > SETTLED * self.loading.steps as f64;
        let walls = course.step.iter().zip(&course.stress).filter(|(step, _)| late(**step));
        let [top, base] = [WallId::YMax, WallId::YMin].map(WallId::index);
        walls.map(|(_, s)| (s[top] - s[base]).abs()).fold(0.0, f64::max) / self.load()
    }

    fn load(&self) -> f64 {
        AFTER - BEFORE
    }

    /// What was asked: the two programs over the whole time; and that what they differ by
    /// is what is known of YADE.
    pub fn verdicts(&self) -> Vec<Verdict> {
        let gap = Gap::between(&self.ours, &self.yade, self.load());
        let [.., aligned] = &self.changed;
        let rest = Gap::between(&self.ours.first(aligned.step.len()), aligned, self.load());
        let mut judged = verdicts("oedometer", &gap);
        for verdict in &mut judged {
            if !verdict.is_within() && rest.largest() <= BOUND {
                verdict.explanation = Some(format!(
                    "with the push of the corner pores, which YADE leaves out, and the plain slip \
                     of contacts in YADE, at most {:.2} % is left, in the same run",
                    100.0 * rest.largest()
                ));
            }
        }
        let name = format!("oedometer to T_v = {BEGINNING}, YADE with corner pores and plain slip");
        judged.extend(verdicts(&name, &rest));
        judged
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
            self.loading.steps,
            self.ours.seconds,
            self.yade.seconds
        );
        text += HEADER;
        text += &self.rows();
        text += EXPLANATION;
        text += &format!(
            "An independent look: walls are smooth, so the loaded wall and the one opposite carry the \
             same once the knock of the load is over. From T_v = {SETTLED} on they differ by at most \
             {:.2} % of the load in dempfv, and by {:.2} % in YADE.\n\n",
            100.0 * self.imbalance(&self.ours),
            100.0 * self.imbalance(&self.yade),
        );
        Ok(text)
    }

    fn rows(&self) -> String {
        let [corners, plain, aligned] = &self.changed;
        let count = aligned.step.len();
        let (yade, ours) = (self.yade.first(count), self.ours.first(count));
        let [fine_yade, fine_ours] = &self.refined;
        let compared = [
            ("dempfv with YADE, to T_v = 1", &self.ours, &self.yade),
            ("the same, to T_v = 0.05 as from here on", &ours, &yade),
            ("dempfv with YADE, both with Δt/2", fine_ours, fine_yade),
            ("YADE, Δt with Δt/2", &yade, fine_yade),
            ("dempfv, Δt with Δt/2", &ours, fine_ours),
            ("dempfv with YADE and its corner pores", &ours, corners),
            ("dempfv with YADE, plain slip", &ours, plain),
            ("dempfv with YADE, corner pores and plain slip", &ours, aligned),
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
        steps,
        samples: samples(50, 100, steps),
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
Δt moves both programs alike and leaves their difference as it is: neither is nearer to its limit, and
the time step is not what they differ by. The last lines show what is. YADE leaves out the push of the
eight corner pores on their spheres (their opposite facet lies on the hull), which makes the stress on
the other walls differ: the fluid's forces on YADE's spheres and walls do not add up to zero. The slip
of contacts (see above) makes the settlement differ. With both changed in YADE, by its own Python and
its own switch, next to nothing is left.

Other things that the programs do in different ways make up the rest: YADE takes V̇ from the pores'
volumes before and after the last step, ours from E of the last remesh and the velocities; YADE
remeshes at the end of a step, with the positions of its beginning, ours at the beginning of the next,
which is what differs in the steps after a remesh. YADE's servo does not count the resistance of the fluid,
which is none at a drained wall. After a remesh YADE shows the pressures of the new network before it
has solved them, so the looks lie between remeshes.

";
