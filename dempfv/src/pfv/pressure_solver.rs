//! Solves `G p = -V̇ + Q` for the pressures: by a factor of `G`, or, where the network has moved
//! on from its factor, by conjugate gradients preconditioned by it.

use std::ops::ControlFlow;

use super::extrapolation::{Extrapolation, Replaced, Sizes};
use super::geometry_update::WeakenedThroat;
use super::operators::NetVolumeRate;
use super::{Operators, PfvError, PoreConditions};
use crate::parallel::parts;
use crate::solver::{
    ConjugateGradients, ErrorGoal, Factor, Iterations, LinearOperator, Preconditioner, Refinement,
    SolverError, refine,
};

/// Largest error that a solve may leave, unless told otherwise.
const DEFAULT_TOLERANCE: f64 = 1e-11;
/// Solves for a correction, at most: the first and three refinements.
const MAX_CORRECTIONS: usize = 4;
/// Solves that make the response of pores without a path to an imposed pressure right to about six
/// digits.
const RESPONSE_ROUNDS: usize = 2;
/// Of what fills the pores in one step this share is resolved to the digits that a tolerance may ask
/// for: less than that flowing counts as so much.
const RESOLVED_SHARE: f64 = 1e-4;
/// Round-off of pressures, relative to the largest imposed one.
const ROUND_OFF: f64 = 1e-13;

/// The factor of a network's conductance matrix, the memory of its solves, and how they went.
/// All of it but the statistics is scratch: the state is in [`Extrapolation`].
pub(super) struct PressureSolver {
    /// `None` when every pore has an imposed pressure.
    factor: Option<Box<dyn Factor>>,
    pub tolerance: f64,
    pub statistics: SolveStatistics,
    rhs: Vec<f64>,
    correction: Vec<f64>,
    /// Flux from each set of pores with an imposed pressure.
    flux: Vec<f64>,
    gradients: ConjugateGradients,
    /// A vector over all pores, 0 where the pressure is imposed.
    scattered: Vec<f64>,
    /// What goes back into its place where a solve fails.
    replaced: Replaced,
    /// What pores that store fluid take up at the pressures of the moment; empty without.
    taken: Vec<f64>,
    /// A residual whose closed groups have been leveled; empty without such groups.
    leveled: Vec<f64>,
}

/// How the solves went.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SolveStatistics {
    /// Residual of the first solve after the factorization; `None` before it.
    pub residual: Option<f64>,
    /// See [`Operators::imbalance`].
    pub imbalance: f64,
    /// The pressures are a solution.
    pub solved: bool,
    /// What the last solve left, where that was more than the tolerance after all refinements:
    /// the larger of the estimated error of the pressures and the imbalance (1).
    pub unmet: Option<f64>,
}

/// What is solved for: pressures for these demands.
pub(super) struct PressureProblem<'a> {
    pub operators: &'a Operators,
    /// What the throats of each pore must bring (m³/s): its growth, and what terms take up.
    pub demand: &'a [f64],
    /// Less flow than this (m³/s) counts as so much.
    pub least: f64,
    /// Of the unknowns, with what came before.
    pub extrapolation: &'a mut Extrapolation,
    /// Of all pores (Pa, above the reference).
    pub pressure: &'a mut [f64],
    /// What pressures are measured from (Pa).
    pub reference: f64,
}

impl PressureSolver {
    pub fn new(factor: Option<Box<dyn Factor>>, operators: &Operators) -> PressureSolver {
        let unknowns = operators.unknowns();
        PressureSolver {
            factor,
            tolerance: DEFAULT_TOLERANCE,
            statistics: SolveStatistics::default(),
            rhs: vec![0.0; unknowns],
            correction: vec![0.0; unknowns],
            flux: vec![0.0; operators.conditions().sets()],
            gradients: ConjugateGradients::default(),
            scattered: vec![],
            replaced: Replaced::default(),
            taken: vec![],
            leveled: vec![],
        }
    }

    /// Factors the matrix of the operators anew, in the place of the old factor.
    pub fn renew_factor(
        &mut self,
        operators: &Operators,
        fresh: impl FnOnce() -> Result<Box<dyn Factor>, SolverError>,
    ) -> Result<(), SolverError> {
        self.statistics.residual = None;
        self.factor = Some(match self.factor.take() {
            Some(factor) => factor.refactor(&operators.matrix)?,
            None => fresh()?,
        });
        Ok(())
    }

