//! Pressures for conductances of other origin.

use dempfv::Vec3;
use dempfv::pfv::{Derivatives, Network, Operators};
use dempfv::solver::SolverKind;

use super::case::boundary;
use crate::Error;

/// Solutions are refined this often: enough for the last digits.
const REFINEMENTS: usize = 5;

/// A flow at rest.
pub struct Solution {
    /// Per pore (Pa).
    pub pressure: Vec<f64>,
    /// Per wall, into the box (m³/s).
    pub flux: [f64; 6],
    /// Per sphere, with the pushes of our throats (N).
    pub force: Vec<Vec3>,
}

impl Solution {
    /// Solves for the network's pores with these conductances of its throats
    /// (m³/(Pa·s)).
    ///
    /// # Errors
    /// When a pore is cut off, or the factorization fails.
    pub fn new(
        network: &Network,
        derivatives: &Derivatives,
        conductance: Vec<f64>,
    ) -> Result<Solution, Error> {
        let mut network = network.clone();
        network.throats.conductance = conductance;
        let operators = Operators::new(&network, derivatives.clone(), boundary())
            .map_err(dempfv::Error::from)?;
        let places: Vec<[f64; 3]> =
            operators.pore_of.iter().map(|&i| network.center[i as usize].into()).collect();
        let (pores, unknowns) = (network.pores(), operators.unknowns());
        let mut factor = SolverKind::default()
            .backend()
            .analyze(&operators.matrix, Some(&places))
            .and_then(|symbolic| symbolic.factor(&operators.matrix))
            .map_err(dempfv::Error::from)?;
        let (mut pressure, at_rest) = (vec![0.0; pores], vec![0.0; pores]);
        let (mut solution, mut rhs) = (vec![0.0; unknowns], vec![0.0; unknowns]);
        let mut change = vec![0.0; unknowns];
        operators.pressures(&solution, &mut pressure).map_err(dempfv::Error::from)?;
        for _ in 0..REFINEMENTS {
            operators.residual(&pressure, &at_rest, &mut rhs).map_err(dempfv::Error::from)?;
            factor.solve(&rhs, &mut change).map_err(dempfv::Error::from)?;
            solution.iter_mut().zip(&change).for_each(|(p, c)| *p += c);
            operators.pressures(&solution, &mut pressure).map_err(dempfv::Error::from)?;
        }
        let flux = operators.flux(&pressure, &at_rest).map_err(dempfv::Error::from)?;
        let mut force = vec![Vec3::zeros(); network.tessellation.spheres];
        operators
            .forces(&pressure, &mut force, &mut [Vec3::zeros(); 6])
            .map_err(dempfv::Error::from)?;
        Ok(Solution { pressure, flux, force })
    }
}
