//! Small loadings whose course in YADE is kept, for tests on machines without YADE.

use std::path::Path;

use dempfv::io::atomic;
use serde::Serialize;

use super::loading::{Change, Course, Loading, Material, Packing, Wet, samples, settled};
use super::peer::Bench;
use crate::Error;

/// File of the packing, beside the others.
const PACKING: &str = "loading-200.txt";

/// A loading in YADE.
#[derive(Serialize)]
struct Reference<'a> {
    /// Version of YADE.
    yade: &'a str,
    /// The loading as a scene of ours.
    scene: String,
    /// Stress that is put on (Pa).
    load: f64,
    /// YADE as it is.
    plain: Course,
    /// YADE with the slip of contacts and the push of corner pores that ours has.
    aligned: Course,
}

/// Writes the packing, and a file for each loading.
///
/// # Errors
/// What failed.
pub fn write(bench: &Bench, folder: &Path) -> Result<(), Error> {
    let mut packing = settled(bench, 200)?;
    let made = std::fs::read(&packing.path).map_err(|e| dempfv::Error::io(&packing.path, e))?;
    atomic::write(&folder.join(PACKING), &made)?;
    // The scene names the file beside it.
    packing.path = PACKING.into();
    for (name, loading) in [("dry", dry()), ("coupled", coupled(&packing))] {
        let step = format!("reference-{name}");
        let run =
            |name: &str, change| loading.yade(bench, &format!("{step}-{name}"), &packing, change);
        let reference = Reference {
            yade: &bench.peer.version,
            scene: loading.scene(&packing),
            load: loading.stress - 1e4,
            plain: run("plain", Change::default())?,
            aligned: run("aligned", Change::ALIGNED)?,
        };
        let path = folder.join(format!("yade-{name}.json"));
        let text =
            serde_json::to_string(&reference).map_err(|e| dempfv::Error::io(&path, e.into()))?;
        atomic::write(&path, (text + "\n").as_bytes())?;
    }
    Ok(())
}

/// 300 steps in which the wall takes up a fifth more.
fn dry() -> Loading {
    Loading {
        material: Material::default(),
        dt: 5e-4,
        stress: 1.2e4,
        max_velocity: 0.03,
        wet: None,
        probes: vec![],
        steps: 300,
        samples: samples(15, 15, 300),
    }
}

/// 200 steps with a fluid, remeshed three times on the way.
fn coupled(packing: &Packing) -> Loading {
    Loading {
        dt: 2e-4,
        max_velocity: 0.1,
        wet: Some(Wet { viscosity: 10.0, remesh_interval: 50, clamp: true }),
        probes: packing.vertical([0.1, 0.3, 0.5, 0.7, 0.9]),
        steps: 200,
        samples: samples(5, 10, 200),
        ..dry()
    }
}
