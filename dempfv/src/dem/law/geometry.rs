//! How two bodies meet: a sphere and a sphere, or a sphere and a wall. A law
//! is written once and compiled for both.

use super::batch::{Lane, ZERO_LANE, get, put};
use super::vector::{Vector, add_scaled, cross, dot, scaled, tangential};

/// The radii of the two surfaces in a contact.
pub trait Radii: Copy {
    /// `factor` times the reduced radius r₁ r₂ / (r₁ + r₂), which is r for a
    /// sphere of radius r on a plane (m).
    fn reduced(self, factor: f64) -> f64;

    /// The reduced mass m₁ m₂ / (m₁ + m₂) of spheres of these densities (kg/m³), which is m on a
    /// wall: what each of two free spheres has against the other (kg).
    fn reduced_mass(self, densities: [f64; 2]) -> f64;

    /// The smaller radius (m).
    fn smaller(self) -> f64;
}

/// Mass of a sphere (kg).
#[inline(always)]
fn mass(density: f64, radius: f64) -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * density * (radius * radius * radius)
}

/// The radii of two spheres (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoSpheres(pub f64, pub f64);

/// The radius of a sphere on a plane (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereOnPlane(pub f64);

impl Radii for TwoSpheres {
    #[inline(always)]
    fn reduced(self, factor: f64) -> f64 {
        let TwoSpheres(r1, r2) = self;
        factor * r1 * r2 / (r1 + r2)
    }

    #[inline(always)]
    fn reduced_mass(self, densities: [f64; 2]) -> f64 {
        let (m1, m2) = (mass(densities[0], self.0), mass(densities[1], self.1));
        m1 * m2 / (m1 + m2)
    }

    #[inline(always)]
    fn smaller(self) -> f64 {
        self.0.min(self.1)
    }
}

impl Radii for SphereOnPlane {
    #[inline(always)]
    fn reduced(self, factor: f64) -> f64 {
        factor * self.0
    }

    #[inline(always)]
    fn reduced_mass(self, densities: [f64; 2]) -> f64 {
        mass(densities[0], self.0)
    }

    #[inline(always)]
    fn smaller(self) -> f64 {
        self.0
    }
}

/// How a contact moved during the last step.
#[derive(Clone, Copy, Debug)]
pub struct Sliding {
    /// Unit normal now.
    pub normal: Vector,
    /// Half the change of the normal during the step.
    pub half_turn: Vector,
    /// Mean rotation of the two bodies about the normal during the step (rad).
    pub twist: f64,
    /// Relative tangential displacement of the second body at the contact (m).
    pub slip: Vector,
}

/// The geometry of the contacts of a batch.
pub trait Geometry {
    /// What bounds the two bodies.
    type Radii: Radii;

    /// Radii of contact `l`.
    fn radii(&self, l: usize) -> Self::Radii;

    /// Unit normal of contact `l` from the first body to the second.
    fn normal(&self, l: usize) -> Vector;

    /// Depth by which the bodies of contact `l` overlap (m); negative where
    /// they do not touch, which only a law with a cut-off meets.
    fn overlap(&self, l: usize) -> f64;

    /// The same before the last step, of `dt` (s). Only where the law asked for the motion.
    fn overlap_before(&self, l: usize, dt: f64) -> f64;

    /// Velocity of the second body's centre, or of the wall, relative to the
    /// first's centre (m/s). Only where the law asked for the motion.
    fn velocity(&self, l: usize) -> Vector;

    /// How contact `l` moved during a step of `dt` (s). With `TORQUES` the
    /// bodies' spins count. Only where the law asked for the motion.
    fn sliding<const TORQUES: bool>(&self, l: usize, dt: f64) -> Sliding;

    /// Velocity of the second body relative to the first at the contact, across the normal (m/s).
    /// With `TORQUES` the bodies' spins count. Only where the law asked for the motion.
    fn slip_velocity<const TORQUES: bool>(&self, l: usize) -> Vector;

    /// Spin of the first body relative to the second (rad/s); a wall does not turn. Only where the
    /// law asked for torques.
    fn relative_spin(&self, l: usize) -> Vector;

