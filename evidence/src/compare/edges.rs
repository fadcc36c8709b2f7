//! The part `edges` of the comparison: forces and couples between neighbours, in one step of spheres
//! that move at random.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use dempfv::coupling::{Coupled, EdgeEffects, FluidEffects, RemeshRule, Saturation};
use dempfv::dem::{Dem, DemOptions, Material, Particles, WallMaterial};
use dempfv::pfv::{Boundary, Clamp, Fluid, Tessellation};
use dempfv::solver::SolverKind;
use dempfv::{Aabb, PerWall, Vec3};
use serde::{Deserialize, Serialize};

use super::loading::Packing;
use super::peer::Bench;
use super::verdict::Verdict;
use crate::Error;

const SCRIPT: &str = include_str!("scripts/edges.py");
/// Packings of more spheres take YADE too long.
const LARGEST: usize = 6000;
const VISCOSITY: f64 = 1e-3;
const ROUGHNESS: f64 = 1e-3;
/// What the two programs may differ by, of the mean.
const BOUND: f64 = 1e-9;
/// The same where facets between power cells count: at walls YADE has other pore centres.
const FACETS: f64 = 5e-3;

/// An effect in both programs.
struct Case {
    name: &'static str,
    on: fn(&mut EdgeEffects),
    /// Whether the spheres turn rather than move.
    turns: bool,
    /// What YADE's couples are multiplied with.
    sign: f64,
    bound: f64,
}

const CASES: [Case; 5] = [
    Case {
        name: "viscous shear",
        on: |e| e.viscous_shear = true,
        turns: false,
        sign: 1.0,
        bound: FACETS,
    },
    Case {
        name: "normal lubrication",
        on: |e| e.normal_lubrication = true,
        turns: false,
        sign: 1.0,
        bound: BOUND,
    },
    Case {
        name: "shear lubrication",
        on: |e| e.shear_lubrication = true,
        turns: false,
        sign: 1.0,
        bound: BOUND,
    },
    Case {
        name: "pump torque",
        on: |e| e.pump_torque = true,
        turns: true,
        sign: -1.0,
        bound: BOUND,
    },
    Case {
        name: "twist torque",
        on: |e| e.twist_torque = true,
        turns: true,
        sign: -1.0,
        bound: BOUND,
    },
];

#[derive(Serialize)]
struct Job {
    spheres: Vec<[f64; 4]>,
    #[serde(rename = "box")]
    corners: [f64; 6],
    viscosity: f64,
    eps: f64,
    velocity: Vec<Vec3>,
    spin: Vec<Vec3>,
}

/// Forces (N) and torques (N m) of one effect on each sphere.
#[derive(Deserialize)]
struct Loads {
    force: Vec<Vec3>,
    torque: Vec<Vec3>,
}

/// Largest and median difference of one effect on one packing, of the mean.
#[derive(Serialize, Deserialize)]
struct Row {
    packing: String,
    effect: String,
    force: Option<[f64; 2]>,
    torque: Option<[f64; 2]>,
    bound: f64,
}

/// What was measured.
#[derive(Serialize, Deserialize)]
pub struct Part {
    rows: Vec<Row>,
}

impl super::Part for Part {
    const NAME: &'static str = "edges";

    fn measure(bench: &Bench, packings: &[PathBuf]) -> Result<Part, Error> {
        let mut rows = vec![];
        for path in packings {
            let packing = Packing::load(path)?;
            if packing.spheres.len() <= LARGEST {
                rows.extend(compare(bench, &packing)?);
            }
        }
        Ok(Part { rows })
    }

    fn verdicts(&self) -> Vec<Verdict> {
        let verdict = |row: &Row, quantity: &str, apart: [f64; 2]| Verdict {
            on: row.packing.clone(),
            quantity: format!("{quantity} of {}, of the mean", row.effect),
            largest: apart[0],
            median: Some(apart[1]),
            bound: row.bound,
            explanation: None,
        };
        let rows = self.rows.iter().flat_map(|row| {
            let force = row.force.map(|apart| verdict(row, "forces", apart));
            force.into_iter().chain(row.torque.map(|apart| verdict(row, "torques", apart)))
        });
        rows.collect()
    }

    fn section(&self, _: &Path) -> Result<String, Error> {
        let mut text = INTRODUCTION.to_owned();
        let cell = |apart: Option<[f64; 2]>| {
            apart.map_or("–".to_owned(), |[most, median]| format!("{most:.1e} / {median:.1e}"))
        };
        for row in &self.rows {
            let (force, torque) = (cell(row.force), cell(row.torque));
            text += &format!("| {} | {} | {force} | {torque} |\n", row.packing, row.effect);
        }
        Ok(text + "\n")
    }
}

const INTRODUCTION: &str = "\
## Forces between neighbours

Both programs take the same packing, give every sphere the same random velocity (spin, for the two
couples), and evaluate each effect alone, with ε = 10⁻³, no spring in series with the films, and slip
walls. Largest / median difference of the forces and torques on spheres, of their mean. Spheres at
walls are left out of normal lubrication: YADE has no films at walls, ours has. So are, for the two couples,
those with a neighbour across more than a radius: there the expansions turn negative and would drive
what they should brake; ours are 0.

YADE 2023.02a differs in what it does with them: with shear lubrication on it leaves viscous shear
out; it computes the two couples beside shear lubrication only; and it applies both with the other
sign, so that they drive what they should brake (here they are turned). Its slip takes the rims at
the radii, the moments of the forces at the plane between the power cells; ours takes both there, so
that a pair that turns as one body feels nothing and energy is lost only. The depth of viscous shear,
gap + 0.45 r of the smaller sphere, is what YADE's forces follow.

