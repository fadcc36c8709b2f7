//! What reads files.

use std::path::Path;

use dempfv::io::packing::Packing;
use dempfv::io::{checkpoint, matrix_market};
use dempfv::scene::Plan;
use dempfv::simulation::{Estimate, SimulationState, Specimen};
use dempfv::solver::SymmetricCsc;

use super::corpus;
use super::harness::{fuzz, inputs};

#[test]
fn packings_are_read_or_refused() {
    fuzz("packing", &corpus::packings(), inputs(3000, 0.3), |bytes| {
        let text = String::from_utf8_lossy(bytes);
        let packing = Packing::parse(&text).map_err(|e| e.to_string())?;
        let numbers = packing.position.iter().flat_map(|x| [x.x, x.y, x.z]);
        assert!(numbers.chain(packing.radius.iter().copied()).all(f64::is_finite));
        assert!(packing.radius.iter().all(|&r| r > 0.0));
        Ok(())
    });
}

/// What is valid has an estimate in numbers, and is written so that it is read back as itself.
#[test]
fn scenes_are_read_or_refused() {
    let folder = corpus::folder("scenes");
    std::fs::write(folder.join("few.txt"), &corpus::few_spheres()[0]).unwrap();
    let file = folder.join("scene.toml");
    let all: Vec<Vec<u8>> = corpus::scenes().into_iter().chain(corpus::small_scenes()).collect();
    fuzz("scene", &all, inputs(1500, 0.3), |bytes| {
        let text = String::from_utf8_lossy(bytes);
        let plan = Plan::from_toml(&text, Some(&file)).map_err(|e| e.to_string())?;
        plan.validate().unwrap_or_else(|e| panic!("read, but not valid: {e}"));
        let specimen = Specimen::of_cloud(&plan).unwrap_or_default();
        let estimate = Estimate::of(&plan, &specimen).map_err(|e| e.to_string())?;
        assert!(estimate.memory.is_finite(), "memory of {}", estimate.memory);
        let again = Plan::from_toml(&plan.to_toml(), Some(&file));
        let again = again.unwrap_or_else(|e| panic!("written, but not read: {e}"));
        assert_eq!(again.stages.len(), plan.stages.len());
        Ok(())
    });
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn matrices_are_read_or_refused() {
    let folder = corpus::folder("matrices");
    let file = folder.join("a.mtx");
    fuzz("matrix", &corpus::matrices(), inputs(3000, 0.2), |bytes| {
        std::fs::write(&file, bytes).unwrap();
        let vector = matrix_market::read_vector(&file, 3);
        assert!(vector.iter().flatten().all(|x| x.is_finite()));
        let matrix = matrix_market::read_matrix(&file).map_err(|e| e.to_string())?;
        is_sound(&matrix);
        Ok(())
    });
    std::fs::remove_dir_all(folder).unwrap();
}

fn is_sound(a: &SymmetricCsc) {
    assert_eq!(a.col_ptr.len(), a.n + 1);
    assert!(a.values.iter().all(|x| x.is_finite()));
    assert!(a.row_idx.iter().all(|&row| (row as usize) < a.n));
}

/// Of bytes that are not those that were written, none are taken; the checksum is right in half
/// of the inputs, so that what is behind it is read, too.
#[test]
fn checkpoints_are_read_or_refused() {
    let folder = corpus::folder("checkpoints");
    let file = folder.join("a.dempfv");
    checkpoint::save(&file, &corpus::state()).unwrap();
    let whole = std::fs::read(&file).unwrap();
    let turns = std::cell::Cell::new(0);
    fuzz("checkpoint", std::slice::from_ref(&whole), inputs(1500, 0.2), |bytes| {
        turns.set(turns.get() + 1);
        let mut bytes = bytes.to_vec();
        if turns.get() % 2 == 0 {
            vouch(&mut bytes);
        }
        std::fs::write(&file, &bytes).unwrap();
        checkpoint::load::<SimulationState>(&file).map(drop).map_err(|e| e.to_string())
    });
    std::fs::remove_dir_all(folder).unwrap();
}

/// Makes a checkpoint's head fit what follows it: length and checksum.
pub fn vouch(bytes: &mut [u8]) {
    let head = 28 + env!("CARGO_PKG_VERSION").len();
    if bytes.len() <= head {
        return;
    }
    let (start, body) = bytes.split_at_mut(head);
    start[12..16].copy_from_slice(&crc32(body).to_le_bytes());
    start[16..24].copy_from_slice(&(body.len() as u64).to_le_bytes());
}

/// CRC-32 as in zip files (polynomial 0xedb88320), bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, &b| (0..8).fold(crc ^ u32::from(b), step))
}

/// The head that `vouch` writes is one that is taken.
#[test]
fn a_vouched_checkpoint_is_read() {
    let folder = corpus::folder("vouched");
    let file = folder.join("a.dempfv");
    checkpoint::save(&file, &corpus::state()).unwrap();
    let mut bytes = std::fs::read(&file).unwrap();
    bytes[12..24].fill(0xff);
    vouch(&mut bytes);
    std::fs::write(&file, &bytes).unwrap();
    let read: SimulationState = checkpoint::load(Path::new(&file)).unwrap();
    assert_eq!(read, corpus::state());
    std::fs::remove_dir_all(folder).unwrap();
}
