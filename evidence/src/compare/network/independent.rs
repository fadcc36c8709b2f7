//! The second evaluation of the formulas, by a program of its own.

use dempfv::Vec3;
use dempfv::pfv::Network;
use serde::{Deserialize, Serialize};

use super::case::{Packing, VISCOSITY, boundary};
use super::difference::{Place, places};
use super::theirs::{Match, Theirs};
use crate::Error;
use crate::compare::peer::Bench;

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
    rows: Vec<Row>,
    doubtful: Vec<usize>,
    cases: Vec<IndependentFlow>,
}

#[derive(Deserialize)]
struct Row {
    model: Model,
    slip: bool,
    conductance: Vec<Option<f64>>,
    push: Vec<Push>,
}

/// What a throat pushes its spheres by (m²): force per pressure in its first pore.
type Push = Vec<(u32, Vec3)>;

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
    /// Throats of the rows' pushes.
    pushed: Vec<usize>,
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
            pressure: boundary().pressure.0,
            solve: all,
        };
        let step = format!("network-{}-independent", packing.name);
        let answer: Answer = bench.python(&step, SCRIPT, &job)?.result;
        let (pores, throats) = (network.pores(), network.throats.pores.len());
        let whole = answer.volume.len() == if all { pores } else { 0 }
            && answer.rows.iter().all(|row| {
                let pushes = if all { 0 } else { chosen.len() };
                row.conductance.len() == chosen.len() && row.push.len() <= pushes
            })
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
            for (&k, value) in chosen.iter().zip(row.conductance) {
                values[k] = value;
            }
            Row { conductance: values, ..row }
        };
        Ok(Independent {
            volume: answer.volume,
            doubtful: answer.doubtful.len(),
            flows: answer.cases,
            rows: answer.rows.into_iter().map(spread).collect(),
            pushed: chosen,
        })
    }

    /// Conductances without a clamp; `None` for throats that this model was not asked for:
    /// the walls are far, and it makes no difference.
    pub fn conductances(&self, model: Model, slip: bool) -> &[Option<f64>] {
        self.row(model, slip).map_or(&[], |row| &row.conductance)
    }

    /// What forces at these pressures are in a model beyond those of walls as planes, where
    /// the pushes of the throats are known: at walls, in packings that are not solved.
    pub fn beyond_planes(
        &self,
        network: &Network,
        (model, slip): (Model, bool),
        pressure: &[f64],
        force: &mut [Vec3],
    ) {
        let rows = self.row(model, slip).zip(self.row(Model::Planes, slip));
        let Some((row, planes)) = rows else { return };
        for ((&k, there), here) in self.pushed.iter().zip(&row.push).zip(&planes.push) {
            let [i, j] = network.throats.pores[k].map(|p| pressure[p as usize]);
            for (push, sign) in [(there, 1.0), (here, -1.0)] {
                for (sphere, push) in push {
                    if let Some(f) = force.get_mut(*sphere as usize) {
                        *f += sign * (i - j) * push;
                    }
                }
            }
        }
    }

    fn row(&self, model: Model, slip: bool) -> Option<&Row> {
        self.rows.iter().find(|row| row.model == model && row.slip == slip)
    }
}
