//! `dempfv check`: is the scene right, and what will it cost?

use std::fmt;
use std::path::PathBuf;

use dempfv::coupling::TimeStepBounds;
use dempfv::io::packing::Packing;
use dempfv::pfv::{Boundary, Fluid, Network, Operators};
use dempfv::scene::{Plan, Stage, StageKind, TimeStep, Until};
use dempfv::simulation::{Advice, Estimate, Specimen, Stability, check_conditions};
use dempfv::{Aabb, Error};
use dempfv_report::format::{bytes, count, duration, si, three_digits};
use dempfv_report::memory::room;
use serde::Serialize;

use super::{describe, memory};

/// The pores of packings of up to so many spheres are counted.
const COUNTED: usize = 50_000;
/// The time step of packings of up to so many spheres is found from the
/// network itself, which takes a factorization.
const MEASURED: usize = 20_000;

/// What `check` takes.
#[derive(clap::Args)]
pub struct Args {
    /// Scene file (TOML)
    pub scene: PathBuf,
}

/// The plan of a scene and what it will need.
#[derive(Serialize)]
pub struct Report {
    title: String,
    effects: Effects,
    stages: Vec<StageReport>,
    bounds: Option<Aabb>,
    /// Expected time of a step (ms), its share of remeshing included.
    ms_per_step: Option<f64>,
    /// Expected peak memory (bytes).
    memory_bytes: f64,
    /// What dimensionless numbers say about its effects.
    advice: Vec<Advice>,
    warnings: Vec<String>,
    estimate: Estimate,
    /// Where the fastest viscous mode lives; `None` where there is no packing
    /// yet, or a large one.
    stability: Option<Stability>,
    plan: Plan,
}

/// What the scene simulates, and what it could.
#[derive(Serialize)]
struct Effects {
    on: Vec<&'static str>,
    /// What those that are on make necessary.
    needs: Vec<Need>,
    off: Vec<&'static str>,
}

/// What an effect makes necessary.
#[derive(Serialize)]
struct Need {
    effect: &'static str,
    needs: &'static str,
}

impl Effects {
    fn of(plan: &Plan) -> Effects {
        let on = plan.effects().into_iter().filter_map(|(effect, on)| on.then_some(effect));
        let needs = on.filter(|effect| !effect.needs.is_empty());
        let needs = needs.map(|effect| Need { effect: effect.name, needs: effect.needs });
        Effects { on: plan.effects_on(), needs: needs.collect(), off: plan.effects_off() }
    }
}

#[derive(Serialize)]
struct StageReport {
    name: String,
    kind: &'static str,
    what: String,
    /// Number of steps, where the scene fixes it.
    steps: Option<u64>,
    /// Expected time on the clock (s), where the number of steps is known.
    expected_s: Option<f64>,
}

/// Reads and validates a scene and, where it has one, its packing.
///
/// # Errors
/// [`Error::Input`] for whatever is wrong in the scene or the packing; why there is no
/// network of the packing, where the scene needs one.
pub fn run(args: &Args) -> Result<Report, Error> {
    let plan = Plan::load(&args.scene)?;
    let (specimen, bounds, stability) = specimen(&plan)?;
    let estimate = Estimate::of(&plan, &specimen)?;
    let advise = |bounds| Advice::of(&plan, &specimen, &estimate, bounds);
    let advice = bounds.as_ref().map_or_else(Vec::new, advise);
    let tight = room().and_then(|room| memory::tight(estimate.memory, room));
    let stages = plan
        .stages
        .iter()
        .map(|stage| {
            let steps = steps(&stage.kind, time_step(&plan, stage, &estimate));
            StageReport {
                name: stage.name.clone(),
                kind: stage.kind.name(),
                what: describe::stage(stage),
                steps,
                expected_s: expected(&stage.kind, steps, &estimate),
            }
        })
        .collect();
    Ok(Report {
        title: plan.title.clone(),
        effects: Effects::of(&plan),
        stages,
        bounds,
        advice,
        ms_per_step: estimate.ms_per_step(),
        memory_bytes: estimate.memory,
        warnings: estimate.warnings().into_iter().chain(tight).collect(),
        estimate,
        stability,
        plan,
    })
}

type Known = (Specimen, Option<Aabb>, Option<Stability>);

