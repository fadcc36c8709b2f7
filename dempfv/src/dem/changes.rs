//! Changes of a system under way: friction, damping, sizes.

use super::error::DemError;
use super::law::Needs;
use super::material::{Material, MaterialPair, check_friction, positive};
use super::system::{Dem, DemOptions};

impl Dem {
    /// Changes the friction angle between spheres (rad), whatever their material.
    ///
    /// # Errors
    /// [`DemError::Parameter`] for an angle that is not from 0 to less than π/2.
    pub fn set_friction(&mut self, angle: f64) -> Result<(), DemError> {
        check_friction(angle)?;
        for material in &mut self.materials {
            material.friction_angle = angle;
        }
        for pair in &mut self.pairs {
            pair.friction_angle = None;
        }
        self.renew_table();
        Ok(())
    }

    /// Changes what the spheres are made of, and what pairs of materials have against each other. Masses
    /// stay.
    ///
    /// # Errors
    /// [`DemError::NumberOfMaterials`] for another number of materials, [`DemError::Parameter`] for
    /// values that make no sense.
    pub fn set_materials(
        &mut self,
        materials: &[Material],
        pairs: &[MaterialPair],
    ) -> Result<(), DemError> {
        if materials.len() != self.materials.len() {
            return Err(DemError::NumberOfMaterials { found: materials.len() });
        }
        materials.iter().try_for_each(Material::check)?;
        pairs.iter().try_for_each(|pair| pair.check(materials))?;
        self.materials = materials.to_vec();
        self.pairs = pairs.to_vec();
        self.renew_table();
        self.look_at_sizes();
        Ok(())
    }

    /// Makes the table of contacts anew.
    fn renew_table(&mut self) {
        self.law.set_materials((&self.materials, &self.pairs), &self.wall_material);
        // A pass that needs overlaps alone does not look at the history.
        if self.law.pair_needs() == Needs::Overlap {
            self.list.history.fill(0.0);
        }
        if self.law.wall_needs() == Needs::Overlap {
            self.list.wall_history.fill(0.0);
        }
    }

    /// Changes the local damping λ.
    ///
    /// # Errors
    /// [`DemError::Parameter`] for a value that is not from 0 to less than 1.
    pub fn set_damping(&mut self, damping: f64) -> Result<(), DemError> {
        let options = DemOptions { damping, ..self.options };
        options.check()?;
        self.options = options;
        Ok(())
    }

    /// Multiplies all radii by `factor` and all masses by its cube. Energy that is tracked
    /// ([`Dem::track_energy`]) is tracked anew.
    ///
    /// # Errors
    /// [`DemError::Parameter`] for a factor that is not positive, or that makes
    /// a radius or a mass too large or too small for double precision.
    pub fn scale_radii(&mut self, factor: f64) -> Result<(), DemError> {
        positive("radius factor", factor)?;
        let mass_factor = factor.powi(3);
        let p = &mut self.particles;
        let stays = |values: &[f64], factor: f64| values.iter().all(|v| (v * factor).is_normal());
        if !(stays(&p.radius, factor) && stays(&p.mass, mass_factor)) {
            let expected = "so near to 1 that radii and masses remain positive and finite";
            return Err(DemError::Parameter { name: "radius factor", value: factor, expected });
        }
        for ((r, m), c) in p.radius.iter_mut().zip(&mut p.mass).zip(&mut self.centre) {
            *r *= factor;
            *m *= mass_factor;
            c[3] = *r;
        }
        let Dem { held, particles, centre, .. } = self;
        held.clumps.scale(factor, particles, centre);
        self.list.resized();
        if self.tracks_energy() {
            self.track_energy(true);
        }
        Ok(())
    }
}
