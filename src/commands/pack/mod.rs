//! `dempfv pack`: makes a settled packing, or a larger one of copies.

mod tile;

use std::fmt;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

use dempfv::dem::Dem;
use dempfv::io::packing;
use dempfv::scene::{Plan, StageKind, validate_packing};
use dempfv::simulation::{Compaction, Outcome, Simulation, Specimen};
use dempfv::{Error, InputError};
use dempfv_report::format::{count, si, three_digits};
use dempfv_report::output::{OutputArgs, make_folder};
use serde::Serialize;

use super::{Context, memory};

/// File in the output folder that holds the packing.
const FILE: &str = "packing.txt";

/// What `pack` takes: a scene with a compact stage, the options that stand for
/// one, or a packing to be copied.
#[derive(clap::Args)]
pub struct Args {
    /// Scene file with a compact stage; the packing is that stage's. With --tile: a packing
    #[arg(conflicts_with_all = ["count", "spread", "edge", "seed"], value_name = "SCENE")]
    input: Option<PathBuf>,
    /// Put so many copies of a packing side by side along x, y and z
    #[arg(long, num_args = 3, value_names = ["NX", "NY", "NZ"], requires = "input")]
    tile: Option<Vec<u32>>,
    /// Number of spheres
    #[arg(long, default_value_t = 1000)]
    count: u32,
    /// Radii are uniform in mean·(1 ± SPREAD)
    #[arg(long, default_value_t = 0.3, allow_negative_numbers = true)]
    spread: f64,
    /// Edge of the cubical box (m)
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true)]
    edge: f64,
    /// Isotropic stress (Pa); 1e4 if not given. Copies settle again only where it is given
    #[arg(long, allow_negative_numbers = true)]
    stress: Option<f64>,
    /// Contact modulus (Pa); 1e6 if not given
    #[arg(long, allow_negative_numbers = true)]
    young: Option<f64>,
    /// Friction angle while packing (degrees): low packs densely; 3 if not given
    #[arg(long, allow_negative_numbers = true)]
    friction: Option<f64>,
    /// Seed of the random cloud
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    output: OutputArgs,
}

impl Args {
    /// Stress (Pa), modulus (Pa) and friction angle (degrees) of the growth.
    fn growth(&self) -> (f64, f64, f64) {
        (self.stress.unwrap_or(1e4), self.young.unwrap_or(1e6), self.friction.unwrap_or(3.0))
    }
}

/// The packing that was made.
#[derive(Serialize)]
pub struct Report {
    file: PathBuf,
    particles: usize,
    steps: u64,
    /// `None` of copies that have not settled again.
    #[serde(flatten)]
    compaction: Option<Compaction>,
}

/// Makes a packing and writes it. `None`: Ctrl-C ended it, nothing was written.
///
/// # Errors
/// What is wrong in the scene or the options, or why the packing does not
/// settle.
pub fn run(args: &Args, context: &Context) -> Result<Option<Report>, Error> {
    if let (Some(copies), Some(packing)) = (&args.tile, &args.input) {
        return tile::run(args, copies, packing, context);
    }
    let plan = compaction_plan(args)?;
    let name = args.input.clone().unwrap_or_else(|| PathBuf::from("packing"));
    let folder = args.output.folder(&name, FILE)?;
    let interrupted = context.interruption()?;
    Specimen::of_cloud(&plan).map(|cloud| memory::check(&plan, &cloud)).transpose()?;
    let mut simulation = Simulation::new(plan)?;
    let mut progress = context.progress();
    progress.begin("compact", 0, false);
    while simulation.advance()? {
        if interrupted.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let coupled = simulation.coupled();
        progress.update(simulation.step(), None, || si(coupled.dem().mean_stress(), "Pa"));
    }
    progress.end(simulation.step(), "");
    let Some(Outcome::Compact(compaction)) =
        simulation.outcomes().last().map(|o| o.outcome.clone())
    else {
        return Err(InputError::new("the scene has no compact stage", "add one").into());
    };
    check_overlaps(simulation.coupled().dem(), &compaction)?;
    make_folder(&folder)?;
    let file = folder.join(FILE);
    write(&file, &simulation, &compaction)?;
    let particles = simulation.coupled().dem().storage().len();
    Ok(Some(Report { file, particles, steps: simulation.step(), compaction: Some(compaction) }))
}

/// Refuses a packing that no command would read: one that is mostly overlap.
fn check_overlaps(dem: &Dem, compaction: &Compaction) -> Result<(), InputError> {
    if dem.cell().is_some() {
        // The rule is how far spheres may reach through walls.
        return Ok(());
    }
    let particles = dem.storage();
    validate_packing(&particles.position, &particles.radius, None, &dem.box_(), None).map_err(|e| {
        let (stress, young) = (si(compaction.stress_pa, "Pa"), si(dem.material().young, "Pa"));
        let what = format!(
            "at {stress} spheres of E = {young} overlap so much that they make no packing (porosity {}): {}",
            three_digits(compaction.porosity),
            e.what
        );
        InputError::new(what, "ask for a stress of no more than some hundredths of E, or a larger E")
    })
}

