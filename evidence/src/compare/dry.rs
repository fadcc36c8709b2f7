//! The part `dry` of the comparison: a packing is loaded by a servo wall, without fluid.

use std::path::{Path, PathBuf};

use dempfv::WallId;
use dempfv_report::plot::Axis;
use serde::{Deserialize, Serialize};

use super::figures::{self, Curve};
use super::loading::{Change, Course, Gap, Loading, Material, Packing, samples};
use super::peer::Bench;
use super::verdict::Verdict;
use crate::Error;

/// Packings of more spheres take YADE too long.
pub const LARGEST: usize = 6000;
/// What the two programs may differ by, of the load or of the last settlement.
const BOUND: f64 = 5e-3;
/// Stress that the shipped packings have settled at (Pa).
const BEFORE: f64 = 1e3;

/// A packing that was loaded.
#[derive(Serialize, Deserialize)]
struct Case {
    packing: String,
    spheres: usize,
    loading: Loading,
    yade: Course,
    ours: Course,
    understood: Option<Understood>,
}

/// Runs of YADE that show where differences come from.
#[derive(Serialize, Deserialize)]
struct Understood {
    /// YADE with the plain slip of contacts.
    plain: Course,
    /// YADE with other last digits of the positions.
    perturbed: Course,
    /// By how much these were changed (m).
    perturbation: f64,
}

/// What was measured.
#[derive(Serialize, Deserialize)]
pub struct Part {
    cases: Vec<Case>,
}

/// The loading: the stress on y_max is doubled within two thirds of 2,000 steps.
pub fn loading(packing: &Packing) -> Loading {
    Loading {
        material: Material::default(),
        dt: 2e-5,
        stress: 2.0 * BEFORE,
        // The shipped packings strain by 0.4 % on the way.
        max_velocity: 0.045 * packing.size().y,
        wet: None,
        probes: vec![],
        steps: 2000,
        samples: samples(10, 10, 2000),
    }
}

impl Case {
    fn measure(bench: &Bench, packing: &Packing, understand: bool) -> Result<Case, Error> {
        let loading = loading(packing);
        let step = format!("dry-{}", packing.name());
        Ok(Case {
            packing: packing.name(),
            spheres: packing.spheres.len(),
            yade: loading.yade(bench, &step, packing, Change::default())?,
            ours: loading.ours(bench, &step, packing)?,
            understood: understand
                .then(|| Understood::measure(bench, packing, &loading, &step))
                .transpose()?,
            loading,
        })
    }

    fn gap(&self, a: &Course, b: &Course) -> Gap {
        Gap::between(a, b, self.loading.stress - BEFORE)
    }

    fn row(&self, what: &str, gap: &Gap) -> String {
        format!(
            "| {} | {what} | {:.2} % | {:.2} % | {:.2} % | {:.3} % |\n",
            self.packing,
            100.0 * gap.stress.largest,
            100.0 * gap.settlement.largest,
            100.0 * gap.coordination.largest,
            100.0 * gap.last_coordination,
        )
    }

    fn draw(&self, folder: &Path) -> Result<(), Error> {
        let time: Vec<f64> =
            self.yade.step.iter().map(|&s| 1e3 * s as f64 * self.loading.dt).collect();
        let caption =
            format!("{}, {} spheres; lines: YADE, dots: dempfv", self.packing, self.spheres);
        let walls = [
            (WallId::YMax, "loaded wall"),
            (WallId::YMin, "opposite wall"),
            (WallId::XMin, "side wall"),
        ];
        let scaled = |values: Vec<f64>, by: f64| values.into_iter().map(|v| v * by).collect();
        let stress: Vec<Curve> = walls
            .iter()
            .map(|(w, name)| Curve {
                name,
                yade: scaled(self.yade.stress_on(*w), 1e-3),
                ours: scaled(self.ours.stress_on(*w), 1e-3),
            })
            .collect();
        let settlement = [Curve {
            name: "settlement",
            yade: scaled(self.yade.settlement(), 1e3),
            ours: scaled(self.ours.settlement(), 1e3),
        }];
        let stress = (Axis::linear("Wall stress (kPa)"), &stress[..]);
        let settlement = (Axis::linear("Settlement (mm)"), &settlement[..]);
        figures::beside(
            "Dry loading by a servo wall",
            &caption,
            (Axis::linear("Time (ms)"), &time),
            &[stress, settlement],
        )
        .save(folder, &format!("dry-{}", self.packing))?;
        Ok(())
    }
}

impl Understood {
    fn measure(
        bench: &Bench,
        packing: &Packing,
        loading: &Loading,
        step: &str,
    ) -> Result<Understood, Error> {
        let run =
            |name: &str, change| loading.yade(bench, &format!("{step}-{name}"), packing, change);
        // What the ten digits of a packing file leave open.
        let perturbation = 1e-10 * packing.size().max();
        Ok(Understood {
            plain: run("plain", Change { plain_slip: true, ..Change::default() })?,
            perturbed: run("perturbed", Change { perturbation, ..Change::default() })?,
            perturbation,
        })
    }
}

