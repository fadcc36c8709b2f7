//! What a plan will cost, before anything is built.
//!
//! Counts and rates were fitted to settled packings of 1,000 to 135,000 spheres of similar
//! size on two cores of a server of 2022 (November 2026, `benches/report.md` of the
//! repository); they are right within a factor of two or so on other machines and packings.
//! The solvers tell of themselves ([`SolverKind::cost`](crate::solver::SolverKind::cost)).
//! Where exact counts are known, they are used.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::phase_costs::{
    BASE_BYTES, BYTES_PER_SPHERE, FlowSize, PICTURE_BYTES, dry_step, remesh_share,
};
use super::specimen::Specimen;
use crate::coupling::{TimeStepBounds, TimeStepRule, viscous_time_step};
use crate::dem::law::{ContactLaw, Stiffness, TwoSpheres};
use crate::scene::*;
use crate::{InputError, Result};

/// The bounds on the time step for the smallest sphere of a specimen, where
/// its contacts and pores are not known: √2 √(m / k), k for six contacts of
/// random direction, and eq. A.11 of Caulk 2020 where a stage couples the
/// fluid.
///
/// With contacts of random direction, the diagonal of the summed stiffness is 6 (k_n + 2 k_s) / 3;
/// k_n = E r between equal spheres of the linear law.
fn estimated_bounds(plan: &Plan, smallest_radius: f64) -> TimeStepBounds {
    let material = &plan.particles.material;
    let r = smallest_radius;
    let mass = 4.0 / 3.0 * std::f64::consts::PI * r.powi(3) * material.density;
    let linear = Stiffness {
        normal: material.young * r,
        shear: material.stiffness_ratio * material.young * r,
    };
    // Of a law that makes no sense the run itself will tell.
    let law = plan.granular_law().ok().flatten();
    let Stiffness { normal, shear } = law.map_or(linear, |law| {
        let spheres = law.between_spheres(material, material);
        // The overlap that a run expects of contacts that do not exist yet.
        law.stiffness(&spheres, TwoSpheres(r, r), 0.01 * r)
    });
    let stiffness = 2.0 * (normal + 2.0 * shear);
    let coupled = plan.stages.iter().any(|s| s.kind.is_coupled());
    let fluid = plan.fluid.as_ref().filter(|f| coupled && !f.effects.one_way);
    let undamped = plan.dem.as_ref().is_some_and(|dem| dem.options.damping == 0.0);
    // As `Dem::collision_time_step`.
    let collision = std::f64::consts::PI * (mass / (2.0 * normal)).sqrt() / 16.0;
    TimeStepBounds {
        contact: (2.0 * mass / stiffness).sqrt(),
        viscous_estimate: fluid.map(|f| viscous_time_step(r, material.density, f.fluid.viscosity)),
        viscous: None,
        collision: undamped.then_some(collision),
    }
}

/// Sizes, memory and times that a plan can be expected to need.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Number of spheres.
    pub spheres: usize,
    /// Number of pores; 0 when no stage has flow.
    pub pores: usize,
    /// Number of unknown pressures.
    pub unknowns: usize,
    /// Entries of the Cholesky factor.
    pub factor_entries: usize,
    /// False where `pores` and `unknowns` are estimates.
    pub counted: bool,
    /// Peak memory (bytes).
    pub memory: f64,
    /// Bounds on the time step; `None` when nothing moves or no radius is known. Where the viscous
    /// bound of the network is not known, estimates from the smallest sphere.
    pub bounds: Option<TimeStepBounds>,
    /// Time step of stages without one of their own (s); `None` when nothing moves.
    pub dt: Option<f64>,
    /// Stages whose time step is fixed above their limit.
    pub unstable_stages: Vec<UnstableStage>,
    /// Stages in which local damping takes from rebounds beside a coefficient of restitution.
    pub damped_twice: Vec<String>,
    /// Time of a dry step (s); `None` when nothing moves.
    pub dry_step: Option<f64>,
    /// Time of a coupled step with its share of remeshing (s); `None` when nothing couples.
    pub coupled_step: Option<f64>,
    /// Time of one remesh: triangulation, network, ordering, factorization (s); `None`
    /// without flow.
    pub remesh: Option<f64>,
}

/// A stage whose time step is fixed above its limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UnstableStage {
    /// The stage's name.
    pub stage: String,
    /// Its time step (s).
    pub dt: f64,
    /// The largest stable one (s): without the fluid's share in dry stages.
    pub limit: f64,
    /// What sets it.
    pub rule: TimeStepRule,
}

