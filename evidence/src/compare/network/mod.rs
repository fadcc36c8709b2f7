//! The part `network` of the comparison: pores, throats, pressures, forces and fluxes of a
//! packing at rest, one by one.

mod case;
mod degenerate;
mod difference;
mod evidence;
mod independent;
mod judge;
mod reference;
mod scales;
mod section;
mod solve;
mod stat;
mod theirs;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use self::case::{Case, Packing};
use self::degenerate::Differing;
use self::difference::{Difference, Geometry};
use self::evidence::Evidence;
use self::independent::Independent;
pub use self::reference::write as write_reference;
use self::scales::Scale;
use self::stat::Stat;
use self::theirs::{Match, Theirs};
use super::peer::Bench;
use super::verdict::Verdict;
use crate::Error;

/// What was measured.
#[derive(Serialize, Deserialize)]
pub struct Part {
    /// One packing each.
    packings: Vec<Compared>,
    /// The smallest packing, in several units of length.
    scales: Vec<Scale>,
    /// Its name.
    scaled: String,
}

/// One packing in both programs.
#[derive(Serialize, Deserialize)]
struct Compared {
    name: String,
    spheres: usize,
    pores: usize,
    throats: usize,
    /// 1 − solid/box.
    porosity: f64,
    differing: Differing,
    geometry: Geometry,
    /// In the order of [`Case::ALL`].
    flows: Vec<Difference>,
    /// Those that the second evaluation has.
    evidence: Vec<Evidence>,
    /// Our volumes from those of the second evaluation, relative.
    our_volume: Stat,
    /// Throats whose overlap depends on the order of the vertices.
    doubtful: usize,
}

impl super::Part for Part {
    const NAME: &'static str = "network";

    fn measure(bench: &Bench, packings: &[PathBuf]) -> Result<Part, Error> {
        let packings = Packing::read_all(packings)?;
        let smallest = (0..packings.len()).min_by_key(|&i| packings[i].position.len());
        let mut part = Part { packings: vec![], scales: vec![], scaled: String::new() };
        for (i, packing) in packings.iter().enumerate() {
            let is_smallest = Some(i) == smallest;
            let scales = if is_smallest { scales::wanted(packing) } else { vec![] };
            let theirs = Theirs::ask(bench, packing, scales)?;
            part.packings.push(Compared::new(bench, packing, &theirs)?);
            if is_smallest {
                part.scales = scales::measure(packing, &theirs)?;
                part.scaled.clone_from(&packing.name);
            }
        }
        Ok(part)
    }

    fn verdicts(&self) -> Vec<Verdict> {
        judge::verdicts(&self.packings)
    }

    fn headline(&self) -> Option<String> {
        section::headline(&self.packings)
    }

    fn section(&self, folder: &Path) -> Result<String, Error> {
        section::section(self, folder)
    }
}

impl Compared {
    fn new(bench: &Bench, packing: &Packing, theirs: &Theirs) -> Result<Compared, Error> {
        let first = packing.flow(&Case::ALL[0].fluid())?;
        let matched = Match::new(first.network(), theirs);
        let independent = Independent::ask(bench, packing, first.network(), theirs, &matched)?;
        let (mut flows, mut evidence) = (vec![], vec![]);
        for (case, theirs) in Case::ALL.into_iter().zip(&theirs.cases) {
            let flow = packing.flow(&case.fluid())?;
            let derivatives = packing.derivatives(&case.fluid())?;
            let ours = (&flow, &derivatives);
            flows.push(Difference::new(packing, case, ours, theirs, &matched));
            evidence.extend(Evidence::new(case, ours, theirs, &matched, &independent)?);
        }
        let network = first.network();
        let volumes = network.volume.iter().zip(&independent.volume);
        Ok(Compared {
            name: packing.name.clone(),
            spheres: packing.position.len(),
            pores: network.pores(),
            throats: network.throats.pores.len(),
            porosity: packing.porosity(),
            differing: Differing::new(packing, network, &matched),
            geometry: Geometry::new(packing, &first, theirs, &matched),
            flows,
            evidence,
            our_volume: Stat::relative(volumes.map(|(a, b)| (*a, *b))),
            doubtful: independent.doubtful,
        })
    }
}
