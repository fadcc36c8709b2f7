//! Mass, centre and inertia of a union of spheres.

use std::f64::consts::PI;

use crate::{Tensor, Vec3};

/// A member as the shape needs it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    /// Centre (m) and radius (m).
    pub centre: Vec3,
    pub radius: f64,
    /// Mass of the whole sphere (kg).
    pub mass: f64,
}

/// Mass properties of a rigid body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    pub mass: f64,
    pub centre: Vec3,
    /// About the centre (kg m²).
    pub inertia: Tensor,
    /// Volume (m³).
    pub volume: f64,
}

/// Moments of a body of revolution: mass and volume, centre, inertia along its axis and across it
/// about that centre.
struct Revolved {
    mass: f64,
    volume: f64,
    centre: Vec3,
    axis: Vec3,
    along: f64,
    across: f64,
}

impl Ball {
    fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.radius.powi(3)
    }

    fn whole(&self) -> Revolved {
        let moment = 0.4 * self.mass * self.radius.powi(2);
        Revolved {
            mass: self.mass,
            volume: self.volume(),
            centre: self.centre,
            axis: Vec3::x(),
            along: moment,
            across: moment,
        }
    }
}

/// Volume of a spherical cap of `height` (m), distance of its centroid from the sphere's centre, and
/// its moments per density along the axis and across it, about the sphere's centre.
fn cap(radius: f64, height: f64) -> [f64; 4] {
    let from = radius - height;
    // ∫ π (R² − z²) zⁿ dz from R − h to R.
    let power = |n: i32| (radius.powi(n) - from.powi(n)) / f64::from(n);
    let r2 = radius * radius;
    let volume = PI * (r2 * power(1) - power(3));
    let first = PI * (r2 * power(2) - power(4));
    let second = PI * (r2 * power(3) - power(5));
    // ∫ π/2 (R² − z²)² dz
    let along = 0.5 * PI * (r2 * r2 * power(1) - 2.0 * r2 * power(3) + power(5));
    [volume, first / volume, along, 0.5 * along + second]
}

/// What two balls share, if they overlap: of the mean of their densities, counted negative.
fn lens(a: &Ball, b: &Ball) -> Option<Revolved> {
    let apart = b.centre - a.centre;
    let distance = apart.norm();
    if distance >= a.radius + b.radius {
        return None;
    }
    let density = 0.5 * (a.mass / a.volume() + b.mass / b.volume());
    let (small, large) = if a.radius < b.radius { (a, b) } else { (b, a) };
    if distance <= large.radius - small.radius {
        let scale = density * small.volume() / small.mass;
        let Revolved { mass, volume, centre, axis, along, across } = small.whole();
        let [mass, along, across] = [mass, along, across].map(|x| -scale * x);
        return Some(Revolved { mass, volume: -volume, centre, axis, along, across });
    }
    let axis = apart / distance;
    // The plane in which the two surfaces cross.
    let plane = 0.5 * (distance + (a.radius.powi(2) - b.radius.powi(2)) / distance);
    let of_a = cap(a.radius, a.radius - plane);
    let of_b = cap(b.radius, b.radius - (distance - plane));
    let volume = of_a[0] + of_b[0];
    let along = of_a[2] + of_b[2];
    // The centroid, from a's centre, and the moments across about it.
    let middle = (of_a[0] * of_a[1] + of_b[0] * (distance - of_b[1])) / volume;
    let about_middle = |[volume, centroid, _, across]: [f64; 4], away: f64| {
        across - volume * centroid * centroid + volume * away * away
    };
    let across =
        about_middle(of_a, of_a[1] - middle) + about_middle(of_b, distance - of_b[1] - middle);
    Some(Revolved {
        mass: -density * volume,
        volume: -volume,
        centre: a.centre + middle * axis,
        axis,
        along: -density * along,
        across: -density * across,
    })
}

/// Whether three of the balls may share a volume: whether each two of them do.
fn three_overlap(balls: &[Ball]) -> bool {
    let meet = |a: &Ball, b: &Ball| (a.centre - b.centre).norm() < a.radius + b.radius;
    balls.iter().enumerate().any(|(i, a)| {
        let with_a: Vec<&Ball> = balls[i + 1..].iter().filter(|b| meet(a, b)).collect();
        with_a.iter().enumerate().any(|(j, b)| with_a[j + 1..].iter().any(|c| meet(b, c)))
    })
}

