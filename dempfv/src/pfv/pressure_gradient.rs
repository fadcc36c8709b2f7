//! A mean pressure gradient through a periodic cell.
//!
//! The pressure is p + G·x with p the same in all copies of a pore: that of [`Flow::pressure`]. A
//! throat feels p_j − p_i + G·l, l the way from the one centre to the other of the copy that it leads
//! to. So the known part makes a source in each pore, of which the sum is zero, and a force on each
//! sphere: F (p + G·(c − x)), c the centres of the pores around it as they lie around it.

use super::gradient_load::GradientLoad;
use super::terms::FluidTerm;
use super::{Flow, Network, PfvError};
use crate::{Effect, EffectKey, Family, Tensor, Vec3};

/// What this effect says of itself.
pub const EFFECT: Effect = Effect {
    name: GradientFlow::NAME,
    family: Family::Fluid,
    equation: "Σ_j g_ij (p_j − p_i + G·l_ij) = dV_i/dt, f = F (p + G·(c − x)), Σ f = −G V; \
               U = (1/V) Σ g_ij (p_i − p_j − G·l_ij) l_ij",
    source: "a periodic pressure beside a linear one; the flow in a cell as in G. Allaire 1989 (homogenization of \
             Stokes flow)",
    keys: &[EffectKey { key: "pressure_gradient in [fluid]", unit: "Pa/m", default: "0" }],
    needs: "a periodic cell",
    test: "dempfv/tests/pfv_cell.rs, dempfv/tests/coupling_cell.rs",
};

/// What flows into each pore by the mean gradient (m³/s).
#[derive(Debug)]
struct GradientFlow {
    inflow: Vec<f64>,
}

impl GradientFlow {
    const NAME: &str = "pressure gradient";

    fn new(network: &Network, ways: &[Vec3], gradient: Vec3) -> GradientFlow {
        let mut inflow = vec![0.0; network.pores()];
        let throats = network.throats.pores.iter().zip(&network.throats.conductance);
        for ((&[i, j], g), way) in throats.zip(ways) {
            let flux = g * gradient.dot(way);
            inflow[i as usize] += flux;
            inflow[j as usize] -= flux;
        }
        GradientFlow { inflow }
    }
}

impl FluidTerm for GradientFlow {
    fn name(&self) -> &'static str {
        GradientFlow::NAME
    }

    fn add_uptake(&self, uptake: &mut [f64]) {
        uptake.iter_mut().zip(&self.inflow).for_each(|(u, inflow)| *u -= inflow);
    }
}

impl Flow {
    /// Imposes a mean pressure gradient (Pa/m) on the flow through a periodic cell, in the place of
    /// an earlier one: the fluid flows against it. From the next solve on.
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] for one that is not finite, and for a network between walls.
    pub fn set_pressure_gradient(&mut self, gradient: Vec3) -> Result<(), PfvError> {
        let wrong = |problem: String| {
            Err(PfvError::InvalidInput { argument: "gradient", index: None, problem })
        };
        if !gradient.iter().all(|g| g.is_finite()) {
            let [x, y, z] = gradient.into();
            return wrong(format!("({x}, {y}, {z}) Pa/m is not finite"));
        }
        let Flow { network, operators, terms, gradient: load, .. } = self;
        let Some(periodic) = network.periodic() else {
            return wrong("is given between walls, whose pressures make one".to_owned());
        };
        if gradient == Vec3::zeros() {
            terms.remove(GradientFlow::NAME);
            *load = GradientLoad::default();
            return Ok(());
        }
        terms.set(Box::new(GradientFlow::new(network, &periodic.way, gradient)));
        let cells = &network.tessellation.cells;
        let arm = |pore: u32, sphere: usize| {
            let corner = cells[pore as usize].iter().position(|&v| v as usize == sphere);
            periodic.arm[pore as usize][corner.unwrap_or(0)]
        };
        let forces = &operators.forces;
        let force = |sphere: usize| {
            let around = forces.pores.of(sphere).iter();
            let coefficients = &forces.coefficient[forces.pores.range(sphere)];
            around.zip(coefficients).fold(Vec3::zeros(), |sum, (&pore, per_pa)| {
                sum + gradient.dot(&arm(pore, sphere)) * per_pa
            })
        };
        let throats = periodic.way.iter().zip(&network.throats.conductance);
        let through = throats.map(|(way, g)| (g * gradient.dot(way)).abs()).sum();
        let force = (0..operators.spheres()).map(force).collect();
        *load = GradientLoad { gradient, through, force };
        Ok(())
    }

    /// The mean pressure gradient (Pa/m) of a periodic cell; zero between walls.
    pub fn pressure_gradient(&self) -> Vec3 {
        self.gradient.gradient
    }

    /// Shares the force that the mean gradient puts on all spheres together, −G V, out to their masses
    /// (kg), the other way: the forces are then those in the frame that goes with the spheres'
    /// centre of mass, which nothing holds in a periodic cell. To be called after
    /// [`Flow::set_pressure_gradient`].
    ///
    /// # Errors
    /// [`PfvError::InvalidInput`] for masses that are not one per sphere, or of which the sum is not
    /// positive and finite.
    pub fn move_with_spheres(&mut self, mass: &[f64]) -> Result<(), PfvError> {
        self.require_one_per_sphere("mass", mass.len())?;
        let whole: f64 = mass.iter().sum();
        if !(whole > 0.0 && whole.is_finite()) {
            let problem = format!("{whole} kg in all; it must be positive and finite");
            return Err(PfvError::InvalidInput { argument: "mass", index: None, problem });
        }
        let volume = self.network.periodic().map_or(0.0, |periodic| periodic.cell.volume());
        let acceleration = self.gradient.gradient * (volume / whole);
        let forces = self.gradient.force.iter_mut().zip(mass);
        forces.for_each(|(force, mass)| *force += *mass * acceleration);
        Ok(())
    }

    /// Mean velocity of the fluid through a periodic cell, over its whole area (Darcy's), relative to
    /// the spheres at rest (m/s), of the last solve; `None` between walls.
    pub fn mean_velocity(&self) -> Option<Vec3> {
        let periodic = self.network.periodic()?;
        let throats = self.network.throats.pores.iter().zip(&self.network.throats.conductance);
        let pressure = self.pressure();
        let flow = throats.zip(&periodic.way).fold(Vec3::zeros(), |sum, ((&[i, j], g), way)| {
            let drop = pressure[i as usize] - pressure[j as usize];
            sum + g * (drop - self.pressure_gradient().dot(way)) * way
        });
        Some(flow / periodic.cell.volume())
    }

    /// Permeability of a periodic cell (m²): K of U = −K G / μ, from one solve for each axis with
    /// spheres at rest. The gradient is then what it was, and waits for the next solve. `None` between
    /// walls.
    ///
    /// # Errors
    /// As [`Flow::solve_static`].
    pub fn permeability_tensor(&mut self) -> Result<Option<Tensor>, PfvError> {
        if self.network.periodic().is_none() {
            return Ok(None);
        }
        let before = self.pressure_gradient();
        let mut permeability = Tensor::zeros();
        for axis in 0..3 {
            self.set_pressure_gradient(Vec3::ith(axis, 1.0))?;
            self.solve_static()?;
            let velocity = self.mean_velocity().unwrap_or_default();
            permeability.set_column(axis, &(-self.fluid.viscosity * velocity));
        }
        self.set_pressure_gradient(before)?;
        Ok(Some(permeability))
    }
}