    /// Distance of the contact point from each centre (m): the middle of the
    /// overlap. A wall does not turn: 0.
    fn arms(&self, l: usize) -> [f64; 2];
}

/// Contacts of spheres with spheres. Arrays of two hold the first's and the
/// second's.
#[derive(Debug)]
pub struct SpherePairs {
    /// Vector from the first centre to the second (m).
    pub(in crate::dem) apart: [Lane; 3],
    /// Radii (m).
    pub(in crate::dem) radius: [Lane; 2],
    /// Velocity of the second sphere relative to the first (m/s).
    pub(in crate::dem) velocity: [Lane; 3],
    /// Spins (rad/s).
    pub(in crate::dem) spin: [[Lane; 3]; 2],
    normal: [Lane; 3],
    /// 1 / distance (1/m)
    inverse: Lane,
    overlap: Lane,
}

impl Default for SpherePairs {
    fn default() -> SpherePairs {
        SpherePairs {
            apart: [ZERO_LANE; 3],
            radius: [ZERO_LANE; 2],
            velocity: [ZERO_LANE; 3],
            spin: [[ZERO_LANE; 3]; 2],
            normal: [ZERO_LANE; 3],
            inverse: ZERO_LANE,
            overlap: ZERO_LANE,
        }
    }
}

impl SpherePairs {
    /// Normal and overlap of contact `l`.
    #[inline(always)]
    pub(in crate::dem) fn measure(&mut self, l: usize) {
        let (r1, r2) = (self.radius[0][l], self.radius[1][l]);
        let apart = get(&self.apart, l);
        let distance = dot(apart, apart).sqrt();
        let inverse = 1.0 / distance;
        put(&mut self.normal, l, scaled(inverse, apart));
        self.inverse[l] = inverse;
        self.overlap[l] = (r1 + r2) - distance;
    }
}

impl Geometry for SpherePairs {
    type Radii = TwoSpheres;

    #[inline(always)]
    fn radii(&self, l: usize) -> TwoSpheres {
        TwoSpheres(self.radius[0][l], self.radius[1][l])
    }

    #[inline(always)]
    fn normal(&self, l: usize) -> Vector {
        get(&self.normal, l)
    }

    #[inline(always)]
    fn overlap(&self, l: usize) -> f64 {
        self.overlap[l]
    }

    #[inline(always)]
    fn overlap_before(&self, l: usize, dt: f64) -> f64 {
        let apart = add_scaled(get(&self.apart, l), -dt, get(&self.velocity, l));
        (self.radius[0][l] + self.radius[1][l]) - dot(apart, apart).sqrt()
    }

    #[inline(always)]
    fn velocity(&self, l: usize) -> Vector {
        get(&self.velocity, l)
    }

    #[inline(always)]
    fn sliding<const TORQUES: bool>(&self, l: usize, dt: f64) -> Sliding {
        let normal = get(&self.normal, l);
        let velocity = get(&self.velocity, l);
        let across = tangential(velocity, normal);
        let half_turn = scaled(0.5 * dt * self.inverse[l], across);
        let mut motion = Sliding { normal, half_turn, twist: 0.0, slip: scaled(dt, across) };
        if TORQUES {
            let (a, b) = (get(&self.spin[0], l), get(&self.spin[1], l));
            let (r1, r2) = (self.radius[0][l], self.radius[1][l]);
            let spin = add_scaled(a, 1.0, b);
            // Σ arm ω with the arms r − overlap/2
            let rim = add_scaled(scaled(r1, a), r2, b);
            let rim = add_scaled(rim, -0.5 * self.overlap[l], spin);
            // The normal half way: a contact that only turns must not slip.
            let middle = add_scaled(normal, -1.0, half_turn);
            let slip = add_scaled(velocity, -1.0, cross(rim, middle));
            motion.twist = 0.5 * dt * dot(spin, normal);
            motion.slip = scaled(dt, tangential(slip, normal));
        }
        motion
    }