/// The spheres of a plan, the box they are in, and what bounds the time step.
/// The pores of a packing file are counted, not estimated, if that takes no
/// longer than a second or two.
fn specimen(plan: &Plan) -> Result<Known, Error> {
    let Some((packing, bounds)) = plan.packing()? else {
        return Ok((Specimen::of_cloud(plan).unwrap_or_default(), plan.bounds, None));
    };
    check_conditions(plan, &packing.position, &packing.radius, bounds)?;
    let radii = &packing.radius;
    let mut specimen = Specimen::of_radii(radii).in_box(radii, &bounds, plan);
    let mut stability = None;
    if !plan.stages.iter().any(|s| matches!(s.kind, StageKind::Compact(_))) {
        if packing.len() <= MEASURED {
            stability = Stability::of(plan)?;
        }
        match &stability {
            Some(found) => {
                specimen.pores = Some(found.pores);
                specimen.unknowns = Some(found.unknowns);
                specimen.factor_entries = Some(found.factor_entries as usize);
                specimen.bounds = Some(found.bounds);
            }
            None if packing.len() <= COUNTED => count_pores(plan, &packing, bounds, &mut specimen)?,
            None => {}
        }
    }
    Ok((specimen, Some(bounds), stability))
}

/// Counts pores, unknowns and the entries of the factor, where a stage has
/// flow.
fn count_pores(
    plan: &Plan,
    packing: &Packing,
    bounds: Aabb,
    specimen: &mut Specimen,
) -> Result<(), Error> {
    let (Some(fluid), Some(pressure)) = (&plan.fluid, pressures(plan)) else { return Ok(()) };
    let boundary = Boundary { pressure: pressure.into(), ..fluid.fluid.boundary };
    let fluid_in_pores = Fluid { boundary, ..fluid.fluid };
    let (position, radius) = (&packing.position, &packing.radius);
    let (network, derivatives) = match packing.cell.filter(|_| plan.cell.is_some()) {
        None => Network::new(position, radius, bounds, &fluid_in_pores)?,
        Some(cell) => Network::in_cell(position, radius, &cell, &fluid.fluid)?,
    };
    let boundary = if network.periodic().is_some() { fluid.fluid.boundary } else { boundary };
    let operators = Operators::new(&network, derivatives, boundary)?;
    specimen.pores = Some(network.pores());
    specimen.unknowns = Some(operators.unknowns());
    specimen.factor_entries = Some(0);
    if operators.unknowns() > 0 {
        let places: Vec<[f64; 3]> =
            operators.pore_of.iter().map(|&i| network.center[i as usize].into()).collect();
        let symbolic = fluid.solver.backend().analyze(&operators.matrix, Some(&places))?;
        specimen.factor_entries = Some(symbolic.analysis().nnz_l as usize);
    }
    Ok(())
}

/// The pressures on the walls in the stages that couple the fluid, else in the first
/// measurement of a permeability; `None` when no stage has flow.
fn pressures(plan: &Plan) -> Option<[Option<f64>; 6]> {
    if plan.stages.iter().any(|s| s.kind.has_conditions()) {
        return plan.fluid.as_ref().map(|f| f.fluid.boundary.pressure.0);
    }
    plan.stages.iter().find_map(|s| match &s.kind {
        StageKind::Permeability(p) => {
            let mut pressure = [None; 6];
            pressure[2 * p.axis.index()] = Some(1.0);
            pressure[2 * p.axis.index() + 1] = Some(0.0);
            Some(pressure)
        }
        _ => None,
    })
}

/// The time step of a stage (s), as far as it is known.
fn time_step(plan: &Plan, stage: &Stage, estimate: &Estimate) -> Option<f64> {
    let dem = plan.mechanics(stage)?;
    match dem.dt {
        TimeStep::Fixed(dt) => Some(dt),
        TimeStep::Auto => estimate.bounds.map(|bounds| bounds.automatic(dem.safety)),
    }
}

fn steps(kind: &StageKind, dt: Option<f64>) -> Option<u64> {
    let run = match kind {
        StageKind::Run(run) => run,
        StageKind::Flow(flow) => return Some(flow.steps),
        _ => return None,
    };
    match run.until {
        Until::Steps(steps) => Some(steps),
        Until::Time(time) => dt.map(|dt| (time / dt).ceil() as u64),
        Until::Strain { .. }
        | Until::Stress { .. }
        | Until::Porosity { .. }
        | Until::Unbalanced { .. } => None,
    }
}

fn expected(kind: &StageKind, steps: Option<u64>, estimate: &Estimate) -> Option<f64> {
    if !kind.moves() {
        return estimate.remesh;
    }
    let step = if kind.is_coupled() { estimate.coupled_step } else { estimate.dry_step };
    Some(steps? as f64 * step?)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plan = &self.plan;
        writeln!(f, "{}\n", self.title)?;
        for (i, stage) in self.stages.iter().enumerate() {
            let expected = stage.expected_s.map(|s| format!(" (about {})", duration(s)));
            let text = format!("{}: {}{}", stage.name, stage.what, expected.unwrap_or_default());
            line(f, &format!("stage {}", i + 1), &text)?;
        }
        line(f, "effects on", &list(&self.effects.on))?;
        for Need { effect, needs } in &self.effects.needs {
            line(f, "needs", &format!("{effect}: {needs}"))?;
        }
        line(f, "effects off", &list(&self.effects.off))?;
        let spheres = count(self.estimate.spheres as u64);
        line(f, "particles", &format!("{spheres}: {}", describe::source(&plan.particles.source)))?;
        if let Some(cell) = &plan.cell {
            line(f, "cell", &describe::cell(cell))?;
        }
        if let Some(bounds) = self.bounds.as_ref().filter(|_| plan.cell.is_none()) {
            let size = bounds.size().map(|x| si(x, "m"));
            line(f, "box", &format!("{} × {} × {}", size.x, size.y, size.z))?;
        }
        if let Some(fluid) = &plan.fluid {
            line(f, "fluid", &describe::fluid(fluid, &plan.stages, plan.cell.is_some()))?;
        }
        self.write_mechanics(f)?;
        self.write_cost(f)?;
        self.advice.iter().try_for_each(|advice| line(f, "advice", &advice.to_string()))?;
        self.warnings.iter().try_for_each(|warning| line(f, "warning", warning))
    }
}

