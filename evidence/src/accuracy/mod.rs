//! `dempfv accuracy`: what accuracy costs in time, for any scene whose spheres move.

mod choose;
mod course;
mod errors;
mod knobs;
mod page;
mod picture;
mod setting;
mod study;
mod sweep;

use std::fmt;
use std::path::{Path, PathBuf};

use dempfv::InputError;
use dempfv::io::atomic;
use dempfv::scene::{ParticleSource, Plan};
use dempfv_report::machine;
use dempfv_report::output::{OutputArgs, lock_folder, make_folder};
use serde::{Deserialize, Serialize};

use self::choose::{Choice, choose};
use self::setting::Setting;
use self::study::{Extent, Study};
use self::sweep::{Point, Runs};
use crate::Result;

/// The file that marks a result, and the other ones beside it.
const JSON: &str = "accuracy.json";
const CSV: &str = "accuracy.csv";
const MARKDOWN: &str = "accuracy.md";
const HTML: &str = "accuracy.html";
const PICTURES: [&str; 2] = ["accuracy", "accuracy-alone"];
/// The scene with the settings for `--target`.
const SCENE: &str = "chosen.toml";
/// Folder of single runs, so that a sweep that was stopped goes on.
const RUNS: &str = "runs";
const BEGUN: &str = "begun.json";
/// Errors for which settings are chosen where none is asked for.
const TARGETS: [f64; 3] = [0.05, 0.01, 0.001];
/// Seconds that the reference may take.
const BUDGET: f64 = 240.0;
const QUICK_BUDGET: f64 = 18.0;

/// What `accuracy` takes.
#[derive(clap::Args)]
pub struct Args {
    /// Scene file
    scene: PathBuf,
    /// Error to choose settings for, as 0.01 for 1 %; writes the scene with them
    #[arg(long, value_name = "ERR")]
    target: Option<f64>,
    /// A short window and fewer settings: minutes become one or two
    #[arg(long)]
    quick: bool,
    /// Seconds that the reference may take: they choose how much of the stage is looked at. 240 if not
    /// given, 18 with --quick
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    seconds: Option<f64>,
    #[command(flatten)]
    output: OutputArgs,
}

impl Args {
    /// Seconds for the reference.
    fn budget(&self) -> Result<f64> {
        let budget = self.seconds.unwrap_or(if self.quick { QUICK_BUDGET } else { BUDGET });
        if budget > 0.0 && budget.is_finite() {
            return Ok(budget);
        }
        let remedy = "give a number of seconds above 0";
        Err(InputError::new(format!("--seconds is {budget}"), remedy).into())
    }
}

/// Of a sweep that has begun: it goes on with the same window.
#[derive(PartialEq, Serialize, Deserialize)]
struct Begun {
    scene: String,
    budget: f64,
    window: f64,
    whole: bool,
    state_hash: String,
}

/// What was found.
#[derive(Serialize)]
pub struct Report {
    scene: PathBuf,
    spheres: usize,
    stage: String,
    /// Model time of all runs (s), and whether that is the whole stage.
    window_s: f64,
    whole_stage: bool,
    /// What separates two references (1): by their solvers, and by steps twice as long.
    floor: f64,
    step_floor: f64,
    /// Wall seconds per second of model time of the reference.
    reference_seconds: f64,
    points: Vec<Point>,
    chosen: Vec<Choice>,
    #[serde(skip)]
    words: String,
    #[serde(skip)]
    page: PathBuf,
}

