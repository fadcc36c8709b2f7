//! A contact law of one's own: a linear spring without friction and with
//! viscous normal damping, F = k δ + c δ', in this one file.
//!
//! Run it with `cargo run --example custom_contact_law`; its tests run with
//! the library's.

use std::f64::consts::PI;

use dempfv::dem::law::vector::{dot, scaled};
use dempfv::dem::law::{Batch, ContactForce, ContactLaw, Geometry, Needs, Radii, Stiffness, put};
use dempfv::dem::{Dem, DemError, DemOptions, Material, Particles, WallMaterial};
use dempfv::{Aabb, Vec3};

/// Spring and dashpot along the normal.
#[derive(Clone, Copy, Debug)]
struct SpringDashpot {
    /// Damping constant c (N s/m).
    viscosity: f64,
}

/// The spring's constant follows from the materials.
#[derive(Clone, Copy, Debug)]
struct Spring {
    /// k over the reduced radius (Pa).
    modulus: f64,
}

impl ContactLaw for SpringDashpot {
    /// The dashpot's force in the last evaluation (N): velocities are not
    /// seen between two steps, so it is kept for the observer.
    type History = [f64; 1];
    type Parameters = Spring;
    type Scratch = ();

    fn name(&self) -> &'static str {
        "spring and dashpot"
    }

    fn between_spheres(&self, first: &Material, second: &Material) -> Spring {
        Spring { modulus: first.young + second.young }
    }

    fn on_wall(&self, sphere: &Material, wall: &WallMaterial) -> Spring {
        Spring { modulus: 2.0 * sphere.young * wall.young / (sphere.young + wall.young) }
    }

    fn needs(&self, _: &Spring) -> Needs {
        Needs::Motion
    }

    fn stiffness(&self, spring: &Spring, radii: impl Radii, _: f64) -> Stiffness {
        Stiffness { normal: radii.reduced(spring.modulus), shear: 0.0 }
    }

    fn force(
        &self,
        spring: &Spring,
        radii: impl Radii,
        overlap: f64,
        [dashpot]: &[f64; 1],
    ) -> ContactForce {
        let normal = radii.reduced(spring.modulus) * overlap + dashpot;
        ContactForce { normal, shear: Vec3::zeros() }
    }

    fn elastic_energy(
        &self,
        spring: &Spring,
        radii: impl Radii,
        overlap: f64,
        _: &[f64; 1],
    ) -> f64 {
        0.5 * radii.reduced(spring.modulus) * overlap.powi(2)
    }

    fn reversed(&self, history: [f64; 1]) -> [f64; 1] {
        history
    }

    #[inline(always)]
    fn evaluate<G: Geometry, const MOTION: bool, const TORQUES: bool>(
        &self,
        batch: &mut Batch<G, [f64; 1]>,
        (): &mut (),
        parameters: impl Fn(usize) -> Spring + Copy,
    ) {
        for l in batch.lanes() {
            let contact = &batch.geometry;
            let normal = contact.normal(l);
            let spring = contact.radii(l).reduced(parameters(l).modulus) * contact.overlap(l);
            let dashpot = -self.viscosity * dot(contact.velocity(l), normal);
            put(&mut batch.force, l, scaled(spring + dashpot, normal));
            batch.history[0][l] = dashpot;
        }
    }
}

const MATERIAL: Material =
    Material { young: 1e6, stiffness_ratio: 0.0, friction_angle: 0.0, density: 2600.0 };
const WALLS: WallMaterial = WallMaterial { young: 1e6, friction_angle: 0.0 };
const BOX: Aabb = Aabb { min: Vec3::new(0.0, 0.0, 0.0), max: Vec3::new(1.0, 1.0, 1.0) };
const RADIUS: f64 = 0.1;
const SPEED: f64 = 0.1;

/// A collision of the mass m (kg) against a spring k (N/m): the time step (s)
/// of which 2000 make its half period, and the dashpot (N s/m) of the damping
/// ratio 0.2.
fn collision(m: f64, k: f64) -> (f64, f64) {
    (PI * (m / k).sqrt() / 2000.0, 2.0 * 0.2 * (k * m).sqrt())
}

/// Speed after a collision over that before it, of a contact that ends when
/// the overlap does: exp(−π ζ / √(1 − ζ²)).
fn expected_restitution() -> f64 {
    let ratio: f64 = 0.2;
    (-PI * ratio / (1.0 - ratio * ratio).sqrt()).exp()
}