    pub fn factor(&self) -> Option<&dyn Factor> {
        self.factor.as_deref()
    }

    pub fn into_factor(self) -> Option<Box<dyn Factor>> {
        self.factor
    }

    /// Solves by the factor for the change from what the last pressures predict; repeated
    /// until the tolerance holds.
    pub fn solve(&mut self, problem: PressureProblem) -> Result<(), PfvError> {
        self.statistics.solved = false;
        let PressureProblem { operators, demand, least, extrapolation, pressure, reference } =
            problem;
        extrapolation.predict(&mut self.replaced, &operators.pore_of, pressure);
        let net_rate = NetVolumeRate::of(demand).at_least(least);
        let gain_is_due = extrapolation.gain_is_due();
        let mut balance = Balance { net_rate, flux: &mut self.flux, taken: &mut self.taken };
        let Some(factor) = self.factor.as_deref_mut() else {
            self.statistics.imbalance = balance.imbalance(operators, demand, pressure);
            extrapolation.solved();
            check_finite(pressure)?;
            self.statistics.solved = true;
            return Ok(());
        };
        self.statistics.unmet = None;
        let problem =
            PressureProblem { operators, demand, least, extrapolation, pressure, reference };
        let mut refined = RefinedPressures {
            factor,
            problem,
            balance,
            gain_is_due,
            tolerance: self.tolerance,
            statistics: &mut self.statistics,
            rhs: &mut self.rhs,
            correction: &mut self.correction,
            last_change: 0.0,
            largest: 0.0,
            error: 0.0,
        };
        let settled = refine(&mut refined, MAX_CORRECTIONS);
        let RefinedPressures { problem, largest, error, statistics, tolerance, .. } = refined;
        let settled = match settled {
            Ok(settled) => settled,
            Err(error) => {
                // Whoever solves again, as after a restart, starts from what was known before.
                let PressureProblem { operators, extrapolation, pressure, .. } = problem;
                extrapolation.take_back(&mut self.replaced, &operators.pore_of, pressure);
                return Err(error.into());
            }
        };
        if !settled {
            let left = (error / largest).max(statistics.imbalance);
            statistics.unmet = Some(left).filter(|&left| left > tolerance);
        }
        let PressureProblem { extrapolation, pressure, .. } = problem;
        extrapolation.solved();
        if !largest.is_finite() {
            check_finite(pressure)?;
        }
        self.statistics.solved = true;
        Ok(())
    }

    /// Solves by conjugate gradients for a network that has moved on from its factor, until the
    /// estimated error is at most `tolerance`.
    pub fn iterate(
        &mut self,
        problem: PressureProblem,
        weakened: &[WeakenedThroat],
        tolerance: f64,
    ) -> Result<Iterations, PfvError> {
        self.statistics.solved = false;
        let PressureProblem { operators, demand, least, extrapolation, pressure, reference } =
            problem;
        let mut went = Iterations::default();
        if let Some(factor) = self.factor.as_deref_mut() {
            extrapolation.predict(&mut self.replaced, &operators.pore_of, pressure);
            self.scattered.resize(pressure.len(), 0.0);
            operators.evaluate_residual(pressure, demand, &mut self.rhs);
            let goal = goal(operators.conditions(), reference, operators.unknowns(), tolerance);
            let mut matrix = ThroatwiseMatrix { operators, scattered: &mut self.scattered };
            let mut factor = AgedFactor { factor, weakened, operators, leveled: &mut self.leveled };
            let (x, residual) = (&mut extrapolation.now, &mut self.rhs);
            let solved = self.gradients.solve(&mut matrix, &mut factor, x, residual, &goal);
            went = solved.inspect_err(|_| {
                extrapolation.take_back(&mut self.replaced, &operators.pore_of, pressure);
            })?;
        }
        extrapolation.solved();
        operators.evaluate_pressures(&extrapolation.now, reference, pressure);
        let net_rate = NetVolumeRate::of(demand).at_least(least);
        let mut balance = Balance { net_rate, flux: &mut self.flux, taken: &mut self.taken };
        self.statistics.imbalance = balance.imbalance(operators, demand, pressure);
        check_finite(pressure)?;
        self.statistics.solved = true;
        Ok(went)
    }

