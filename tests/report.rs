//! The pictures and tables of a report. The pictures land in
//! `target/tmp/pictures` to be looked at.

#[path = "../src/report/plot/mod.rs"]
#[allow(dead_code)]
mod plot;
#[path = "../src/report/table.rs"]
mod table;

use std::path::{Path, PathBuf};

use dempfv::io::vtk::Cells;
use dempfv::{Aabb, Vec3, theory};
use plot::{Axis, Consolidation, Mark, Profile, SERIES, Section, Series};

fn folder() -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("pictures");
    std::fs::create_dir_all(&path).unwrap();
    path
}

/// Reproducible noise between -1 and 1.
fn noise(i: usize) -> f64 {
    let mut x = i as u64 ^ 0x9e37_79b9_7f4a_7c15;
    for _ in 0..3 {
        x = (x ^ (x >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    }
    (x >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

#[test]
fn consolidation() {
    let d = 0.052;
    let t: Vec<f64> = (1..=3000).map(|i| 1.55 * i as f64 / 3000.0).collect();
    let u: Vec<f64> = t
        .iter()
        .enumerate()
        .map(|(i, &t)| theory::degree_of_consolidation_drained_top(t, d) + 0.012 * (9.0 * t).sin() * (-t).exp() + 0.002 * noise(i))
        .collect();
    let p: Vec<f64> = t.iter().map(|&t| 0.98 * theory::excess_pressure(1.0, t / (1.0 - d) / (1.0 - d))).collect();
    let picture = plot::consolidation(&Consolidation {
        time_factor: &t,
        degree: &u,
        base_pressure: &p,
        drained_share: d,
        caption: "1000 spheres, 10 → 11 kPa, drained at the top; *c*_{v} = 0.318 m²/s from the modulus and the permeability that the same run measured",
    });
    picture.save(&folder(), "consolidation").unwrap();
}

#[test]
fn profiles() {
    let d = 0.052;
    let height: Vec<f64> = (0..20).map(|i| (i as f64 + 0.5) / 20.0).collect();
    let times = [0.02, 0.05, 0.1, 0.2, 0.4, 0.8];
    let pressure: Vec<Vec<f64>> = times
        .iter()
        .map(|&t| {
            height
                .iter()
                .enumerate()
                .map(|(i, h)| {
                    let z = (1.0 - h / (1.0 - d)).max(0.0);
                    (theory::excess_pressure(z, t / (1.0 - d) / (1.0 - d)) + 0.02 * noise(i)).max(0.0)
                })
                .collect()
        })
        .collect();
    let profiles: Vec<_> = times
        .iter()
        .zip(&pressure)
        .map(|(&time_factor, pressure)| Profile { time_factor, height: &height, pressure })
        .collect();
    let picture = plot::profiles(&profiles, d, "Dots: mean of the pores in 20 layers; lines: Terzaghi, drained top counted");
    picture.save(&folder(), "pressure-profiles").unwrap();
}

/// A face-centred lattice of touching spheres in a box, and cubes of "pores".
#[test]
fn section() {
    let n = 8;
    let h = 2e-3;
    let mut centers = Vec::new();
    for i in 0..n {
        for j in 0..n {
            for k in 0..n {
                let m = (i * n + j) * n + k;
                let jitter = Vec3::new(noise(3 * m), noise(3 * m + 1), noise(3 * m + 2)) * 0.12;
                centers.push((Vec3::new(i as f64, j as f64, k as f64).add_scalar(0.5) + jitter) * h);
            }
        }
    }
    let radii: Vec<f64> = (0..centers.len()).map(|i| 0.5 * h * (0.85 + 0.13 * noise(i))).collect();
    let bounds = Aabb { min: Vec3::zeros(), max: Vec3::repeat(n as f64 * h) };
    let (points, cells, values) = brick_pores(2 * n, 0.5 * h);
    let picture = plot::section(&Section {
        title: "Pore pressure in the section z = 8 mm",
        caption: "at *T*_{v} = 0.1",
        bounds,
        axis: 2,
        position: 8.01e-3,
        centers: &centers,
        radii: &radii,
        points: &points,
        cells: &cells,
        values: &values,
        quantity: "Excess pore pressure",
        unit: "Pa",
    });
    picture.save(&folder(), "section").unwrap();
}

fn brick_pores(n: usize, h: f64) -> (Vec<Vec3>, Cells, Vec<f64>) {
    let (mut points, mut cells, mut values) = (Vec::new(), Cells::default(), Vec::new());
    for i in 0..n {
        for j in 0..n {
            for k in 0..n {
                let first = points.len() as u32;
                for (a, b, c) in [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)] {
                    points.push(Vec3::new((i + a) as f64, (j + b) as f64, (k + c) as f64) * h);
                }
                cells.push_hexahedron(std::array::from_fn(|v| first + v as u32));
                let z = 1.0 - (j as f64 + 0.5) / n as f64;
                values.push(1000.0 * theory::excess_pressure(z, 0.1) * (1.0 + 0.05 * noise(values.len())));
            }
        }
    }
    (points, cells, values)
}

#[test]
fn stress_strain() {
    let strain: Vec<f64> = (0..=400).map(|i| 0.03 * i as f64).collect();
    let curve = |peak: f64| -> Vec<f64> {
        strain.iter().enumerate().map(|(i, e)| 100.0 * (1.0 + peak * (1.0 - (-e).exp()) * (1.0 + 0.8 * (-0.3 * e).exp())) + 2.0 * noise(i)).collect()
    };
    let curves = [curve(1.2), curve(1.6), curve(0.6)];
    let series: Vec<Series> = ["axial stress", "dense specimen, axial stress", "radial stress"]
        .iter()
        .zip(&curves)
        .zip(SERIES)
        .map(|((name, y), color)| Series {
            name: Some((*name).to_owned()),
            x: &strain,
            y,
            color,
            mark: Mark::Line { width: 1.6, dash: None },
        })
        .collect();
    let picture = plot::xy("Dry triaxial compression", "500 spheres, 100 kPa", Axis::linear("Axial strain (%)"), Axis::linear("Stress (kPa)"), &series);
    picture.save(&folder(), "stress-strain").unwrap();
}

#[test]
fn log_axes() {
    let n: Vec<f64> = [1e3, 5e3, 2e4, 1.35e5, 1e6].to_vec();
    let t: Vec<f64> = n.iter().map(|n| 2e-9 * n * n.ln()).collect();
    let line = Series { name: Some("2 threads".into()), x: &n, y: &t, color: SERIES[0], mark: Mark::Line { width: 1.6, dash: None } };
    let dots = Series { mark: Mark::Dots { radius: 3.0, apart: 0.0 }, name: None, ..line.clone() };
    let picture = plot::xy("Time per step", "", Axis::log("Spheres"), Axis::log("Time per step (s)"), &[line, dots]);
    picture.save(&folder(), "log-axes").unwrap();
    let small: Vec<f64> = t.iter().map(|t| 1e-9 * t - 1e-13).collect();
    let line = Series { name: Some("flux".into()), x: &t, y: &small, color: SERIES[1], mark: Mark::Line { width: 1.6, dash: Some([4.0, 2.0]) } };
    let picture = plot::xy("Small and large numbers", "", Axis::linear("Time (s)"), Axis::linear("Flux (m³/s)"), &[line]);
    picture.save(&folder(), "powers").unwrap();
}
