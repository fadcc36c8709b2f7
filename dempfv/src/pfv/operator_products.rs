//! The operators for whoever solves by himself: everything that is given is checked first.

use super::operators::NetVolumeRate;
use super::packing_check::require_length;
use super::{Boundary, Derivatives, NONE, Network, Operators, PfvError, PoreConditions};
use crate::Vec3;

impl Operators {
    /// Builds the operators of a network from its derivatives, with conditions at walls.
    ///
    /// # Errors
    /// As [`Operators::with_conditions`].
    pub fn new(
        network: &Network,
        derivatives: Derivatives,
        boundary: Boundary,
    ) -> Result<Operators, PfvError> {
        check_network(network)?;
        let conditions = PoreConditions::of_walls(network, &boundary);
        Operators::with_conditions(network, derivatives, conditions)
    }

    /// Builds the operators of a network from its derivatives, with any conditions. Pores
    /// without a path to an imposed pressure are found ([`Operators::sealed_pores`]).
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] where network, derivatives and conditions have not as many
    /// pores, an imposed pressure is not finite, or the arrays of the network do not belong
    /// together.
    pub fn with_conditions(
        network: &Network,
        derivatives: Derivatives,
        conditions: PoreConditions,
    ) -> Result<Operators, PfvError> {
        check_network(network)?;
        let pores = network.pores();
        let Derivatives { volume_gradient, force_coefficient } = &derivatives;
        for (argument, found) in [
            ("derivatives.volume_gradient", volume_gradient.len()),
            ("derivatives.force_coefficient", force_coefficient.len()),
            ("conditions", conditions.pores()),
        ] {
            require_length(argument, found, pores, "pores")?;
        }
        let finite = |p: &Option<f64>| p.is_none_or(f64::is_finite);
        if let Some(set) = conditions.pressures().iter().position(|p| !finite(p)) {
            return Err(PfvError::invalid("imposed pressure", set, "is not finite"));
        }
        Ok(Operators::assemble(network, derivatives, conditions, None))
    }

    /// `V̇ = E v`: the rate at which each pore grows (m³/s), from the velocities
    /// of spheres and walls (m/s; a wall's along its axis).
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] when there is not one velocity per sphere, or `out` has not one
    /// entry per pore.
    pub fn volume_rate(
        &self,
        velocity: &[Vec3],
        wall_velocity: &[f64; 6],
        out: &mut [f64],
    ) -> Result<(), PfvError> {
        require_length("velocity", velocity.len(), self.spheres(), "spheres")?;
        require_length("out", out.len(), self.unknown_of.len(), "pores")?;
        self.evaluate_volume_rate(velocity, wall_velocity, out);
        Ok(())
    }

    /// Spreads the solution over all pores, imposed ones included (Pa).
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] when the solution has not one entry per unknown, or `out` not
    /// one per pore.
    pub fn pressures(&self, solution: &[f64], out: &mut [f64]) -> Result<(), PfvError> {
        require_length("solution", solution.len(), self.unknowns(), "unknowns")?;
        require_length("out", out.len(), self.unknown_of.len(), "pores")?;
        self.evaluate_pressures(solution, 0.0, out);
        Ok(())
    }

    /// `f = F p`: the fluid's force on each sphere and each wall (N).
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] when there is not one pressure per pore, or `spheres` has not
    /// one entry per sphere.
    pub fn forces(
        &self,
        pressure: &[f64],
        spheres: &mut [Vec3],
        walls: &mut [Vec3; 6],
    ) -> Result<(), PfvError> {
        require_length("pressure", pressure.len(), self.unknown_of.len(), "pores")?;
        require_length("spheres", spheres.len(), self.spheres(), "spheres")?;
        self.evaluate_forces(pressure, spheres, walls);
        Ok(())
    }

    /// Flux through each wall, positive into the box (m³/s).
    ///
    /// # Errors
    /// As [`Operators::write_flux`].
    pub fn flux(&self, pressure: &[f64], volume_rate: &[f64]) -> Result<[f64; 6], PfvError> {
        let mut flux = [0.0; 6];
        self.write_flux(pressure, volume_rate, &mut flux)?;
        Ok(flux)
    }

    /// Writes the flux from each set of pores with an imposed pressure, positive into the box
    /// (m³/s): through the walls, then from the sets beside them
    /// ([`PoreConditions`]); as many as `flux` has room for.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] when there is not one pressure and one volume rate per pore.
    pub fn write_flux(
        &self,
        pressure: &[f64],
        volume_rate: &[f64],
        flux: &mut [f64],
    ) -> Result<(), PfvError> {
        self.check_pores(pressure, volume_rate)?;
        self.evaluate_flux(pressure, volume_rate, flux);
        Ok(())
    }

    /// What enters from all sets less what the pores swallow, over the
    /// larger of the two (1): the flows from the sets without their signs,
    /// or the sum of the volume rates. Where the rates nearly cancel, a
    /// hundredth of their sum without signs counts. Zero when nothing flows.
    ///
    /// # Errors
    /// As [`Operators::write_flux`].
    pub fn imbalance(&self, pressure: &[f64], volume_rate: &[f64]) -> Result<f64, PfvError> {
        let mut flux = vec![0.0; self.conditions().sets()];
        self.write_flux(pressure, volume_rate, &mut flux)?;
        Ok(NetVolumeRate::of(volume_rate).imbalance(&flux))
    }

    /// What each free pore gains through its throats less what it swallows
    /// (m³/s), throat by throat: the difference of pressures comes first, so
    /// that a wide throat between pores of nearly one pressure does not drown
    /// the narrow ones, as it does in the rows of the assembled matrix.
    ///
    /// # Errors
    /// As [`Operators::write_flux`], and when `out` has not one entry per unknown.
    pub fn residual(
        &self,
        pressure: &[f64],
        volume_rate: &[f64],
        out: &mut [f64],
    ) -> Result<(), PfvError> {
        self.check_pores(pressure, volume_rate)?;
        require_length("out", out.len(), self.unknowns(), "unknowns")?;
        self.evaluate_residual(pressure, volume_rate, out);
        Ok(())
    }

    fn check_pores(&self, pressure: &[f64], volume_rate: &[f64]) -> Result<(), PfvError> {
        let pores = self.unknown_of.len();
        require_length("pressure", pressure.len(), pores, "pores")?;
        require_length("volume_rate", volume_rate.len(), pores, "pores")
    }
}

