//! Reference files: what YADE and the second evaluation find for small packings, for tests
//! that have neither.

use std::path::{Path, PathBuf};

use dempfv::Vec3;
use dempfv::io::atomic;
use dempfv::pfv::Network;
use dempfv_report::machine;
use serde::Serialize;

use super::case::{Case, Packing};
use super::independent::{Independent, IndependentFlow, Model};
use super::theirs::{Match, TheirFlow, Theirs};
use crate::Error;
use crate::compare::peer::Bench;

/// What a file holds. Vertices are spheres from 0 and, after them, the walls; throats are
/// pairs of cells.
#[derive(Serialize)]
struct Reference {
    /// Program, versions, day.
    made: String,
    /// YADE's pores, by their vertices.
    cells: Vec<[u32; 4]>,
    /// All throats, those at walls first.
    throats: Vec<[u32; 2]>,
    /// Number of those.
    at_walls: usize,
    /// Dynamic viscosity (Pa·s).
    viscosity: f64,
    /// Imposed pressure of each wall (Pa).
    pressure: [Option<f64>; 6],
    yade: Vec<Flow>,
    /// Walls as planes, at 50 digits.
    exact: Vec<Flow>,
}

/// One flow. YADE's to seven digits, pressures to 1e-6 of the imposed difference, forces to
/// 1e-5 of their mean; the exact one to ten.
#[derive(Serialize)]
struct Flow {
    #[serde(flatten)]
    case: Case,
    /// Per throat (m³/(Pa·s)); the exact ones only at walls, and none with the clamp: there
    /// they follow from its bounds.
    conductance: Vec<f64>,
    /// Smallest and largest conductance.
    bounds: [f64; 2],
    /// Per cell (Pa); empty in the exact flows.
    pressure: Vec<f64>,
    /// Mean size of the forces on the spheres (N).
    mean_force: f64,
    /// Per sphere, over that mean; empty in the exact flows.
    force: Vec<Vec3>,
    /// Into the box at the bottom and at the top (m³/s).
    flux: [f64; 2],
}

/// Writes a file for each packing into a folder; returns their paths.
///
/// # Errors
/// When a program fails, when the two find different pores, or when the system refuses.
pub fn write(bench: &Bench, packings: &[PathBuf], folder: &Path) -> Result<Vec<PathBuf>, Error> {
    Packing::read_all(packings)?.iter().map(|packing| write_one(bench, packing, folder)).collect()
}

fn write_one(bench: &Bench, packing: &Packing, folder: &Path) -> Result<PathBuf, Error> {
    let flow = packing.flow(&Case::ALL[0].fluid())?;
    let theirs = Theirs::ask(bench, packing, vec![])?;
    let matched = Match::new(flow.network(), &theirs);
    let independent = Independent::ask(bench, packing, flow.network(), &theirs, &matched)?;
    if matched.differing() > 0 || independent.flows.is_empty() {
        return Err(Error::Peer {
            step: format!("network-{}", packing.name),
            what: "a packing whose triangulation or size leaves a choice is no reference".into(),
            log: None,
        });
    }
    let reference =
        Reference::new(&bench.peer.version, flow.network(), &theirs, &matched, &independent);
    let text = serde_json::to_vec(&reference).map_err(|e| dempfv::Error::io(folder, e.into()))?;
    let path = folder.join(format!("{}.json", packing.name));
    atomic::write(&path, &text)?;
    Ok(path)
}

impl Reference {
    fn new(
        version: &str,
        network: &Network,
        theirs: &Theirs,
        matched: &Match,
        independent: &Independent,
    ) -> Reference {
        let at_walls = |k: &usize| independent.conductances(Model::Double, true)[*k].is_some();
        let all = 0..network.throats.pores.len();
        let (walls, inside): (Vec<usize>, Vec<usize>) = all.partition(at_walls);
        let order: Vec<usize> = walls.iter().chain(&inside).copied().collect();
        // By YADE's numbers of its cells.
        let number = |i: u32| matched.pore[i as usize].unwrap_or_default();
        let exact = independent.flows.iter().filter(|f| f.model == Model::Planes);
        Reference {
            made: format!(
                "YADE {version} and mpmath, by `dempfv compare yade --write-reference`, dempfv {}, {}",
                env!("CARGO_PKG_VERSION"),
                machine::today()
            ),
            cells: theirs.cells.clone(),
            throats: order.iter().map(|&k| network.throats.pores[k].map(number)).collect(),
            at_walls: walls.len(),
            viscosity: network.viscosity,
            pressure: super::case::boundary().pressure.0,
            yade: (Case::ALL.into_iter().zip(&theirs.cases))
                .map(|(case, flow)| of_yade(case, flow, matched, &order))
                .collect(),
            exact: exact.map(|flow| of_exact(flow, &walls)).collect(),
        }
    }
}

fn of_yade(case: Case, flow: &TheirFlow, matched: &Match, order: &[usize]) -> Flow {
    let all: Vec<f64> = matched.conductances(flow).map(Option::unwrap_or_default).collect();
    let mean = mean(&flow.force);
    let chosen = order.iter().filter(|_| !case.clamp).map(|&k| digits(all[k], 6));
    Flow {
        case,
        conductance: chosen.collect(),
        bounds: bounds(&all, 9),
        pressure: flow.pressure.iter().map(|p| round(*p, 1e6)).collect(),
        mean_force: digits(mean, 9),
        force: flow.force.iter().map(|f| f.map(|c| round(c / mean, 1e5))).collect(),
        // YADE counts what leaves the box.
        flux: [digits(-flow.flux[2], 9), digits(-flow.flux[3], 9)],
    }
}

fn of_exact(flow: &IndependentFlow, walls: &[usize]) -> Flow {
    let chosen = walls.iter().filter(|_| !flow.clamp).map(|&k| digits(flow.conductance[k], 9));
    Flow {
        case: Case { slip: flow.slip, clamp: flow.clamp },
        conductance: chosen.collect(),
        bounds: bounds(&flow.conductance, 14),
        pressure: vec![],
        mean_force: digits(mean(&flow.force), 14),
        force: vec![],
        flux: [digits(flow.flux[2], 14), digits(flow.flux[3], 14)],
    }
}

fn mean(force: &[Vec3]) -> f64 {
    force.iter().map(Vec3::norm).sum::<f64>() / force.len().max(1) as f64
}

fn bounds(conductance: &[f64], decimals: usize) -> [f64; 2] {
    let least = conductance.iter().copied().fold(f64::INFINITY, f64::min);
    let most = conductance.iter().copied().fold(0.0, f64::max);
    [digits(least, decimals), digits(most, decimals)]
}

/// A number with so many digits behind its first.
fn digits(value: f64, decimals: usize) -> f64 {
    format!("{value:.decimals$e}").parse().unwrap_or(value)
}

/// A number as a multiple of 1/`unit`.
fn round(value: f64, unit: f64) -> f64 {
    (value * unit).round() / unit
}
