//! Rows of what reads and writes files.

use std::path::{Path, PathBuf};

use super::{NO_LENGTHS, Table};
use dempfv::io::history::{History, Value};
use dempfv::io::matrix_market::{read_matrix, read_vector, write_matrix, write_vector};
use dempfv::io::packing::{self, Packing};
use dempfv::io::vtk::{self, Cells, Collection, LineData, SphereFrame};
use dempfv::pfv::{Boundary, Clamp, Fluid, Network};
use dempfv::solver::SymmetricCsc;
use dempfv::{Aabb, Vec3};

const NAN: Vec3 = Vec3::new(f64::NAN, f64::NAN, f64::NAN);
const UNIT: Aabb = Aabb { min: Vec3::new(0.0, 0.0, 0.0), max: Vec3::new(1.0, 1.0, 1.0) };

/// A file that no other test writes: each has a thread of its own.
fn path(name: &str) -> PathBuf {
    let (process, thread) = (std::process::id(), std::thread::current().id());
    let folder =
        Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("arguments-{process}-{thread:?}"));
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}

fn text(name: &str, contents: &str) -> PathBuf {
    let path = path(name);
    std::fs::write(&path, contents).unwrap();
    path
}

pub fn table() -> Table {
    let mut t = Table::default();
    packings(&mut t);
    matrices(&mut t);
    tables(&mut t);
    frames(&mut t);
    t
}

fn packings(t: &mut Table) {
    let write = "io::packing::write";
    let x = [Vec3::repeat(0.5)];
    let file = path("packing.txt");
    for (word, position, radius, bounds) in [
        ("radius", &x[..], &[][..], None),
        ("position", &[][..], &[][..], None),
        ("position", &[NAN][..], &[0.1][..], None),
        ("radius", &x[..], &[f64::NAN][..], None),
        ("radius", &x[..], &[-1.0][..], None),
        ("bounds", &x[..], &[0.1][..], Some(Aabb { min: UNIT.max, max: UNIT.min })),
        ("bounds", &x[..], &[0.1][..], Some(Aabb { min: UNIT.min, max: NAN })),
    ] {
        t.refuses(write, word, || packing::write(&file, position, radius, bounds.as_ref(), ""));
    }
    t.gives(write, "nothing is left of a refused packing", || !file.exists());
    let one = || Packing::parse("# box 0 0 0 1 1 1\n.5 .5 .5 .1\n").unwrap();
    for copies in [[0, 1, 1], [u32::MAX, 2, 1], [u32::MAX; 3]] {
        t.refuses("io::packing::Packing::tiled", "copies", || one().tiled(copies));
    }
    t.refuses("io::packing::Packing::tiled", "radius", || {
        Packing { radius: vec![], ..one() }.tiled([1, 1, 1])
    });
    t.refuses("io::packing::Packing::tiled", "copies", || {
        let huge = Aabb { min: UNIT.min, max: Vec3::repeat(1e308) };
        Packing { bounds: Some(huge), ..one() }.tiled([2, 2, 2])
    });
    for (word, contents) in [
        ("no sphere", ""),
        ("NaN", "0 0 0 NaN"),
        ("radius", "0 0 0 -1"),
        ("radius", "0 0 0 0"),
        ("1e999", "0 0 0 1e999"),
        ("columns", "0 0"),
        ("xmax", "# box 1 1 1 0 0 0\n.5 .5 .5 .1"),
    ] {
        t.refuses("io::packing::Packing::parse", word, || Packing::parse(contents));
        let file = text("read.txt", contents);
        t.refuses("io::packing::Packing::read", word, || Packing::read(&file));
    }
    let load = "scene::load_packing";
    let file = text("load.txt", ".5 .5 .5 .1\n");
    for bounds in [
        Aabb { min: UNIT.max, max: UNIT.min },
        Aabb { min: NAN, max: UNIT.max },
        Aabb { min: UNIT.min, max: Vec3::repeat(f64::INFINITY) },
    ] {
        t.refuses(load, "box", || dempfv::scene::load_packing(&file, Some(bounds)));
        t.refuses("scene::validate_packing", "box", || {
            dempfv::scene::validate_packing(&x, &[0.1], None, &bounds, None)
        });
    }
    for value in NO_LENGTHS {
        t.refuses("scene::validate_packing", "radius", || {
            dempfv::scene::validate_packing(&x, &[value], None, &UNIT, None)
        });
    }
    t.refuses("scene::validate_packing", "radii", || {
        dempfv::scene::validate_packing(&x, &[], None, &UNIT, None)
    });
    t.refuses("scene::validate_packing", "y = NaN", || {
        let position = [Vec3::new(0.5, f64::NAN, 0.5)];
        dempfv::scene::validate_packing(&position, &[0.1], Some(&[]), &UNIT, None)
    });
}

