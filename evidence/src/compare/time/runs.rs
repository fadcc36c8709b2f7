//! The specimen of Caulk et al. (2020) in both programs.

use std::path::PathBuf;

use dempfv::Aabb;
use dempfv::io::packing::{self, Packing};
use dempfv::scene::load_packing;
use serde::{Deserialize, Serialize};

use super::measured::Times;
use super::record::Record;
use super::{SMALL, Side};
use crate::Error;
use crate::compare::peer::Bench;

/// The script that YADE runs.
const SCRIPT: &str = include_str!("../scripts/time.py");

/// A packing to be loaded.
pub struct Specimen {
    pub spheres: usize,
    path: PathBuf,
    bounds: Aabb,
}

impl Specimen {
    /// A packing in a file, by absolute path.
    pub fn new(spheres: usize, path: PathBuf, bounds: Aabb) -> Specimen {
        Specimen { spheres, path, bounds }
    }
}

/// The packings by size, and eight copies of the largest of the small ones where they make
/// a larger one than all.
///
/// # Errors
/// What is wrong in a packing.
pub fn specimens(bench: &Bench, packings: &[PathBuf]) -> Result<Vec<Specimen>, Error> {
    let mut found = Vec::new();
    let mut small: Option<Packing> = None;
    for path in packings {
        let (packing, bounds) = load_packing(path, None)?;
        let spheres = packing.len();
        found.push(Specimen { spheres, path: path.clone(), bounds });
        if spheres <= SMALL && small.as_ref().is_none_or(|s| s.len() < spheres) {
            small = Some(Packing { bounds: Some(bounds), ..packing });
        }
    }
    let largest = found.iter().map(|s| s.spheres).max().unwrap_or(0);
    if let Some(tiled) = small.filter(|s| 8 * s.len() > largest).map(|s| s.tiled([2; 3])) {
        let Packing { position, radius, bounds: Some(bounds), .. } = tiled? else {
            return Ok(found);
        };
        let path = bench.folder.join("scenes").join(format!("tiled-{}.txt", radius.len()));
        // A scene looks for it from its own folder.
        let path = std::path::absolute(&path).map_err(|e| dempfv::Error::io(&path, e))?;
        packing::write(&path, &position, &radius, Some(&bounds), "2 × 2 × 2 copies; metres")?;
        found.push(Specimen { spheres: radius.len(), path, bounds });
    }
    found.sort_by_key(|s| s.spheres);
    Ok(found)
}

/// How YADE solves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tuning {
    /// `FlowEngine.useSolver`: 3 is CHOLMOD through Eigen, 4 is CHOLMOD itself.
    pub solver: u32,
    /// `numSolveThreads` and `numFactorizeThreads`, which are those of the BLAS.
    pub blas_threads: usize,
}

impl Tuning {
    /// YADE's default solver.
    pub const DEFAULT: u32 = 3;
    /// Its solvers that reuse a Cholesky factor.
    pub const SOLVERS: [u32; 2] = [3, 4];

    /// A solver with one thread of the BLAS and with all.
    pub fn all(solver: u32, threads: usize) -> impl Iterator<Item = Tuning> {
        let more = (threads > 1).then_some(threads);
        [1].into_iter().chain(more).map(move |blas_threads| Tuning { solver, blas_threads })
    }
}

/// A run, and everything that it depends on: what the script is told.
#[derive(Serialize)]
pub struct Job {
    packing: PathBuf,
    #[serde(rename = "box")]
    bounds: [[f64; 3]; 2],
    #[serde(skip)]
    spheres: usize,
    threads: usize,
    solver: u32,
    blas_threads: usize,
    run: usize,
    pub steps: u64,
    remesh_interval: u64,
    /// Pa, 1, rad, kg/m³.
    young: f64,
    stiffness_ratio: f64,
    friction_angle: f64,
    density: f64,
    damping: f64,
    /// Pa·s, Pa, s.
    viscosity: f64,
    stress: f64,
    dt: f64,
}

