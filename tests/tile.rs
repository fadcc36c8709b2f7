//! Copies of a packing side by side.

mod program;

use dempfv::Vec3;
use dempfv::io::packing::Packing;
use program::{Folder, error, packing};

fn read(folder: &Folder, name: &str) -> Packing {
    Packing::read(&folder.0.join(name)).unwrap()
}

/// Overlap of two spheres (m), negative where they are apart.
fn overlap(p: &Packing, i: usize, j: usize) -> f64 {
    p.radius[i] + p.radius[j] - (p.position[i] - p.position[j]).norm()
}

/// Copies have the box, the spheres and the overlaps of the original; across the former
/// wall, two spheres overlap by no more than both pressed into it (their distance is at
/// least the sum of their distances to the wall).
#[test]
fn copies_touch_as_they_touched_the_wall() {
    let folder = Folder::new("tile");
    let file = packing("oedometer-1000.txt");
    folder.done(&["pack", "--tile", "2", "1", "3", &file, "--out", "out"]);
    let one = Packing::read(file.as_ref()).unwrap();
    let tiled = read(&folder, "out/packing.txt");
    let (small, large) = (one.bounds.unwrap(), tiled.bounds.unwrap());
    assert_eq!(tiled.len(), 6 * one.len());
    assert!((large.size() - small.size().component_mul(&Vec3::new(2.0, 1.0, 3.0))).norm() < 1e-15);
    // The first copy is the packing itself, bit for bit.
    assert_eq!(tiled.position[..one.len()], one.position);
    let wall = small.max.x;
    let mut touching = 0;
    for i in 0..one.len() {
        for j in 0..one.len() {
            let other = one.len() + j;
            let shift = tiled.position[other] - one.position[j];
            assert!((shift - Vec3::new(small.size().x, 0.0, 0.0)).norm() < 1e-16);
            let across = overlap(&tiled, i, other);
            let depth = |k: usize| tiled.radius[k] - (tiled.position[k].x - wall).abs();
            assert!(across <= depth(i) + depth(other) + 1e-15, "spheres {i} and {other}");
            touching += usize::from(across > 0.0);
        }
    }
    assert!(touching > 0, "neither copy reaches the other");
}

/// With a stress the copies settle together: the radii have grown alike, the stress is
/// the one asked for, and the bits do not depend on the number of threads.
#[test]
fn copies_settle_together() {
    let folder = Folder::new("tile-settle");
    let file = packing("oedometer-1000.txt");
    let options = ["pack", &file, "--tile", "1", "2", "1", "--stress", "1500"];
    folder.done(&[&options[..], &["--out", "a", "--json", "a.json"]].concat());
    folder.done(&[&options[..], &["--out", "b", "--threads", "1"]].concat());
    assert_eq!(folder.read("a/packing.txt"), folder.read("b/packing.txt"));
    let report = folder.json("a.json");
    assert!((report["stress_pa"].as_f64().unwrap() / 1500.0 - 1.0).abs() < 1e-3);
    assert!(report["unbalanced_force"].as_f64().unwrap() < 1e-3);
    let (one, two) = (Packing::read(file.as_ref()).unwrap(), read(&folder, "a/packing.txt"));
    let growth = two.radius[0] / one.radius[0];
    assert!(growth > 1.0, "more stress than the packing's own 1 kPa needs growth");
    for (i, r) in two.radius.iter().enumerate() {
        assert!((r / one.radius[i % one.len()] / growth - 1.0).abs() < 1e-12);
    }
}

#[test]
fn what_makes_no_copies_is_named() {
    let folder = Folder::new("tile-bad");
    folder.write("p.txt", "0.5 0.5 0.5 0.1\n");
    folder.write("scene.toml", &program::scene("", ""));
    let cases: [(&[&str], &str); 6] = [
        (&["--tile", "0", "1", "1", "p.txt"], "0 × 1 × 1 copies"),
        (&["--tile", "2000", "2000", "2000", "p.txt"], "give one sphere to"),
        (&["--tile", "1", "1", "1"], "required"),
        (&["--tile", "1", "1", "1", "none.txt"], "no such packing file"),
        (&["--tile", "1", "1", "1", "p.txt", "--stress", "-1"], "--stress -1"),
        (&["scene.toml", "--stress", "1e4"], "--stress beside a scene"),
    ];
    for (args, what) in cases {
        let output = folder.dempfv(&[&["pack"], args].concat());
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        assert!(error(&output).contains(what), "{args:?}: {}", error(&output));
    }
    assert!(!folder.0.join("out").exists());
}
