//! What dimensionless numbers say about the effects of a scene: what each would change, and whether
//! it can be left out. Closed forms with mean-field moduli: right within a factor of two or so.

use std::f64::consts::PI;
use std::fmt;

use serde::Serialize;

use super::estimate::Estimate;
use super::specimen::Specimen;
use crate::dem::WallControl;
use crate::domain::{Aabb, Axis, WallId};
use crate::scene::{NormalLaw, Plan, Run, Stage, StageKind, TimeStep, Until};
use crate::theory::kozeny_carman;

/// An effect that changes less than this can be left out.
const NEGLIGIBLE: f64 = 0.01;
/// Standard gravity (m/s²), where a scene has none.
const STANDARD_GRAVITY: f64 = 9.81;
/// Bulk modulus (Pa) and density (kg/m³) of water, where a scene says neither.
const WATER_MODULUS: f64 = 2.2e9;
const WATER_DENSITY: f64 = 1000.0;
/// Contacts per sphere of a dense packing with friction.
const COORDINATION: f64 = 5.5;
/// Slip and rearrangement make a packing softer than the mean field of its contacts: 0.40 against
/// 0.46 MPa in the oedometer of 1,000 spheres.
const SOFTER_THAN_MEAN_FIELD: f64 = 0.87;
/// Rise of the friction coefficient with the inertial number, (μ₂ − μ₁) / (μ₁ I₀) of Jop, Forterre
/// and Pouliquen (2006): 0.38, 0.64 and 0.279.
const FRICTION_PER_INERTIA: f64 = 2.45;

/// What becomes of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It changes less than one per cent.
    LeaveOut,
    /// It changes more.
    Needed,
    /// It matters, and cannot be simulated or avoided by a key: a warning.
    Beware,
}

/// What a dimensionless number says about one effect in one stage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Advice {
    /// The stage's name.
    pub stage: String,
    /// The effect.
    pub effect: &'static str,
    /// The number, as `T_v = c_v T / H²`.
    pub number: &'static str,
    /// Its value (1).
    pub value: f64,
    /// What the effect changes, as a share (1) of `of`.
    pub change: f64,
    /// What it changes.
    pub of: &'static str,
    /// What follows.
    pub verdict: Verdict,
}

impl fmt::Display for Advice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Advice { stage, effect, number, value, change, of, verdict } = self;
        let percent = 100.0 * change;
        write!(
            f,
            "stage \"{stage}\", {effect}: {number} = {value:.2e}, changes {of} by about {percent:.2} %: "
        )?;
        f.write_str(match verdict {
            Verdict::LeaveOut => "leave it out",
            Verdict::Needed => "you need it",
            Verdict::Beware => "no key takes it away; change the scene",
        })
    }
}

/// What the formulas take of a scene.
struct Scene<'a> {
    plan: &'a Plan,
    bounds: Aabb,
    /// Diameter of the spheres (m) and share of the pores (1).
    diameter: f64,
    porosity: f64,
}

impl Advice {
    /// What can be said about the stages of a plan in this box, for spheres of which `specimen`
    /// tells the size. Empty where that is not known, and in a periodic cell, which has no walls,
    /// gravity or fluid; of linear contacts alone where the stiffness of the packing counts.
    pub fn of(plan: &Plan, specimen: &Specimen, estimate: &Estimate, bounds: &Aabb) -> Vec<Advice> {
        let Specimen { diameter, porosity, .. } = *specimen;
        let known = diameter > 0.0 && porosity > 0.0 && porosity < 1.0;
        if plan.validate().is_err() || plan.cell.is_some() || !known {
            return vec![];
        }
        let scene = Scene { plan, bounds: *bounds, diameter, porosity };
        let mut stress = None;
        let mut advice = vec![];
        for stage in &plan.stages {
            if let Some(goal) = goal_stress(stage) {
                stress = Some(goal);
            }
            if plan.mechanics(stage).is_none() {
                continue;
            }
            let StageKind::Run(run) = &stage.kind else {
                advice.extend(scene.gravity(stage, stress));
                continue;
            };
            let time = duration(run, plan, stage, estimate, bounds);
            advice.extend(scene.gravity(stage, stress));
            advice.extend(scene.inertia(stage, run, stress));
            if stage.kind.is_coupled() {
                advice.extend(scene.viscous_step(stage, estimate));
                advice.extend(scene.lubrication(stage, run, stress));
                advice.extend(time.and_then(|time| scene.pore_flow(stage, time)));
                advice.extend(scene.compressibility(stage));
                advice.extend(scene.fluid_inertia(stage));
            }
        }
        advice
    }
}

