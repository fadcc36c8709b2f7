//! The second evaluation of the formulas, by a program of its own.

use dempfv::Vec3;
use dempfv::pfv::Network;
use serde::{Deserialize, Serialize};

use super::case::{Packing, VISCOSITY, boundary};
use super::difference::{Place, places};
use super::theirs::{Match, Theirs};
use crate::commands::Error;
use crate::commands::compare::peer::Bench;

const SCRIPT: &str = include_str!("../scripts/independent.py");

/// In packings of up to so many spheres every throat is evaluated again, in larger ones
/// those at the walls.
const EVERY_THROAT: usize = 2500;

/// How the second evaluation takes the walls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Model {
    /// As planes, at 50 digits.
    Planes,
    /// As YADE's huge spheres, at 50 digits.
    Spheres,
    /// As YADE's huge spheres, at the precision of a double.
    Double,
}

#[derive(Serialize)]
struct Job {
    spheres: Vec<[f64; 4]>,
    #[serde(rename = "box")]
    corners: [f64; 6],
    cells: Vec<[u32; 4]>,
    throats: Vec<[u32; 2]>,
    viscosity: f64,
    pressure: [Option<f64>; 6],
    solve: bool,
}

#[derive(Deserialize)]
struct Answer {
    volume: Vec<f64>,
    conductance: Vec<Row>,
    doubtful: Vec<usize>,
    cases: Vec<IndependentFlow>,
}

#[derive(Deserialize)]
struct Row {
    model: Model,
    slip: bool,
    values: Vec<Option<f64>>,
}

/// One flow of the second evaluation.
#[derive(Deserialize)]
pub struct IndependentFlow {
    /// The walls.
    pub model: Model,
    /// Does the fluid slip?
    pub slip: bool,
    /// YADE's clamp?
    pub clamp: bool,
    /// Per throat (m³/(Pa·s)).
    pub conductance: Vec<f64>,
    /// Per pore (Pa).
    pub pressure: Vec<f64>,
    /// Per wall, into the box (m³/s).
    pub flux: [f64; 6],
    /// Per sphere (N).
    pub force: Vec<Vec3>,
    /// What the forces sum to beyond the facets' areas (N).
    pub excess: Vec3,
}

/// What the second evaluation found, for our throats.
pub struct Independent {
    /// Volume of each pore (m³), where all throats were evaluated.
    pub volume: Vec<f64>,
    /// Throats where two spheres reach past an edge: the order of the vertices decides
    /// which of them counts.
    pub doubtful: usize,
    /// Flows, where all throats were evaluated.
    pub flows: Vec<IndependentFlow>,
    rows: Vec<Row>,
}

impl Independent {
    /// Evaluates the throats of a network, at least those at walls.
    ///
    /// # Errors
    /// [`Error::Peer`] when Python fails.
    pub fn ask(
        bench: &Bench,
        packing: &Packing,
        network: &Network,
        theirs: &Theirs,
        matched: &Match,
    ) -> Result<Independent, Error> {
        let all = packing.position.len() <= EVERY_THROAT;
        let chosen: Vec<usize> = (places(network).iter().enumerate())
            .filter(|(_, place)| all || **place != Place::Inside)
            .map(|(k, _)| k)
            .collect();
        // In YADE's order of the vertices: its round-off depends on the first one.
        let cell = |(i, p): (usize, &Option<u32>)| match p {
            Some(p) => theirs.cells[*p as usize],
            None => network.tessellation.cells[i],
        };
        let job = Job {
            spheres: packing.spheres(),
            corners: packing.corners(),
            cells: matched.pore.iter().enumerate().map(cell).collect(),
            throats: chosen.iter().map(|&k| network.throats.pores[k]).collect(),
            viscosity: VISCOSITY,
            pressure: boundary().pressure,
            solve: all,
        };
        let step = format!("network-{}-independent", packing.name);
        let answer: Answer = bench.python(&step, SCRIPT, &job)?.result;
        let (pores, throats) = (network.pores(), network.throats.pores.len());
        let whole = answer.volume.len() == if all { pores } else { 0 }
            && answer.conductance.iter().all(|row| row.values.len() == chosen.len())
            && answer.cases.iter().all(|case| {
                let found = [case.conductance.len(), case.pressure.len(), case.force.len()];
                found == [throats, pores, packing.position.len()]
            });
        if !whole {
            let what = "the independent evaluation does not fit the network".to_owned();
            return Err(Error::Peer { step, what, log: None });
        }
        let spread = |row: Row| {
            let mut values = vec![None; throats];
            for (&k, value) in chosen.iter().zip(row.values) {
                values[k] = value;
            }
            Row { values, ..row }
        };
        Ok(Independent {
            volume: answer.volume,
            doubtful: answer.doubtful.len(),
            flows: answer.cases,
            rows: answer.conductance.into_iter().map(spread).collect(),
        })
    }

    /// Conductances without a clamp; `None` for throats that this model was not asked for:
    /// the walls are far, and it makes no difference.
    pub fn conductances(&self, model: Model, slip: bool) -> &[Option<f64>] {
        let row = self.rows.iter().find(|row| row.model == model && row.slip == slip);
        row.map_or(&[], |row| &row.values)
    }
}
