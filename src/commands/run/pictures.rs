//! The pictures of a run.

use std::path::Path;

use dempfv::Result;
use dempfv::io::atomic;
use dempfv::scene::{StageKind, Until};
use dempfv::simulation::{
    Consolidation, ConsolidationSample, Outcome, Simulation, StageOutcome, StressPath,
    StressPathSample,
};
use dempfv::theory::degree_of_consolidation;
use dempfv_report::format::{si, three_digits};
use dempfv_report::plot::{self, Section};

/// Draws what a finished stage has to show.
pub fn of_stage(folder: &Path, simulation: &Simulation, stage: &StageOutcome) -> Result<()> {
    match &stage.outcome {
        Outcome::Consolidate(c) => consolidation(folder, simulation, stage, c),
        Outcome::Run(m) => {
            section(folder, simulation, &format!("at the end of {}", stage.name))?;
            motion(folder, simulation, stage, m)
        }
        Outcome::Flow(_) => section(folder, simulation, &format!("at the end of {}", stage.name)),
        Outcome::Compact(_) | Outcome::Cycle(_) | Outcome::Permeability(_) => Ok(()),
    }
}

fn consolidation(
    folder: &Path,
    simulation: &Simulation,
    stage: &StageOutcome,
    c: &Consolidation,
) -> Result<()> {
    write_table(folder, &name("consolidation", simulation, stage), c)?;
    let caption = caption(simulation, c);
    let series =
        |pick: fn(&ConsolidationSample) -> f64| c.samples.iter().map(pick).collect::<Vec<f64>>();
    let (time_factor, degree) = (series(|s| s.time_factor), series(|s| s.degree));
    let base_pressure = series(|s| s.base_pressure);
    plot::consolidation(&plot::Consolidation {
        time_factor: &time_factor,
        degree: &degree,
        base_pressure: &base_pressure,
        drained_share: c.drained_share,
        both_ends: c.drains_at_both_ends(),
        caption: &caption,
    })
    .save(folder, &name("consolidation", simulation, stage))?;
    if c.profiles.is_empty() {
        return Ok(());
    }
    let heights: Vec<Vec<f64>> =
        c.profiles.iter().map(|p| p.depth.iter().map(|d| 1.0 - d).collect()).collect();
    let profiles: Vec<plot::Profile> = c
        .profiles
        .iter()
        .zip(&heights)
        .map(|(p, height)| plot::Profile {
            time_factor: p.time_factor,
            height,
            pressure: &p.pressure,
        })
        .collect();
    plot::profiles(&profiles, (c.drained_share, c.drains_at_both_ends()), &caption)
        .save(folder, &name("profiles", simulation, stage))
}

/// The course of a consolidation and the theory beside it, as a table.
fn write_table(folder: &Path, name: &str, c: &Consolidation) -> Result<()> {
    let mut text =
        "time_factor,settlement_m,degree,terzaghi_top_drained,terzaghi,base_pressure\n".to_owned();
    for s in &c.samples {
        let (drained, plain) = (c.theory(s.time_factor), degree_of_consolidation(s.time_factor));
        let row = [s.time_factor, s.settlement_m, s.degree, drained, plain, s.base_pressure];
        text.push_str(&row.map(|v| v.to_string()).join(","));
        text.push('\n');
    }
    Ok(atomic::write(&folder.join(format!("{name}.csv")), text.as_bytes())?)
}