impl Job {
    /// The run with this number on a specimen. Two remeshes follow the first network; the
    /// larger the specimen, the fewer steps lie between them.
    pub fn new(specimen: &Specimen, threads: usize, tuning: Tuning, run: usize) -> Job {
        let remesh_interval = (1_200_000 / specimen.spheres as u64).clamp(20, 200);
        let Aabb { min, max } = specimen.bounds;
        Job {
            packing: specimen.path.clone(),
            bounds: [min.into(), max.into()],
            spheres: specimen.spheres,
            threads,
            solver: tuning.solver,
            blas_threads: tuning.blas_threads,
            run,
            steps: 2 * remesh_interval + 1,
            remesh_interval,
            young: 1e6,
            stiffness_ratio: 0.5,
            friction_angle: 30_f64.to_radians(),
            density: 2600.0,
            damping: 0.2,
            viscosity: 1e-3,
            stress: 1e3,
            dt: 1e-6,
        }
    }

    /// The run in YADE, and its number of pores.
    ///
    /// # Errors
    /// [`Error::Peer`] when it fails or its clocks are not those expected.
    pub fn yade(&self, bench: &Bench) -> Result<(Side, u64), Error> {
        let Job { spheres, threads, solver, blas_threads, run, .. } = self;
        let step = format!("time-{spheres}-{threads}-solver{solver}-blas{blas_threads}-run{run}");
        bench.remembered(&step, self, || {
            let answer = bench.yade::<Record>(&step, SCRIPT, self.threads, self)?;
            let times = answer.result.times(self.steps).map_err(|what| Error::Peer {
                step: step.clone(),
                what: format!("YADE {what}"),
                log: Some(bench.folder.join("logs").join(format!("{step}.log"))),
            })?;
            let side = Side {
                times,
                peak_memory_bytes: answer.peak_memory_bytes,
                base_memory_bytes: Some(answer.result.base_memory_bytes),
            };
            Ok((side, answer.result.pores))
        })
    }

    /// The run in our program.
    ///
    /// # Errors
    /// [`Error::Peer`] when it fails.
    pub fn ours(&self, bench: &Bench) -> Result<Side, Error> {
        let step = format!("time-{}-{}-run{}", self.spheres, self.threads, self.run);
        bench.remembered(&format!("{step}-ours"), self, || {
            let summary = bench.ours(&step, &self.scene(), self.threads)?.summary;
            let wrong = |what: String| Error::Peer {
                step: step.clone(),
                what: format!("dempfv: {what}"),
                log: Some(bench.folder.join("logs").join(format!("{step}-dempfv.log"))),
            };
            let times = Times::from_summary(&summary).map_err(wrong)?;
            let peak_memory_bytes = summary["peak_memory_bytes"].as_u64().unwrap_or(0);
            Ok(Side { times, peak_memory_bytes, base_memory_bytes: None })
        })
    }

    fn scene(&self) -> String {
        format!(
            r#"title = "the specimen of Caulk et al. (2020), for its times"
[particles]
packing = {:?}
density = {:?}
young = {:?}
stiffness_ratio = {:?}
friction_angle = {:?}
[walls]
friction_angle = 0.0
[dem]
dt = {:?}
damping = {:?}
[fluid]
viscosity = {:?}
remesh_interval = {}
clamp = "yade"
pressure = {{ y_max = 0.0 }}
[[stage]]
kind = "run"
steps = {}
walls = {{ y_max = {{ stress = {:?} }} }}
[output]
history_every = {}
pictures = false
"#,
            self.packing.display().to_string(),
            self.density,
            self.young,
            self.stiffness_ratio,
            self.friction_angle.to_degrees(),
            self.dt,
            self.damping,
            self.viscosity,
            self.remesh_interval,
            self.steps,
            self.stress,
            self.steps,
        )
    }
}
