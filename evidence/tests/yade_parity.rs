//! Our network and flow against what YADE and an evaluation at 50 digits find for the same
//! packings. `dempfv compare yade --write-reference` wrote the files; their first key says
//! with which versions, and when.
//!
//! Bounds against YADE are those of the comparison where its walls, which are huge spheres,
//! are far, and what these cost it where they are near. Against the exact evaluation they
//! are the digits that the files hold.

use std::collections::{BTreeSet, HashMap};
use std::path::PathBuf;

use dempfv::Vec3;
use dempfv::pfv::{Boundary, Clamp, Flow, Fluid};
use dempfv::scene::load_packing;
use dempfv::solver::SolverKind;
use serde::Deserialize;

const PACKINGS: [&str; 2] = ["settled-200", "polydisperse-150"];

#[derive(Deserialize)]
struct Reference {
    cells: Vec<[u32; 4]>,
    throats: Vec<[u32; 2]>,
    at_walls: usize,
    viscosity: f64,
    pressure: [Option<f64>; 6],
    yade: Vec<Case>,
    exact: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    slip: bool,
    clamp: bool,
    conductance: Vec<f64>,
    bounds: [f64; 2],
    pressure: Vec<f64>,
    mean_force: f64,
    force: Vec<Vec3>,
    flux: [f64; 2],
}

/// A packing, its reference, and our flow for each case.
struct Parity {
    name: &'static str,
    reference: Reference,
    flows: Vec<Flow>,
    /// Our number of each of the reference's cells.
    ours: Vec<usize>,
}

impl Parity {
    fn all() -> impl Iterator<Item = Parity> {
        PACKINGS.into_iter().map(Parity::new)
    }

    fn new(name: &'static str) -> Parity {
        let file = |ending: &str| {
            let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/reference");
            folder.join(format!("{name}.{ending}"))
        };
        let text = std::fs::read(file("json")).unwrap();
        let reference: Reference = serde_json::from_slice(&text).unwrap();
        let (packing, bounds) = load_packing(&file("txt"), None).unwrap();
        let flow = |case: &Case| {
            let fluid = Fluid {
                viscosity: reference.viscosity,
                slip_walls: case.slip,
                clamp: if case.clamp { Clamp::Yade } else { Clamp::Unlimited },
                boundary: Boundary { pressure: reference.pressure.into(), ..Boundary::default() },
            };
            let solver = SolverKind::default();
            let mut flow =
                Flow::new(&packing.position, &packing.radius, bounds, &fluid, solver).unwrap();
            flow.solve_static().unwrap();
            flow
        };
        let flows: Vec<Flow> = reference.yade.iter().map(flow).collect();
        let cells = &flows[0].network().tessellation.cells;
        let numbers: HashMap<[u32; 4], usize> =
            cells.iter().enumerate().map(|(i, c)| (sorted(*c), i)).collect();
        let theirs: BTreeSet<[u32; 4]> = reference.cells.iter().copied().map(sorted).collect();
        assert_eq!(theirs, numbers.keys().copied().collect(), "{name}: other pores than YADE's");
        let ours = reference.cells.iter().map(|c| numbers[&sorted(*c)]).collect();
        Parity { name, reference, flows, ours }
    }

    /// Our conductance of each of the reference's throats.
    fn conductances(&self, flow: &Flow) -> Vec<f64> {
        let network = flow.network();
        let between = |&[i, j]: &[u32; 2]| {
            let (i, j) = (self.ours[i as usize], self.ours[j as usize]);
            let around = network.tessellation.neighbors[i];
            let k = around.iter().position(|&n| n as usize == j).expect("pores that touch");
            network.conductances_of(i)[k]
        };
        self.reference.throats.iter().map(between).collect()
    }

    fn cases(&self) -> impl Iterator<Item = (&Flow, &Case, &Case)> {
        let exact = |case: &Case| {
            let mut all = self.reference.exact.iter();
            all.find(|e| e.slip == case.slip && e.clamp == case.clamp).unwrap()
        };
        self.flows.iter().zip(&self.reference.yade).map(move |(f, y)| (f, y, exact(y)))
    }

    /// Spheres that a corner pore touches.
    fn corner_spheres(&self) -> BTreeSet<usize> {
        let spheres = self.flows[0].force().len();
        let corner = |c: &&[u32; 4]| c.iter().filter(|&&v| v as usize >= spheres).count() == 3;
        let vertices = self.reference.cells.iter().filter(corner).flatten();
        vertices.map(|&v| v as usize).filter(|&v| v < spheres).collect()
    }
}

fn sorted(mut cell: [u32; 4]) -> [u32; 4] {
    cell.sort_unstable();
    cell
}