impl Report {
    fn write_mechanics(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Some(dem), Some(dt), Some(bounds)) =
            (&self.plan.dem, self.estimate.dt, self.estimate.bounds)
        else {
            return Ok(());
        };
        let material = &self.plan.particles.material;
        let text = format!(
            "ρ = {} kg/m³, E = {}, k_s/k_n = {}, friction {}°{}",
            three_digits(material.density),
            si(material.young, "Pa"),
            three_digits(material.stiffness_ratio),
            three_digits(material.friction_angle.to_degrees()),
            match &self.plan.cell {
                None => {
                    let walls = self.plan.walls.material.friction_angle.to_degrees();
                    format!(" (walls {}°)", three_digits(walls))
                }
                Some(_) => String::new(),
            },
        );
        line(f, "material", &text)?;
        let limit = bounds.limit();
        let choice = match dem.dt {
            TimeStep::Auto => format!("automatic, about {}", si(dt, "s")),
            TimeStep::Fixed(_) => si(dt, "s"),
        };
        let text = format!("{choice}; limit about {}, set by {}", si(limit, "s"), bounds.rule());
        line(f, "time step", &text)?;
        self.write_bounds(f, &bounds)
    }

    /// The three bounds that the limit comes from.
    fn write_bounds(&self, f: &mut fmt::Formatter<'_>, bounds: &TimeStepBounds) -> fmt::Result {
        line(f, "  contacts", &format!("{} (Δt_MK)", si(bounds.contact, "s")))?;
        if let Some(collision) = bounds.collision {
            let text = format!("{} (16 steps each: nothing damps them)", si(collision, "s"));
            line(f, "  collisions", &text)?;
        }
        let Some(estimate) = bounds.viscous_estimate else { return Ok(()) };
        let exact = match (bounds.viscous, &self.stability) {
            (Some(exact), Some(found)) if exact.is_finite() => {
                let carriers: Vec<String> = found
                    .carriers
                    .iter()
                    .map(|(i, share)| format!("{i} ({:.0} %)", 100.0 * share))
                    .collect();
                format!(
                    "{} (2/λ_max of V M⁻¹, damping counted); fastest where spheres {} are",
                    si(exact, "s"),
                    carriers.join(", ")
                )
            }
            (Some(_), _) => "none: no pore resists".to_owned(),
            (None, _) => "not known before there is a network; until then eq. A.11".to_owned(),
        };
        line(f, "  viscosity", &exact)?;
        let side = match bounds.viscous {
            Some(exact) if exact.is_finite() => {
                let ratio = estimate / exact;
                let side = if ratio > 1.0 { "unsafe" } else { "safe" };
                format!(", {} times that, on the {side} side", three_digits(ratio))
            }
            _ => String::new(),
        };
        line(f, "  eq. A.11", &format!("{} (Δt_MV){side}", si(estimate, "s")))
    }

    fn write_cost(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let estimate = &self.estimate;
        let about = if estimate.counted { "" } else { "about " };
        if estimate.unknowns > 0 {
            let text = format!(
                "{about}{} pores, {} unknown pressures; factor of {} entries",
                count(estimate.pores as u64),
                count(estimate.unknowns as u64),
                three_digits(estimate.factor_entries as f64),
            );
            line(f, "unknowns", &text)?;
        }
        line(f, "memory", &format!("about {}", bytes(estimate.memory)))?;
        let costs = [
            ("dry", estimate.dry_step),
            ("coupled", estimate.coupled_step),
            ("remesh", estimate.remesh),
        ];
        let costs: Vec<String> = costs
            .iter()
            .filter_map(|(name, cost)| cost.map(|s| format!("{name} {}", duration(s))))
            .collect();
        line(f, "cost per step", &format!("about: {}", costs.join(", ")))
    }
}

fn line(f: &mut fmt::Formatter<'_>, name: &str, text: &str) -> fmt::Result {
    writeln!(f, "  {name:<13} {text}")
}

fn list(names: &[&str]) -> String {
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}
