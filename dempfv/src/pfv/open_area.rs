//! What discs leave open of a convex polygon: the area of the polygon beside their union, and
//! which disc covers which part of the rest.
//!
//! Where discs overlap, each has what is nearer to it in power: the radical lines cut the
//! polygon into one convex cell per disc, and no disc reaches a place in another's cell that
//! the other does not cover, too.

/// A point of the plane (m).
pub(super) type Point = [f64; 2];

/// Vertices of a polygon at most: four, and one more for each line that cuts.
const VERTICES: usize = 8;
/// A smaller share of a polygon counts as covered. What a throat conducts goes with the cube of
/// the share: with less than a millionth, next to pores of a lattice that coincide, it would
/// be no more than round-off in their balance.
const COVERED: f64 = 1e-2;

/// A disc.
#[derive(Clone, Copy, Debug)]
pub(super) struct Disc {
    /// Centre (m).
    pub center: Point,
    /// Radius (m).
    pub radius: f64,
}

/// Areas (m²) of a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OpenArea {
    /// Beside all discs; exactly zero where they cover all but a hundredth.
    pub open: f64,
    /// Covered by each of up to three discs.
    pub covered: [f64; 3],
}

/// Open and covered parts of a convex polygon whose vertices turn counterclockwise, beneath up
/// to three discs.
pub(super) fn open_area(polygon: &[Point], discs: &[Disc]) -> OpenArea {
    let whole = Polygon::new(polygon);
    let area = whole.area();
    let mut covered = [0.0; 3];
    for (k, disc) in discs.iter().enumerate() {
        let mut cell = whole;
        for other in discs.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, d)| d) {
            cell = cell.nearer(disc, other);
        }
        covered[k] = cell.area_within(disc);
    }
    let open = area - covered.iter().sum::<f64>();
    OpenArea { open: if open > COVERED * area { open } else { 0.0 }, covered }
}

#[derive(Clone, Copy)]
struct Polygon {
    vertex: [Point; VERTICES],
    count: usize,
}

impl Polygon {
    fn new(vertices: &[Point]) -> Polygon {
        let mut polygon = Polygon { vertex: [[0.0; 2]; VERTICES], count: 0 };
        for &vertex in vertices {
            polygon.push(vertex);
        }
        polygon
    }

    fn push(&mut self, vertex: Point) {
        if let Some(place) = self.vertex.get_mut(self.count) {
            *place = vertex;
            self.count += 1;
        }
    }

    fn edges(&self) -> impl Iterator<Item = (Point, Point)> + '_ {
        (0..self.count).map(|k| (self.vertex[k], self.vertex[(k + 1) % self.count]))
    }

    fn area(&self) -> f64 {
        0.5 * self.edges().map(|(a, b)| cross(a, b)).sum::<f64>()
    }

    /// The part that is nearer, in power, to one disc than to another.
    fn nearer(&self, disc: &Disc, other: &Disc) -> Polygon {
        // |x - c|² - r² of the one less that of the other is linear: positive beyond the line.
        let along = sub(other.center, disc.center);
        let middle = dot(other.center, other.center) - dot(disc.center, disc.center);
        let offset = middle + (disc.radius - other.radius) * (disc.radius + other.radius);
        let beyond = |x: Point| 2.0 * dot(x, along) - offset;
        let mut part = Polygon { vertex: [[0.0; 2]; VERTICES], count: 0 };
        for (a, b) in self.edges() {
            let (fa, fb) = (beyond(a), beyond(b));
            if fa <= 0.0 {
                part.push(a);
            }
            if (fa <= 0.0) != (fb <= 0.0) {
                let t = fa / (fa - fb);
                part.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
            }
        }
        part
    }

    /// Area of the part within a disc: the sum over the edges of what the disc has of the
    /// triangle between the edge and its centre, with the sign of that triangle.
    fn area_within(&self, disc: &Disc) -> f64 {
        let relative = |x: Point| sub(x, disc.center);
        self.edges().map(|(a, b)| swept(relative(a), relative(b), disc.radius)).sum()
    }
}