impl UnstableStage {
    /// A stage whose fixed time step is above the limit that these bounds set.
    pub(super) fn of(plan: &Plan, stage: &Stage, bounds: TimeStepBounds) -> Option<UnstableStage> {
        let TimeStep::Fixed(dt) = plan.mechanics(stage)?.dt else { return None };
        let bounds = match stage.kind.is_coupled() {
            true => bounds,
            false => TimeStepBounds { viscous: None, viscous_estimate: None, ..bounds },
        };
        let (limit, rule) = (bounds.limit(), bounds.rule());
        (dt > limit).then(|| UnstableStage { stage: stage.name.clone(), dt, limit, rule })
    }
}

impl fmt::Display for UnstableStage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let UnstableStage { stage, dt, limit, rule } = self;
        write!(
            f,
            "stage \"{stage}\": the time step of {dt:.3e} s is above the limit of about {limit:.3e} s that is \
             set by {rule}: expect it to blow up; take a smaller dt, or dt = \"auto\""
        )
    }
}

impl Estimate {
    /// What `plan` needs for `specimen`, with the threads that there are.
    ///
    /// # Errors
    /// What [`Plan::validate`] finds; a smallest radius that is negative or not finite.
    pub fn of(plan: &Plan, specimen: &Specimen) -> Result<Estimate, InputError> {
        Estimate::with_threads(plan, specimen, rayon::current_num_threads())
    }

    /// As [`Estimate::of`], with a number of threads, of which there is one at least.
    ///
    /// # Errors
    /// As [`Estimate::of`].
    pub fn with_threads(
        plan: &Plan,
        specimen: &Specimen,
        threads: usize,
    ) -> Result<Estimate, InputError> {
        plan.validate()?;
        let smallest = specimen.smallest_radius;
        if !(smallest >= 0.0 && smallest.is_finite()) {
            let what = format!("`smallest_radius` of the specimen is {smallest}");
            return Err(InputError::new(what, "give a radius in m, or 0"));
        }
        Ok(Estimate::expected(plan, specimen, threads.max(1)))
    }

    fn expected(plan: &Plan, specimen: &Specimen, threads: usize) -> Estimate {
        let any = |holds: fn(&StageKind) -> bool| plan.stages.iter().any(|s| holds(&s.kind));
        let measured = any(|k| matches!(k, StageKind::Permeability(_)));
        let coupled = any(StageKind::is_coupled);
        let conditioned = any(StageKind::has_conditions);
        let fluid = plan.fluid.as_ref().filter(|_| conditioned || measured);
        let flow = fluid.map(|fluid| {
            let drained = if conditioned { fluid.pressure_walls().count() } else { 2 };
            FlowSize::of(specimen, drained, fluid, threads)
        });
        let dem = plan.dem.as_ref().filter(|_| any(StageKind::moves));
        let estimated = || estimated_bounds(plan, specimen.smallest_radius);
        let known = || (specimen.smallest_radius > 0.0).then(estimated);
        let bounds = dem.and_then(|_| specimen.bounds.or_else(known));
        let dt = dem.zip(bounds).map(|(dem, bounds)| match dem.dt {
            TimeStep::Fixed(dt) => dt,
            TimeStep::Auto => bounds.automatic(dem.safety),
        });
        // Pictures of what has moved are drawn while all else is still there.
        let moves = any(StageKind::moves);
        let picture = if moves && plan.output.pictures { PICTURE_BYTES } else { 0.0 };
        let dry = dry_step(specimen.spheres, threads);
        let coupled_step = flow.as_ref().zip(fluid).filter(|_| coupled).map(|(flow, fluid)| {
            let step = dry + flow.step(fluid);
            step + remesh_share(fluid, step, flow.remesh())
        });
        Estimate {
            spheres: specimen.spheres,
            pores: flow.as_ref().map_or(0, |f| f.pores as usize),
            unknowns: flow.as_ref().map_or(0, |f| f.unknowns as usize),
            factor_entries: flow.as_ref().map_or(0, |f| f.cost.fill.nnz_l as usize),
            counted: specimen.pores.is_some() && specimen.unknowns.is_some(),
            memory: BASE_BYTES
                + picture
                + BYTES_PER_SPHERE * specimen.spheres as f64
                + flow.as_ref().zip(fluid).map_or(0.0, |(flow, fluid)| flow.bytes(fluid)),
            unstable_stages: bounds.map_or(vec![], |bounds| {
                plan.stages.iter().filter_map(|s| UnstableStage::of(plan, s, bounds)).collect()
            }),
            damped_twice: damped_twice(plan),
            bounds,
            dt,
            dry_step: dem.map(|_| dry),
            coupled_step,
            remesh: flow.as_ref().map(FlowSize::remesh),
        }
    }

