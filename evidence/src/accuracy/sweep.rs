//! All runs of a study: the reference, the scene as it is, and each setting of each knob.

use std::path::{Path, PathBuf};

use dempfv::io::atomic;
use dempfv::scene::Plan;
use dempfv::solver::SolverKind;
use dempfv_report::progress::Progress;
use serde::{Deserialize, Serialize};

use super::course::{Course, run};
use super::errors::Errors;
use super::knobs::knobs;
use super::setting::Setting;
use super::study::Study;
use crate::Result;
use crate::bench::sample::Sample;

/// Runs that take less than so many seconds are carried out as often as [`TURNS`], to see how times
/// spread.
const SHORT: f64 = 8.0;
const TURNS: usize = 3;

/// A run beside the reference.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    /// What it changes.
    pub knob: &'static str,
    /// How, as a scene says it.
    pub setting: String,
    /// Distance from the reference.
    pub errors: Errors,
    /// Distance from the same scene with the finest setting of this knob.
    pub own: Errors,
    /// The main one of `errors` ([`Errors::main`]); `null` where the run failed.
    pub error: f64,
    /// Wall seconds per second of model time, of each turn.
    pub seconds_per_second: Sample,
    /// Their median.
    pub seconds: f64,
    /// The finest setting of its knob, which has no error of its own.
    pub is_finest: bool,
    /// The own error is below what separates two references.
    pub under_floor: bool,
    /// Steps, and networks that came into use.
    pub steps: u64,
    pub networks: u64,
    /// Largest distance of the degree of consolidation from Terzaghi's theory (1), in a consolidation.
    pub theory: Option<f64>,
    /// The error that the run estimated of itself (1).
    pub estimate: Option<f64>,
    /// What the balance of energy misses, over all that was moved (1).
    pub energy: Option<f64>,
    /// Why the run did not come through the window.
    pub failed: Option<String>,
    /// The settings themselves.
    #[serde(skip)]
    pub settings: Vec<Setting>,
}

/// All runs of a study.
pub struct Sweep {
    pub reference: Course,
    /// What separates two references that differ by the linear solver alone.
    pub floor: Errors,
    /// What separates the reference from one whose steps are twice as long: no error below is known.
    pub step_floor: Errors,
    /// The scene as it is.
    pub scene: Point,
    pub points: Vec<Point>,
}

impl Sweep {
    /// Wall seconds per second of model time that the reference takes, whose window has this length (s).
    pub fn reference_seconds(&self, window: f64) -> f64 {
        Sample(self.reference.seconds.clone()).median() / window
    }
}

/// Runs, kept in files, so that a sweep that was stopped goes on.
pub struct Runs<'a> {
    study: &'a Study,
    folder: PathBuf,
    quick: bool,
    progress: Progress,
    /// What separates two references.
    floor: Errors,
}

/// A run that is done.
#[derive(Serialize, Deserialize)]
struct Kept {
    /// Of the spheres where it began, and the program.
    state: String,
    scene: String,
    start: f64,
    window: f64,
    course: Course,
}