| packing | effect | forces | torques |
|---|---|---|---|
";

/// Runs both programs.
fn compare(bench: &Bench, packing: &Packing) -> Result<Vec<Row>, Error> {
    let mut random = 1u64;
    let mut vectors = |size: f64| -> Vec<Vec3> {
        let count = packing.spheres.len();
        (0..count).map(|_| Vec3::from_fn(|_, _| size * uniform(&mut random))).collect()
    };
    let job = Job {
        spheres: packing.spheres.clone(),
        corners: packing.bounds,
        viscosity: VISCOSITY,
        eps: ROUGHNESS,
        velocity: vectors(1e-3),
        spin: vectors(1.0),
    };
    let step = format!("edges-{}", packing.name());
    let theirs = bench.yade::<Vec<Loads>>(&step, SCRIPT, 1, &job)?.result;
    let mut rows = vec![];
    for (case, theirs) in CASES.iter().zip(&theirs) {
        let (ours, left_out) = ours(&job, case)?;
        let kept = |k: &usize| !left_out.contains(k);
        let apart = |a: &[Vec3], b: &[Vec3], sign: f64| -> Option<[f64; 2]> {
            let mean = a.iter().map(Vec3::norm).sum::<f64>() / a.len() as f64;
            let places = (0..a.len()).filter(kept);
            let mut off: Vec<f64> = places.map(|k| (a[k] - sign * b[k]).norm() / mean).collect();
            off.sort_by(f64::total_cmp);
            (mean > 0.0).then(|| [off[off.len() - 1], off[off.len() / 2]])
        };
        rows.push(Row {
            packing: packing.name(),
            effect: case.name.to_owned(),
            force: apart(&ours.force, &theirs.force, 1.0),
            torque: apart(&ours.torque, &theirs.torque, case.sign),
            bound: case.bound,
        });
    }
    Ok(rows)
}

/// Uniform in [-1, 1): a linear congruence with Knuth's constants.
pub fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// Our loads, and the spheres where the two programs mean to differ.
fn ours(job: &Job, case: &Case) -> Result<(Loads, HashSet<usize>), Error> {
    let (position, radius): (Vec<Vec3>, Vec<f64>) =
        job.spheres.iter().map(|&[x, y, z, r]| (Vec3::new(x, y, z), r)).unzip();
    let [a, b, c, d, e, f] = job.corners;
    let bounds = Aabb { min: Vec3::new(a, b, c), max: Vec3::new(d, e, f) };
    let material =
        Material { young: 1e6, stiffness_ratio: 0.5, friction_angle: 0.0, density: 2600.0 };
    let walls = WallMaterial { young: 1e6, friction_angle: 0.0 };
    let mut particles = Particles::new(position, radius, material.density);
    match case.turns {
        true => particles.spin.clone_from(&job.spin),
        false => particles.velocity.clone_from(&job.velocity),
    }
    let dem = Dem::new(particles, bounds, material, walls, DemOptions::default())
        .map_err(dempfv::Error::from)?;
    let mut coupled = Coupled::new(dem);
    let boundary = Boundary { pressure: PerWall::from_fn(|_| Some(0.0)), ..Boundary::default() };
    let fluid = Fluid { viscosity: VISCOSITY, slip_walls: true, clamp: Clamp::None, boundary };
    let remesh = RemeshRule { interval: Some(1000), strain: None };
    coupled.saturate(Saturation { fluid, solver: SolverKind::default(), remesh });
    let mut edges =
        EdgeEffects { roughness: ROUGHNESS, stiffness: Some(1e30), ..Default::default() };
    (case.on)(&mut edges);
    coupled.set_fluid_effects(FluidEffects { edges, ..Default::default() });
    coupled.step(1e-12).map_err(dempfv::Error::from)?;
    let Some(flow) = coupled.storage_flow() else { return Ok((Loads::none(), HashSet::new())) };
    let pores = coupled.dem().by_number(flow.force()).map_err(dempfv::Error::from)?;
    let force = coupled.fluid_force().iter().zip(&pores).map(|(all, pores)| all - pores).collect();
    let left_out = left_out(&job.spheres, &flow.network().tessellation, coupled.dem(), case);
    Ok((Loads { force, torque: coupled.fluid_torque() }, left_out))
}

/// Spheres at walls, where ours has films and YADE none; for the two couples those with a neighbour across
/// more than a radius, where the expansions turn negative, YADE's with them.
fn left_out(spheres: &[[f64; 4]], t: &Tessellation, dem: &Dem, case: &Case) -> HashSet<usize> {
    let id = &dem.storage().id;
    let number = |v: u32| id.get(v as usize).map(|&number| number as usize);
    let is_far = |[a, b]: [usize; 2]| {
        let ([x, y, z, r], [u, v, w, s]) = (spheres[a], spheres[b]);
        let gap = Vec3::new(x - u, y - v, z - w).norm() - r - s;
        gap.max(0.0) > (0.5 - ROUGHNESS) * (r + s)
    };
    let mut found = HashSet::new();
    for cell in &t.cells {
        let inside: Vec<usize> = cell.iter().filter_map(|&v| number(v)).collect();
        if case.name == "normal lubrication" && inside.len() < cell.len() {
            found.extend(&inside);
        }
        for (k, &a) in inside.iter().enumerate().filter(|_| case.turns) {
            let far = inside[k + 1..].iter().filter(|&&b| is_far([a, b]));
            found.extend(far.flat_map(|&b| [a, b]));
        }
    }
    found
}

impl Loads {
    fn none() -> Loads {
        Loads { force: vec![], torque: vec![] }
    }
}
