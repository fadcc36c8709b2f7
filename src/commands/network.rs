//! `dempfv network`: the pore network of a packing and one static flow.

use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, Write};
use std::path::PathBuf;

use dempfv::io::matrix_market;
use dempfv::pfv::{Boundary, Clamp, Flow, Fluid, NONE, NetworkRemarks, SealedPores, UnknownClamp};
use dempfv::scene::load_packing;
use dempfv::solver::SolverKind;
use dempfv::{Aabb, Error, InputError, Vec3, WallId};
use dempfv_report::format::{bytes, count, three_digits};
use dempfv_report::json;
use dempfv_report::output::{self, OutputArgs};
use serde::Serialize;

use super::Context;

/// File in the output folder that holds the network.
const FILE: &str = "network.json";

/// What a pore and a sphere take in it (bytes), within some percent.
const PORE: f64 = 405.0;
const SPHERE: f64 = 100.0;
/// Files from this size on are announced (bytes).
const LARGE: f64 = 1e7;

/// What `network` takes.
#[derive(clap::Args)]
pub struct Args {
    /// Packing file
    pub packing: PathBuf,
    #[command(flatten)]
    fluid: FluidArgs,
    /// Pressure on a wall in Pa, for example y_min=1; walls not named let nothing
    /// through [default: y_min=1 y_max=0]
    #[arg(long, value_name = "WALL=VALUE", num_args = 1..)]
    pressure: Vec<String>,
    /// Also write the matrix of the unknown pressures (Matrix Market), for `dempfv solve` and
    /// other solvers
    #[arg(long, value_name = "FILE")]
    matrix: Option<PathBuf>,
    /// Also write the network into this folder, as network.json
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace results that are already there
    #[arg(long)]
    force: bool,
}

/// The fluid, as options.
#[derive(clap::Args)]
pub struct FluidArgs {
    /// Dynamic viscosity (Pa·s)
    #[arg(long, value_name = "MU", default_value_t = 1e-3, allow_negative_numbers = true)]
    pub viscosity: f64,
    /// Does the fluid slip along walls without imposed pressure?
    #[arg(long, value_name = "true|false", default_value_t = true, action = clap::ArgAction::Set)]
    pub slip: bool,
    /// Bounds on the conductances: none, relative, unlimited or yade
    #[arg(long, default_value = "none")]
    pub clamp: String,
    /// Linear solver
    #[arg(long, default_value = "auto")]
    pub solver: String,
}

impl FluidArgs {
    /// The fluid between walls with these pressures, and the solver.
    ///
    /// # Errors
    /// [`InputError`] for a viscosity that is not positive and unknown names.
    pub fn fluid(&self, boundary: Boundary) -> Result<(Fluid, SolverKind), InputError> {
        if !(self.viscosity > 0.0 && self.viscosity.is_finite()) {
            let what = format!("--viscosity {} is not positive", self.viscosity);
            return Err(InputError::new(
                what,
                "give the dynamic viscosity in Pa·s; water has 1e-3",
            ));
        }
        let clamp: Clamp =
            self.clamp.parse().map_err(|e: UnknownClamp| InputError::new(e.to_string(), ""))?;
        let solver = self.solver.parse().map_err(|e| InputError::new(format!("{e}"), ""))?;
        Ok((Fluid { viscosity: self.viscosity, slip_walls: self.slip, clamp, boundary }, solver))
    }
}

/// A vertex of a cell: a sphere's number or a wall's name.
#[derive(Serialize)]
#[serde(untagged)]
enum Vertex {
    Sphere(u32),
    Wall(WallId),
}

/// The network and its flow.
#[derive(Serialize)]
pub struct Report {
    spheres: usize,
    bounds: Aabb,
    cells: Vec<[Vertex; 4]>,
    neighbors: Vec<[Option<u32>; 4]>,
    center: Vec<Vec3>,
    volume: Vec<f64>,
    pressure: Vec<f64>,
    imposed: Vec<bool>,
    conductance: Vec<[f64; 4]>,
    force: Vec<Vec3>,
    wall_force: BTreeMap<&'static str, Vec3>,
    flux: BTreeMap<&'static str, f64>,
    permeability_m2: Option<f64>,
    /// Overlaps counted twice; `None` where they leave nothing.
    porosity: Option<f64>,
    hidden: Vec<u32>,
    unknowns: usize,
    /// Pores and throats that are out of the ordinary.
    remarks: NetworkRemarks,
    sealed: SealedPores,
    warnings: Vec<String>,
    residual: Option<f64>,
    #[serde(skip)]
    written: Option<PathBuf>,
}

/// Triangulates a packing and solves one static flow.
///
/// # Errors
/// What is wrong in the packing or the options, or why there is no network or
/// no solution.
pub fn run(args: &Args, context: &Context) -> Result<Report, Error> {
    let (packing, bounds) = load_packing(&args.packing, None)?;
    let (fluid, solver) = args.fluid.fluid(boundary(&args.pressure)?)?;
    let folder = folder(args)?;
    if let Some(file) = args.matrix.as_ref().filter(|f| !args.force && f.exists()) {
        let what = format!("--matrix {} is there already", file.display());
        return Err(InputError::new(what, "give --force to replace it, or another name").into());
    }
    let mut flow = Flow::new(&packing.position, &packing.radius, bounds, &fluid, solver)?;
    if folder.is_some() || context.has_json() {
        announce(flow.network().pores(), packing.len());
    }
    flow.solve_static()?;
    let mut report = report(&flow, &packing.radius, &fluid);
    if let Some(file) = &args.matrix {
        matrix_market::write_matrix(file, &flow.operators().matrix)?;
    }
    if let Some(folder) = folder {
        output::make_folder(&folder)?;
        json::write(&folder.join(FILE), &report)?;
        report.written = Some(folder.join(FILE));
    }
    Ok(report)
}

