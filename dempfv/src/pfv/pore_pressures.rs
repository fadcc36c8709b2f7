//! Pressures of the pores, measured from a reference so that only differences cost digits.
//!
//! Flow and the forces on spheres follow from differences of pressure alone: a uniform pressure
//! moves no fluid and pushes no sphere. Where the imposed ones are 1e5 Pa and a hundred more, five
//! digits of each pressure would be spent on what has no effect.

use super::{Operators, PoreConditions};
use crate::parallel::for_each;
use crate::{Aabb, Vec3, WallId};

/// The pressures of all pores.
#[derive(Clone, Debug)]
pub(super) struct PorePressures {
    /// What the others are measured from (Pa).
    pub reference: f64,
    /// Above the reference (Pa).
    pub relative: Vec<f64>,
    /// With the reference (Pa); empty where that is zero.
    absolute: Vec<f64>,
}

impl PorePressures {
    /// The imposed pressures; the others are the reference.
    pub fn at_rest(operators: &Operators) -> PorePressures {
        let reference = operators.conditions().reference();
        let mut relative = vec![0.0; operators.conditions().pores()];
        let rest = vec![0.0; operators.unknowns()];
        operators.evaluate_pressures(&rest, reference, &mut relative);
        let absolute = if reference == 0.0 { vec![] } else { vec![0.0; relative.len()] };
        let mut pressures = PorePressures { reference, relative, absolute };
        pressures.update_absolute();
        pressures
    }

    /// Takes a solution (Pa, above the reference).
    pub fn spread(&mut self, operators: &Operators, solution: &[f64]) {
        operators.evaluate_pressures(solution, self.reference, &mut self.relative);
        self.update_absolute();
    }

    /// The pressures (Pa).
    pub fn absolute(&self) -> &[f64] {
        if self.reference == 0.0 { &self.relative } else { &self.absolute }
    }

    /// To be called whenever the relative ones have changed.
    pub fn update_absolute(&mut self) {
        let PorePressures { reference, relative, absolute } = self;
        for_each(absolute, &|i, p| *p = *reference + relative[i]);
    }

    /// Adds the reference's force on each wall (N), which is that on its whole area.
    pub fn push_walls(&self, bounds: &Aabb, wall_force: &mut [Vec3; 6]) {
        if self.reference == 0.0 {
            return;
        }
        for wall in WallId::ALL {
            let outward = -wall.inward_normal() * bounds.wall_area(wall);
            wall_force[wall.index()] += self.reference * outward;
        }
    }
}

impl PoreConditions {
    /// The pressure from which the others are best measured (Pa): the imposed one nearest to zero
    /// where all of them are on one side of it, zero else.
    pub(super) fn reference(&self) -> f64 {
        let lowest = self.ranges().map(|[low, _, _]| low).fold(f64::INFINITY, f64::min);
        let highest = self.ranges().map(|[_, _, high]| high).fold(f64::NEG_INFINITY, f64::max);
        if lowest.is_finite() && highest.is_finite() {
            lowest.max(0.0) + highest.min(0.0)
        } else {
            0.0
        }
    }
}
