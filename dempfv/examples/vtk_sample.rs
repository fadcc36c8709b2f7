//! Writes frames whose every number follows from its index, for a reader that
//! knows the rule (`tests/vtk_read_back.py`) to check:
//! `cargo run --example vtk_sample -- FOLDER`.

use std::path::Path;

use dempfv::io::vtk::{self, Cells, Collection, SphereFrame};
use dempfv::{Result, Vec3};

const SPHERES: u32 = 1000;
const FRAMES: u32 = 3;
/// Cells of each shape.
const BLOCKS: u32 = 50;

fn main() -> Result<()> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "target/vtk-sample".into());
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder).map_err(|e| dempfv::Error::io(folder, e))?;
    let mut spheres = Collection::new(&folder.join("spheres.pvd"));
    let mut pores = Collection::new(&folder.join("pores.pvd"));
    for frame in 0..FRAMES {
        let time = 0.125 * f64::from(frame);
        let name = format!("spheres-{frame:06}.vtu");
        write_spheres(&folder.join(&name), time)?;
        spheres.push(time, &name)?;
        let name = format!("pores-{frame:06}.vtu");
        write_pores(&folder.join(&name), time)?;
        pores.push(time, &name)?;
    }
    println!("wrote {FRAMES} frames to {}", folder.display());
    Ok(())
}

fn write_spheres(path: &Path, time: f64) -> Result<()> {
    let id: Vec<u32> = (0..SPHERES).rev().collect();
    let i = || id.iter().map(|&i| f64::from(i));
    let position: Vec<_> = i().map(|i| Vec3::new(i, i / 7.0 + time, -i.sqrt())).collect();
    let radius: Vec<_> = i().map(|i| 1e-3 * (i + 1.0)).collect();
    let velocity: Vec<_> = i().map(|i| Vec3::new(time, -i, 1.0 / (i + 1.0))).collect();
    let force: Vec<_> = i().map(|i| Vec3::new(1e-300 * i, i * i, 1e300 * time)).collect();
    let frame = SphereFrame {
        position: &position,
        radius: &radius,
        velocity: &velocity,
        force: &force,
        id: &id,
    };
    Ok(vtk::write_spheres(path, &frame)?)
}

/// Block `i` is a unit cube at (3i, 0, 0) with its top stretched to height
/// 1 + i/10: a tetrahedron, a wedge and a hexahedron of known volumes on it.
/// Every other block names its vertices the other way round.
fn write_pores(path: &Path, time: f64) -> Result<()> {
    let mut points = Vec::new();
    let mut cells = Cells::default();
    let (mut volume, mut pressure) = (Vec::new(), Vec::new());
    for i in 0..BLOCKS {
        let x = |dx, dy, dz| Vec3::new(3.0 * f64::from(i) + dx, dy, dz);
        let h = 1.0 + f64::from(i) / 10.0;
        let first = points.len() as u32;
        points.extend([x(0., 0., 0.), x(1., 0., 0.), x(1., 1., 0.), x(0., 1., 0.)]);
        points.extend([x(0., 0., h), x(1., 0., h), x(1., 1., h), x(0., 1., h)]);
        let mut v: [u32; 8] = std::array::from_fn(|k| first + k as u32);
        if i % 2 == 1 {
            v.reverse();
            v.swap(0, 4);
            v.swap(1, 5);
            v.swap(2, 6);
            v.swap(3, 7);
        }
        cells.push_tetra([v[0], v[1], v[2], v[4]]);
        cells.push_wedge([v[0], v[1], v[2], v[4], v[5], v[6]]);
        cells.push_hexahedron(v);
        volume.extend([h / 6.0, h / 2.0, h]);
        pressure.extend([0, 1, 2].map(|k| 1000.0 * f64::from(3 * i + k) / 7.0 + time));
    }
    cells.orient(&points);
    Ok(vtk::write_cells(path, &points, &cells, &[("pressure", &pressure), ("volume", &volume)])?)
}