/// The folder that the network goes to, where one is given.
fn folder(args: &Args) -> Result<Option<PathBuf>, InputError> {
    if args.out.is_none() {
        return Ok(None);
    }
    let output = OutputArgs { out: args.out.clone(), force: args.force };
    output.folder(&args.packing, FILE).map(Some)
}

/// Says on stderr how large the JSON will be, where that is large.
fn announce(pores: usize, spheres: usize) {
    let size = PORE * pores as f64 + SPHERE * spheres as f64;
    if size > LARGE {
        // A closed stderr must not end the work.
        let _ = writeln!(io::stderr(), "the JSON will have about {}", bytes(size));
    }
}

fn boundary(pressures: &[String]) -> Result<Boundary, InputError> {
    let mut boundary = Boundary::default();
    if pressures.is_empty() {
        boundary.pressure[WallId::YMin] = Some(1.0);
        boundary.pressure[WallId::YMax] = Some(0.0);
    }
    for text in pressures {
        let wrong = |why: String| {
            InputError::new(
                format!("--pressure {text}: {why}"),
                "write for example --pressure y_min=1",
            )
        };
        let (wall, value) = text.split_once('=').ok_or_else(|| wrong("no `=`".into()))?;
        let wall: WallId =
            wall.trim().parse().map_err(|e: dempfv::UnknownWall| wrong(e.to_string()))?;
        let value: f64 =
            value.trim().parse().map_err(|_| wrong(format!("`{value}` is no number")))?;
        if !value.is_finite() {
            return Err(wrong(format!("`{value}` is not finite")));
        }
        if boundary.pressure[wall].replace(value).is_some() {
            return Err(wrong(format!("{wall} has two pressures")));
        }
    }
    Ok(boundary)
}

fn report(flow: &Flow, radius: &[f64], fluid: &Fluid) -> Report {
    let network = flow.network();
    let t = &network.tessellation;
    let pores = network.pores();
    let by_name = |w: WallId| w.name();
    let upstream = WallId::ALL.into_iter().find(|w| fluid.boundary.pressure[*w].is_some());
    let solid: f64 = radius.iter().map(|r| 4.0 / 3.0 * std::f64::consts::PI * r.powi(3)).sum();
    Report {
        spheres: radius.len(),
        bounds: network.bounds,
        cells: t
            .cells
            .iter()
            .map(|c| c.map(|v| t.wall(v).map_or(Vertex::Sphere(v), Vertex::Wall)))
            .collect(),
        neighbors: t.neighbors.iter().map(|n| n.map(|j| (j != NONE).then_some(j))).collect(),
        center: network.center.clone(),
        volume: network.volume.clone(),
        pressure: flow.pressure().to_vec(),
        imposed: (0..pores).map(|i| flow.operators().imposed(i).is_some()).collect(),
        conductance: (0..pores).map(|i| network.conductances_of(i)).collect(),
        force: flow.force().to_vec(),
        wall_force: WallId::ALL
            .into_iter()
            .map(|w| (by_name(w), flow.wall_force()[w.index()]))
            .collect(),
        flux: WallId::ALL.into_iter().map(|w| (by_name(w), flow.flux()[w.index()])).collect(),
        permeability_m2: upstream.and_then(|w| flow.permeability(w)).map(|k| k.value),
        porosity: Some(1.0 - solid / network.bounds.volume()).filter(|&n| n > 0.0),
        hidden: t.hidden.clone(),
        unknowns: flow.operators().unknowns(),
        remarks: flow.remarks(),
        sealed: flow.operators().sealed_pores().clone(),
        warnings: flow.remarks().warnings(),
        residual: flow.residual(),
        written: None,
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "  spheres        {}", count(self.spheres as u64))?;
        if !self.hidden.is_empty() {
            let names: Vec<String> = self.hidden.iter().map(u32::to_string).collect();
            writeln!(
                f,
                "  hidden         {} (inside the power cells of others; no pore has them)",
                names.join(", ")
            )?;
        }
        writeln!(
            f,
            "  pores          {} ({} unknown)",
            count(self.cells.len() as u64),
            count(self.unknowns as u64)
        )?;
        if let Some(porosity) = self.porosity {
            writeln!(f, "  porosity       {}", three_digits(porosity))?;
        }
        for (wall, flux) in self.flux.iter().filter(|(_, q)| **q != 0.0) {
            writeln!(f, "  flux at {wall}  {flux:.4e} m³/s into the box")?;
        }
        if let Some(k) = self.permeability_m2 {
            writeln!(f, "  permeability   {k:.6e} m²")?;
        }
        self.warnings.iter().try_for_each(|w| writeln!(f, "  warning        {w}"))?;
        if let Some(path) = &self.written {
            writeln!(f, "  written        {}", path.display())?;
        }
        Ok(())
    }
}
