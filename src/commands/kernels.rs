//! What to say where CHOLMOD takes longer than need be.

use std::io::{self, Write};

use dempfv::solver::{SolverKind, blas};

/// For a solver that computes with the BLAS, where that uses old kernels. Not for `auto`, which leaves
/// small systems to CHOLMOD only: those take milliseconds either way.
pub fn warning(solver: SolverKind) -> Option<String> {
    match solver {
        SolverKind::Cholmod | SolverKind::CholmodGpu(_) => {
            blas::old_kernels().map(|kernels| kernels.to_string())
        }
        SolverKind::Auto | SolverKind::Frontal => None,
    }
}

/// The same on stderr, before the work.
pub fn announce(solver: SolverKind) {
    if let Some(warning) = warning(solver) {
        // A closed stderr must not end the work.
        let _ = writeln!(io::stderr(), "warning: {warning}");
    }
}