impl super::Part for Part {
    const NAME: &'static str = "dry";

    fn measure(bench: &Bench, packings: &[PathBuf]) -> Result<Part, Error> {
        let cases = chosen(packings)?;
        let cases: Result<_, Error> = cases
            .iter()
            .zip(0..)
            .map(|(packing, i)| Case::measure(bench, packing, i == 0))
            .collect();
        Ok(Part { cases: cases? })
    }

    fn verdicts(&self) -> Vec<Verdict> {
        let verdicts = self.cases.iter().flat_map(|case| {
            let gap = case.gap(&case.ours, &case.yade);
            let verdict = |quantity: &str, largest, median| Verdict {
                on: format!("dry loading, {}", case.packing),
                quantity: quantity.to_owned(),
                largest,
                median,
                bound: BOUND,
                explanation: None,
            };
            [
                verdict(
                    "stress on the six walls, of the load",
                    gap.stress.largest,
                    Some(gap.stress.median),
                ),
                verdict(
                    "settlement, of the last",
                    gap.settlement.largest,
                    Some(gap.settlement.median),
                ),
                verdict(
                    "coordination number, relative",
                    gap.coordination.largest,
                    Some(gap.coordination.median),
                ),
            ]
        });
        verdicts.collect()
    }

    fn section(&self, folder: &Path) -> Result<String, Error> {
        let mut text = INTRODUCTION.to_owned();
        if self.cases.is_empty() {
            text += "None of the packings has settled at 1 kPa and up to 6,000 spheres.\n";
            return Ok(text);
        }
        text += "| packing | compared | wall stress, of the load | settlement, of the last | \
                 coordination number | the same at the end |\n|---|---|---|---|---|---|\n";
        for case in &self.cases {
            text += &case.row("dempfv with YADE", &case.gap(&case.ours, &case.yade));
            let Some(Understood { plain, perturbed, perturbation }) = &case.understood else {
                continue;
            };
            let rows = [
                ("dempfv with YADE, plain slip".to_owned(), case.gap(&case.ours, plain)),
                ("YADE, plain slip, with YADE".to_owned(), case.gap(plain, &case.yade)),
                (
                    format!("YADE with itself, spheres moved by {perturbation:.0e} m"),
                    case.gap(perturbed, &case.yade),
                ),
            ];
            for (what, gap) in rows {
                text += &case.row(&what, &gap);
            }
        }
        text += "\nLargest differences at any of the times, over all six walls.\n\n";
        for case in &self.cases {
            case.draw(folder)?;
            let last = |c: &Course| {
                (c.contacts.last().copied().unwrap_or(0), c.coordination.last().copied())
            };
            let ((a, z), (b, y)) = (last(&case.ours), last(&case.yade));
            text += &format!(
                "![Dry loading of {0}](dry-{0}.png)\n\n{0}: {a} contacts at the end in dempfv, {b} \
                 in YADE: {1:.3} and {2:.3} for each sphere. 2,000 steps took dempfv {3:.2} s and \
                 YADE {4:.1} s, one thread each.\n\n",
                case.packing,
                z.unwrap_or(f64::NAN),
                y.unwrap_or(f64::NAN),
                case.ours.seconds,
                case.yade.seconds
            );
        }
        Ok(text)
    }
}

/// The packings that are loaded, the smallest first: those that are small enough, have
/// settled at 1 kPa, and whose contacts are stable with the time step.
///
/// # Errors
/// What is wrong with a packing.
pub fn chosen(paths: &[PathBuf]) -> Result<Vec<Packing>, Error> {
    let mut chosen = Vec::new();
    for path in paths {
        let packing = Packing::load(path)?;
        if packing.spheres.len() > LARGEST {
            continue;
        }
        let (stress, stable) = packing.rest(Material::default())?;
        if (stress / BEFORE - 1.0).abs() < 0.2 && loading(&packing).dt < stable {
            chosen.push(packing);
        }
    }
    chosen.sort_by_key(|p| p.spheres.len());
    Ok(chosen)
}

const INTRODUCTION: &str = "\
## Dry loading

The spheres of a packing file that has settled at 1 kPa, without shear forces (the file holds none); the
wall `y_max` is moved by the servo until it carries 2 kPa, twice what the packing has settled at, while
the other five stand still. 2,000 steps of 2·10⁻⁵ s, local damping 0.2, smooth walls. YADE's servo
sums up the stiffness of its contacts at every step here, as ours does (YADE's default: every 10).

Two differences are left, and both are known. YADE takes the slip of a contact from the translation
of the spheres times (r₁ + r₂)/d, d the distance of their centres, and from surfaces of full radius;
ours takes the two surfaces at the point that the forces act on, so that the work of a contact is
what the spheres lose. That is 0.2 % more slip in the mean at 1 kPa, and 1.3 % at 10 kPa. With YADE's
switch for it off (`avoidGranularRatcheting=False`, \"plain slip\") both programs have the same law. What is left
then is the growth of round-off: contacts open and close, and two runs of YADE itself that differ in
the last digits of the packing file come as far apart.

";
