//! Which solver is the fastest for how many unknowns, and which takes the matrix at all.

use super::cost::FRONTAL_FROM;
use super::frontal::{FrontalFactor, FrontalSymbolic};
use super::{
    Analysis, Backend, Cholmod, Cost, Factor, Frontal, Placement, SolverError, Symbolic,
    SymmetricCsc, SystemSize, cholmod, cost,
};

/// CHOLMOD for small systems, the frontal solver for large ones. Where the frontal solver
/// refuses a matrix, since it is no diagonally dominant M-matrix (an entry off the diagonal is
/// positive, or a row has a negative sum), or since the pattern has too many entries for it,
/// CHOLMOD takes it. Where CHOLMOD finds a small system singular to working precision, as networks with
/// nearly closed throats are to it, the frontal solver tries, which cancels nothing.
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
            let cholmod = Cholmod.analyze(a, coordinates)?;
            let coordinates = coordinates.map(<[_]>::to_vec);
            return Ok(Box::new(SmallSymbolic { cholmod, coordinates }));
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
}

impl Chosen for AutoFactor {
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

    fn factor_again(mut self: Box<Self>, a: &SymmetricCsc) -> Result<Box<dyn Factor>, SolverError> {
        self.factorize(a)?;
        Ok(self)
    }

    fn memory(&self) -> usize {
        let held = self.cholmod.as_ref().map_or(0, |factor| factor.memory_bytes());
        held + self.frontal.memory_bytes()
    }
}

/// The pattern of a small system.
struct SmallSymbolic {
    cholmod: Box<dyn Symbolic>,
    coordinates: Option<Vec<[f64; 3]>>,
}

impl Symbolic for SmallSymbolic {
    fn analysis(&self) -> Analysis {
        self.cholmod.analysis()
    }

    fn factor(self: Box<Self>, a: &SymmetricCsc) -> Result<Box<dyn Factor>, SolverError> {
        let SmallSymbolic { cholmod, coordinates } = *self;
        let cholmod = cholmod.factor(a);
        Ok(Box::new(SmallFactor::new(cholmod, a, coordinates)?))
    }
}

/// A factor of a small system, by the solver that has found it regular.
struct SmallFactor {
    factor: Box<dyn Factor>,
    by_frontal: bool,
    coordinates: Option<Vec<[f64; 3]>>,
}

impl SmallFactor {
    /// CHOLMOD's factor, or that of the frontal solver where there is none.
    fn new(
        cholmod: Result<Box<dyn Factor>, SolverError>,
        a: &SymmetricCsc,
        coordinates: Option<Vec<[f64; 3]>>,
    ) -> Result<SmallFactor, SolverError> {
        let singular = match cholmod {
            Ok(factor) => return Ok(SmallFactor { factor, by_frontal: false, coordinates }),
            Err(
                e @ (SolverError::NotPositiveDefinite { .. } | SolverError::NearlySingular { .. }),
            ) => e,
            Err(error) => return Err(error),
        };
        let frontal = Frontal.analyze(a, coordinates.as_deref())?.factor(a);
        // What CHOLMOD has found is the better reason.
        let factor = frontal.map_err(|_| singular)?;
        Ok(SmallFactor { factor, by_frontal: true, coordinates })
    }
}

impl Chosen for SmallFactor {
    fn active(&self) -> &dyn Factor {
        &*self.factor
    }

    fn active_mut(&mut self) -> &mut dyn Factor {
        &mut *self.factor
    }

    fn factor_again(self: Box<Self>, a: &SymmetricCsc) -> Result<Box<dyn Factor>, SolverError> {
        let SmallFactor { factor, by_frontal, coordinates } = *self;
        let cholmod = match by_frontal {
            true => Cholmod.analyze(a, coordinates.as_deref())?.factor(a),
            false => factor.refactor(a),
        };
        Ok(Box::new(SmallFactor::new(cholmod, a, coordinates)?))
    }

    fn memory(&self) -> usize {
        self.factor.memory_bytes()
    }
}

/// A factor that is that of one of several solvers.
trait Chosen: Send {
    fn active(&self) -> &dyn Factor;
    fn active_mut(&mut self) -> &mut dyn Factor;
    /// See [`Factor::refactor`].
    fn factor_again(self: Box<Self>, a: &SymmetricCsc) -> Result<Box<dyn Factor>, SolverError>;
    /// See [`Factor::memory_bytes`].
    fn memory(&self) -> usize;
}

impl<C: Chosen> Factor for C {
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

    fn refactor(self: Box<Self>, a: &SymmetricCsc) -> Result<Box<dyn Factor>, SolverError> {
        self.factor_again(a)
    }

    fn memory_bytes(&self) -> usize {
        self.memory()
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
