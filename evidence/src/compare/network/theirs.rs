//! YADE's answer, and which of its pores is which of ours.

use std::collections::HashMap;

use dempfv::Vec3;
use dempfv::pfv::{Network, Tessellation};
use serde::{Deserialize, Serialize};

use super::case::{Case, Packing, VISCOSITY, boundary};
use crate::Error;
use crate::compare::peer::Bench;

const SCRIPT: &str = include_str!("../scripts/network.py");

/// What YADE is asked.
#[derive(Serialize)]
struct Job {
    spheres: Vec<[f64; 4]>,
    #[serde(rename = "box")]
    corners: [f64; 6],
    viscosity: f64,
    pressure: [Option<f64>; 6],
    cases: [Case; 4],
    scales: Vec<f64>,
}

/// YADE's network of a packing and its flows.
#[derive(Deserialize)]
pub struct Theirs {
    /// Vertices of each pore; spheres first, then walls.
    pub cells: Vec<[u32; 4]>,
    /// Pores that share a facet with each pore.
    pub neighbors: Vec<Vec<u32>>,
    /// Centre of each pore (m).
    pub center: Vec<Vec3>,
    /// Volume of each pore (m³), where YADE tells.
    pub volume: Vec<Option<f64>>,
    /// Whether its pressure is imposed.
    pub imposed: Vec<bool>,
    /// One flow for each of [`Case::ALL`].
    pub cases: Vec<TheirFlow>,
    /// Flows through the packing in other units of length.
    pub scaled: Vec<Scaled>,
}

/// One flow of YADE's.
#[derive(Deserialize)]
pub struct TheirFlow {
    /// Per pore across the facet opposite each vertex (m³/(Pa·s)).
    pub conductance: Vec<[f64; 4]>,
    /// Per pore (Pa).
    pub pressure: Vec<f64>,
    /// Per wall, out of the box (m³/s).
    pub flux: [f64; 6],
    /// Per sphere (N).
    pub force: Vec<Vec3>,
    /// As Python prints it.
    pub porosity: String,
}

/// A flow in another unit of length.
#[derive(Deserialize)]
pub struct Scaled {
    /// Lengths over those of the packing.
    pub scale: f64,
    /// YADE's clamp?
    pub clamp: bool,
    /// Per wall, out of the box.
    pub flux: [f64; 6],
}

impl Theirs {
    /// Asks YADE. `scales`: units of length in which the flow is wanted too.
    ///
    /// # Errors
    /// [`Error::Peer`] when YADE fails or answers something else.
    pub fn ask(bench: &Bench, packing: &Packing, scales: Vec<f64>) -> Result<Theirs, Error> {
        let job = Job {
            spheres: packing.spheres(),
            corners: packing.corners(),
            viscosity: VISCOSITY,
            pressure: boundary().pressure.0,
            cases: Case::ALL,
            scales,
        };
        let step = format!("network-{}", packing.name);
        let theirs: Theirs = bench.yade(&step, SCRIPT, 1, &job)?.result;
        match theirs.disorder(packing.position.len()) {
            None => Ok(theirs),
            Some(what) => Err(Error::Peer { step, what, log: None }),
        }
    }

    /// What of the answer does not fit together.
    fn disorder(&self, spheres: usize) -> Option<String> {
        let pores = self.cells.len();
        let per_pore = [self.neighbors.len(), self.center.len(), self.volume.len()];
        let flows = self.cases.iter().all(|c| {
            [c.conductance.len(), c.pressure.len(), c.force.len()] == [pores, pores, spheres]
        });
        let known = self.cells.as_flattened().iter().all(|&v| (v as usize) < spheres + 6);
        let fits = per_pore == [pores; 3] && flows && known;
        let fits = fits && self.imposed.len() == pores && self.cases.len() == Case::ALL.len();
        (!fits).then(|| format!("YADE's network of {pores} pores does not fit together"))
    }
}

/// Which pores and throats of YADE's are which of ours.
pub struct Match {
    /// YADE's number of each of our pores, where it has that pore.
    pub pore: Vec<Option<u32>>,
    /// Pores that only YADE has.
    pub only_theirs: Vec<u32>,
    /// Our throats' places in YADE's arrays: its pore, and the vertex opposite.
    throat: Vec<Option<(u32, usize)>>,
}

impl Match {
    /// Matches pores by their four vertices, throats by their two pores.
    pub fn new(ours: &Network, theirs: &Theirs) -> Match {
        let key = |cell: &[u32; 4]| {
            let mut key = *cell;
            key.sort_unstable();
            key
        };
        let numbers: HashMap<[u32; 4], u32> =
            theirs.cells.iter().zip(0..).map(|(cell, i)| (key(cell), i)).collect();
        let t: &Tessellation = &ours.tessellation;
        let pore: Vec<Option<u32>> =
            t.cells.iter().map(|cell| numbers.get(&key(cell)).copied()).collect();
        let mut known = vec![false; theirs.cells.len()];
        pore.iter().flatten().for_each(|&i| known[i as usize] = true);
        let only_theirs = (0..).zip(&known).filter(|(_, known)| !**known).map(|(i, _)| i).collect();
        let throat = ours.throats.pores.iter().map(|&[i, j]| {
            let (a, b) = (pore[i as usize]?, pore[j as usize]?);
            let (cell, other) = (theirs.cells[a as usize], theirs.cells[b as usize]);
            let opposite = cell.iter().position(|v| !other.contains(v));
            opposite.filter(|_| theirs.neighbors[a as usize].contains(&b)).map(|k| (a, k))
        });
        Match { throat: throat.collect(), pore, only_theirs }
    }

    /// Number of pores that only one of the two has.
    pub fn differing(&self) -> usize {
        self.only_ours().count() + self.only_theirs.len()
    }

    /// Pores that only we have.
    pub fn only_ours(&self) -> impl Iterator<Item = usize> + '_ {
        self.pore.iter().enumerate().filter(|(_, p)| p.is_none()).map(|(i, _)| i)
    }

    /// Our pores that YADE has too, with its number.
    pub fn common(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.pore.iter().enumerate().filter_map(|(i, p)| p.map(|p| (i, p as usize)))
    }

    /// YADE's conductance of each of our throats, where it has that throat.
    pub fn conductances<'a>(
        &'a self,
        flow: &'a TheirFlow,
    ) -> impl Iterator<Item = Option<f64>> + 'a {
        self.throat.iter().map(|place| place.map(|(pore, k)| flow.conductance[pore as usize][k]))
    }
}
