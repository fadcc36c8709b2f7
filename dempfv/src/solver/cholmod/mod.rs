//! CHOLMOD of SuiteSparse (Chen, Davis, Hager and Rajamanickam 2008): LLᵀ by
//! supernodes, ordered by minimum cuts where the unknowns have coordinates, by METIS
//! where not. The largest parts may go to a GPU.

mod accelerator;
#[cfg(feature = "cuda")]
mod gpu;
mod raw;

use std::sync::{Mutex, PoisonError};

use super::address_space::reserve_buffer;
use super::{
    Analysis, Backend, Cost, Factor, GpuOptions, Placement, SolverError, Symbolic, SymmetricCsc,
    SystemSize, blas, cost, ordering, require_size,
};
use accelerator::Accelerator;
use raw::{Fault, Raw};

/// In messages.
const NAME: &str = "cholmod";

/// METIS seeds and then draws from the C library's `rand`, which is the
/// process's: two analyses at once would disturb each other's ordering.
static ORDERING: Mutex<()> = Mutex::new(());

/// Pivots below this part of the diagonal are round-off. Networks whose
/// conductances span ten decades keep theirs well above.
const PIVOT_LIMIT: f64 = 1e-14;

/// The CHOLMOD backend. With coordinates it orders by them ([`ordering::order`]), which
/// is faster and fills less in; without, METIS orders by the graph.
///
/// The BLAS runs on one thread, so that the factor is the same bits on any
/// machine load and thread count; see [`super::blas::set_threads`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Cholmod;

impl Backend for Cholmod {
    fn name(&self) -> &'static str {
        "cholmod"
    }

    fn analyze(
        &self,
        a: &SymmetricCsc,
        coordinates: Option<&[[f64; 3]]>,
    ) -> Result<Box<dyn Symbolic>, SolverError> {
        analyze(a, coordinates, None)
    }

    fn cost(&self, size: &SystemSize) -> Option<Cost> {
        Some(cost::CHOLMOD.cost(size))
    }
}

/// The CHOLMOD backend with its largest dense parts on an NVIDIA GPU (Rennich,
/// Stosic and Davis 2016); solves are the CPU's. Whatever goes wrong with the
/// GPU, the CPU does the work, and [`Factor::placement`] says why.
///
/// Factors of one device share its memory, which is kept until the process
/// ends. A GPU rounds otherwise than a CPU, and what it gets to do depends on
/// how busy it is: bits differ from run to run.
#[derive(Clone, Copy, Debug, Default)]
pub struct CholmodGpu(pub GpuOptions);

impl Backend for CholmodGpu {
    fn name(&self) -> &'static str {
        "cholmod-gpu"
    }

    fn analyze(
        &self,
        a: &SymmetricCsc,
        coordinates: Option<&[[f64; 3]]>,
    ) -> Result<Box<dyn Symbolic>, SolverError> {
        analyze(a, coordinates, Some(self.0))
    }

    /// That of the CPU, which a GPU may undercut by as much as it is faster.
    fn cost(&self, size: &SystemSize) -> Option<Cost> {
        Cholmod.cost(size)
    }
}

fn analyze(
    a: &SymmetricCsc,
    coordinates: Option<&[[f64; 3]]>,
    gpu: Option<GpuOptions>,
) -> Result<Box<dyn Symbolic>, SolverError> {
    a.validate()?;
    if let Some(points) = coordinates {
        require_size("the list of coordinates", a.n, points.len())?;
    }
    // Minimum cuts count in 32 bits, METIS in 64.
    let (name, raw) = match coordinates.filter(|_| a.counts_in_32_bits()) {
        Some(points) => ("minimum cuts", Raw::analyze(a, Some(&ordering::minimum_cuts(a, points)))),
        None => {
            // A panic in another analysis leaves nothing behind in METIS.
            let _alone = ORDERING.lock().unwrap_or_else(PoisonError::into_inner);
            ("metis", Raw::analyze(a, None))
        }
    };
    let raw = raw.map_err(|fault| error(fault, "analyze", a.n))?;
    Ok(Box::new(CholmodFactor::new(a, raw, name, gpu.map(Accelerator::new))?))
}

/// Analyzes a validated matrix by an order of elimination that is known, under its name.
///
/// # Errors
/// Memory ran out, or the address space, or CHOLMOD refused.
pub(super) fn analyze_in_order(
    a: &SymmetricCsc,
    order: &[u32],
    ordering: &'static str,
) -> Result<Box<dyn Symbolic>, SolverError> {
    let order: Vec<i64> = order.iter().map(|&k| k.into()).collect();
    let raw = Raw::analyze(a, Some(&order)).map_err(|fault| error(fault, "analyze", a.n))?;
    Ok(Box::new(CholmodFactor::new(a, raw, ordering, None)?))
}

/// The order of elimination that METIS finds, through CHOLMOD: entry k is the
/// unknown that is eliminated as the k-th.
///
/// # Errors
/// Memory ran out, or CHOLMOD refused.
pub(super) fn metis_order(a: &SymmetricCsc) -> Result<Vec<u32>, SolverError> {
    let guard = ORDERING.lock().unwrap_or_else(PoisonError::into_inner);
    let raw = Raw::analyze(a, None).map_err(|fault| error(fault, "analyze", a.n))?;
    drop(guard);
    Ok(raw.permutation().iter().map(|&k| k as u32).collect())
}

