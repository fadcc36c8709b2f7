//! `dempfv permeability`: the permeability of a packing along each axis.

use std::fmt;
use std::path::PathBuf;

use dempfv::pfv::{Boundary, Flow};
use dempfv::scene::load_packing;
use dempfv::theory::{KOZENY_CARMAN, kozeny_carman, sauter_diameter};
use dempfv::{Error, InputError, WallId};
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
    /// Whether the fluid slips along the walls beside the flow.
    slip_walls: bool,
    /// Overlaps counted twice; `None` where these are so large that it means nothing.
    porosity: Option<f64>,
    sauter_diameter_m: f64,
    kozeny_carman_m2: Option<f64>,
    /// The constant in it.
    kozeny_carman_constant: f64,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct Axis {
    axis: &'static str,
    permeability_m2: f64,
    /// Farther than a Sauter diameter from every wall; `None` where nothing is.
    core_permeability_m2: Option<f64>,
    flux_m3_s: f64,
    imbalance: f64,
}

/// Solves one static flow per axis: 1 Pa on the lower wall, 0 on the upper, no
/// flow through the others.
///
/// # Errors
/// What is wrong in the packing or the options, or why there is no network or
/// no solution.
pub fn run(args: &Args) -> Result<Report, Error> {
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
            core_permeability_m2: flow.core_permeability(wall, sauter_diameter(&packing.radius)),
            flux_m3_s: k.flux,
            imbalance: k.imbalance,
        });
    }
    let solid: f64 =
        packing.radius.iter().map(|r| 4.0 / 3.0 * std::f64::consts::PI * r.powi(3)).sum();
    let (porosity, sauter_diameter_m) =
        (1.0 - solid / bounds.volume(), sauter_diameter(&packing.radius));
    let porosity = Some(porosity).filter(|&n| n > 0.0);
    if porosity.is_none() {
        warnings.push(
            "the spheres have more volume than the box: overlaps are so large that there is no porosity to tell"
                .to_owned(),
        );
    }
    Ok(Report {
        axes,
        slip_walls: args.fluid.slip,
        porosity,
        sauter_diameter_m,
        kozeny_carman_m2: porosity.map(|n| kozeny_carman(n, sauter_diameter_m)),
        kozeny_carman_constant: KOZENY_CARMAN,
        warnings,
    })
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for a in &self.axes {
            let core = a.core_permeability_m2;
            let core = core.map_or(String::new(), |k| format!(", {k:.6e} m² away from walls"));
            writeln!(f, "  k along {}       {:.6e} m²{core}", a.axis, a.permeability_m2)?;
        }
        let slip = if self.slip_walls { "slips along walls" } else { "sticks to walls" };
        writeln!(f, "                  (the fluid {slip} beside the flow)")?;
        if let (Some(k), Some(n)) = (self.kozeny_carman_m2, self.porosity) {
            writeln!(f, "  Kozeny-Carman   {k:.6e} m²")?;
            let (n, d) = (three_digits(n), si(self.sauter_diameter_m, "m"));
            writeln!(
                f,
                "                  (constant {}, porosity {n}, Sauter mean diameter {d})",
                self.kozeny_carman_constant
            )?;
        }
        self.warnings.iter().try_for_each(|w| writeln!(f, "  warning         {w}"))
    }
}