/// Area of the disc around the origin within the triangle of the origin and an edge from `a` to
/// `b`, negative where these turn clockwise.
fn swept(a: Point, b: Point, radius: f64) -> f64 {
    let along = sub(b, a);
    let length2 = dot(along, along);
    if length2 == 0.0 {
        return 0.0;
    }
    let sector = |a: Point, b: Point| 0.5 * radius * radius * cross(a, b).atan2(dot(a, b));
    // Where the edge's line enters and leaves the disc, in lengths of the edge from `a`.
    let foot = -dot(a, along) / length2;
    let distance2 = cross(a, b).powi(2) / length2;
    let inside2 = radius * radius - distance2;
    if inside2 <= 0.0 {
        return sector(a, b);
    }
    let half = (inside2 / length2).sqrt();
    let (enters, leaves) = ((foot - half).max(0.0), (foot + half).min(1.0));
    if enters >= leaves {
        return sector(a, b);
    }
    let at = |t: f64| [a[0] + t * along[0], a[1] + t * along[1]];
    let (p, q) = (at(enters), at(leaves));
    let before = if enters > 0.0 { sector(a, p) } else { 0.0 };
    let after = if leaves < 1.0 { sector(q, b) } else { 0.0 };
    before + 0.5 * cross(p, q) + after
}

fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    const TRIANGLE: [Point; 3] = [[0.0, 0.0], [2.0, 0.0], [1.0, 1.732_050_807_568_877_2]];

    fn at_corners(radius: f64) -> OpenArea {
        open_area(&TRIANGLE, &TRIANGLE.map(|center| Disc { center, radius }))
    }

    /// Three discs that touch leave √3 − π/2 of a triangle of side 2; each has a sixth of
    /// itself in it.
    #[test]
    fn discs_that_touch_leave_the_known_gap() {
        let found = at_corners(1.0);
        assert!((found.open - (3f64.sqrt() - PI / 2.0)).abs() < 1e-14, "{found:?}");
        assert!(found.covered.iter().all(|c| (c - PI / 6.0).abs() < 1e-14), "{found:?}");
    }

    /// Overlapping discs of radius r at distance 2 share two segments of r² acos(1/r) − √(r² − 1)
    /// each, half of it on this side.
    #[test]
    fn overlaps_count_once() {
        let r: f64 = 1.05;
        let lens = 2.0 * (r * r * (1.0 / r).acos() - (r * r - 1.0).sqrt());
        let expected = 3f64.sqrt() - (PI / 2.0 * r * r - 1.5 * lens);
        let found = at_corners(r);
        assert!((found.open - expected).abs() < 1e-14, "{found:?} {expected}");
    }

    /// They cover all from the circumradius on, 2/√3, and not before; then thirds.
    #[test]
    fn covered_means_exactly_zero() {
        let closing = 2.0 / 3f64.sqrt();
        assert!(at_corners(closing * 0.93).open > 0.0);
        for r in [closing * (1.0 + 1e-9), 1.5, 3.0, 100.0] {
            let found = at_corners(r);
            assert_eq!(found.open, 0.0, "{r}");
            assert!(
                found.covered.iter().all(|c| (c - 1.0 / 3f64.sqrt()).abs() < 1e-12),
                "{found:?}"
            );
        }
    }

    /// Counted on a grid of points: discs of any size anywhere, in a triangle and a trapezoid.
    #[test]
    fn any_discs_cover_what_points_tell() {
        let mut state = 5u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let trapezoid = [[0.0, 0.0], [1.5, 0.0], [1.5, 1.2], [0.0, 0.7]];
        for polygon in [&TRIANGLE[..], &trapezoid] {
            for _ in 0..40 {
                let discs = [0; 3].map(|_| Disc {
                    center: [2.0 * random(), 1.7 * random()],
                    radius: 1.2 * random(),
                });
                let inside = |x: Point| {
                    (0..polygon.len()).all(|k| {
                        let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
                        cross(sub(b, a), sub(x, a)) >= 0.0
                    })
                };
                let free = |x: Point| {
                    discs.iter().all(|d| {
                        let apart = sub(x, d.center);
                        dot(apart, apart) > d.radius * d.radius
                    })
                };
                let steps = 400;
                let cell = 2.0 / f64::from(steps);
                let points = (0..steps * steps).filter(|k| {
                    let x = [k % steps, k / steps].map(|i| (f64::from(i) + 0.5) * cell);
                    inside(x) && free(x)
                });
                let counted = points.count() as f64 * cell * cell;
                let found = open_area(polygon, &discs);
                assert!((found.open - counted).abs() < 0.02, "{found:?} {counted} {discs:?}");
                assert!(found.covered.iter().all(|&c| c >= -1e-15), "{found:?}");
            }
        }
    }
}