/// The union of balls, of which each two may overlap and no three: the balls less the lenses that two
/// share, exactly. `None` where three do.
pub(super) fn union(balls: &[Ball]) -> Option<Shape> {
    if three_overlap(balls) {
        return None;
    }
    let pairs = balls.iter().enumerate();
    let lenses = pairs.flat_map(|(i, a)| balls[i + 1..].iter().filter_map(|b| lens(a, b)));
    let parts: Vec<Revolved> = balls.iter().map(Ball::whole).chain(lenses).collect();
    let mass: f64 = parts.iter().map(|p| p.mass).sum();
    let volume = parts.iter().map(|p| p.volume).sum();
    let origin = balls.first()?.centre;
    let moment: Vec3 = parts.iter().map(|p| p.mass * (p.centre - origin)).sum();
    let centre = origin + moment / mass;
    let about_centre = |p: &Revolved| {
        let away = p.centre - centre;
        let steiner = p.mass * (away.norm_squared() * Tensor::identity() - away * away.transpose());
        let axis = p.axis * p.axis.transpose();
        p.across * (Tensor::identity() - axis) + p.along * axis + steiner
    };
    Some(Shape { mass, centre, inertia: parts.iter().map(about_centre).sum(), volume })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ball(x: f64, radius: f64) -> Ball {
        let mass = 4.0 / 3.0 * PI * radius.powi(3) * 3.0;
        Ball { centre: Vec3::new(x, 0.2, -0.3), radius, mass }
    }

    /// Three balls in a row, of which neighbours overlap: volume, centre and moments of the body of
    /// revolution by Simpson's rule over its cross-sections.
    #[test]
    fn overlapping_balls_count_once() {
        let balls = [ball(0.0, 1.0), ball(1.3, 0.7), ball(2.1, 0.5)];
        let shape = union(&balls).unwrap();
        let steps = 2_000_000;
        let (from, to) = (-1.0, 2.6);
        let h = (to - from) / f64::from(steps);
        let mut sums = [0.0; 5];
        for k in 0..=steps {
            let x = from + h * f64::from(k);
            let area2 = |b: &Ball| b.radius.powi(2) - (x - b.centre.x).powi(2);
            let r2 = balls.iter().map(area2).fold(0.0, f64::max);
            let weight = if k == 0 || k == steps { 1.0 } else { 2.0 + 2.0 * f64::from(k % 2) };
            let w = weight * h / 3.0 * PI * 3.0;
            for (sum, term) in sums.iter_mut().zip([r2, r2 * x, r2 * x * x, r2 * r2, 0.0]) {
                *sum += w * term;
            }
        }
        let [mass, first, second, quartic, _] = sums;
        assert!((shape.mass / mass - 1.0).abs() < 1e-9, "{} {mass}", shape.mass);
        assert!((shape.volume * 3.0 / mass - 1.0).abs() < 1e-9);
        let middle = first / mass;
        assert!((shape.centre - Vec3::new(middle, 0.2, -0.3)).norm() < 1e-9, "{}", shape.centre);
        let (along, across) = (0.5 * quartic, 0.25 * quartic + second - mass * middle * middle);
        let expected = Tensor::from_diagonal(&Vec3::new(along, across, across));
        assert!((shape.inertia - expected).norm() < 1e-8 * across, "{} {expected}", shape.inertia);
    }

    /// A ball inside of another adds nothing; balls apart add up; three that overlap are refused.
    #[test]
    fn inside_apart_and_three() {
        let inside = union(&[ball(0.0, 1.0), ball(0.2, 0.5)]).unwrap();
        let alone = union(&[ball(0.0, 1.0)]).unwrap();
        assert!((inside.mass / alone.mass - 1.0).abs() < 1e-14);
        assert!((inside.inertia - alone.inertia).norm() < 1e-13 * alone.inertia.norm());
        let apart = union(&[ball(0.0, 1.0), ball(2.0, 1.0)]).unwrap();
        assert!((apart.mass / (2.0 * alone.mass) - 1.0).abs() < 1e-15);
        assert!(union(&[ball(0.0, 1.0), ball(0.5, 1.0), ball(1.0, 1.0)]).is_none());
    }
}
