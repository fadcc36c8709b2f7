//! The pictures and tables of a report. The pictures land in
//! `target/tmp/pictures` to be looked at.

use std::path::{Path, PathBuf};

use dempfv::io::vtk::Cells;
use dempfv::{Aabb, Vec3, theory};
use dempfv_report::plot::axis::{Scale, Ticks, prefix};
use dempfv_report::plot::color;
use dempfv_report::plot::picture::Segment;
use dempfv_report::plot::section::{hull, plane_points};
use dempfv_report::plot::text::{Face, Layout};
use dempfv_report::plot::{self};
use dempfv_report::plot::{
    Axis, Consolidation, Layers, Mark, Panel, Profile, SERIES, Section, Series,
};
use dempfv_report::table;

fn folder() -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("pictures");
    std::fs::create_dir_all(&path).unwrap();
    path
}

/// Saves a picture and checks that both files say the same: the PNG two pixels
/// per point, the SVG with all of these words.
fn save(picture: &plot::Picture, name: &str, words: &[&str]) {
    picture.save(&folder(), name).unwrap();
    let png = std::fs::read(folder().join(format!("{name}.png"))).unwrap();
    assert_eq!(&png[..8], b"\x89PNG\r\n\x1a\n");
    let side = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
    assert_eq!(side(16), (2.0 * picture.width) as u32);
    assert_eq!(side(20), (2.0 * picture.height) as u32);
    let svg = std::fs::read_to_string(folder().join(format!("{name}.svg"))).unwrap();
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}: a coordinate is not finite");
    for word in words {
        assert!(svg.contains(&format!("aria-label=\"{word}\"")), "{name} does not say `{word}`");
    }
}

/// Reproducible noise between -1 and 1.
fn noise(i: usize) -> f64 {
    let mut x = i as u64 ^ 0x9e37_79b9_7f4a_7c15;
    for _ in 0..3 {
        x = (x ^ (x >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    }
    (x >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Layers that settle by twice their share of the height.
fn layers(drained_share: f64, sealed_share: f64) -> Layers {
    let theory = theory::WallLayers::new(2.0 * drained_share, 2.0 * sealed_share);
    Layers { both_ends: false, drained_share, sealed_share, theory }
}

#[test]
fn consolidation() {
    let layers = layers(0.05, 0.05);
    let t: Vec<f64> = (1..=3000).map(|i| 1.55 * i as f64 / 3000.0).collect();
    let u: Vec<f64> = t
        .iter()
        .enumerate()
        .map(|(i, &t)| {
            layers.theory.degree(t) + 0.012 * (9.0 * t).sin() * (-t).exp() + 0.002 * noise(i)
        })
        .collect();
    let p: Vec<f64> = t.iter().map(|&t| 0.98 * layers.theory.excess_pressure(1.0, t)).collect();
    let picture = plot::consolidation(&Consolidation {
        time_factor: &t,
        degree: &u,
        base_pressure: &p,
        layers,
        caption: "1000 spheres, 10 → 11 kPa, drained at the top; *c*_{v} = 0.318 m²/s from the modulus and the permeability that the same run measured",
    });
    let words = ["Degree of consolidation U", "Time factor Tv = cv t / H2", "simulated"];
    save(&picture, "consolidation", &words);
    save(&picture, "consolidation", &["theory, layers at the walls counted", "theory, plain"]);
}

/// Where both ends drain, axes and legend say so, and the theory is the same one in T_v.
#[test]
fn consolidation_with_two_drained_ends() {
    let layers = Layers { both_ends: true, ..layers(0.1, 0.0) };
    let t: Vec<f64> = (1..=300).map(|i| i as f64 / 300.0).collect();
    let u: Vec<f64> = t.iter().map(|&t| layers.theory.degree(t)).collect();
    let p: Vec<f64> = t.iter().map(|&t| layers.theory.excess_pressure(1.0, t)).collect();
    let picture = plot::consolidation(&Consolidation {
        time_factor: &t,
        degree: &u,
        base_pressure: &p,
        layers,
        caption: "",
    });
    let words = [
        "Time factor Tv = 4 cv t / H2",
        "Pressure at mid-height",
        "theory, layers at the walls counted",
    ];
    save(&picture, "consolidation-both-ends", &words);
    let height: Vec<f64> = (0..20).map(|i| (i as f64 + 0.5) / 20.0).collect();
    let pressure: Vec<f64> = height
        .iter()
        .map(|h| theory::excess_pressure_both_ends((h - 0.05) / 0.9, 0.2 / 0.8))
        .collect();
    let profile = Profile { time_factor: 0.2, height: &height, pressure: &pressure };
    let picture = plot::profiles(&[profile], &layers, "");
    save(&picture, "profiles-both-ends", &["0.2"]);
}

#[test]
fn profiles() {
    let layers = layers(0.05, 0.05);
    let height: Vec<f64> = (0..20).map(|i| (i as f64 + 0.5) / 20.0).collect();
    let times = [0.02, 0.05, 0.1, 0.2, 0.4, 0.8];
    let pressure: Vec<Vec<f64>> = times
        .iter()
        .map(|&t| {
            height
                .iter()
                .enumerate()
                .map(|(i, h)| {
                    let z = (0.95 - h) / 0.9;
                    (layers.theory.excess_pressure(z, t) + 0.02 * noise(i)).max(0.0)
                })
                .collect()
        })
        .collect();
    let profiles: Vec<_> = times
        .iter()
        .zip(&pressure)
        .map(|(&time_factor, pressure)| Profile { time_factor, height: &height, pressure })
        .collect();
    let picture = plot::profiles(
        &profiles,
        &layers,
        "Dots: mean of the pores in 20 layers; lines: Terzaghi, layers at the walls counted",
    );
    save(
        &picture,
        "pressure-profiles",
        &["Time factor Tv", "0.02", "0.8", "Height / height of the layer"],
    );
}

/// A jittered cubic lattice of spheres over bricks for pores.
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
                centers
                    .push((Vec3::new(i as f64, j as f64, k as f64).add_scalar(0.5) + jitter) * h);
            }
        }
    }
    let radii: Vec<f64> = (0..centers.len()).map(|i| 0.5 * h * (0.85 + 0.13 * noise(i))).collect();
    let bounds = Aabb { min: Vec3::zeros(), max: Vec3::repeat(n as f64 * h) };
    let (points, cells, values) = brick_pores(2 * n, 0.5 * h);
    let picture = plot::section(&Section {
        title: "Pore pressure in the section *z* = 9 mm",
        caption: "at *T*_{v} = 0.1",
        bounds,
        axis: 2,
        position: 9.01e-3,
        centers: &centers,
        radii: &radii,
        points: &points,
        cells: &cells,
        values: &values,
        quantity: "Excess pore pressure",
        unit: "Pa",
    });
    save(&picture, "section", &["x (mm)", "y (mm)", "Excess pore pressure (Pa)"]);
}