    /// Time of a step (ms), a coupled one with its share of remeshing where a
    /// stage couples; `None` when nothing moves.
    pub fn ms_per_step(&self) -> Option<f64> {
        self.coupled_step.or(self.dry_step).map(|s| 1e3 * s)
    }

    /// What a user should know before such a run begins.
    pub fn warnings(&self) -> Vec<String> {
        let twice = self.damped_twice.iter().map(|stage| {
            format!(
                "stage \"{stage}\": local damping acts beside `restitution` in [contacts] and takes from every \
                 rebound: give `damping = 0.0` in [dem] or in the stage, unless that is meant"
            )
        });
        self.unstable_stages.iter().map(UnstableStage::to_string).chain(twice).collect()
    }
}

/// Names of the stages with local damping in a scene with a coefficient of restitution.
fn damped_twice(plan: &Plan) -> Vec<String> {
    let locally = |stage: &&Stage| plan.mechanics(stage).is_some_and(|d| d.options.damping > 0.0);
    let stages = plan.stages.iter().filter(|_| plan.contacts.restitution.is_some());
    stages.filter(locally).map(|stage| stage.name.clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    const UNKNOWN: TimeStepBounds =
        TimeStepBounds { contact: 0.0, viscous: None, viscous_estimate: None, collision: None };

    fn near(value: f64, expected: f64, tolerance: f64) {
        assert!((value / expected - 1.0).abs() < tolerance, "{value} against {expected}");
    }

    /// A plan of coupled steps in a cloud of so many spheres.
    fn coupled_plan(spheres: usize, fluid: &str) -> Plan {
        let text = format!(
            r#"
            [box]
            min = [0, 0, 0]
            max = [1, 1, 1]
            [particles]
            cloud = {{ count = {spheres}, porosity = 0.9 }}
            [dem]
            dt = 1e-6
            [fluid]
            viscosity = 1e-3
            tolerance = 1e-6
            pressure = {{ y_max = 0 }}
            {fluid}
            [[stage]]
            kind = "run"
            steps = 1
            "#
        );
        Plan::from_toml(&text, None).unwrap()
    }

    fn flow_size(specimen: &Specimen) -> FlowSize {
        let plan = coupled_plan(10, "remesh_interval = 200");
        FlowSize::of(specimen, 1, plan.fluid.as_ref().unwrap(), 2)
    }

    /// Coupled steps with a remesh every 200, with two threads: milliseconds in turn, in the
    /// background and without remeshes, as `make compare` measured them on 2026-11-28
    /// (`benches/report.md`). The estimate is within a factor of two.
    #[test]
    fn times_are_those_of_the_contest() {
        for (spheres, in_turn, background, without) in
            [(5_000, 1.5, 1.59, 1.11), (20_000, 8.35, 9.23, 6.58), (135_000, 96.8, 115.0, 66.0)]
        {
            for (fluid, measured) in [
                ("remesh_interval = 200", in_turn),
                ("remesh_interval = 200\nremesh = \"background\"", background),
                ("remesh_strain = 0.1", without),
            ] {
                let specimen = Specimen { spheres, ..Specimen::default() };
                let plan = coupled_plan(spheres, fluid);
                let ms =
                    Estimate::with_threads(&plan, &specimen, 2).unwrap().ms_per_step().unwrap();
                assert!((0.5..2.0).contains(&(ms / measured)), "{spheres}, {fluid}: {ms} ms");
            }
        }
        near(1e3 * dry_step(20_000, 2), 0.838, 0.5);
    }

    /// The most that runs of the shipped scenes and of their larger packing held, measured on
    /// 2026-11-30 with two threads. The estimate is within a quarter.
    #[test]
    fn memory_is_what_shipped_scenes_hold() {
        let scenes = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/");
        for (scene, spheres, pores, unknowns, measured) in MEASURED_BYTES {
            let plan = Plan::load(Path::new(&format!("{scenes}{scene}"))).unwrap();
            let specimen = Specimen {
                spheres,
                pores: Some(pores),
                unknowns: Some(unknowns),
                ..Specimen::default()
            };
            let memory = Estimate::with_threads(&plan, &specimen, 2).unwrap().memory;
            assert!((0.75..1.25).contains(&(memory / measured)), "{scene}: {memory:e}");
        }
    }

    /// Scene, spheres, pores, unknowns, bytes.
    const MEASURED_BYTES: [(&str, usize, usize, usize, f64); 5] = [
        ("first.toml", 1_000, 5_681, 5_487, 36.9e6),
        ("caulk2020.toml", 5_000, 29_318, 28_792, 71.5e6),
        ("caulk2020.toml", 20_000, 119_578, 118_204, 235.2e6),
        ("permeability.toml", 1_000, 5_685, 5_305, 22.4e6),
        ("dry-triaxial.toml", 2_000, 0, 0, 25.2e6),
    ];

    /// A step above the limit is told in words, one below is not.
    #[test]
    fn an_unstable_step_is_warned_of() {
        let plan = coupled_plan(10, "remesh_interval = 200");
        let bounds = |contact| TimeStepBounds { contact, ..UNKNOWN };
        let estimate = |contact| {
            let specimen =
                Specimen { spheres: 10, bounds: Some(bounds(contact)), ..Specimen::default() };
            Estimate::with_threads(&plan, &specimen, 1).unwrap().warnings()
        };
        assert_eq!(estimate(1.1e-6), Vec::<String>::new());
        let [warning] = &estimate(0.9e-6)[..] else { panic!("one warning") };
        assert!(warning.contains("1.000e-6 s") && warning.contains("contacts"), "{warning}");
    }

    /// A stage's own time step counts, not that of [dem]; a dry stage knows no viscosity.
    #[test]
    fn each_stage_is_held_against_its_own_step() {
        let mut plan = coupled_plan(10, "remesh_interval = 200");
        let (contact, viscous) = (1.1e-6, Some(1e-9));
        let bounds = TimeStepBounds { contact, viscous, ..UNKNOWN };
        let specimen = Specimen { spheres: 10, bounds: Some(bounds), ..Specimen::default() };
        let warned =
            |plan: &Plan| Estimate::with_threads(plan, &specimen, 1).unwrap().warnings().len();
        assert_eq!(warned(&plan), 1);
        plan.stages[0].dt = Some(TimeStep::Auto);
        assert_eq!(warned(&plan), 0);
        plan.stages[0].dt = Some(TimeStep::Fixed(1e-8));
        assert_eq!(warned(&plan), 1);
        let StageKind::Run(run) = &mut plan.stages[0].kind else { panic!("no run stage") };
        run.fluid = false;
        assert_eq!(warned(&plan), 0);
    }

    /// Measured on settled packings; unknowns and factor with one drained wall, METIS.
    #[test]
    fn counts_follow_the_packings_they_were_fitted_to() {
        for (spheres, pores, unknowns, entries) in [
            (1_000, 5_685.0, None, None),
            (5_000, 29_319.0, None, None),
            (20_000, 119_578.0, Some(118_199.0), Some(1.48e7)),
            (40_000, 241_321.0, Some(239_227.0), Some(3.92e7)),
            (135_000, 822_396.0, Some(817_690.0), Some(2.11e8)),
        ] {
            let flow = flow_size(&Specimen { spheres, ..Specimen::default() });
            near(flow.pores, pores, 0.01);
            if let (Some(unknowns), Some(entries)) = (unknowns, entries) {
                near(flow.unknowns, unknowns, 0.01);
                near(flow.cost.fill.nnz_l, entries, 0.1);
            }
        }
    }

    #[test]
    fn exact_counts_replace_the_estimates() {
        let known = Specimen {
            spheres: 1000,
            pores: Some(5685),
            unknowns: Some(5500),
            factor_entries: Some(123_456),
            ..Specimen::default()
        };
        let flow = flow_size(&known);
        assert_eq!((flow.pores, flow.unknowns, flow.cost.fill.nnz_l), (5685.0, 5500.0, 123_456.0));
    }

    /// Two π ρ d² / (8000 μ) and √(2 m / k) by hand, for ρ = 2600, d = 1.5 mm, μ = 1e-3,
    /// E = 1e6, k_s/k_n = 0.5: m = 4.595e-6 kg, k = 2·1e6·0.75e-3·2 = 3000 N/m.
    #[test]
    fn step_bounds_by_hand() {
        let scene = r#"
            [box]
            min = [0, 0, 0]
            max = [1, 1, 1]
            [particles]
            cloud = { count = 10, radius = 0.75e-3 }
            [dem]
            [fluid]
            viscosity = 1e-3
            pressure = { y_max = 0 }
            [[stage]]
            kind = "run"
            steps = 1
        "#;
        let plan = Plan::from_toml(scene, None).unwrap();
        let smallest = Specimen::of_cloud(&plan).unwrap().smallest_radius;
        let bounds = estimated_bounds(&plan, smallest);
        near(bounds.contact, (2.0 * 4.595e-6 / 3000.0f64).sqrt(), 1e-3);
        near(bounds.viscous_estimate.unwrap(), 4.594e-3, 1e-3);
        assert_eq!(bounds.rule(), TimeStepRule::Contacts);
    }
}
