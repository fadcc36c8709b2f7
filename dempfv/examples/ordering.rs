//! Orders the network of a packing by minimum cuts and by METIS, and tells what each
//! takes and fills in: `cargo run --release --example ordering -- PACKING`.

use std::time::{Duration, Instant};

use dempfv::io::packing::Packing;
use dempfv::pfv::{Boundary, Clamp, Fluid, Network, Operators};
use dempfv::solver::ordering::order;
use dempfv::solver::{Analysis, SolverKind, SymmetricCsc};
use dempfv::{Error, InputError, Result, WallId};

type Points = Vec<[f64; 3]>;

/// Times are the best of so many.
const TIMES: usize = 3;

fn main() -> Result<()> {
    let mut args = std::env::args().skip(1);
    let usage = || InputError::new("no packing", "give a packing file");
    let packing = Packing::read(args.next().ok_or_else(usage)?.as_ref())?;
    let (a, points) = system(&packing)?;
    println!("{} unknowns, {} entries, threads {}", a.n, a.nnz(), rayon::current_num_threads());
    let metis = analyze("METIS", &a, None)?;
    let cuts = analyze("minimum cuts", &a, Some(&points))?;
    let (time, _) = best(|| order(&a, &points));
    println!("of which the ordering {:.4} s", time.as_secs_f64());
    compare(cuts, metis);
    Ok(())
}

fn best<T>(run: impl Fn() -> T) -> (Duration, T) {
    let once = || {
        let start = Instant::now();
        let result = run();
        (start.elapsed(), result)
    };
    let first = once();
    (1..TIMES).map(|_| once()).fold(first, |a, b| if b.0 < a.0 { b } else { a })
}

/// The matrix of a packing whose top is drained, and the pores' centres.
fn system(packing: &Packing) -> Result<(SymmetricCsc, Points)> {
    let bounds = packing
        .bounds_or_tight()
        .ok_or_else(|| InputError::new("no spheres", "give another packing"))?;
    let mut boundary = Boundary::default();
    boundary.pressure[WallId::YMax] = Some(0.0);
    let fluid = Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary };
    let (network, derivatives) = Network::new(&packing.position, &packing.radius, bounds, &fluid)?;
    let operators = Operators::new(&network, derivatives, fluid.boundary)?;
    let points = operators.pore_of.iter().map(|&i| network.center[i as usize].into()).collect();
    Ok((operators.matrix, points))
}

/// Ordering and CHOLMOD's symbolic analysis.
fn analyze(name: &str, a: &SymmetricCsc, points: Option<&[[f64; 3]]>) -> Result<Analysis> {
    let backend = SolverKind::Cholmod.backend();
    let (time, symbolic) = best(|| backend.analyze(a, points));
    let analysis = symbolic.map_err(Error::from)?.analysis();
    let Analysis { nnz_l, flops, .. } = analysis;
    println!(
        "{name:14} ordering and analysis {:.4} s, nnz(L) {nnz_l}, operations {flops:.4e}",
        time.as_secs_f64()
    );
    Ok(analysis)
}

fn compare(own: Analysis, other: Analysis) {
    let nnz = own.nnz_l as f64 / other.nnz_l as f64;
    println!("nnz(L) {nnz:.4}, operations {:.4} of METIS's", own.flops / other.flops);
}
