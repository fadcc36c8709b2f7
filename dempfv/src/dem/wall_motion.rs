//! How walls move in a step.

use super::compiled::Surfaces;
use super::error::{DemError, Leaving};
use super::law::SphereOnPlane;
use super::material::Material;
use super::servo::shifts;
use super::system::Dem;
use super::walls::{Nearest, Wall, WallControl, WallSituation, check_box};
use crate::{Effect, EffectKey, Family};
use crate::{PerWall, Vec3, WallId};

/// What this effect says of itself.
pub const MOVING_WALLS: Effect = Effect {
    name: "moving walls",
    family: Family::Boundaries,
    equation: "dx/dt = v along the normal",
    source: "",
    keys: &[EffectKey {
        key: "velocity of a wall in a run stage",
        unit: "m/s",
        default: "at rest",
    }],
    needs: "",
    test: "dempfv/tests/dem_walls.rs",
};

impl Dem {
    pub(super) fn move_walls(
        &mut self,
        dt: f64,
        fluid: Option<&PerWall<Vec3>>,
    ) -> Result<(), DemError> {
        let box_ = self.box_();
        let size = box_.size();
        let loads = PerWall::from_fn(|wall| {
            let axis = wall.axis();
            let force = self.wall_sums[wall].force[axis] + fluid.map_or(0.0, |f| f[wall][axis]);
            // A dashpot feels the shift of one step as a speed.
            let stiffness = self.wall_sums[wall].stiffness + self.wall_sums[wall].dashpot / dt;
            let servo = matches!(self.walls[wall].control, WallControl::Servo { .. });
            let situation = WallSituation {
                outward: -wall.inward() * force,
                stiffness,
                per_shift: self.wall_resistance[wall][wall] / dt,
                area: box_.wall_area(wall),
                axis_share: 3.0 * size[axis] / size.sum(),
                density: self.softest.density,
                young: self.softest.young,
                smallest_radius: self.smallest_radius,
                nearest: (servo && stiffness == 0.0).then(|| self.nearest(wall)).flatten(),
            };
            self.walls[wall].servo_load(dt, &situation)
        });
        let shifts = shifts(&loads, &self.wall_resistance, dt);
        for wall in WallId::ALL {
            if let Some(load) = &loads[wall] {
                let touched = self.wall_sums[wall].stiffness > 0.0;
                let wet = self.wall_resistance[wall][wall] > 0.0;
                let area = box_.wall_area(wall);
                self.walls[wall].remember(load, shifts[wall], area, (touched, wet));
            }
            self.walls[wall].advance(wall, dt, shifts[wall]);
        }
        check_box(&self.box_())
    }

    /// The sphere with its surface nearest to a wall.
    fn nearest(&self, wall: WallId) -> Option<Nearest> {
        let position = self.walls[wall].position;
        let distance = |c: &[f64; 4]| (c[wall.axis()] - position) * wall.inward() - c[3];
        let all = self.centre.iter().map(distance).enumerate();
        let (i, distance) = all.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let radius = self.particles.radius[i];
        let surfaces = Surfaces::Wall(SphereOnPlane(radius), self.particles.material_of(i));
        let stiffness = self.law.stiffness(&self.law.expected(surfaces, radius, 0.0)).normal;
        Some(Nearest { distance, radius, stiffness })
    }

    /// Takes the smallest radius and the softest material: that in which a blow puts up the least
    /// stress, the first of several.
    pub(super) fn look_at_sizes(&mut self) {
        let p = &self.particles;
        self.smallest_radius = p.radius.iter().copied().fold(f64::INFINITY, f64::min);
        let impedance2 = |m: &Material| m.density * m.young;
        let all = p.material.iter().map(|&m| &self.materials[usize::from(m)]);
        let softest = all.min_by(|a, b| impedance2(a).total_cmp(&impedance2(b)));
        self.softest = *softest.unwrap_or(&self.materials[0]);
    }

    /// With the motion of a sphere that has left the box in the last step.
    pub(super) fn explained(&self, error: DemError) -> DemError {
        let DemError::OutsideBox { particle, wall } = error else { return error };
        let place = self.place[particle as usize] as usize;
        let (p, Wall { velocity, control, .. }) = (&self.particles, &self.walls[wall]);
        let own = p.velocity[place][wall.axis()];
        let speed = (own - velocity).abs();
        let radii = speed * self.pending_dt / p.radius[place];
        let cause = match (radii > FAST, velocity.abs() > own.abs(), control) {
            (true, true, WallControl::Servo { .. }) => Leaving::FastServo,
            (true, true, _) => Leaving::FastWall,
            (true, false, _) => Leaving::FastSphere,
            (false, ..) => Leaving::Pressed,
        };
        DemError::LeftBox { particle, wall, speed, radii, cause: Some(cause) }
    }
}

/// Travel in a step, in radii, from which on a contact can be missed.
const FAST: f64 = 0.1;