/// Restitution of two equal spheres that meet head on.
fn restitution_of_spheres() -> Result<f64, DemError> {
    let centres = vec![Vec3::new(0.399, 0.5, 0.5), Vec3::new(0.601, 0.5, 0.5)];
    let mut spheres = Particles::new(centres, vec![RADIUS; 2], MATERIAL.density);
    spheres.velocity[0].x = SPEED;
    spheres.velocity[1].x = -SPEED;
    let (dt, viscosity) = collision(0.5 * spheres.mass[0], MATERIAL.young * RADIUS);
    let law = SpringDashpot { viscosity };
    let mut dem = Dem::with_law(law, spheres, BOX, &[MATERIAL], WALLS, DemOptions::default())?;
    for _ in 0..10_000 {
        dem.step(dt)?;
    }
    assert_eq!(dem.contacts().count(), 0);
    Ok(dem.velocity(1).x / SPEED)
}

/// Restitution of a sphere that falls on a wall.
fn restitution_on_a_wall() -> Result<f64, DemError> {
    let centre = Vec3::new(0.5, RADIUS + 1e-3, 0.5);
    let mut spheres = Particles::new(vec![centre], vec![RADIUS], MATERIAL.density);
    spheres.velocity[0].y = -SPEED;
    let (dt, viscosity) = collision(spheres.mass[0], MATERIAL.young * RADIUS);
    let law = SpringDashpot { viscosity };
    let mut dem = Dem::with_law(law, spheres, BOX, &[MATERIAL], WALLS, DemOptions::default())?;
    for _ in 0..10_000 {
        dem.step(dt)?;
    }
    Ok(dem.velocity(0).y / SPEED)
}

fn main() -> Result<(), DemError> {
    println!("restitution, analytic  {:.4}", expected_restitution());
    println!("two spheres            {:.4}", restitution_of_spheres()?);
    println!("a sphere and a wall    {:.4}", restitution_on_a_wall()?);
    Ok(())
}

#[cfg(test)]
mod tests {
    use dempfv::WallId;

    use super::*;

    /// The leapfrog and the velocity half a step behind cost a share of
    /// ω Δt ≈ 1.6e-3 of the damping.
    #[test]
    fn restitution_is_the_analytic_one() {
        let expected = expected_restitution();
        for found in [restitution_of_spheres().unwrap(), restitution_on_a_wall().unwrap()] {
            assert!((found / expected - 1.0).abs() < 2e-3, "{found} {expected}");
        }
    }

    /// A sphere between two walls that come together: an observer sees the
    /// spring and the dashpot, and a restart in the middle of it changes no
    /// bit; the linear law refuses the state.
    #[test]
    fn histories_of_any_length_survive_lists_and_restarts() {
        let law = SpringDashpot { viscosity: 50.0 };
        let centres = (0..4).map(|k| Vec3::new(0.1 + 0.19 * f64::from(k), 0.5, 0.5)).collect();
        let spheres = Particles::new(centres, vec![RADIUS; 4], MATERIAL.density);
        let options = DemOptions { skin: 1e-3, ..DemOptions::default() };
        let mut dem = Dem::with_law(law, spheres, BOX, &[MATERIAL], WALLS, options).unwrap();
        dem.set_velocity(1, Vec3::new(0.3, 0.01, 0.0));
        for _ in 0..200 {
            dem.step(1e-4).unwrap();
        }
        let state = dem.state();
        assert!(state.sphere_history.numbers.iter().any(|f| *f != 0.0));
        assert_eq!(state.sphere_history.numbers.len(), state.sphere_history.bodies.len());
        let error = Dem::from_state(state.clone(), MATERIAL, WALLS, options).unwrap_err();
        assert!(error.to_string().contains("`spring and dashpot`"), "{error}");

        let mut again = Dem::with_law_from_state(law, state, &[MATERIAL], WALLS, options).unwrap();
        for dem in [&mut dem, &mut again] {
            for _ in 0..200 {
                dem.step(1e-4).unwrap();
            }
            dem.compute_contacts().unwrap();
        }
        assert_eq!(dem.state(), again.state());
        let wall: f64 = (dem.contacts())
            .filter(|c| c.partner == dempfv::dem::Partner::Wall(WallId::XMin))
            .map(|c| c.normal_force)
            .sum();
        assert!((wall + dem.wall_force()[WallId::XMin].x).abs() < 1e-9, "{wall}");
    }
}
