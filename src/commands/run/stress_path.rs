//! The pictures of a run stage: stresses, and q, volume and pore pressure where it shears.

use std::path::Path;

use dempfv::scene::{StageKind, Until};
use dempfv::simulation::{Simulation, StageOutcome, StressPath, StressPathSample};
use dempfv::{Axis, Result, Tensor, Vec3, deviatoric_stress};
use dempfv_report::plot::{self, Mark, Panel, SERIES, Series};

const NAMES: [&str; 3] = ["x", "y", "z"];

/// What the course of a stage is drawn over.
enum Course {
    /// The strain along the axis that ends the stage.
    Strain(Axis),
    /// The largest strain of a periodic cell, a shear.
    Shear([usize; 2]),
    Time,
}

impl Course {
    fn of(simulation: &Simulation, stage: &StageOutcome, path: &StressPath) -> Course {
        let planned = simulation.plan().stages.iter().find(|s| s.name == stage.name);
        match planned.map(|s| &s.kind) {
            Some(StageKind::Run(run)) if let Until::Strain { axis, .. } = run.until => {
                Course::Strain(axis)
            }
            _ => largest_shear(path).map_or(Course::Time, Course::Shear),
        }
    }

    fn label(&self) -> String {
        match self {
            Course::Strain(axis) => format!("Strain along *{}* (%)", axis.name()),
            Course::Shear([a, b]) => {
                format!("Shear strain *γ*_{{{}{}}} (%)", NAMES[*a], NAMES[*b])
            }
            Course::Time => "Time (s)".to_owned(),
        }
    }

    fn values(&self, path: &StressPath) -> Vec<f64> {
        let value = |s: &StressPathSample| match self {
            Course::Strain(axis) => 100.0 * s.strain[axis.index()],
            Course::Shear([a, b]) => s.cell.map_or(f64::NAN, |c| 100.0 * c.strain[*a][*b]),
            Course::Time => s.time_s,
        };
        path.samples.iter().map(value).collect()
    }
}

/// The shear strain of a periodic cell that is larger than every other of its strains.
fn largest_shear(path: &StressPath) -> Option<[usize; 2]> {
    let strain = path.cell.as_ref()?.strain;
    let all = (0..9).map(|k| [k / 3, k % 3]);
    let [a, b] =
        all.max_by(|[a, b], [c, d]| strain[*a][*b].abs().total_cmp(&strain[*c][*d].abs()))?;
    (a != b && strain[a][b] != 0.0).then_some([a, b])
}

/// Draws both pictures; `name` is the stage's in names of files.
///
/// # Errors
/// When a file cannot be written.
pub fn draw(
    folder: &Path,
    simulation: &Simulation,
    stage: &StageOutcome,
    path: &StressPath,
    name: &str,
) -> Result<()> {
    let course = Course::of(simulation, stage, path);
    let wet = simulation.coupled().storage_flow().is_some();
    let title = format!("{}: {}", simulation.plan().title, stage.name);
    stresses(folder, &title, path, &course, (wet, name))?;
    match course {
        Course::Time => Ok(()),
        Course::Strain(_) | Course::Shear(_) => {
            invariants(folder, &title, path, &course, (wet, name))
        }
    }
}

/// Stresses along the axes, and the pore pressure.
fn stresses(
    folder: &Path,
    title: &str,
    path: &StressPath,
    course: &Course,
    (wet, name): (bool, &str),
) -> Result<()> {
    let samples = &path.samples;
    let largest = samples.iter().flat_map(|s| s.stress_pa).fold(0.0, |a: f64, b| a.max(b.abs()));
    let (prefix, unit) = plot::axis::prefix(largest);
    let mut curves: Vec<(String, Vec<f64>)> = (0..3)
        .map(|k| {
            let stress = samples.iter().map(|s| s.stress_pa[k] / unit).collect();
            (format!("*σ*_{{{}}}", NAMES[k]), stress)
        })
        .collect();
    if let Course::Shear([a, b]) = *course {
        let stress = |s: &StressPathSample| s.cell.map_or(f64::NAN, |c| -c.stress_pa[a][b] / unit);
        let name = format!("−*σ*_{{{}{}}}", NAMES[a], NAMES[b]);
        curves.push((name, samples.iter().map(stress).collect()));
    }
    if wet {
        let pressure = samples.iter().map(|s| s.mean_pressure_pa / unit).collect();
        curves.push(("mean pore pressure".to_owned(), pressure));
    }
    let x = course.values(path);
    let series: Vec<Series> = curves
        .iter()
        .zip(SERIES)
        .map(|((name, y), color)| Series {
            name: Some(name.clone()),
            x: &x,
            y,
            color,
            mark: Mark::Line { width: 1.6, dash: None },
        })
        .collect();
    let of = if path.cell.is_some() { "in the cell" } else { "on the walls" };
    let (x_label, y_label) = (course.label(), format!("Stress {of} ({prefix}Pa)"));
    let caption = match wet {
        true => "Compression positive; contacts and fluid together.",
        false => "Compression positive.",
    };
    let (x_axis, y_axis) = (plot::Axis::linear(&x_label), plot::Axis::linear(&y_label));
    plot::xy(title, caption, x_axis, y_axis, &series).save(folder, &format!("stress-{name}"))
}

/// Deviatoric stress, volume and, where there is a fluid, pore pressure.
fn invariants(
    folder: &Path,
    title: &str,
    path: &StressPath,
    course: &Course,
    (wet, name): (bool, &str),
) -> Result<()> {
    let samples = &path.samples;
    let x = course.values(path);
    let q: Vec<f64> = samples.iter().map(deviator).collect();
    let volume: Vec<f64> = samples.iter().map(|s| 100.0 * s.strain.iter().sum::<f64>()).collect();
    let pressure: Vec<f64> = samples.iter().map(|s| s.mean_pressure_pa).collect();
    let mut quantities = vec![
        ("Deviatoric stress *q*", Some("Pa"), q),
        ("Volumetric strain *ε*_{v} (%)", None, volume),
    ];
    if wet {
        quantities.push(("Mean excess pore pressure *u*", Some("Pa"), pressure));
    }
    let labelled: Vec<(String, Vec<f64>)> = quantities
        .into_iter()
        .map(|(label, unit, values)| {
            let Some(unit) = unit else { return (label.to_owned(), values) };
            let largest = values.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
            let (prefix, size) = plot::axis::prefix(largest);
            (format!("{label} ({prefix}{unit})"), values.iter().map(|v| v / size).collect())
        })
        .collect();
    let x_label = course.label();
    let series: Vec<[Series; 1]> = labelled
        .iter()
        .zip(SERIES)
        .map(|((_, y), color)| {
            [Series { name: None, x: &x, y, color, mark: Mark::Line { width: 1.6, dash: None } }]
        })
        .collect();
    let panels: Vec<Panel> = labelled
        .iter()
        .zip(&series)
        .map(|((label, _), series)| Panel {
            title: "",
            x: plot::Axis::linear(&x_label),
            y: plot::Axis::linear(label),
            series,
        })
        .collect();
    let caption =
        "Since the stage's start; the volumetric strain is positive where the volume shrinks.";
    plot::row(title, caption, &panels).save(folder, &format!("shear-{name}"))
}

/// q of the stress in the cell, or of the walls' normal stresses, which smooth walls make the
/// principal ones.
fn deviator(sample: &StressPathSample) -> f64 {
    deviatoric_stress(&match sample.cell {
        Some(cell) => Tensor::from_fn(|a, b| cell.stress_pa[a][b]),
        None => Tensor::from_diagonal(&Vec3::from(sample.stress_pa)),
    })
}
