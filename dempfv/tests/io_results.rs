//! Frames for ParaView and checkpoints. What VTK itself makes of the frames is
//! checked by `tests/vtk_read_back.sh`.

use std::fs;
use std::path::{Path, PathBuf};

use dempfv::Vec3;
use dempfv::io::checkpoint;
use dempfv::io::vtk::{self, Cells, Collection, SphereFrame};
use serde::{Deserialize, Serialize};

/// A fresh folder of this test.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

/// The appended array `name` as VTK's file format defines it: at `offset`
/// after the underscore, its length in bytes (u64), then its data.
fn appended<'a>(file: &'a [u8], name: &str) -> &'a [u8] {
    let marker = b"<AppendedData encoding=\"raw\">\n_";
    let start = file.windows(marker.len()).position(|w| w == marker).unwrap() + marker.len();
    let head = std::str::from_utf8(&file[..start]).unwrap();
    let line = head.lines().find(|l| l.contains(&format!("Name=\"{name}\""))).unwrap();
    let offset = line.split("offset=\"").nth(1).unwrap().split('"').next().unwrap();
    let (length, data) = file[start + offset.parse::<usize>().unwrap()..].split_at(8);
    &data[..u64::from_le_bytes(length.try_into().unwrap()) as usize]
}

fn floats(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
}

#[test]
fn sphere_frames_hold_every_number() {
    let path = folder("vtk-spheres").join("s.vtu");
    let vectors = |s: f64| vec![Vec3::new(s, 2.0 * s, -s), Vec3::new(0.1 * s, 1e-9 * s, 0.0)];
    let frame = SphereFrame {
        position: &vectors(1.0),
        radius: &[0.5, 0.25],
        velocity: &vectors(3.0),
        force: &vectors(-5.0),
        id: &[7, u32::MAX],
    };
    vtk::write_spheres(&path, &frame).unwrap();
    let file = fs::read(&path).unwrap();
    assert_eq!(floats(appended(&file, "Points")), [1.0, 2.0, -1.0, 0.1, 1e-9, 0.0]);
    assert_eq!(floats(appended(&file, "radius")), [0.5, 0.25]);
    assert_eq!(floats(appended(&file, "velocity"))[..3], [3.0, 6.0, -3.0]);
    assert_eq!(floats(appended(&file, "force"))[..3], [-5.0, -10.0, 5.0]);
    assert_eq!(appended(&file, "id"), [7, 0, 0, 0, 255, 255, 255, 255]);
    assert_eq!(appended(&file, "types"), [1, 1]);
    // A frame whose arrays do not fit together is refused, not written.
    let path = path.with_file_name("bad.vtu");
    let error = vtk::write_spheres(&path, &SphereFrame { radius: &[0.5], ..frame }).unwrap_err();
    assert!(error.to_string().contains("radius has 1 values, not 2 (points)"), "{error}");
    assert!(!path.exists());
}

#[test]
fn cells_are_turned_to_positive_volume_and_checked() {
    let cube: Vec<_> = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)]
        .into_iter()
        .flat_map(|(x, y)| [Vec3::new(x, y, 0.0), Vec3::new(x, y, 1.0)])
        .collect();
    // Bottom 0 2 4 6, counter-clockwise from above; top 1 3 5 7.
    let positive = |c: &mut Cells| {
        c.push_tetra([0, 2, 4, 1]);
        c.push_wedge([0, 4, 2, 1, 5, 3]);
        c.push_hexahedron([0, 2, 4, 6, 1, 3, 5, 7]);
    };
    let (mut cells, mut expected) = (Cells::default(), Cells::default());
    positive(&mut cells);
    positive(&mut expected);
    cells.orient(&cube);
    assert_eq!(cells, expected, "positive cells stay as they are");
    let mut mirrored = Cells::default();
    mirrored.push_tetra([0, 4, 2, 1]);
    mirrored.push_wedge([0, 2, 4, 1, 3, 5]);
    mirrored.push_hexahedron([0, 6, 4, 2, 1, 7, 5, 3]);
    mirrored.orient(&cube);
    assert_eq!(mirrored, expected);
    assert_eq!(cells.len(), 3);

    let path = folder("vtk-cells").join("c.vtu");
    vtk::write_cells(&path, &cube, &cells, &[("a \"<&>\" b", &[1.0, 2.0, 3.0])]).unwrap();
    let file = fs::read(&path).unwrap();
    assert_eq!(floats(appended(&file, "a &quot;&lt;&amp;&gt;&quot; b")), [1.0, 2.0, 3.0]);
    assert_eq!(appended(&file, "types"), [10, 13, 12]);
    let ends: Vec<_> = appended(&file, "offsets").chunks(8).map(|b| b[0]).collect();
    assert_eq!(ends, [4, 10, 18]);
    let error = vtk::write_cells(&path, &cube[..7], &cells, &[]).unwrap_err();
    assert!(error.to_string().contains("a cell names point 7 of 7"), "{error}");
}