    #[inline(always)]
    fn slip_velocity<const TORQUES: bool>(&self, l: usize) -> Vector {
        let (normal, mut velocity) = (self.normal(l), self.velocity(l));
        if TORQUES {
            let [first, second] = self.arms(l);
            let rim = scaled(first, get(&self.spin[0], l));
            let rim = add_scaled(rim, second, get(&self.spin[1], l));
            velocity = add_scaled(velocity, -1.0, cross(rim, normal));
        }
        tangential(velocity, normal)
    }

    #[inline(always)]
    fn relative_spin(&self, l: usize) -> Vector {
        add_scaled(get(&self.spin[0], l), -1.0, get(&self.spin[1], l))
    }

    #[inline(always)]
    fn arms(&self, l: usize) -> [f64; 2] {
        let half = 0.5 * self.overlap[l];
        [self.radius[0][l] - half, self.radius[1][l] - half]
    }
}

/// Contacts of spheres with walls, which move along their normals only. The
/// wall is the second body.
#[derive(Debug)]
pub struct SpheresOnWalls {
    /// Radius of the sphere (m).
    pub(in crate::dem) radius: Lane,
    /// Unit normal from the sphere to the wall.
    pub(in crate::dem) normal: [Lane; 3],
    /// Depth of the overlap (m).
    pub(in crate::dem) overlap: Lane,
    /// Velocity of the wall relative to the sphere (m/s).
    pub(in crate::dem) velocity: [Lane; 3],
    /// Spin of the sphere (rad/s).
    pub(in crate::dem) spin: [Lane; 3],
}

impl Default for SpheresOnWalls {
    fn default() -> SpheresOnWalls {
        SpheresOnWalls {
            radius: ZERO_LANE,
            normal: [ZERO_LANE; 3],
            overlap: ZERO_LANE,
            velocity: [ZERO_LANE; 3],
            spin: [ZERO_LANE; 3],
        }
    }
}

impl Geometry for SpheresOnWalls {
    type Radii = SphereOnPlane;

    #[inline(always)]
    fn radii(&self, l: usize) -> SphereOnPlane {
        SphereOnPlane(self.radius[l])
    }

    #[inline(always)]
    fn normal(&self, l: usize) -> Vector {
        get(&self.normal, l)
    }

    #[inline(always)]
    fn overlap(&self, l: usize) -> f64 {
        self.overlap[l]
    }

    #[inline(always)]
    fn overlap_before(&self, l: usize, dt: f64) -> f64 {
        self.overlap[l] + dt * dot(get(&self.velocity, l), get(&self.normal, l))
    }

    #[inline(always)]
    fn velocity(&self, l: usize) -> Vector {
        get(&self.velocity, l)
    }

    #[inline(always)]
    fn sliding<const TORQUES: bool>(&self, l: usize, dt: f64) -> Sliding {
        let normal = get(&self.normal, l);
        let velocity = get(&self.velocity, l);
        // The normal is an axis: the part across has no component along it.
        let across = std::array::from_fn(|k| if normal[k] != 0.0 { 0.0 } else { velocity[k] });
        let mut motion =
            Sliding { normal, half_turn: [0.0; 3], twist: 0.0, slip: scaled(dt, across) };
        if TORQUES {
            let spin = get(&self.spin, l);
            let [arm, _] = self.arms(l);
            motion.twist = 0.5 * dt * dot(spin, normal);
            motion.slip = add_scaled(motion.slip, -dt * arm, cross(spin, normal));
        }
        motion
    }

    #[inline(always)]
    fn slip_velocity<const TORQUES: bool>(&self, l: usize) -> Vector {
        let (normal, mut velocity) = (self.normal(l), self.velocity(l));
        if TORQUES {
            let [arm, _] = self.arms(l);
            velocity = add_scaled(velocity, -arm, cross(get(&self.spin, l), normal));
        }
        tangential(velocity, normal)
    }

    #[inline(always)]
    fn relative_spin(&self, l: usize) -> Vector {
        get(&self.spin, l)
    }

    #[inline(always)]
    fn arms(&self, l: usize) -> [f64; 2] {
        [self.radius[l] - 0.5 * self.overlap[l], 0.0]
    }
}