impl<'a> Runs<'a> {
    pub fn new(study: &'a Study, folder: &Path, quick: bool) -> Runs<'a> {
        Runs {
            study,
            folder: folder.to_owned(),
            quick,
            progress: Progress::new(),
            floor: Errors::default(),
        }
    }

    /// The run of a plan under this name, unless it is there already.
    fn course(&mut self, name: &str, plan: &Plan) -> Result<Course> {
        let path = self.folder.join(format!("{}.json", slug(name)));
        let Study { start, window, .. } = *self.study;
        let state = format!("{} {}", env!("CARGO_PKG_VERSION"), self.study.state_hash);
        let scene = plan.to_toml();
        let kept = std::fs::read(&path).ok().and_then(|b| serde_json::from_slice::<Kept>(&b).ok());
        if let Some(kept) = kept
            && (&kept.state, &kept.scene) == (&state, &scene)
            && (kept.start, kept.window) == (start, window)
        {
            return Ok(kept.course);
        }
        self.progress.wait(name);
        let quick = self.quick;
        let turns = |seconds: f64| if quick || seconds > SHORT { 1 } else { TURNS };
        let course = run(self.study, plan, turns)?;
        self.progress.waited();
        let kept = Kept { state, scene, start, window, course };
        let text = dempfv_report::json::text(&kept)?;
        atomic::write(&path, text.as_bytes())?;
        Ok(kept.course)
    }

    /// The reference, and how far it is from the one with the other solver.
    fn reference(&mut self) -> Result<(Course, Errors)> {
        let plan = self.study.reference();
        let reference = self.course("reference", &plan)?;
        let Some(fluid) = &plan.fluid else { return Ok((reference, Errors::default())) };
        let other = match fluid.solver {
            SolverKind::Cholmod => SolverKind::Frontal,
            SolverKind::Frontal => SolverKind::Cholmod,
            _ => self.other_than_auto()?,
        };
        let mut settings = self.study.reference_settings();
        settings.push(Setting::Solver(other));
        let again = self.course("reference, other solver", &self.study.with(&settings))?;
        let floor = Errors::between(&again, &reference);
        Ok((reference, floor))
    }

    /// How far the reference is from one whose steps are twice as long.
    fn longer_steps(&mut self, reference: &Course) -> Result<Errors> {
        if self.study.is_static {
            return Ok(Errors::default());
        }
        let mut settings = self.study.reference_settings();
        for setting in &mut settings {
            if let Setting::TimeStep(share) = setting {
                *share *= 2.0;
            }
        }
        let longer = self.course("reference, longer steps", &self.study.with(&settings))?;
        Ok(Errors::between(&longer, reference).beside_floor(&self.floor))
    }

    /// The solver that `auto` does not take for this scene.
    fn other_than_auto(&self) -> Result<SolverKind> {
        let mut simulation = dempfv::simulation::Simulation::restart(
            self.study.plan.clone(),
            self.study.state.clone(),
        )?;
        simulation.advance()?;
        let taken = simulation.coupled().storage_flow().and_then(|flow| flow.solved_by());
        Ok(if taken == Some("frontal") { SolverKind::Cholmod } else { SolverKind::Frontal })
    }

    /// A run with these settings beside the reference.
    pub fn point(
        &mut self,
        knob: &'static str,
        settings: &[Setting],
        (reference, finest): (&Course, Option<&Course>),
        floor: f64,
    ) -> (Point, Option<Course>) {
        let labels: Vec<String> = settings.iter().map(Setting::to_string).collect();
        let setting = if labels.is_empty() { "as it is".to_owned() } else { labels.join(", ") };
        let plan = self.study.with(settings);
        let name = format!("{knob} {setting}");
        let (course, failed) = match self.course(&name, &plan) {
            Ok(course) => (Some(course), None),
            Err(error) => (None, Some(error.to_string())),
        };
        let between = |a: &Course, b| Errors::between(a, b).beside_floor(&self.floor);
        let errors = course.as_ref().map_or(Errors::default(), |c| between(c, reference));
        let own = match (&course, finest) {
            (Some(course), Some(finest)) => between(course, finest),
            _ => Errors::default(),
        };
        let per_second = |c: &Course| c.seconds.iter().map(|s| s / self.study.window).collect();
        let times: Sample = course.as_ref().map_or(Sample::default(), per_second);
        let point = Point {
            knob,
            setting,
            errors,
            own,
            error: errors.main(),
            seconds: times.median(),
            seconds_per_second: times,
            is_finest: false,
            under_floor: own.main() < floor,
            steps: course.as_ref().map_or(0, |c| c.steps),
            networks: course.as_ref().map_or(0, |c| c.networks),
            theory: course.as_ref().and_then(|c| c.theory),
            estimate: course.as_ref().and_then(|c| c.estimate),
            energy: course.as_ref().and_then(|c| c.energy),
            failed,
            settings: settings.to_vec(),
        };
        (point, course)
    }

    /// The main error of a run with these settings.
    pub fn error(&mut self, settings: &[Setting]) -> Result<f64> {
        let reference = self.course("reference", &self.study.reference())?;
        let course = self.course("chosen", &self.study.with(settings))?;
        Ok(Errors::between(&course, &reference).main())
    }

    /// All runs.
    pub fn sweep(&mut self) -> Result<Sweep> {
        let (exact, floor) = self.reference()?;
        let limit = floor.main();
        self.floor = floor;
        let step_floor = self.longer_steps(&exact)?;
        // A scene that cannot go on has no accuracy.
        self.course("scene as it is", &self.study.plan)?;
        let (scene, _) = self.point("scene", &[], (&exact, None), limit);
        let mut points = vec![];
        // All that renews networks is beside a network at each step.
        let mut each_step: Option<Course> = None;
        for settings in knobs(self.study, self.quick) {
            let mut finest: Option<Course> = None;
            for (i, setting) in settings.iter().enumerate() {
                let beside = match setting {
                    // Nothing is left out in the scene as it is.
                    Setting::Without(_) => Some(self.course("scene as it is", &self.study.plan)?),
                    Setting::Strain(_)
                    | Setting::Mode(_)
                    | Setting::Update(_)
                    | Setting::IteratedTolerance(_) => each_step.clone(),
                    // It has no finest setting.
                    Setting::Target(_) => Some(exact.clone()),
                    _ => finest.clone(),
                };
                let (mut point, course) =
                    self.point(setting.knob(), &[*setting], (&exact, beside.as_ref()), limit);
                if i == 0 && beside.is_none() {
                    point.is_finest = course.is_some();
                    finest = course;
                    if matches!(setting, Setting::Interval(_)) {
                        each_step = finest.clone();
                    }
                }
                points.push(point);
            }
        }
        Ok(Sweep { reference: exact, floor, step_floor, scene, points })
    }
}

/// A name of a file for a setting.
fn slug(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' };
    let all: String = name.chars().map(plain).collect();
    let parts: Vec<&str> = all.split('-').filter(|part| !part.is_empty()).collect();
    parts.join("-").to_lowercase()
}