/// Stress by strain where the strain ends the stage, else stress and pore
/// pressure by time.
fn motion(
    folder: &Path,
    simulation: &Simulation,
    stage: &StageOutcome,
    m: &StressPath,
) -> Result<()> {
    let until = simulation.plan().stages.iter().find(|s| s.name == stage.name).map(|s| &s.kind);
    let wet = simulation.coupled().storage_flow().is_some();
    let axis = match until {
        Some(StageKind::Run(run)) => match run.until {
            Until::Strain { axis, .. } => Some(axis),
            Until::Steps(_) | Until::Time(_) => None,
        },
        _ => None,
    };
    let shear = largest_shear(m).filter(|_| axis.is_none());
    let largest = m.samples.iter().flat_map(|s| s.stress_pa).fold(0.0, |a: f64, b| a.max(b.abs()));
    let (prefix, unit) = plot::axis::prefix(largest);
    let x: Vec<f64> = match (axis, shear) {
        (Some(axis), _) => m.samples.iter().map(|s| 100.0 * s.strain[axis.index()]).collect(),
        (None, Some([a, b])) => {
            let strain = |s: &StressPathSample| s.cell.map_or(f64::NAN, |c| c.strain[a][b]);
            m.samples.iter().map(|s| 100.0 * strain(s)).collect()
        }
        (None, None) => m.samples.iter().map(|s| s.time_s).collect(),
    };
    let names = ["x", "y", "z"];
    let x_label = match (axis, shear) {
        (Some(axis), _) => format!("Strain along *{}* (%)", axis.name()),
        (None, Some([a, b])) => format!("Shear strain *γ*_{{{}{}}} (%)", names[a], names[b]),
        (None, None) => "Time (s)".to_owned(),
    };
    let mut curves: Vec<(String, Vec<f64>)> = (0..3)
        .map(|k| {
            (
                format!("*σ*_{{{}}}", ["x", "y", "z"][k]),
                m.samples.iter().map(|s| s.stress_pa[k] / unit).collect(),
            )
        })
        .collect();
    if let Some([a, b]) = shear {
        let stress = |s: &StressPathSample| s.cell.map_or(f64::NAN, |c| -c.stress_pa[a][b] / unit);
        let name = format!("−*σ*_{{{}{}}}", names[a], names[b]);
        curves.push((name, m.samples.iter().map(stress).collect()));
    }
    if wet {
        curves.push((
            "mean pore pressure".to_owned(),
            m.samples.iter().map(|s| s.mean_pressure_pa / unit).collect(),
        ));
    }
    let series: Vec<plot::Series> = curves
        .iter()
        .zip(plot::SERIES)
        .map(|((name, y), color)| plot::Series {
            name: Some(name.clone()),
            x: &x,
            y,
            color,
            mark: plot::Mark::Line { width: 1.6, dash: None },
        })
        .collect();
    let of = if m.cell.is_some() { "in the cell" } else { "on the walls" };
    let y_label = format!("Stress {of} ({prefix}Pa)");
    let caption = if wet {
        "Compression positive; contacts and fluid together."
    } else {
        "Compression positive."
    };
    let title = format!("{}: {}", simulation.plan().title, stage.name);
    plot::xy(&title, caption, plot::Axis::linear(&x_label), plot::Axis::linear(&y_label), &series)
        .save(folder, &format!("stress-{}", in_file_name(simulation, stage)))
}

/// The shear strain of a periodic cell that is larger than every other of its strains.
fn largest_shear(m: &StressPath) -> Option<[usize; 2]> {
    let strain = m.cell.as_ref()?.strain;
    let all = (0..9).map(|k| [k / 3, k % 3]);
    let [a, b] =
        all.max_by(|[a, b], [c, d]| strain[*a][*b].abs().total_cmp(&strain[*c][*d].abs()))?;
    (a != b && strain[a][b] != 0.0).then_some([a, b])
}

/// A cut through the middle of the packing, coloured by pore pressure.
pub fn section(folder: &Path, simulation: &Simulation, moment: &str) -> Result<()> {
    let coupled = simulation.coupled();
    // A cut through a periodic cell would show each pore at its faces on one side only.
    let between_walls = coupled.dem().cell().is_none();
    let Some(flow) = coupled.storage_flow().filter(|_| between_walls) else { return Ok(()) };
    let particles = coupled.dem().storage();
    let bounds = coupled.dem().box_();
    let (points, cells) =
        dempfv::io::vtk::pore_cells(flow.network(), &particles.position, &bounds)?;
    plot::section(&Section {
        title: "Pore pressure in a section",
        caption: &format!("{}\n{moment}", simulation.plan().title),
        bounds,
        axis: 2,
        position: bounds.center().z,
        centers: &particles.position,
        radii: &particles.radius,
        points: &points,
        cells: &cells,
        values: flow.pressure(),
        quantity: "Pore pressure",
        unit: "Pa",
    })
    .save(folder, "section")
}

/// A picture's name: with the stage's, where several stages have one.
fn name(picture: &str, simulation: &Simulation, stage: &StageOutcome) -> String {
    let stages = &simulation.plan().stages;
    let alike = stages.iter().filter(|s| matches!(s.kind, StageKind::Consolidate(_))).count();
    match alike {
        0 | 1 => picture.to_owned(),
        _ => format!("{picture}-{}", in_file_name(simulation, stage)),
    }
}

/// A stage's name as part of a file's. Characters that mean something to some
/// file system become dashes, and the stage's number then tells it from others.
fn in_file_name(simulation: &Simulation, stage: &StageOutcome) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' };
    let name: String = stage.name.chars().map(plain).collect();
    if name == stage.name {
        return name;
    }
    let number = simulation.plan().stages.iter().position(|s| s.name == stage.name);
    format!("{}-{}", number.map_or(0, |k| k + 1), name.trim_matches('-'))
}

fn caption(simulation: &Simulation, c: &Consolidation) -> String {
    format!(
        "{} spheres, H = {}, Δσ = {}.\nMeasured beforehand: *E*_{{oed}} = {}, *k* = {:.3e} m²; so *c*_{{v}} = {} m²/s.",
        simulation.coupled().dem().storage().len(),
        si(c.height_m, "m"),
        si(c.load_pa, "Pa"),
        si(c.modulus_pa, "Pa"),
        c.permeability_m2,
        three_digits(c.c_v_m2_s),
    )
}