fn brick_pores(n: usize, h: f64) -> (Vec<Vec3>, Cells, Vec<f64>) {
    let (mut points, mut cells, mut values) = (Vec::new(), Cells::default(), Vec::new());
    for i in 0..n {
        for j in 0..n {
            for k in 0..n {
                let first = points.len() as u32;
                for (a, b, c) in [
                    (0, 0, 0),
                    (1, 0, 0),
                    (1, 1, 0),
                    (0, 1, 0),
                    (0, 0, 1),
                    (1, 0, 1),
                    (1, 1, 1),
                    (0, 1, 1),
                ] {
                    points.push(Vec3::new((i + a) as f64, (j + b) as f64, (k + c) as f64) * h);
                }
                cells.push_hexahedron(std::array::from_fn(|v| first + v as u32));
                let z = 1.0 - (j as f64 + 0.5) / n as f64;
                values.push(
                    1000.0 * theory::excess_pressure(z, 0.1) * (1.0 + 0.05 * noise(values.len())),
                );
            }
        }
    }
    (points, cells, values)
}

#[test]
fn stress_strain() {
    let strain: Vec<f64> = (0..=400).map(|i| 0.03 * i as f64).collect();
    let curve = |peak: f64| -> Vec<f64> {
        strain
            .iter()
            .enumerate()
            .map(|(i, e)| {
                100.0 * (1.0 + peak * (1.0 - (-e).exp()) * (1.0 + 0.8 * (-0.3 * e).exp()))
                    + 2.0 * noise(i)
            })
            .collect()
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
    let picture = plot::xy(
        "Dry triaxial compression",
        "500 spheres, 100 kPa",
        Axis::linear("Axial strain (%)"),
        Axis::linear("Stress (kPa)"),
        &series,
    );
    save(&picture, "stress-strain", &["Axial strain (%)", "Stress (kPa)", "radial stress"]);
}

#[test]
fn log_axes() {
    let n: Vec<f64> = [1e3, 5e3, 2e4, 1.35e5, 1e6].to_vec();
    let t: Vec<f64> = n.iter().map(|n| 2e-9 * n * n.ln()).collect();
    let line = Series {
        name: Some("2 threads".into()),
        x: &n,
        y: &t,
        color: SERIES[0],
        mark: Mark::Line { width: 1.6, dash: None },
    };
    let dots = Series { mark: Mark::Dots { radius: 3.0, apart: 0.0 }, name: None, ..line.clone() };
    let picture = plot::xy(
        "Time per step",
        "",
        Axis::log("Spheres"),
        Axis::log("Time per step (s)"),
        &[line, dots],
    );
    save(&picture, "log-axes", &["103", "106", "10−2", "Time per step (s)"]);
    let small: Vec<f64> = t.iter().map(|t| 1e-9 * t - 1e-13).collect();
    let line = Series {
        name: Some("flux".into()),
        x: &t,
        y: &small,
        color: SERIES[1],
        mark: Mark::Line { width: 1.6, dash: Some([4.0, 2.0]) },
    };
    let picture = plot::xy(
        "Small and large numbers",
        "",
        Axis::linear("Time (s)"),
        Axis::linear("Flux (m³/s)"),
        &[line],
    );
    save(&picture, "powers", &["×10−12", "0.025"]);
}

/// Panels beside each other have axes of their own, and one legend has all their series.
#[test]
fn panels_in_a_row() {
    let t: Vec<f64> = (0..50).map(f64::from).collect();
    let (rise, fall): (Vec<f64>, Vec<f64>) =
        t.iter().map(|t| (1e3 * (0.1 * t).tanh(), (-0.1 * t).exp())).unzip();
    let line = Mark::Line { width: 1.4, dash: None };
    let series = |name: &str, y, i: usize| {
        [Series { name: Some(name.to_owned()), x: &t, y, color: SERIES[i], mark: line }]
    };
    let (left, right) = (series("rises", &rise, 0), series("falls", &fall, 1));
    let panel = |label, series| {
        let (x, y) = (Axis::linear("Time (s)"), Axis::linear(label));
        Panel { title: "", x, y, series }
    };
    let picture = plot::row("Two of them", "", &[panel("Up (Pa)", &left), panel("Down", &right)]);
    assert!(picture.width > plot::xy("", "", Axis::linear(""), Axis::linear(""), &[]).width);
    save(&picture, "row", &["Two of them", "rises", "falls", "Up (Pa)", "Down", "1000", "1.0"]);
}

#[test]
fn ticks_are_round_and_few() {
    let ticks = |scale, limits, count| Ticks::new(scale, limits, count).text;
    assert_eq!(
        ticks(Scale::Linear, [0.0, 1.5], 6),
        ["0.00", "0.25", "0.50", "0.75", "1.00", "1.25", "1.50"]
    );
    assert_eq!(ticks(Scale::Linear, [-3.0, 7.9], 5), ["−2.5", "0.0", "2.5", "5.0", "7.5"]);
    assert_eq!(ticks(Scale::Linear, [97.0, 313.0], 5), ["100", "150", "200", "250", "300"]);
    assert_eq!(ticks(Scale::Log, [0.002, 30.0], 8), ["0.01", "0.1", "1", "10"]);
    assert_eq!(
        ticks(Scale::Log, [1e-9, 1e3], 7),
        ["10^{−8}", "10^{−6}", "10^{−4}", "10^{−2}", "10^{0}", "10^{2}"]
    );
    assert_eq!(ticks(Scale::Log, [0.8, 6.0], 7), ["1", "2", "5"]);
    let small = Ticks::new(Scale::Linear, [0.0, 2.7e-11], 5);
    assert_eq!((small.text, small.exponent), (vec!["0".into(), "10".into(), "20".into()], -12));
    for limits in [[0.0, 1e-300], [-1e300, 1e300], [1e9, 1e9 + 1.0], [5.0, -5.0]] {
        let ticks = Ticks::new(Scale::Linear, limits, 6);
        assert!((2..=9).contains(&ticks.at.len()), "{limits:?}: {ticks:?}");
        assert_eq!(ticks.at.len(), ticks.text.len());
    }
}

#[test]
fn axes_show_all_data_and_begin_at_zero_where_data_do() {
    let limits = |axis: Axis, data: &[f64]| axis.limits(data.iter().copied());
    let [low, high] = limits(Axis::linear(""), &[0.1, 5.0, f64::NAN, f64::INFINITY]);
    assert_eq!(low, 0.0);
    assert!((5.01..5.5).contains(&high));
    let [low, high] = limits(Axis::log(""), &[-1.0, 0.0, 1e-3, 10.0]);
    assert!(low < 1e-3 && low > 1e-4 && high > 10.0 && high < 20.0);
    let [low, high] = limits(Axis::linear(""), &[3.0, 3.0]);
    assert!(low < 3.0 && high > 3.0, "one value still has an axis");
    let [low, high] = limits(Axis::linear(""), &[]);
    assert!(low < high);
    assert_eq!(limits(Axis::linear("").spanning(2.0, 1.0), &[7.0]), [2.0, 1.0]);
}

#[test]
fn sizes_get_the_prefix_that_reads_best() {
    let prefixed = |v: f64| format!("{:.0} {}", v / prefix(v).1, prefix(v).0);
    for (value, text) in
        [(0.022, "22 m"), (-1234.0, "-1 k"), (1e6, "1 M"), (2e-7, "200 n"), (0.0, "0 ")]
    {
        assert_eq!(prefixed(value), text);
    }
}

#[test]
fn the_fonts_have_every_sign_that_labels_use() {
    let unknown = Layout::new("?", Face::Regular, 10.0).outline;
    for face in [Face::Regular, Face::Italic, Face::SemiBold] {
        assert!(Layout::new("T", face, 10.0).width > 0.0, "{face:?} does not load");
    }
    for c in "AZaz09.,;:()[]%/+=<>’“”–—−×·°±µ²³√∞∂∆∑≈≠≤≥→←εσφκηρλΔΩΣäöüßéñç".chars()
    {
        for face in [Face::Regular, Face::Italic, Face::SemiBold] {
            let layout = Layout::new(&c.to_string(), face, 10.0);
            assert!(
                !layout.outline.0.is_empty() && layout.outline != unknown,
                "{face:?} lacks {c}"
            );
        }
    }
    assert_eq!(Layout::new("日", Face::Regular, 10.0).outline, unknown);
}

#[test]
fn markup_moves_and_slants_and_is_no_part_of_the_text() {
    let layout = |m: &str| Layout::new(m, Face::Regular, 10.0);
    assert_eq!(layout("*T*_{v} = 10^{−3} m/s").plain, "Tv = 10−3 m/s");
    assert!(layout("x_{2}").width < layout("x2").width, "a script is smaller");
    assert_ne!(layout("*T*").outline, layout("T").outline);
    assert!(layout("Te").width < layout("T").width + layout("e").width, "pairs are kerned");
    let lowest = |m: &str| {
        let points = layout(m).outline.0.into_iter().filter_map(|s| match s {
            Segment::Move(p) | Segment::Line(p) | Segment::Curve(_, _, p) => Some(p.1),
            Segment::Close => None,
        });
        points.fold(f64::NEG_INFINITY, f64::max)
    };
    assert!(lowest("H_{2}") > lowest("H2") + 1.0 && lowest("^{2}") < lowest("2") - 2.0);
}

#[test]
fn viridis_is_ordered_by_lightness() {
    // Relative luminance (Rec. 709), monotone so that it survives grey print.
    let luminance = |i: i32| {
        let color::Color(r, g, b) = color::viridis(f64::from(i) / 100.0);
        0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
    };
    assert!((0..100).all(|i| luminance(i + 1) > luminance(i)));
    assert_eq!(color::viridis(-1.0), color::viridis(0.0));
    assert_eq!(color::viridis(2.0), color::Color(253, 231, 37));
}

/// Area of the polygon in which the plane `axis` = `position` cuts a body.
fn cut_area(corners: &[Vec3], axis: usize, position: f64) -> f64 {
    let points = plane_points(corners, axis, position);
    let flat = points.iter().map(|p| (p[(axis + 1) % 3], p[(axis + 2) % 3])).collect();
    let around = hull(flat);
    let next = around.iter().cycle().skip(1);
    0.5 * around.iter().zip(next).map(|(a, b)| a.0 * b.1 - a.1 * b.0).sum::<f64>()
}

#[test]
fn a_section_cuts_bodies_where_they_are() {
    let cube: Vec<_> = (0..8)
        .map(|i| Vec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
        .collect();
    for axis in 0..3 {
        assert!((cut_area(&cube, axis, 0.3) - 1.0).abs() < 1e-15, "a cube's section is its face");
        assert_eq!(cut_area(&cube, axis, 1.2), 0.0);
    }
    // The unit tetrahedron at height 1/2: a triangle of half the size.
    let tetra = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
    assert!((cut_area(&tetra, 2, 0.5) - 0.125).abs() < 1e-15);
    // Between two opposite edges the section is a quadrangle: here a square.
    let wedge = [
        Vec3::new(-1.0, 0.0, 0.0),
        Vec3::new(1.0, 0.0, 0.0),
        Vec3::new(0.0, -1.0, 1.0),
        Vec3::new(0.0, 1.0, 1.0),
    ];
    assert!((cut_area(&wedge, 2, 0.5) - 1.0).abs() < 1e-15);
}

#[test]
fn tables_line_up() {
    let rows = |rows: &[&[&str]]| {
        rows.iter().map(|r| r.iter().map(|c| (*c).to_owned()).collect()).collect::<Vec<_>>()
    };
    let rows = rows(&[&["0.1", "0.43", "plain"], &["1.25", "0.9", "with σ"], &["10"]]);
    let expected = [
        " T_v     U  theory\n",
        "----  ----  ------\n",
        " 0.1  0.43  plain\n",
        "1.25   0.9  with σ\n",
        "  10\n",
    ];
    assert_eq!(table(&["T_v", "U", "theory"], &rows), expected.concat());
}
