//! Packing files, the history table, and files that appear whole or not at all.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use dempfv::io::atomic::{self, AtomicFile};
use dempfv::io::history::History;
use dempfv::io::packing::{self, Packing};
use dempfv::{Aabb, InputError, Vec3};

/// A fresh folder of this test.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// Numbers of every magnitude, from a small congruential generator.
fn awkward_numbers(n: usize) -> Vec<f64> {
    let mut state = 42_u64;
    let mut out = Vec::with_capacity(n);
    while out.len() < n {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let x = f64::from_bits(state);
        if x.is_finite() && x > 0.0 {
            out.push(x);
        }
    }
    out
}

#[test]
fn a_packing_reads_back_to_the_same_bits() {
    let v = awkward_numbers(4000);
    let position: Vec<_> = v.chunks(4).map(|c| Vec3::new(-c[0], c[1], -c[2])).collect();
    let radius: Vec<_> = v.chunks(4).map(|c| c[3]).collect();
    let bounds = Aabb { min: Vec3::new(-0.1, 1e-300, 0.0), max: Vec3::new(0.3, 7e22, 1.0 / 3.0) };
    let path = folder("packing-bits").join("p.txt");
    packing::write(&path, &position, &radius, Some(&bounds), "two\nlines").unwrap();
    let back = Packing::read(&path).unwrap();
    assert_eq!(back.position, position);
    assert_eq!(back.radius, radius);
    assert_eq!(back.bounds, Some(bounds));
    assert_eq!(back.line[0], 5, "two comment lines, the box and the header come first");
    assert_eq!(back.line[999], 1004);
}

#[test]
fn what_yade_exports_loads_as_it_is() {
    // YADE's export.text: a format comment, tabs, no box.
    let p = Packing::parse("#format x_y_z_r\r\n0.5\t1.5\t-2\t1e-1\r\n\r\n1\t1\t1\t0.2 # top\r\n")
        .unwrap();
    assert_eq!(p.position, [Vec3::new(0.5, 1.5, -2.0), Vec3::new(1.0, 1.0, 1.0)]);
    assert_eq!(p.line, [2, 4]);
    assert_eq!(p.bounds, None);
    let tight = p.bounds_or_tight().unwrap();
    assert_eq!(tight.min, Vec3::new(0.4, 0.8, -2.1));
    assert_eq!(tight.max, Vec3::new(1.2, 1.6, 1.2));
}

/// One sphere at (1, 2, 3) of radius 0.5, in every form that a program writes.
#[test]
fn packings_of_other_programs_load() {
    let dump = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n0 9\n0 9\n0 9\n\
                ITEM: ATOMS id x y z diameter\n1 7 7 7 7\n2 8 8 8 8\n\
                ITEM: TIMESTEP\n9\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n0 4\n0 5\n0 6\n\
                ITEM: ATOMS id type x y z diameter\n1 1 1 2 3 1.0\n";
    for (text, has_box) in [
        ("1 2 3 .5 -1\n", false),
        ("#format x_y_z_r_matId\n1\t2\t3\t0.5\t0\n", false),
        ("#format x_y_z_r_attrs\n1\t2\t3\t0.5\t1.28445\t6\n", false),
        ("0 Sphere 1 2 3 0.5\n", false),
        ("x,y,z,radius\n1,2,3,0.5\n", false),
        ("id; Diameter; X; Y; Z\n7; 1.0; 1; 2; 3\n", false),
        ("1, 2, 3, 0.5\n", false),
        ("\u{feff}1.0D0 2.0d+00 3 5d-1\n", false),
        ("# Box: 0 0 0 4 5 6\n1 2 3 0.5\n", true),
        ("# BOX= 0 0 0 4 5 6\n1 2 3 0.5\n", true),
        (dump, true),
    ] {
        let p = Packing::parse(text).unwrap_or_else(|e| panic!("{text:?}: {e}"));
        assert_eq!((&p.position[..], &p.radius[..]), (&[Vec3::new(1.0, 2.0, 3.0)][..], &[0.5][..]));
        let size = p.bounds.map(|b| [b.size().x, b.size().y, b.size().z]);
        assert_eq!(size, has_box.then_some([4.0, 5.0, 6.0]), "{text:?}");
    }
}