fn relative(a: f64, b: f64) -> f64 {
    (a / b - 1.0).abs()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The six digits that YADE exports (half a unit of the last: 5e-7) where no pore has a
/// wall; at walls in the middle of the distribution 1e-4.
#[test]
fn conductances_are_yades() {
    for parity in Parity::all() {
        let (name, walls) = (parity.name, parity.reference.at_walls);
        for (flow, yade, _) in parity.cases().filter(|(_, yade, _)| !yade.clamp) {
            let off: Vec<f64> = (parity.conductances(flow).iter().zip(&yade.conductance))
                .map(|(a, b)| relative(*a, *b))
                .collect();
            assert_eq!(off.len(), yade.conductance.len());
            let (at_walls, inside) = off.split_at(walls);
            let worst = inside.iter().copied().fold(0.0, f64::max);
            assert!(worst < 5e-7, "{name}: {worst:e} between pores without walls");
            let middle = median(at_walls.to_vec());
            assert!(middle < 1e-4, "{name}: {middle:e} at walls");
        }
    }
}

/// At walls, where YADE is off, against walls as planes: the ten digits of the file.
#[test]
fn conductances_at_walls_are_those_of_planes() {
    for parity in Parity::all() {
        for (flow, _, exact) in parity.cases().filter(|(_, yade, _)| !yade.clamp) {
            assert_eq!(exact.conductance.len(), parity.reference.at_walls);
            for (a, b) in parity.conductances(flow).iter().zip(&exact.conductance) {
                assert!(relative(*a, *b) < 1e-9, "{}: {a:e}, not {b:e}", parity.name);
            }
        }
    }
}

/// YADE's clamp cuts where YADE cuts: to 5e-5, its means being those of its walls; and
/// where the exact evaluation does.
#[test]
fn the_clamp_is_yades() {
    for parity in Parity::all() {
        for (flow, yade, exact) in parity.cases().filter(|(_, yade, _)| yade.clamp) {
            let ours = parity.conductances(flow);
            let least = ours.iter().copied().fold(f64::INFINITY, f64::min);
            let cut = ours.iter().filter(|&&g| g == least).count();
            assert!(cut > 10, "{}: {cut} throats on the clamp", parity.name);
            assert!(relative(least, yade.bounds[0]) < 5e-5);
            assert!(relative(least, exact.bounds[0]) < 1e-12);
        }
    }
}

/// Pressures to 1e-4 of the imposed difference, their median to 1e-5: with so few spheres
/// every second pore is at a wall.
#[test]
fn pressures_are_yades() {
    for parity in Parity::all() {
        for (flow, yade, _) in parity.cases() {
            let off: Vec<f64> = (parity.ours.iter().zip(&yade.pressure))
                .map(|(&i, p)| (flow.pressure()[i] - p).abs())
                .collect();
            assert_eq!(off.len(), flow.pressure().len());
            let worst = off.iter().copied().fold(0.0, f64::max);
            assert!(worst < 1e-4, "{}: {worst:e} Pa of 1", parity.name);
            assert!(median(off) < 1e-5);
        }
    }
}

/// Forces to 5e-4 of their mean, their median to 1e-4, but for the spheres of corner pores:
/// YADE leaves out a push of their pores there.
#[test]
fn forces_are_yades() {
    for parity in Parity::all() {
        let corner = parity.corner_spheres();
        for (flow, yade, exact) in parity.cases() {
            let (mut off, mut at_corners) = (vec![], 0.0f64);
            for (i, (ours, theirs)) in flow.force().iter().zip(&yade.force).enumerate() {
                let away = (ours / yade.mean_force - theirs).norm();
                match corner.contains(&i) {
                    true => at_corners = at_corners.max(away),
                    false => off.push(away),
                }
            }
            // Were these right in YADE, they need not be left out.
            assert!(at_corners > 0.5, "{}: {at_corners:e}", parity.name);
            let worst = off.iter().copied().fold(0.0, f64::max);
            assert!(worst < 5e-4, "{}: {worst:e} of the mean", parity.name);
            assert!(median(off) < 1e-4);
            let forces = flow.force();
            let mean = forces.iter().map(Vec3::norm).sum::<f64>() / forces.len() as f64;
            assert!(relative(mean, exact.mean_force) < 1e-10);
        }
    }
}

/// Fluxes to 1e-4 of YADE's, whose walls are not planes, and to 1e-10 of those of planes.
#[test]
fn fluxes_are_yades() {
    for parity in Parity::all() {
        for (flow, yade, exact) in parity.cases() {
            let ours = [flow.flux()[2], flow.flux()[3]];
            for ((q, theirs), planes) in ours.into_iter().zip(yade.flux).zip(exact.flux) {
                assert!(relative(q, theirs) < 1e-4, "{}: {q:e}, {theirs:e}", parity.name);
                assert!(relative(q, planes) < 1e-10, "{}: {q:e}, {planes:e}", parity.name);
            }
        }
    }
}