fn matrices(t: &mut Table) {
    let file = path("matrix.mtx");
    let a = SymmetricCsc { n: 1, col_ptr: vec![0, 1], row_idx: vec![0], values: vec![1.0] };
    let write = "io::matrix_market::write_matrix";
    for (word, a) in [
        ("column pointers", SymmetricCsc { n: 3, ..a.clone() }),
        ("values", SymmetricCsc { values: vec![], ..a.clone() }),
        ("matrix entry", SymmetricCsc { values: vec![f64::NAN], ..a.clone() }),
    ] {
        t.refuses(write, word, || write_matrix(&file, &a));
    }
    t.refuses("io::matrix_market::write_vector", "entry 0", || write_vector(&file, &[f64::NAN]));
    t.refuses("io::matrix_market::write_vector", "empty", || write_vector(&file, &[]));
    t.gives(write, "nothing is left of what was refused", || !file.exists());
    let head = "%%MatrixMarket matrix array real general\n";
    let vector = text("vector.mtx", &format!("{head}2 1\n1\n2\n"));
    for n in [0, 3, usize::MAX] {
        t.refuses("io::matrix_market::read_vector", "right-hand side", || read_vector(&vector, n));
    }
    t.refuses("io::matrix_market::read_matrix", "2 rows", || read_matrix(&vector));
    let huge = text("huge.mtx", &format!("{head}99999999999999 99999999999999\n1\n"));
    t.refuses("io::matrix_market::read_matrix", "ends after", || read_matrix(&huge));
}

fn tables(t: &mut Table) {
    let file = path("history.csv");
    for columns in [&[][..], &[""], &["a,b"], &["a\nb"]] {
        t.refuses("io::history::History::create", "columns", || History::create(&file, columns));
    }
    t.refuses("io::history::History::row", "1 values in 2 columns", || {
        History::create(&file, &["step", "time"])?.row(&[Value::Count(1)])
    });
    let resume = "io::history::History::resume";
    t.refuses(resume, "columns", || History::resume(&file, &["step"], "step", 0));
    t.refuses(resume, "no column `x`", || History::resume(&file, &["step", "time"], "x", 0));
    for time in [f64::NAN, f64::INFINITY] {
        let file = path("frames.pvd");
        t.refuses("io::vtk::Collection::resume", "last_time", || Collection::resume(&file, time));
        t.refuses("io::vtk::Collection::push", "time", || {
            Collection::new(&file).push(time, "a.vtu")
        });
    }
}

fn frames(t: &mut Table) {
    let file = path("cells.vtu");
    let frame =
        SphereFrame { position: &[NAN; 2], radius: &[1.0], velocity: &[], force: &[], id: &[] };
    t.refuses("io::vtk::write_spheres", "radius", || vtk::write_spheres(&file, &frame));
    let mut cells = Cells::default();
    cells.push_tetra([0, 1, 2, u32::MAX]);
    let write = "io::vtk::write_cells";
    t.refuses(write, "point", || vtk::write_cells(&file, &[Vec3::zeros()], &cells, &[]));
    t.refuses(write, "pressure", || {
        vtk::write_cells(&file, &[], &Cells::default(), &[("pressure", &[1.0])])
    });
    let two = LineData { scalars: &[("force", &[1.0, 2.0])], vectors: &[] };
    t.refuses("io::vtk::write_lines", "force", || {
        vtk::write_lines(&file, &[[Vec3::zeros(), Vec3::x()]], &two)
    });
    let boundary = Boundary::default();
    let fluid = Fluid { viscosity: 1.0, slip_walls: true, clamp: Clamp::None, boundary };
    let x = [Vec3::repeat(0.5)];
    let (network, _) = Network::new(&x, &[0.2], UNIT, &fluid).unwrap();
    for length in [0, 2] {
        t.refuses("io::vtk::pore_cells", "position", || {
            vtk::pore_cells(&network, &vec![x[0]; length], &UNIT)
        });
    }
}
