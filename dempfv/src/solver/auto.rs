//! Which solver is the fastest for how many unknowns, and which takes the matrix at all.

use super::cost::FRONTAL_FROM;
use super::frontal::{FrontalFactor, FrontalSymbolic};
use super::{
    Analysis, Backend, Cholmod, Cost, Factor, Placement, SolverError, Symbolic, SymmetricCsc,
    SystemSize, cholmod, cost,
};

/// CHOLMOD for small systems, the frontal solver for large ones. Where the frontal solver
/// refuses a matrix, since it is no diagonally dominant M-matrix (an entry off the diagonal is
/// positive, or a row has a negative sum), or since the pattern has too many entries for it,
/// CHOLMOD takes it.
///
/// Which one it is depends on the matrix alone, never on what was factored before: a refactored
/// matrix has the bits of a fresh factor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Auto;

impl Backend for Auto {
    fn name(&self) -> &'static str {
        "auto"
    }

    fn analyze(
        &self,
        a: &SymmetricCsc,
        coordinates: Option<&[[f64; 3]]>,
    ) -> Result<Box<dyn Symbolic>, SolverError> {
        if a.n < FRONTAL_FROM {
            return Cholmod.analyze(a, coordinates);
        }
        match FrontalSymbolic::new(a, coordinates) {
            Ok(frontal) => Ok(Box::new(AutoSymbolic { frontal })),
            Err(SolverError::TooLarge { .. }) => Cholmod.analyze(a, coordinates),
            Err(error) => Err(error),
        }
    }

    fn cost(&self, size: &SystemSize) -> Option<Cost> {
        Some(cost::auto(size.unknowns).cost(size))
    }
}

/// The pattern of a large system.
struct AutoSymbolic {
    frontal: FrontalSymbolic,
}

impl Symbolic for AutoSymbolic {
    fn analysis(&self) -> Analysis {
        self.frontal.analysis()
    }

    fn factor(self: Box<Self>, a: &SymmetricCsc) -> Result<Box<dyn Factor>, SolverError> {
        let mut factor = AutoFactor { frontal: self.frontal.into_factor(), cholmod: None };
        factor.factorize(a)?;
        Ok(Box::new(factor))
    }
}

/// A factor of a large system, by the solver that takes the values.
struct AutoFactor {
    /// Without memory for entries while CHOLMOD has the factor.
    frontal: FrontalFactor,
    cholmod: Option<Box<dyn Factor>>,
}

impl AutoFactor {
    fn factorize(&mut self, a: &SymmetricCsc) -> Result<(), SolverError> {
        match self.frontal.factorize(a) {
            Ok(()) => self.cholmod = None,
            Err(SolverError::PositiveOffDiagonal { .. } | SolverError::NotDominant { .. }) => {
                self.frontal.release();
                self.cholmod = Some(match self.cholmod.take() {
                    Some(factor) => factor.refactor(a)?,
                    None => {
                        let ordering = self.frontal.analysis().ordering;
                        cholmod::analyze_in_order(a, self.frontal.order(), ordering)?.factor(a)?
                    }
                });
            }
            Err(error) => return Err(error),
        }
        Ok(())
    }

    fn active(&self) -> &dyn Factor {
        match &self.cholmod {
            Some(cholmod) => &**cholmod,
            None => &self.frontal,
        }
    }

    fn active_mut(&mut self) -> &mut dyn Factor {
        match &mut self.cholmod {
            Some(cholmod) => &mut **cholmod,
            None => &mut self.frontal,
        }
    }
}

impl Factor for AutoFactor {
    fn solver(&self) -> &'static str {
        self.active().solver()
    }

    fn analysis(&self) -> Analysis {
        self.active().analysis()
    }

    fn solve(&mut self, b: &[f64], x: &mut [f64]) -> Result<(), SolverError> {
        self.active_mut().solve(b, x)
    }

    fn solve_many(&mut self, b: &[f64], x: &mut [f64], columns: usize) -> Result<(), SolverError> {
        self.active_mut().solve_many(b, x, columns)
    }

    fn correct(&mut self, r: &[f64], x: &mut [f64]) -> Result<(), SolverError> {
        self.active_mut().correct(r, x)
    }

    fn correct_checked(
        &mut self,
        a: &SymmetricCsc,
        r: &[f64],
        x: &mut [f64],
    ) -> Result<f64, SolverError> {
        self.active_mut().correct_checked(a, r, x)
    }

    fn refactor(mut self: Box<Self>, a: &SymmetricCsc) -> Result<Box<dyn Factor>, SolverError> {
        self.factorize(a)?;
        Ok(self)
    }

    fn memory_bytes(&self) -> usize {
        let held = self.cholmod.as_ref().map_or(0, |factor| factor.memory_bytes());
        held + self.frontal.memory_bytes()
    }

    fn placement(&self) -> &Placement {
        self.active().placement()
    }

    fn solve_checked(
        &mut self,
        a: &SymmetricCsc,
        b: &[f64],
        x: &mut [f64],
    ) -> Result<f64, SolverError> {
        self.active_mut().solve_checked(a, b, x)
    }
}