#[test]
fn a_bad_packing_is_an_error_that_says_where_and_what() {
    for (text, line, what) in [
        ("0 0 0 1\n0 0 1\n", Some(2), "3 columns where 4 are due"),
        ("0 0 0 1 7.5\n", Some(1), "5 columns where 4 are due"),
        ("0 0 0 1 7\n0 0 0 1\n", Some(2), "4 columns where 5 are due"),
        ("a,b,c,d\n0,0,0,1\n", Some(1), "the columns `a b c d` have no x, y, z and radius"),
        ("# Box 0 0 0 1 1\n0 0 0 1\n", Some(1), "5 columns where 6 are due"),
        (
            "##PERIODIC:: 1 1 1\n0 0 0 1 -1\n",
            Some(1),
            "a periodic packing: its spheres reach past the cell's faces",
        ),
        (
            "ITEM: BOX BOUNDS xy xz yz pp pp pp\n",
            Some(1),
            "a triclinic box: its walls are not along the axes",
        ),
        ("\n0 zero 0 1\n", Some(2), "`zero` is not a number"),
        ("0 0 0 1\n# \n0 NaN 0 1\n", Some(3), "`NaN` is not a finite number"),
        ("0 0 inf 1\n", Some(1), "`inf` is not a finite number"),
        ("0 0 0 1e999\n", Some(1), "`1e999` is not a finite number"),
        ("0 0 0 -0.5\n", Some(1), "the radius is -0.5"),
        ("0 0 0 0\n", Some(1), "the radius is 0"),
        ("# box 0 0 0 1 1\n0 0 0 1\n", Some(1), "5 columns where 6 are due"),
        ("# box 0 0 0 1 1 a\n0 0 0 1\n", Some(1), "`a` is not a number"),
        ("# box 0 2 0 1 1 1\n0 0 0 1\n", Some(1), "the box's ymax (1) is not above its ymin (2)"),
        ("# box 0 0 0 1 1 1\n# box 0 0 0 1 1 2\n", Some(2), "a second, different box"),
        ("# nothing\n\n", None, "the packing has no sphere"),
        ("", None, "the packing has no sphere"),
    ] {
        let error = Packing::parse(text).unwrap_err();
        assert_eq!((error.line, error.what.as_str()), (line, what), "{text:?}");
        assert!(!error.remedy.is_empty(), "{text:?} has no remedy");
    }
}

#[test]
fn an_unreadable_packing_is_the_users_error_and_names_the_file() {
    let folder = folder("packing-missing");
    let message = |e: InputError| e.to_string();
    let missing = folder.join("p.txt");
    let text = message(Packing::read(&missing).unwrap_err());
    assert!(text.starts_with(missing.to_str().unwrap()), "{text}");
    assert!(text.contains("no such packing file; ") && text.contains("dempfv pack"), "{text}");
    let text = message(Packing::read(&folder.join("no/p.txt")).unwrap_err());
    assert!(text.contains("there is no folder"), "{text}");
    let text = message(Packing::read(&folder).unwrap_err());
    assert!(text.contains("cannot be read"), "{text}");
    fs::write(&missing, b"0 0 0 1\n\xff\xfe\n").unwrap();
    let text = message(Packing::read(&missing).unwrap_err());
    assert!(text.contains("p.txt:2: not text"), "{text}");
}

#[test]
fn a_file_appears_whole_or_not_at_all() {
    let folder = folder("atomic");
    let path = folder.join("file.txt");
    atomic::write(&path, b"old").unwrap();
    // Dropped half-way: the old file stands and nothing is left beside it.
    let mut file = AtomicFile::create(&path).unwrap();
    file.write_all(b"half").unwrap();
    file.flush().unwrap();
    assert_eq!(names(&folder).len(), 2, "the new one is beside the old one while it is written");
    drop(file);
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(names(&folder), ["file.txt"]);
    // The writer fails.
    let failed = atomic::write_with(&path, |out| {
        out.write_all(b"half")?;
        Err(std::io::Error::other("no"))
    });
    assert!(failed.unwrap_err().to_string().contains("file.txt: no"));
    assert_eq!(fs::read(&path).unwrap(), b"old");
    // The place cannot be taken (a folder is in it).
    fs::create_dir(folder.join("dir")).unwrap();
    assert!(atomic::write(&folder.join("dir"), b"x").is_err());
    atomic::write(&path, b"new").unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"new");
    assert_eq!(names(&folder), ["dir", "file.txt"]);
}