    /// Writes the pressures (Pa) that these volume rates (m³/s) cause by themselves, the imposed
    /// pressures being zero: `-G⁻¹ V̇`. Entries of pores with an imposed pressure stay as they
    /// are. False when no pressure is unknown.
    pub fn respond(
        &mut self,
        operators: &Operators,
        volume_rate: &[f64],
        pressure: &mut [f64],
    ) -> Result<bool, PfvError> {
        let Some(factor) = &mut self.factor else { return Ok(false) };
        let PressureSolver { rhs, correction, leveled, .. } = self;
        for (b, &pore) in rhs.iter_mut().zip(&operators.pore_of) {
            *b = -volume_rate[pore as usize];
        }
        if !operators.has_closed() {
            factor.solve(rhs, correction)?;
            for (p, &pore) in correction.iter().zip(&operators.pore_of) {
                pressure[pore as usize] = *p;
            }
            return Ok(true);
        }
        // The factor has the means of closed groups wrong: they are leveled before each round, and
        // what a round leaves of their means is leveled last.
        for &pore in &operators.pore_of {
            pressure[pore as usize] = 0.0;
        }
        leveled.resize(rhs.len(), 0.0);
        for round in 0..=RESPONSE_ROUNDS {
            operators.conduct(pressure, leveled);
            leveled.iter_mut().zip(&*rhs).for_each(|(r, b)| *r = b - *r);
            operators.level_closed(leveled, |u, change| {
                pressure[operators.pore_of[u] as usize] += change;
            });
            if round < RESPONSE_ROUNDS {
                factor.correct(leveled, correction)?;
                for (p, &pore) in correction.iter().zip(&operators.pore_of) {
                    pressure[pore as usize] += *p;
                }
            }
        }
        Ok(true)
    }
}

/// Refuses pressures that are not finite.
fn check_finite(pressure: &[f64]) -> Result<(), PfvError> {
    let finite = |part: &[f64]| part.iter().all(|p| p.is_finite());
    if parts(pressure, finite, true, |a, b| a && b) {
        return Ok(());
    }
    let pore = pressure.iter().position(|p| !p.is_finite()).unwrap_or(0);
    Err(PfvError::PressureNotFinite { pore: pore as u32 })
}

/// What flows from pores with an imposed pressure against what all pores take up.
struct Balance<'a> {
    /// Of what the pores take up whatever their pressures.
    net_rate: NetVolumeRate,
    flux: &'a mut [f64],
    taken: &'a mut Vec<f64>,
}

impl Balance<'_> {
    /// See [`Operators::imbalance`].
    fn imbalance(&mut self, operators: &Operators, demand: &[f64], pressure: &[f64]) -> f64 {
        let Some(storage) = operators.storage() else {
            operators.evaluate_flux(pressure, demand, self.flux);
            return self.net_rate.imbalance(self.flux);
        };
        self.taken.clear();
        self.taken.extend_from_slice(demand);
        storage.add_uptake(pressure, self.taken);
        operators.evaluate_flux(pressure, self.taken, self.flux);
        let resolved = RESOLVED_SHARE * storage.refill(pressure);
        let least = self.net_rate.least().max(resolved);
        NetVolumeRate::of(self.taken).at_least(least).imbalance(self.flux)
    }
}

/// Pressures that are corrected by the factor of their matrix.
struct RefinedPressures<'a> {
    factor: &'a mut dyn Factor,
    problem: PressureProblem<'a>,
    balance: Balance<'a>,
    /// What a correction leaves is to be looked up.
    gain_is_due: bool,
    tolerance: f64,
    statistics: &'a mut SolveStatistics,
    rhs: &'a mut [f64],
    correction: &'a mut [f64],
    /// Size of the last correction (Pa).
    last_change: f64,
    /// Largest pressure (Pa).
    largest: f64,
    /// Estimated error of the pressures (Pa).
    error: f64,
}