/// The scene up to its first compact stage.
fn compaction_plan(args: &Args) -> Result<Plan, Error> {
    let Some(scene) = &args.input else {
        check_options(args)?;
        return Ok(Plan::from_toml(&scene_text(args), None)?);
    };
    let given = [("stress", args.stress), ("young", args.young), ("friction", args.friction)];
    if let Some((name, _)) = given.iter().find(|(_, value)| value.is_some()) {
        let what = format!("--{name} beside a scene, which says what it is");
        return Err(InputError::new(what, "change the scene, or leave the scene out").into());
    }
    let mut plan = Plan::load(scene)?;
    let compact = plan.stages.iter().position(|s| matches!(s.kind, StageKind::Compact(_)));
    let compact = compact.ok_or_else(|| {
        InputError::new("no stage of the kind compact", "add one: it is what makes a packing")
            .in_file(scene)
    })?;
    plan.stages.truncate(compact + 1);
    Ok(plan)
}

/// What a scene would refuse, in the words of the options.
fn check_options(args: &Args) -> Result<(), InputError> {
    let positive = |v: f64| v > 0.0 && v.is_finite();
    let (stress, young, friction) = args.growth();
    let checks = [
        ("count", f64::from(args.count), args.count >= 2, "give two spheres or more"),
        ("spread", args.spread, (0.0..1.0).contains(&args.spread), "give 0 to less than 1"),
        ("edge", args.edge, positive(args.edge), "give a length in m"),
        ("stress", stress, positive(stress), "give a pressure in Pa"),
        ("young", young, positive(young), "give a modulus in Pa"),
        ("friction", friction, (0.0..90.0).contains(&friction), "give 0 to less than 90 degrees"),
    ];
    match checks.into_iter().find(|(_, _, fine, _)| !fine) {
        Some((name, value, _, remedy)) => {
            Err(InputError::new(format!("--{name} {value} makes no packing"), remedy))
        }
        None => Ok(()),
    }
}

/// The options as a scene, so that they meet the same checks.
fn scene_text(args: &Args) -> String {
    let Args { count, spread, edge, seed, .. } = args;
    let (stress, young, friction) = args.growth();
    format!(
        "title = \"packing\"\nseed = {seed}\n\
         [box]\nmin = [0, 0, 0]\nmax = [{edge:?}, {edge:?}, {edge:?}]\n\
         [particles]\nyoung = {young:?}\ncloud = {{ count = {count}, spread = {spread:?}, porosity = 0.9 }}\n\
         [dem]\n\
         [[stage]]\nkind = \"compact\"\nstress = {stress:?}\nfriction_angle = {friction:?}\n"
    )
}

fn write(
    file: &std::path::Path,
    simulation: &Simulation,
    compaction: &Compaction,
) -> Result<(), Error> {
    let comment = format!(
        "{}: settled at {:.6e} Pa by growth (dempfv {}, seed {}); metres",
        simulation.plan().title,
        compaction.stress_pa,
        env!("CARGO_PKG_VERSION"),
        simulation.plan().seed
    );
    write_spheres(file, simulation.coupled().dem(), &comment)
}

/// The spheres of a packing in the user's order, with their box or their periodic cell.
///
/// # Errors
/// When the file cannot be written.
pub fn write_spheres(file: &std::path::Path, dem: &Dem, comment: &str) -> Result<(), Error> {
    if let Some(cell) = dem.cell() {
        let (position, radius) = (dem.wrapped_positions(), dem.radii());
        return Ok(packing::write_in_cell(file, &position, &radius, cell.cell(), comment)?);
    }
    let particles = dem.storage();
    let mut order: Vec<usize> = (0..particles.len()).collect();
    order.sort_unstable_by_key(|&i| particles.id[i]);
    let position: Vec<_> = order.iter().map(|&i| particles.position[i]).collect();
    let radius: Vec<_> = order.iter().map(|&i| particles.radius[i]).collect();
    Ok(packing::write(file, &position, &radius, Some(&dem.box_()), comment)?)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "  particles            {}", count(self.particles as u64))?;
        writeln!(f, "  steps                {}", count(self.steps))?;
        if let Some(c) = &self.compaction {
            writeln!(f, "  stress               {}", si(c.stress_pa, "Pa"))?;
            writeln!(f, "  unbalanced force     {:.1e}", c.unbalanced_force)?;
            writeln!(f, "  porosity             {}", three_digits(c.porosity))?;
            writeln!(f, "  coordination number  {}", three_digits(c.coordination_number))?;
        }
        writeln!(f, "  written              {}", self.file.display())
    }
}