/// Sweeps a scene's settings and writes the table, the picture and the pages.
///
/// # Errors
/// What is wrong in the options or the scene; or why the reference, or the scene itself, cannot go on.
pub fn run(args: &Args) -> Result<Report> {
    if let Some(target) = args.target
        && !(target > 0.0 && target < 1.0)
    {
        let remedy = "give the error as a share between 0 and 1, as 0.01 for 1 %";
        return Err(InputError::new(format!("--target is {target}"), remedy).into());
    }
    let budget = args.budget()?;
    let mut plan = Plan::load(&args.scene)?;
    if let ParticleSource::Packing(path) = &mut plan.particles.source {
        // A scene that is written elsewhere finds it, too. What is not there is told of below.
        *path = path.canonicalize().unwrap_or_else(|_| path.clone());
    }
    let folder = args.output.folder(&args.scene, JSON)?;
    let title = format!("What accuracy costs: {}", plan.title);
    let runs_folder = folder.join(RUNS);
    let scene = plan.to_toml();
    // Where there is a result, its times are not wanted again.
    let begun = (!folder.join(JSON).exists()).then(|| Begun::read(&runs_folder)).flatten();
    let begun = begun.filter(|b| b.scene == scene && b.budget == budget);
    let extent = begun.as_ref().map_or(Extent::Budget(budget), |b| Extent::Window(b.window));
    let mut study = Study::of(plan.clone(), extent)?;
    let begun = begun.filter(|begun| begun.state_hash == study.state_hash);
    match &begun {
        Some(begun) => study.whole |= begun.whole,
        None if matches!(extent, Extent::Window(_)) => {
            study = Study::of(plan, Extent::Budget(budget))?;
        }
        None => {}
    }
    make_folder(&folder)?;
    let _alone = lock_folder(&folder)?;
    if begun.is_none() && runs_folder.exists() {
        let gone = std::fs::remove_dir_all(&runs_folder);
        gone.map_err(|e| dempfv::Error::io(&runs_folder, e))?;
    }
    make_folder(&runs_folder)?;
    dempfv_report::json::write(
        &runs_folder.join(BEGUN),
        &Begun {
            scene,
            budget,
            window: study.window,
            whole: study.whole,
            state_hash: study.state_hash.clone(),
        },
    )?;
    let mut runs = Runs::new(&study, &runs_folder, args.quick);
    let sweep = runs.sweep()?;
    let targets = args.target.map_or(TARGETS.to_vec(), |target| vec![target]);
    let mut chosen: Vec<Choice> =
        targets.iter().map(|&target| choose(&study, &mut runs, &sweep, target)).collect();
    if args.target.is_some() {
        for choice in &mut chosen {
            let settings = &choice.point.settings;
            let scene = study.with(settings).to_toml();
            atomic::write(&folder.join(SCENE), scene.as_bytes())?;
            match elsewhere(&study, settings, &runs_folder) {
                Ok(error) => choice.elsewhere = error,
                Err(error) => choice.not_elsewhere = Some(error.to_string()),
            }
        }
    }
    let pictures = [picture::together(&title, &sweep, &chosen), picture::alone(&title, &sweep)];
    for (picture, name) in pictures.iter().zip(PICTURES) {
        picture.save(&folder, name)?;
    }
    let parts = [
        page::about(&study, &sweep),
        page::words(&chosen, sweep.step_floor.main()),
        page::orders(&sweep),
        page::DEFINITIONS.to_owned(),
        format!("{}. Measured on {}.", machine::description(), machine::today()),
    ];
    let parts: Vec<String> = parts.into_iter().filter(|part| !part.is_empty()).collect();
    let markdown = format!(
        "# {title}\n\n![Error against time]({}.png)\n\n![What each knob does alone]({}.png)\n\n{}\n\n{}",
        PICTURES[0],
        PICTURES[1],
        parts.join("\n\n"),
        page::points_table(&sweep, &chosen)
    );
    atomic::write(&folder.join(MARKDOWN), markdown.as_bytes())?;
    atomic::write(&folder.join(CSV), page::csv(&sweep, &chosen).as_bytes())?;
    let svg = pictures.map(|picture| picture.to_svg()).join("\n");
    let html = page::html(&title, &svg, &parts, &sweep, &chosen);
    let html_path = folder.join(HTML);
    atomic::write(&html_path, html.as_bytes())?;
    let words = page::words(&chosen, sweep.step_floor.main());
    let (floor, reference_seconds) = (sweep.floor.main(), sweep.reference_seconds(study.window));
    let step_floor = sweep.step_floor.main();
    let mut points = vec![sweep.scene];
    points.extend(sweep.points);
    let report = Report {
        scene: args.scene.clone(),
        spheres: study.spheres,
        stage: study.stage_name.clone(),
        window_s: study.window,
        whole_stage: study.whole,
        floor,
        step_floor,
        reference_seconds,
        points,
        words,
        chosen,
        page: html_path,
    };
    dempfv_report::json::write(&folder.join(JSON), &report)?;
    Ok(report)
}

impl Begun {
    fn read(folder: &Path) -> Option<Begun> {
        serde_json::from_slice(&std::fs::read(folder.join(BEGUN)).ok()?).ok()
    }
}

/// Error of these settings in a study that was not used for choosing them.
fn elsewhere(study: &Study, settings: &[Setting], folder: &Path) -> Result<Option<f64>> {
    let Some(other) = study.another(study.window / 3.0)? else { return Ok(None) };
    let folder = folder.join("elsewhere");
    make_folder(&folder)?;
    Runs::new(&other, &folder, true).error(settings).map(Some)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "  stage          {}, {} spheres", self.stage, self.spheres)?;
        for line in self.words.lines() {
            writeln!(f, "  {line}")?;
        }
        writeln!(f, "  written        {}", self.page.display())
    }
}
