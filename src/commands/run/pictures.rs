//! The pictures of a run.

use std::path::Path;

use dempfv::io::atomic;
use dempfv::scene::{SectionPlane, StageKind};
use dempfv::simulation::{Consolidation, ConsolidationSample, Outcome, Simulation, StageOutcome};
use dempfv::theory::degree_of_consolidation;
use dempfv::{Axis, Result};
use dempfv_report::format::{si, three_digits};
use dempfv_report::outputs::tables::CONSOLIDATION;
use dempfv_report::plot::{self, Section};

use super::stress_path;

/// Draws what a finished stage has to show.
pub fn of_stage(folder: &Path, simulation: &Simulation, stage: &StageOutcome) -> Result<()> {
    match &stage.outcome {
        Outcome::Consolidate(c) => consolidation(folder, simulation, stage, c),
        Outcome::Run(m) => {
            section(folder, simulation, &format!("at the end of {}", stage.name))?;
            stress_path::draw(folder, simulation, stage, m, &in_file_name(simulation, stage))
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
        layers: layers(c),
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
    plot::profiles(&profiles, &layers(c), &caption)
        .save(folder, &name("profiles", simulation, stage))
}

fn layers(c: &Consolidation) -> plot::Layers {
    plot::Layers {
        both_ends: c.drains_at_both_ends(),
        drained_share: c.drained_share,
        sealed_share: c.sealed_share,
        theory: c.wall_layers(),
    }
}

/// The course of a consolidation and the theory beside it, as a table.
fn write_table(folder: &Path, name: &str, c: &Consolidation) -> Result<()> {
    let mut text = CONSOLIDATION.map(|column| column.name).join(",") + "\n";
    let theory = c.wall_layers();
    for s in &c.samples {
        let (layers, plain) =
            (theory.degree(s.time_factor), degree_of_consolidation(s.time_factor));
        let row = [s.time_factor, s.settlement_m, s.degree, layers, plain, s.base_pressure];
        text.push_str(&row.map(|v| v.to_string()).join(","));
        text.push('\n');
    }
    Ok(atomic::write(&folder.join(format!("{name}.csv")), text.as_bytes())?)
}

/// A cut through the packing, coloured by pore pressure.
pub fn section(folder: &Path, simulation: &Simulation, moment: &str) -> Result<()> {
    let coupled = simulation.coupled();
    // A cut through a periodic cell would show each pore at its faces on one side only.
    let between_walls = coupled.dem().cell().is_none();
    let Some(flow) = coupled.storage_flow().filter(|_| between_walls) else { return Ok(()) };
    let particles = coupled.dem().storage();
    let bounds = coupled.dem().box_();
    let (points, cells) =
        dempfv::io::vtk::pore_cells(flow.network(), &particles.position, &bounds)?;
    let SectionPlane { axis, position } = simulation
        .plan()
        .output
        .section
        .unwrap_or(SectionPlane { axis: Axis::Z, position: bounds.center().z });
    plot::section(&Section {
        title: "Pore pressure in a section",
        caption: &format!("{}\n{moment}", simulation.plan().title),
        bounds,
        axis: axis.index(),
        position,
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