/// CHOLMOD keeps the symbolic and the numeric factor in one object; the two
/// traits keep them apart.
struct CholmodFactor {
    raw: Raw,
    n: usize,
    pattern: u64,
    analysis: Analysis,
    accelerator: Option<Accelerator>,
    placement: Placement,
}

impl CholmodFactor {
    fn new(
        a: &SymmetricCsc,
        raw: Raw,
        ordering: &'static str,
        accelerator: Option<Accelerator>,
    ) -> Result<CholmodFactor, SolverError> {
        blas::choose_default();
        reserve_buffer(NAME)?;
        let (nnz_l, flops) = raw.counts();
        Ok(CholmodFactor {
            raw,
            n: a.n,
            pattern: a.pattern_hash(),
            analysis: Analysis { ordering, nnz_l: nnz_l as u64, flops },
            accelerator,
            placement: Placement::default(),
        })
    }

    fn factorize(&mut self, a: &SymmetricCsc) -> Result<(), SolverError> {
        if a.n != self.n || a.pattern_hash() != self.pattern {
            return Err(SolverError::PatternChanged);
        }
        a.check_finite()?;
        let (result, placement) = match &self.accelerator {
            Some(accelerator) => accelerator.factorize(&mut self.raw, a),
            None => (self.raw.factorize(a), Placement::Cpu),
        };
        self.placement = placement;
        match result {
            Err(Fault::NotPositiveDefinite) => {
                let column = self.raw.permutation()[self.raw.stopped_at()] as usize;
                Err(SolverError::NotPositiveDefinite { column })
            }
            // A small pivot is a warning, and the factor is complete.
            Ok(()) | Err(Fault::SmallPivot) => self.check_pivots(a),
            Err(fault) => Err(error(fault, "factor", self.n)),
        }
    }

    /// Refuses a factor one of whose pivots is mere round-off.
    fn check_pivots(&self, a: &SymmetricCsc) -> Result<(), SolverError> {
        let permutation = self.raw.permutation();
        let mut worst = (0, f64::INFINITY);
        self.raw.for_each_pivot(|k, pivot| {
            let column = permutation[k] as usize;
            let ratio = pivot * pivot / a.values[a.col_ptr[column] as usize];
            if ratio < worst.1 {
                worst = (column, ratio);
            }
        });
        let (column, ratio) = worst;
        if ratio < PIVOT_LIMIT {
            Err(SolverError::NearlySingular { column, ratio })
        } else {
            Ok(())
        }
    }
}

impl Symbolic for CholmodFactor {
    fn analysis(&self) -> Analysis {
        self.analysis
    }

    fn factor(mut self: Box<Self>, a: &SymmetricCsc) -> Result<Box<dyn Factor>, SolverError> {
        self.factorize(a)?;
        Ok(self)
    }
}

impl Factor for CholmodFactor {
    fn solver(&self) -> &'static str {
        if self.accelerator.is_some() { "cholmod-gpu" } else { NAME }
    }

    fn analysis(&self) -> Analysis {
        self.analysis
    }

    fn solve(&mut self, b: &[f64], x: &mut [f64]) -> Result<(), SolverError> {
        require_size("the right-hand side", self.n, b.len())?;
        require_size("the solution", self.n, x.len())?;
        if let Some(row) = b.iter().position(|v| !v.is_finite()) {
            return Err(SolverError::RightHandSideNotFinite { row, value: b[row] });
        }
        self.raw.solve(b, x).map_err(|fault| error(fault, "solve", self.n))
    }

    fn refactor(mut self: Box<Self>, a: &SymmetricCsc) -> Result<Box<dyn Factor>, SolverError> {
        self.factorize(a)?;
        Ok(self)
    }

    fn memory_bytes(&self) -> usize {
        self.raw.memory()
    }

    fn placement(&self) -> &Placement {
        &self.placement
    }
}

/// A fault of CHOLMOD's as the library's error.
fn error(fault: Fault, phase: &'static str, n: usize) -> SolverError {
    let solver = NAME;
    match fault {
        Fault::OutOfMemory => SolverError::OutOfMemory { solver, phase, n },
        Fault::TooLarge => SolverError::TooLarge { solver, n },
        Fault::Refused(what) => SolverError::Refused { solver, phase, what },
        // Statuses of a factorization, where `factorize` names the column.
        Fault::NotPositiveDefinite | Fault::SmallPivot => {
            SolverError::Refused { solver, phase, what: "a pivot is not positive".to_owned() }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One unknown that is joined to all others, eliminated first: all of L fills in, with
    /// n (n + 1) / 2 = 2.45e9 entries, more than 2³¹.
    #[test]
    fn factors_beyond_31_bits_are_counted() {
        let n = 70_000;
        let joined = (1..n).flat_map(|k| [(k, k, 1.0), (k, 0, -1.0)]);
        let a = SymmetricCsc::from_triplets(n, joined.chain([(0, 0, n as f64)])).unwrap();
        let order: Vec<u32> = (0..n as u32).collect();
        let symbolic = analyze_in_order(&a, &order, "given").unwrap();
        assert_eq!(symbolic.analysis().nnz_l, (n * (n + 1) / 2) as u64);
    }
}
