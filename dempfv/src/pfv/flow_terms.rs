//! What a flow has in the balance of its pores beside throats and motion.

use super::terms::{FluidTerm, PoreSource, Sources};
use super::{Flow, PfvError};
use crate::Vec3;

impl Flow {
    /// Takes a term into the balance of the pores, in the place of one of the same name: from the
    /// next solve on, of this network.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] for a term that stores fluid: the matrix is made with it
    /// ([`Assembled::with_terms`](super::Assembled::with_terms)).
    pub fn set_term(&mut self, term: Box<dyn FluidTerm>) -> Result<(), PfvError> {
        if term.stores() {
            let problem =
                format!("`{}` stores fluid; give it to Assembled::with_terms", term.name());
            return Err(PfvError::InvalidInput { argument: "term", index: None, problem });
        }
        self.terms.set(term);
        Ok(())
    }

    /// Takes a term out of the balance. Returns whether there was one of this name.
    pub fn remove_term(&mut self, name: &str) -> bool {
        self.terms.remove(name)
    }

    /// Names of the terms in the balance beside throats and motion.
    pub fn terms(&self) -> impl Iterator<Item = &'static str> {
        self.terms.names()
    }

    /// Lets fluid enter pores of choice, in the place of earlier sources (none takes these out); `position` has the
    /// sphere centres (m) that the network was built of. Another network has other pores: who
    /// builds one sets its sources.
    ///
    /// ```
    /// use dempfv::pfv::terms::PoreSource;
    /// use dempfv::pfv::{Boundary, Clamp, Flow, Fluid, PoreSelection};
    /// use dempfv::solver::SolverKind;
    /// use dempfv::{Aabb, Vec3, WallId};
    ///
    /// // A box that is open at the top; a litre an hour enters in a corner of the bottom.
    /// let mut boundary = Boundary::default();
    /// boundary.pressure[WallId::YMax] = Some(0.0);
    /// let fluid = Fluid { viscosity: 1e-3, slip_walls: true, clamp: Clamp::None, boundary };
    /// let bounds = Aabb { min: Vec3::zeros(), max: Vec3::repeat(1.0) };
    /// let x = [Vec3::new(0.3, 0.3, 0.4), Vec3::new(0.7, 0.6, 0.6)];
    /// let mut flow = Flow::new(&x, &[0.2, 0.2], bounds, &fluid, SolverKind::default())?;
    /// let rate = 1e-3 / 3600.0;
    /// let tube = PoreSelection::Around { center: Vec3::zeros(), radius: 0.3 };
    /// flow.set_sources(&x, &[PoreSource { pores: tube, rate }])?;
    /// flow.solve_static()?;
    /// assert!((flow.flux()[WallId::YMax.index()] + rate).abs() < 1e-10 * rate);
    /// # Ok::<(), dempfv::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Sources::new`]; for another number of spheres.
    pub fn set_sources(
        &mut self,
        position: &[Vec3],
        sources: &[PoreSource],
    ) -> Result<(), PfvError> {
        self.require_one_per_sphere("position", position.len())?;
        let sources = Sources::new(&self.network, self.operators.conditions(), position, sources)?;
        if sources.is_empty() {
            self.remove_term(Sources::NAME);
        } else {
            self.terms.set_sources(sources);
        }
        Ok(())
    }
}
