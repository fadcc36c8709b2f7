//! The part of a ball that lies in a box.

use std::f64::consts::PI;

use super::{Aabb, Vec3};

/// Nodes on [-1, 1] and weights of Gauss and Legendre's rule of five points.
const RULE: [(f64, f64); 5] = [
    (0.0, 128.0 / 225.0),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
];
/// Parts of each interval in which the area is smooth: the volume is then right to 1e-9 of the ball's.
const PARTS: u32 = 8;

/// Volume of the part of a ball that lies in a box (m³).
pub(crate) fn ball_in_box(center: &Vec3, radius: f64, bounds: &Aabb) -> f64 {
    let (low, high) = (bounds.min - center, bounds.max - center);
    let is_cut = |axis: usize| low[axis] > -radius || high[axis] < radius;
    let cuts: Vec<usize> = (0..3).filter(|&axis| is_cut(axis)).collect();
    if cuts.iter().any(|&axis| low[axis] >= radius || high[axis] <= -radius) {
        return 0.0;
    }
    match cuts[..] {
        [] => 4.0 / 3.0 * PI * radius.powi(3),
        [axis] => below(radius, high[axis]) - below(radius, low[axis]),
        _ => integrated(radius, &low, &high),
    }
}

/// Volume of a ball around the origin below the height h.
fn below(radius: f64, h: f64) -> f64 {
    let h = h.clamp(-radius, radius);
    PI * (2.0 / 3.0 * radius.powi(3) + radius * radius * h - h.powi(3) / 3.0)
}

/// The area of cuts normal to z, summed up over z.
fn integrated(radius: f64, low: &Vec3, high: &Vec3) -> f64 {
    let (from, to) = (low.z.max(-radius), high.z.min(radius));
    // Where the rim of the disc comes to an edge or a corner of the rectangle the area is not smooth.
    let edges = [low.x, high.x, low.y, high.y];
    let corners = [low.x, high.x].into_iter().flat_map(|x| [low.y, high.y].map(|y| x.hypot(y)));
    let mut ends: Vec<f64> = edges
        .into_iter()
        .chain(corners)
        .filter(|d| d.abs() < radius)
        .flat_map(|d| {
            let z = (radius * radius - d * d).sqrt();
            [-z, z]
        })
        .filter(|z| (from..to).contains(z))
        .chain([from, to])
        .collect();
    ends.sort_by(f64::total_cmp);
    let area = |z: f64| {
        let rim = (radius * radius - z * z).max(0.0).sqrt();
        disc_in_rectangle(rim, [low.x, high.x], [low.y, high.y])
    };
    ends.windows(2).map(|pair| integral(area, pair[0], pair[1])).sum()
}

/// Roots at the ends become polynomials of t, z = a + (b − a) t² (3 − 2 t).
fn integral(of: impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    let part = 1.0 / f64::from(PARTS);
    let all =
        (0..PARTS).flat_map(|k| RULE.map(|(x, w)| ((f64::from(k) + 0.5 * (1.0 + x)) * part, w)));
    let slope = |t: f64| 6.0 * t * (1.0 - t) * (b - a);
    all.map(|(t, w)| 0.5 * part * w * slope(t) * of(a + (b - a) * t * t * (3.0 - 2.0 * t))).sum()
}

/// Area of a disc around the origin within a rectangle.
fn disc_in_rectangle(radius: f64, [x0, x1]: [f64; 2], [y0, y1]: [f64; 2]) -> f64 {
    let corner = |x, y| disc_in_quarter(radius, x, y);
    corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0)
}

/// Area of a disc around the origin with X < x and Y < y.
fn disc_in_quarter(radius: f64, x: f64, y: f64) -> f64 {
    if radius == 0.0 {
        return 0.0;
    }
    let (x, y) = (x.clamp(-radius, radius), y.clamp(-radius, radius));
    let disc = PI * radius * radius;
    // From the middle to t, of one half.
    let strip = |t: f64| {
        0.5 * (t * (radius * radius - t * t).sqrt() + radius * radius * (t / radius).asin())
    };
    if x * x + y * y < radius * radius {
        return 0.25 * disc + strip(x) + strip(y) + x * y;
    }
    let half = |t: f64| 0.5 * disc + 2.0 * strip(t);
    match (x >= 0.0, y >= 0.0) {
        (true, true) => half(x) + half(y) - disc,
        (false, true) => half(x),
        (true, false) => half(y),
        (false, false) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn within(min: [f64; 3], max: [f64; 3]) -> f64 {
        let bounds = Aabb { min: Vec3::from(min), max: Vec3::from(max) };
        ball_in_box(&Vec3::zeros(), 1.0, &bounds) / (4.0 / 3.0 * PI)
    }

    /// A half, a quarter and an eighth of a ball; a cap of height h has π h² (3 − h) / 3; a cube in the
    /// ball is all of itself.
    #[test]
    fn parts_of_a_ball_have_their_closed_forms() {
        const FAR: f64 = 3.0;
        let cases = [
            (within([-FAR; 3], [FAR; 3]), 1.0),
            (within([0.0, -FAR, -FAR], [FAR; 3]), 0.5),
            (within([0.0, 0.0, -FAR], [FAR; 3]), 0.25),
            (within([-FAR, 0.0, 0.0], [FAR; 3]), 0.25),
            (within([0.0; 3], [FAR; 3]), 0.125),
            (within([-FAR; 3], [FAR, -0.4, FAR]), 0.6 * 0.6 * (3.0 - 0.6) / 4.0),
            (within([-0.5; 3], [0.5; 3]), 1.0 / (4.0 / 3.0 * PI)),
            (within([1.0, -FAR, -FAR], [FAR; 3]), 0.0),
            (within([0.8, 0.8, -FAR], [FAR; 3]), 0.0),
        ];
        for (k, (found, exact)) in cases.into_iter().enumerate() {
            assert!((found - exact).abs() < 1e-9, "{k}: {found} {exact}");
        }
    }

    /// Boxes that fill space hold the whole ball, wherever they cut it.
    #[test]
    fn parts_add_up() {
        let at = [-1.5, -0.61, 0.13, 0.97, 1.5];
        let mut sum = 0.0;
        for i in 0..64 {
            let [a, b, c] = [i % 4, i / 4 % 4, i / 16];
            sum += within([at[a], at[b], at[c]], [at[a + 1], at[b + 1], at[c + 1]]);
        }
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    }
}