/// Refuses a network whose arrays have been changed so that they do not belong together.
fn check_network(network: &Network) -> Result<(), PfvError> {
    let (t, throats, pores) = (&network.tessellation, &network.throats, network.pores());
    for (argument, found) in [
        ("network.tessellation.neighbors", t.neighbors.len()),
        ("network.throat_of", network.throat_of.len()),
        ("network.center", network.center.len()),
        ("network.volume", network.volume.len()),
    ] {
        require_length(argument, found, pores, "pores")?;
    }
    let (found, expected) = (throats.conductance.len(), throats.pores.len());
    require_length("network.throats.conductance", found, expected, "throats")?;
    let below = |v: u32, end: usize| (v as usize) < end;
    let or_none = |v: u32, end: usize| v == NONE || below(v, end);
    let fits = |i: &usize| {
        t.cells[*i].iter().all(|&v| below(v, t.spheres + 6))
            && t.neighbors[*i].iter().all(|&j| or_none(j, pores))
            && network.throat_of[*i].iter().all(|&k| or_none(k, expected))
    };
    match (0..pores).find(|i| !fits(i)) {
        None => Ok(()),
        Some(pore) => {
            let problem = "names a sphere, a pore or a throat that there is not";
            Err(PfvError::invalid("network", pore, problem))
        }
    }
}