/// `--json /dev/null` must leave a device behind and no file (as root it could).
/// Through a link: a test that fails replaces that and nothing of the system's.
#[test]
fn a_device_stays_a_device() {
    let folder = folder("device");
    let link = folder.join("nothing");
    std::os::unix::fs::symlink("/dev/null", &link).unwrap();
    atomic::write(&link, b"gone").unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(names(&folder), ["nothing"]);
}

#[test]
fn history_rows_read_back_exactly_and_in_full() {
    let path = folder("history").join("history.csv");
    let values = awkward_numbers(3000);
    let mut history = History::create(&path, &["step", "stage", "a_pa", "b_m"]).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "step,stage,a_pa,b_m\n");
    for (i, pair) in values.chunks(2).enumerate() {
        let row = [(i as u64).into(), "one,\"two\"".into(), (-pair[0]).into(), pair[1].into()];
        history.row(&row).unwrap();
    }
    assert!(history.row(&[1.0.into()]).is_err(), "a row must have one value per column");
    drop(history);
    let text = fs::read_to_string(&path).unwrap();
    let mut lines = text.lines().skip(1);
    for (i, pair) in values.chunks(2).enumerate() {
        let rest = lines.next().unwrap().strip_prefix(&format!("{i},one  two ,")).unwrap();
        let (a, b) = rest.split_once(',').unwrap();
        assert_eq!((a.parse(), b.parse()), (Ok(-pair[0]), Ok(pair[1])));
    }
    assert_eq!(lines.next(), None);
}

#[test]
fn a_restart_continues_the_history_after_the_checkpoint() {
    let path = folder("history-restart").join("history.csv");
    let columns = ["time_s", "step"];
    let row = |step: u64| [(0.1 * step as f64).into(), step.into()];
    let mut history = History::create(&path, &columns).unwrap();
    (0..10).for_each(|i| history.row(&row(i)).unwrap());
    drop(history);
    let whole = fs::read_to_string(&path).unwrap();
    // A run that died while it wrote, beyond the checkpoint at step 6.
    fs::write(&path, format!("{whole}1.0,1")).unwrap();
    let mut history = History::resume(&path, &columns, "step", 6).unwrap();
    assert_eq!(history.last_step(), Some(6));
    (7..10).for_each(|i| history.row(&row(i)).unwrap());
    history.flush().unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), whole);
    drop(history);
    // Only torn: all whole rows stay.
    fs::write(&path, format!("{whole}1.0,1")).unwrap();
    drop(History::resume(&path, &columns, "step", 100).unwrap());
    assert_eq!(fs::read_to_string(&path).unwrap(), whole);
    // Other columns: refused with what has changed, and left alone.
    for (others, told) in [
        (&["step"][..], "the run has no `time_s`;"),
        (&["time_s", "step", "probe_0_pa"], "the table has no `probe_0_pa`;"),
        (
            &["step", "a", "b", "c", "d", "e"],
            "has `time_s` where the run has `a`, `b`, `c`, `d` and 1 more;",
        ),
        (&["step", "time_s"], "in another order;"),
    ] {
        let error = History::resume(&path, others, "step", 6).unwrap_err();
        let message = error.to_string();
        assert!(error.is_input() && message.contains("history.csv:1: "), "{message}");
        assert!(message.contains(told) && message.contains("probes"), "{message}");
        assert_eq!(fs::read_to_string(&path).unwrap(), whole);
    }
    // No file: a new table.
    let fresh = path.with_file_name("fresh.csv");
    drop(History::resume(&fresh, &columns, "step", 6).unwrap());
    assert_eq!(fs::read_to_string(&fresh).unwrap(), "time_s,step\n");
}