impl Scene<'_> {
    /// Oedometric modulus of the packing (Pa), by the mean field of linear contacts (Walton 1987):
    /// M = (1 − n) Z E (3 + 2 k_s/k_n) / 10π.
    /// `None` where it goes with the stress, as with Hertz's contacts.
    fn modulus(&self) -> Option<f64> {
        if self.plan.contacts.law != NormalLaw::Linear {
            return None;
        }
        let material = &self.plan.particles.material;
        let density =
            (1.0 - self.porosity) * COORDINATION * material.young * SOFTER_THAN_MEAN_FIELD;
        Some(density * (3.0 + 2.0 * material.stiffness_ratio) / (10.0 * PI))
    }

    /// Permeability (m²) by Kozeny and Carman.
    fn permeability(&self) -> f64 {
        kozeny_carman(self.porosity, self.diameter)
    }

    /// The weight of the bed, less its buoyancy, against the stress on it: ρ (1 − n) g H / σ.
    fn gravity(&self, stage: &Stage, stress: Option<f64>) -> Option<Advice> {
        let gravity = self.plan.dem.as_ref().and_then(|dem| dem.options.gravity);
        let size = self.bounds.size();
        let (g, height) = match gravity {
            Some(g) => (g.norm(), g.abs().dot(&size) / g.norm()),
            None => (STANDARD_GRAVITY, size.max()),
        };
        let wet = self.plan.fluid.as_ref().filter(|_| stage.kind.is_coupled());
        let fluid = wet.and_then(|fluid| fluid.effects.density).unwrap_or(0.0);
        let density = (self.plan.particles.material.density - fluid).abs();
        let weight = density * (1.0 - self.porosity) * g * height;
        let value = weight / stress.filter(|&s| s > 0.0)?;
        Some(Advice {
            stage: stage.name.clone(),
            effect: "gravity",
            number: "ρ (1 − n) g H / σ",
            value,
            change: value,
            of: "the stress at the bottom",
            verdict: verdict(value),
        })
    }

    /// The inertial number I = ε̇ d √(ρ/σ). A load that comes at once adds ρ c v, c² = M/ρ of the bed.
    fn inertia(&self, stage: &Stage, run: &Run, stress: Option<f64>) -> Option<Advice> {
        let rate = strain_rate(run, &self.bounds)?;
        let density = self.plan.particles.material.density;
        let value = rate * self.diameter * (density / stress.filter(|&s| s > 0.0)?).sqrt();
        let bed = (1.0 - self.porosity) * density;
        let shock = (bed * self.modulus()?).sqrt() * rate * self.bounds.size().max();
        let change = (FRICTION_PER_INERTIA * value).max(shock / stress?);
        let verdict = if change < NEGLIGIBLE { Verdict::LeaveOut } else { Verdict::Beware };
        Some(Advice {
            stage: stage.name.clone(),
            effect: "rate of loading",
            number: "I = ε̇ d √(ρ/σ)",
            value,
            change,
            of: "the stress",
            verdict,
        })
    }

    /// Drained or not: T_v = c_v T / H² of the time that loading takes. Under a load that grows
    /// evenly the water carries 1 / 2T_v of it at the sealed end (Schiffman 1958).
    fn pore_flow(&self, stage: &Stage, time: f64) -> Option<Advice> {
        let fluid = self.plan.fluid.as_ref()?;
        let open = |wall: WallId| fluid.fluid.boundary.pressure[wall].is_some();
        let paths = Axis::ALL.into_iter().filter_map(|axis| {
            let [low, high] = axis.walls().map(open);
            let length = self.bounds.size()[axis.index()];
            match (low, high) {
                (true, true) => Some(0.5 * length),
                (true, false) | (false, true) => Some(length),
                (false, false) => None,
            }
        });
        let path = paths.fold(f64::INFINITY, f64::min);
        let modulus = self.modulus()?;
        let value = self.permeability() * modulus / fluid.fluid.viscosity * time / path.powi(2);
        let change = (0.5 / value).min(1.0);
        Some(Advice {
            stage: stage.name.clone(),
            effect: "pore flow",
            number: "T_v = c_v T / H²",
            value,
            change,
            of: "the part of a load that the grains carry",
            verdict: verdict(change),
        })
    }

    /// The stiffness of the packing between walls against that of the fluid: 1 − B, with
    /// Skempton's B = 1 / (1 + n M / K_f).
    fn compressibility(&self, stage: &Stage) -> Option<Advice> {
        let fluid = self.plan.fluid.as_ref()?;
        let modulus = fluid.effects.bulk_modulus.unwrap_or(WATER_MODULUS);
        let skeleton = self.modulus()?;
        let value = self.porosity * skeleton / modulus;
        let change = value / (1.0 + value);
        Some(Advice {
            stage: stage.name.clone(),
            effect: "fluid compressibility",
            number: "n M / K_f",
            value,
            change,
            of: "the pressure under an undrained load",
            verdict: verdict(change),
        })
    }

    /// The bound that viscosity sets to the time step against that of the contacts.
    fn viscous_step(&self, stage: &Stage, estimate: &Estimate) -> Option<Advice> {
        let bounds = estimate.bounds?;
        let change = 1.0 - bounds.limit() / bounds.contact;
        Some(Advice {
            stage: stage.name.clone(),
            effect: "viscosity in the time step",
            number: "Δt_V / Δt_K",
            value: bounds.viscosity() / bounds.contact,
            change,
            of: "the largest stable time step",
            verdict: verdict(change),
        })
    }

    /// Films between neighbours: beside the stress that a packing is strained under, or on the impacts
    /// of spheres that fall.
    fn lubrication(&self, stage: &Stage, run: &Run, stress: Option<f64>) -> Option<Advice> {
        let rate = strain_rate(run, &self.bounds);
        match rate.zip(stress.filter(|&s| s > 0.0)) {
            Some((rate, stress)) => self.strained_films(stage, rate, stress),
            None => self.struck_films(stage),
        }
    }

    /// The viscous number J = μ ε̇ / σ. Neighbours that near each other by ε̇ d across films of 2 ε R, whose
    /// force is 3/2 π μ R² ε̇ d / 2 ε R, carry that beside the 4 R² σ of a contact: 3/8 π J / ε.
    fn strained_films(&self, stage: &Stage, rate: f64, stress: f64) -> Option<Advice> {
        let fluid = self.plan.fluid.as_ref()?;
        let value = fluid.fluid.viscosity * rate / stress;
        let change = 0.375 * PI * value / fluid.effects.edges.roughness;
        Some(Advice {
            stage: stage.name.clone(),
            effect: "lubrication",
            number: "J = μ ε̇ / σ",
            value,
            change,
            of: "the stress",
            verdict: verdict(change),
        })
    }

    /// The Stokes number St = ρ_s d v / 18 μ at the speed of spheres that sink, by Stokes's law or
    /// freely through the box where that is less. The film takes ∫ 3/2 π μ R² / h dh from the momentum
    /// of each of two spheres that meet, from h = R to the roughness 2 ε R, and as much where they part:
    /// ln(1/2ε) / 2 St of the speed; and π c / 2√(k m/2) while they touch, c = 3/4 π μ R / ε, k = E R.
    fn struck_films(&self, stage: &Stage) -> Option<Advice> {
        if self.plan.contacts.law != NormalLaw::Linear {
            return None;
        }
        let fluid = self.plan.fluid.as_ref()?;
        let gravity = self.plan.dem.as_ref()?.options.gravity?;
        let (d, mu, g) = (self.diameter, fluid.fluid.viscosity, gravity.norm());
        let density = self.plan.particles.material.density;
        let excess = (density - fluid.effects.density.unwrap_or(0.0)).abs();
        let fall = gravity.abs().dot(&self.bounds.size()) / g;
        let speed = (excess * g * d * d / (18.0 * mu)).min((2.0 * g * fall).sqrt());
        let value = density * d * speed / (18.0 * mu);
        let thinnest = 2.0 * fluid.effects.edges.roughness;
        let (r, young) = (0.5 * d, self.plan.particles.material.young);
        let mass = 4.0 / 3.0 * PI * r.powi(3) * density;
        let touching = 0.5 * PI * 1.5 * PI * mu * r / thinnest / (0.5 * young * r * mass).sqrt();
        let change = (touching - 0.5 * thinnest.ln() / value).clamp(0.0, 1.0);
        Some(Advice {
            stage: stage.name.clone(),
            effect: "lubrication",
            number: "St = ρ_s d v / 18 μ",
            value,
            change,
            of: "the speed of a rebound",
            verdict: verdict(change),
        })
    }

    /// The Reynolds number of the seepage, Re = ρ_f v d / μ, and what Ergun's (1952) inertial term
    /// adds to the viscous one: 1.75 Re / 150 (1 − n).
    fn fluid_inertia(&self, stage: &Stage) -> Option<Advice> {
        let effects = &self.plan.fluid.as_ref()?.effects;
        let fluid = &self.plan.fluid.as_ref()?.fluid;
        let pressure = |wall: WallId| fluid.boundary.pressure[wall];
        let gradients = Axis::ALL.into_iter().filter_map(|axis| {
            let [low, high] = axis.walls().map(pressure);
            Some((high? - low?).abs() / self.bounds.size()[axis.index()])
        });
        let velocity = self.permeability() / fluid.viscosity * gradients.fold(0.0, f64::max);
        if velocity == 0.0 {
            return None;
        }
        let density = effects.density.unwrap_or(WATER_DENSITY);
        let value = density * velocity * self.diameter / fluid.viscosity;
        let change = 1.75 * value / (150.0 * (1.0 - self.porosity));
        let verdict = if change < NEGLIGIBLE { Verdict::LeaveOut } else { Verdict::Beware };
        Some(Advice {
            stage: stage.name.clone(),
            effect: "inertia of the fluid",
            number: "Re = ρ_f v d / μ",
            value,
            change,
            of: "the flux",
            verdict,
        })
    }
}

