//! `dempfv permeability`: the permeability of a packing along each axis.

use std::fmt;
use std::path::PathBuf;

use dempfv::io::packing::Packing;
use dempfv::pfv::{Boundary, Flow};
use dempfv::scene::{load_packing, load_periodic_packing};
use dempfv::theory::{kozeny_carman, sauter_diameter};
use dempfv::{Cell, Error, InputError, WallId};
use dempfv_report::format::{si, three_digits};
use serde::Serialize;

use super::network::FluidArgs;

/// What `permeability` takes.
#[derive(clap::Args)]
pub struct Args {
    /// Packing file
    pub packing: PathBuf,
    #[command(flatten)]
    fluid: FluidArgs,
}

/// Permeability by axis.
#[derive(Serialize)]
pub struct Report {
    axes: Vec<Axis>,
    /// Of a periodic cell the whole tensor, by rows.
    #[serde(skip_serializing_if = "Option::is_none")]
    tensor_m2: Option<[[f64; 3]; 3]>,
    /// Overlaps counted twice; `None` where these are so large that it means nothing.
    porosity: Option<f64>,
    sauter_diameter_m: f64,
    kozeny_carman_m2: Option<f64>,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct Axis {
    axis: &'static str,
    permeability_m2: f64,
    flux_m3_s: f64,
    imbalance: f64,
}

/// Solves one static flow per axis: 1 Pa on the lower wall, 0 on the upper, no
/// flow through the others; through a periodic cell where the packing states one.
///
/// # Errors
/// What is wrong in the packing or the options, or why there is no network or
/// no solution.
pub fn run(args: &Args) -> Result<Report, Error> {
    if let Some((packing, cell)) = load_periodic_packing(&args.packing)? {
        return in_cell(args, &packing, &cell);
    }
    let (packing, bounds) = load_packing(&args.packing, None)?;
    let (mut axes, mut warnings) = (vec![], vec![]);
    for (axis, wall) in [("x", WallId::XMin), ("y", WallId::YMin), ("z", WallId::ZMin)] {
        let mut boundary = Boundary::default();
        boundary.pressure[wall] = Some(1.0);
        boundary.pressure[wall.opposite()] = Some(0.0);
        let (fluid, solver) = args.fluid.fluid(boundary)?;
        let mut flow = Flow::new(&packing.position, &packing.radius, bounds, &fluid, solver)?;
        flow.solve_static()?;
        for remark in flow.remarks().warnings() {
            if !warnings.contains(&remark) {
                warnings.push(remark);
            }
        }
        let measured = flow.permeability(wall);
        let k = measured
            .ok_or_else(|| InputError::new("no flow to measure", "give a packing with pores"))?;
        axes.push(Axis {
            axis,
            permeability_m2: k.value,
            flux_m3_s: k.flux,
            imbalance: k.imbalance,
        });
    }
    Ok(Report::of(axes, None, &packing, bounds.volume(), warnings))
}

/// One flow per axis through a periodic cell, by a mean gradient of 1 Pa/m.
fn in_cell(args: &Args, packing: &Packing, cell: &Cell) -> Result<Report, Error> {
    let (fluid, solver) = args.fluid.fluid(Boundary::default())?;
    let mut flow = Flow::in_cell(&packing.position, &packing.radius, cell, &fluid, solver)?;
    let warnings = flow.remarks().warnings();
    let tensor = flow.permeability_tensor()?.unwrap_or_default();
    let axes = ["x", "y", "z"].into_iter().enumerate();
    let axes = axes.map(|(k, axis)| Axis {
        axis,
        permeability_m2: tensor[(k, k)],
        // Of a cube of the cell's volume, for 1 Pa across it.
        flux_m3_s: tensor[(k, k)] * cell.volume().cbrt() / fluid.viscosity,
        imbalance: flow.imbalance(),
    });
    let rows = [0, 1, 2].map(|a| [0, 1, 2].map(|b| tensor[(a, b)]));
    Ok(Report::of(axes.collect(), Some(rows), packing, cell.volume(), warnings))
}

impl Report {
    /// Of a packing in so much volume (m³).
    fn of(
        axes: Vec<Axis>,
        tensor_m2: Option<[[f64; 3]; 3]>,
        packing: &Packing,
        volume: f64,
        mut warnings: Vec<String>,
    ) -> Report {
        let solid: f64 =
            packing.radius.iter().map(|r| 4.0 / 3.0 * std::f64::consts::PI * r.powi(3)).sum();
        let sauter_diameter_m = sauter_diameter(&packing.radius);
        let porosity = Some(1.0 - solid / volume).filter(|&n| n > 0.0);
        if porosity.is_none() {
            warnings.push(
                "the spheres have more volume than the box: overlaps are so large that there is no porosity to \
                 tell"
                    .to_owned(),
            );
        }
        Report {
            axes,
            tensor_m2,
            porosity,
            sauter_diameter_m,
            kozeny_carman_m2: porosity.map(|n| kozeny_carman(n, sauter_diameter_m)),
            warnings,
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for a in &self.axes {
            writeln!(f, "  k along {}       {:.6e} m²", a.axis, a.permeability_m2)?;
        }
        for (name, row) in ["x", "y", "z"].iter().zip(self.tensor_m2.iter().flatten()) {
            let [x, y, z] = row;
            writeln!(f, "  K, row {name}        {x:.6e}  {y:.6e}  {z:.6e} m²")?;
        }
        if let (Some(k), Some(n)) = (self.kozeny_carman_m2, self.porosity) {
            writeln!(f, "  Kozeny-Carman   {k:.6e} m²")?;
            let (n, d) = (three_digits(n), si(self.sauter_diameter_m, "m"));
            writeln!(f, "                  (porosity {n}, Sauter mean diameter {d})")?;
        }
        self.warnings.iter().try_for_each(|w| writeln!(f, "  warning         {w}"))
    }
}
