//! Checkpoints that are cut or spoilt.

use crate::program::error;
use crate::specimen::{Random, Specimen, count, scene};

/// A checkpoint that is cut at any length or has a bit flipped anywhere is refused with its name
/// and the reason (status 2), and the results in its folder stay as they are.
#[test]
fn cut_and_spoilt_checkpoints_are_refused() {
    let specimen = Specimen::new("spoilt", &scene(60, [3, 0, 0]));
    let folder = &specimen.folder;
    folder.done(&["run", "scene.toml", "--out", "out", "--steps", "40"]);
    let whole = std::fs::read(folder.0.join("out/checkpoint.dempfv")).unwrap();
    let before = folder.files();
    let mut random = Random::new(4);
    let (cuts, flips) = (count("DEMPFV_CUTS", 6), count("DEMPFV_FLIPS", 12));
    let refuse = |bytes: &[u8], context: String| {
        std::fs::write(folder.0.join("spoilt.dempfv"), bytes).unwrap();
        let args = ["run", "scene.toml", "--out", "new", "--restart", "spoilt.dempfv"];
        let output = folder.dempfv(&args);
        let message = error(&output);
        assert_eq!(output.status.code(), Some(2), "{context}: {message}");
        assert!(message.starts_with("error: spoilt.dempfv: "), "{context}: {message}");
        assert_eq!(message.lines().count(), 1, "{context}: {message}");
    };
    // The head is where each length is another case.
    let head = 40.min(cuts / 2);
    for k in 0..cuts {
        let length = if k < head { k } else { random.below(whole.len() as u64) as usize };
        refuse(&whole[..length], format!("cut to {length} bytes"));
    }
    for _ in 0..flips {
        let bit = random.below(8 * whole.len() as u64) as usize;
        let mut bytes = whole.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        refuse(&bytes, format!("bit {bit} flipped"));
    }
    std::fs::remove_file(folder.0.join("spoilt.dempfv")).unwrap();
    assert!(folder.files() == before);
    println!("checkpoints: {cuts} cut, {flips} with a flipped bit; all refused");
}