fn verdict(change: f64) -> Verdict {
    if change < NEGLIGIBLE { Verdict::LeaveOut } else { Verdict::Needed }
}

/// The stress that a stage works at (Pa): the lowest of its goals.
fn goal_stress(stage: &Stage) -> Option<f64> {
    match &stage.kind {
        StageKind::Compact(compact) => Some(compact.stress),
        StageKind::Cycle(cycle) => Some(cycle.from),
        StageKind::Consolidate(consolidate) => Some(consolidate.stress),
        StageKind::Permeability(_) | StageKind::Flow(_) => None,
        StageKind::Run(run) => {
            let goals = run.walls.values().filter_map(|control| match control {
                WallControl::Servo { stress, .. } => Some(*stress),
                WallControl::Fixed | WallControl::Velocity(_) => None,
            });
            goals.reduce(f64::min)
        }
    }
}

/// The largest rate at which given velocities strain the box (1/s); `None` where no wall has one.
fn strain_rate(run: &Run, bounds: &Aabb) -> Option<f64> {
    let rates = Axis::ALL.into_iter().map(|axis| {
        let speeds = axis.walls().map(|wall| match run.walls[wall] {
            WallControl::Velocity(velocity) => velocity * wall.inward(),
            WallControl::Fixed | WallControl::Servo { .. } => 0.0,
        });
        (speeds[0] + speeds[1]).abs() / bounds.size()[axis.index()]
    });
    Some(rates.fold(0.0, f64::max)).filter(|&rate| rate > 0.0)
}

/// How long a stage lasts (s), where that is known.
fn duration(
    run: &Run,
    plan: &Plan,
    stage: &Stage,
    estimate: &Estimate,
    bounds: &Aabb,
) -> Option<f64> {
    match run.until {
        Until::Time(time) => Some(time),
        Until::Strain { strain, .. } => Some(strain.abs() / strain_rate(run, bounds)?),
        Until::Stress { .. } | Until::Porosity { .. } | Until::Unbalanced { .. } => None,
        Until::Steps(steps) => {
            let dt = match plan.mechanics(stage)?.dt {
                TimeStep::Fixed(dt) => dt,
                TimeStep::Auto => estimate.dt?,
            };
            Some(steps as f64 * dt)
        }
    }
}
