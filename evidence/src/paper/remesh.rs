//! Figure 2: what the remesh interval does to the pressures, and what it costs.

use std::path::Path;
use std::time::Instant;

use dempfv::Vec3;
use dempfv::coupling::Coupled;
use dempfv::scene::Plan;
use dempfv::simulation::Simulation;
use dempfv::solver::SolverKind;
use dempfv_report::versions;
use serde::{Deserialize, Serialize};

use super::specimens::{SPECIMENS, Specimen};
use crate::Error;
use crate::bench::Bench;

/// Steps after which the pressures are compared; every interval below divides it, so that
/// each network is at its oldest then.
pub const STEPS: u64 = 1200;
/// The remesh intervals, beside that of the reference: every step.
pub const INTERVALS: [u64; 9] = [2, 5, 10, 20, 50, 100, 200, 400, 1200];
/// Runs of the same scene.
pub const REPLICATES: usize = 6;
/// Load on the drained wall (Pa), on a packing that has settled at a tenth of it: the
/// pressures have to change in 1200 steps for their error to be seen.
pub const LOAD: f64 = 1e4;

/// The specimen: a remesh at every step has to be affordable.
pub const SPECIMEN: Specimen = SPECIMENS[0];

/// The state of a run after its last step.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct End {
    /// Steps from one remesh to the next.
    pub interval: u64,
    /// Threads that it ran on.
    pub threads: usize,
    /// Time of all steps by the clock (s).
    pub wall_s: f64,
    /// Pressure at the sphere nearest to the middle of the sealed bottom (Pa).
    pub at_bottom: f64,
    /// Pressure at each sphere, by the user's numbers: the mean of the pores around it,
    /// by volume (Pa). Networks differ in their pores, but not in their spheres.
    pub at_spheres: Vec<f64>,
    /// Of positions, velocities and pressures.
    pub state_hash: String,
    /// Revision of this program.
    pub git: String,
}

/// Every run of Figure 2.
#[derive(Debug, Serialize, Deserialize)]
pub struct Remesh {
    /// The same scene with a remesh at every step, then with each interval.
    pub intervals: Vec<End>,
    /// The same scene and interval again and again, on one thread and on all.
    pub replicates: Vec<End>,
}

impl Remesh {
    /// The run that remeshes at every step.
    pub fn reference(&self) -> Option<&End> {
        self.intervals.iter().find(|end| end.interval == 1)
    }

    /// Distance of a run's pressures from the reference's, relative to those (1).
    pub fn error(&self, end: &End) -> f64 {
        let Some(reference) = self.reference() else { return f64::NAN };
        let pairs = || end.at_spheres.iter().zip(&reference.at_spheres);
        let off: f64 = pairs().map(|(p, q)| (p - q).powi(2)).sum();
        let size: f64 = pairs().map(|(_, q)| q.powi(2)).sum();
        (off / size).sqrt()
    }

    /// True when all replicates have ended in the same bits.
    pub fn is_reproducible(&self) -> bool {
        self.replicates.windows(2).all(|w| w[0].state_hash == w[1].state_hash)
    }
}

/// The runs of one interval or replicate that an earlier call has not made.
///
/// # Errors
/// As a simulation, and when the result cannot be kept.
pub fn measure(bench: &Bench, run: Run, all: usize) -> Result<End, Error> {
    let threads = run.threads(all);
    let packing = SPECIMEN.packing(bench)?;
    let input = (scene(Path::new(&SPECIMEN.origin()), run.interval()), threads);
    let name = run.name();
    bench.remembered(&name, &input, || {
        let plan = Plan::from_toml(&scene(&packing, run.interval()), None)?;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|e| dempfv::Error::io("threads", std::io::Error::other(e)))?;
        bench.step(&name, || pool.install(|| carry_out(plan, run.interval(), threads)))
    })
}

/// What an earlier call measured; `None` unless all of it is known.
///
/// # Errors
/// None that a user could cause.
pub fn known(bench: &Bench, all: usize) -> Result<Option<Remesh>, Error> {
    let origin = SPECIMEN.origin();
    let end = |run: Run| {
        let input = (scene(Path::new(&origin), run.interval()), run.threads(all));
        bench.known::<End>(&run.name(), &input)
    };
    let ends: Option<Vec<End>> = Run::all().map(end).collect::<Result<_, _>>()?;
    Ok(ends.map(|mut intervals| {
        let replicates = intervals.split_off(INTERVALS.len() + 1);
        Remesh { intervals, replicates }
    }))
}

/// One run of Figure 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Run {
    /// With this remesh interval.
    Interval(u64),
    /// Once more with the paper's interval.
    Replicate(usize),
}

impl Run {
    /// Every run: those of 2a, then those of 2b.
    pub fn all() -> impl Iterator<Item = Run> {
        let intervals = [1].into_iter().chain(INTERVALS).map(Run::Interval);
        intervals.chain((1..=REPLICATES).map(Run::Replicate))
    }

    /// Name of its file.
    pub fn name(self) -> String {
        match self {
            Run::Interval(steps) => format!("remesh-every-{steps}"),
            Run::Replicate(k) => format!("remesh-replicate-{k}"),
        }
    }

    /// Steps from one remesh to the next.
    pub fn interval(self) -> u64 {
        match self {
            Run::Interval(steps) => steps,
            Run::Replicate(_) => super::timing::INTERVAL,
        }
    }

    /// Threads where there are `all`: replicates take turns between one and all.
    fn threads(self, all: usize) -> usize {
        match self {
            Run::Replicate(k) if k % 2 == 0 => 1,
            _ => all,
        }
    }
}

fn scene(packing: &Path, interval: u64) -> String {
    // By name, as in the runs of the other figures.
    let solver = SolverKind::default();
    format!(
        "title = \"Remesh every {interval} steps\"\n\
         [particles]\npacking = {packing:?}\ndensity = 2600.0\nyoung = 1.0e6\n\
         stiffness_ratio = 0.5\nfriction_angle = 30.0\n\
         [dem]\ndt = 1.0e-6\ndamping = 0.2\n\
         [fluid]\nviscosity = 1.0e-3\npressure = {{ y_max = 0.0 }}\n\
         remesh_interval = {interval}\nsolver = \"{solver}\"\n\
         [[stage]]\nkind = \"run\"\nsteps = {STEPS}\nwalls = {{ y_max = {{ stress = {LOAD:?} }} }}\n"
    )
}

fn carry_out(plan: Plan, interval: u64, threads: usize) -> Result<End, Error> {
    let mut simulation = Simulation::new(plan)?;
    let start = Instant::now();
    while simulation.advance()? {}
    let wall_s = start.elapsed().as_secs_f64();
    let coupled = simulation.coupled();
    let at_spheres = coupled.pressure_at_spheres();
    Ok(End {
        interval,
        threads,
        wall_s,
        at_bottom: at_spheres[bottom(coupled)],
        at_spheres,
        state_hash: simulation.state_hash(),
        git: versions::GIT.to_owned(),
    })
}

/// The user's number of the sphere nearest to the middle of the bottom, y_min.
fn bottom(coupled: &Coupled) -> usize {
    let particles = coupled.dem().particles();
    let bounds = coupled.dem().box_();
    let mut middle = 0.5 * (bounds.min + bounds.max);
    middle.y = bounds.min.y;
    let off = |x: &Vec3| (x - middle).norm_squared();
    let nearest = (0..particles.len())
        .min_by(|&i, &j| off(&particles.position[i]).total_cmp(&off(&particles.position[j])));
    nearest.map_or(0, |i| particles.id[i] as usize)
}