impl Refinement for RefinedPressures<'_> {
    fn evaluate_residual(&mut self) {
        let PressureProblem { operators, demand, pressure, extrapolation, .. } = &mut self.problem;
        operators.evaluate_residual(pressure, demand, self.rhs);
        operators.level_closed(self.rhs, |u, change| {
            extrapolation.now[u] += change;
            pressure[operators.pore_of[u] as usize] = extrapolation.now[u];
        });
    }

    fn evaluate_correction(&mut self) -> Result<(), SolverError> {
        let RefinedPressures { factor, statistics, rhs, correction, .. } = self;
        if statistics.residual.is_some() {
            return factor.correct(rhs, correction);
        }
        let matrix = &self.problem.operators.matrix;
        statistics.residual = Some(factor.correct_checked(matrix, rhs, correction)?);
        Ok(())
    }

    /// Enough is enough when both the imbalance of fluid mass and the error are small; the
    /// error is known by what a correction has been seen to leave.
    fn correct(&mut self, round: usize) -> ControlFlow<()> {
        let PressureProblem { operators, demand, extrapolation, pressure, .. } = &mut self.problem;
        let Sizes { change, pressure: largest } =
            extrapolation.correct(self.correction, &operators.pore_of, pressure);
        self.largest = largest;
        self.statistics.imbalance = self.balance.imbalance(operators, demand, pressure);
        if round == 1 {
            extrapolation.observe_gain(change, self.last_change);
        }
        self.last_change = change;
        self.error = extrapolation.gain() * change;
        let small = self.error <= self.tolerance * largest;
        if self.statistics.imbalance <= self.tolerance && small && (round > 0 || !self.gain_is_due)
        {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// The conductance matrix of the moment, applied throat by throat.
struct ThroatwiseMatrix<'a> {
    operators: &'a Operators,
    scattered: &'a mut [f64],
}

impl LinearOperator for ThroatwiseMatrix<'_> {
    fn unknowns(&self) -> usize {
        self.operators.unknowns()
    }

    fn apply(&mut self, x: &[f64], y: &mut [f64]) {
        for (d, &pore) in x.iter().zip(&self.operators.pore_of) {
            self.scattered[pore as usize] = *d;
        }
        self.operators.conduct(self.scattered, y);
    }
}

/// The factor of an earlier network of the same pores.
struct AgedFactor<'a> {
    factor: &'a mut dyn Factor,
    weakened: &'a [WeakenedThroat],
    operators: &'a Operators,
    leveled: &'a mut Vec<f64>,
}

impl Preconditioner for AgedFactor<'_> {
    fn precondition(&mut self, r: &[f64], correction: &mut [f64]) -> Result<(), SolverError> {
        self.factor.correct(r, correction)?;
        correct_weakened(self.weakened, r, correction);
        if self.operators.has_closed() {
            self.leveled.clear();
            self.leveled.extend_from_slice(r);
            self.operators.level_closed(self.leveled, |u, change| correction[u] += change);
        }
        Ok(())
    }
}

/// Adds what the aged factor does too little of: where a throat was much wider
/// when it was factored, the difference of its two pores hardly counts. Each
/// such difference is solved for by itself (additive Schwarz).
fn correct_weakened(weakened: &[WeakenedThroat], residual: &[f64], correction: &mut [f64]) {
    for &WeakenedThroat { unknowns, inverse } in weakened {
        let [u, v] = unknowns.map(|u| u as usize);
        let at = |u: usize| residual.get(u).copied().unwrap_or(0.0);
        let step = inverse * (at(u) - at(v));
        if let Some(c) = correction.get_mut(u) {
            *c += step;
        }
        if let Some(c) = correction.get_mut(v) {
            *c -= step;
        }
    }
}

/// Pressures are measured from the mean imposed one, and their round-off follows from the
/// largest.
fn goal(
    conditions: &PoreConditions,
    reference: f64,
    unknowns: usize,
    relative_error: f64,
) -> ErrorGoal {
    let imposed = || conditions.ranges().map(|range| range.map(|p| p - reference));
    let datum = imposed().map(|[_, mean, _]| mean).sum::<f64>() / imposed().count().max(1) as f64;
    let largest = imposed().flatten().fold(0.0f64, |m, p| m.max(p.abs()));
    ErrorGoal { relative_error, datum, round_off: ROUND_OFF * largest * (unknowns as f64).sqrt() }
}