#[test]
fn a_collection_drops_the_frames_after_a_restart() {
    let path = folder("vtk-collection").join("pores.pvd");
    let mut frames = Collection::new(&path);
    for i in 0..5 {
        frames.push(0.1 * f64::from(i), &format!("a&b-{i}.vtu")).unwrap();
    }
    let whole = fs::read_to_string(&path).unwrap();
    assert_eq!(whole.matches("<DataSet ").count(), 5);
    assert!(whole.contains("timestep=\"0.30000000000000004\""), "{whole}");
    let mut frames = Collection::resume(&path, 0.2).unwrap();
    assert_eq!(frames.len(), 3);
    frames.push(0.1 * 3.0, "a&b-3.vtu").unwrap();
    frames.push(0.1 * 4.0, "a&b-4.vtu").unwrap();
    // The collection could not be written, say, and is once more.
    frames.push(0.1 * 4.0, "a&b-4.vtu").unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), whole);
    fs::write(&path, whole.replace("timestep", "time")).unwrap();
    let error = Collection::resume(&path, 0.2).unwrap_err();
    assert!(error.is_input() && error.to_string().contains("pores.pvd:4: "), "{error}");
    assert!(Collection::resume(&path.with_file_name("none.pvd"), 1.0).unwrap().is_empty());
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct State {
    step: u64,
    x: Vec<Vec3>,
    stage: String,
}

fn state() -> State {
    let x = (0..1000).map(|i| Vec3::new(0.1 * f64::from(i), -0.0, 1e-310)).collect();
    State { step: u64::MAX - 1, x, stage: "consolidate".into() }
}

#[test]
fn a_checkpoint_keeps_every_bit() {
    let path = folder("checkpoint").join("c");
    checkpoint::save(&path, &state()).unwrap();
    let back: State = checkpoint::load(&path).unwrap();
    assert_eq!(back, state());
    assert!(back.x[3].y.is_sign_negative(), "-0.0 keeps its sign");
}

#[test]
fn a_bad_checkpoint_is_refused_with_the_reason() {
    let path = folder("checkpoint-bad").join("c");
    checkpoint::save(&path, &state()).unwrap();
    let good = fs::read(&path).unwrap();
    let reason = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        let error = checkpoint::load::<State>(&path).unwrap_err();
        assert_eq!(error.file.as_deref(), Some(path.as_path()));
        error.what
    };
    assert_eq!(reason(b""), "not a checkpoint");
    assert_eq!(reason(b"time_s,step\n0,0\n"), "not a checkpoint");
    for end in [8, 20, 30] {
        assert_eq!(reason(&good[..end]), "the checkpoint is cut short");
    }
    assert!(reason(&good[..good.len() - 1]).starts_with("the checkpoint is cut short: "));
    assert_eq!(reason(&[&good[..], b"x"].concat()), "the checkpoint has bytes after its end");
    // A flipped bit anywhere is found, be it in the head or in the state.
    for at in (0..good.len()).step_by(97).chain(0..40) {
        let mut bytes = good.clone();
        bytes[at] ^= 4;
        assert!(!reason(&bytes).is_empty(), "byte {at}");
    }
    let mut bytes = good.clone();
    bytes[8] = 99;
    assert_eq!(reason(&bytes), "a checkpoint of format 99; this program reads format 11");
    let mut bytes = good.clone();
    bytes[good.len() / 2] ^= 1;
    assert_eq!(reason(&bytes), "the checkpoint is damaged: its checksum does not match");
    let version = env!("CARGO_PKG_VERSION");
    let mut bytes = good.clone();
    let at = bytes.windows(version.len()).position(|w| w == version.as_bytes()).unwrap();
    bytes[at] = b'9';
    let expected = format!("a checkpoint of dempfv 9{}; this is dempfv {version}", &version[1..]);
    assert_eq!(reason(&bytes), expected);

    fs::write(&path, &good).unwrap();
    let other = checkpoint::load::<(u64, u64)>(&path).unwrap_err();
    assert!(other.what.starts_with("the checkpoint holds "), "{}", other.what);
    let missing = checkpoint::load::<State>(&path.with_file_name("none")).unwrap_err();
    assert_eq!(missing.what, "no such checkpoint");
}
