//! A cut through the packing: spheres over pores coloured by a value.

use dempfv::io::vtk::Cells;
use dempfv::{Aabb, Vec3};

use super::axis::{self, Axis, Scale, Ticks};
use super::chart::{MARGIN, heading};
use super::color::{Color, INK, viridis};
use super::panel::{Panel, label_style};
use super::picture::{Anchor, Path, Picture, Point, Rect, Stroke, Type};
use super::text::{self, CAP_HEIGHT, Face};

/// What is cut, and where.
#[derive(Clone, Copy, Debug)]
pub struct Section<'a> {
    /// Above the picture.
    pub title: &'a str,
    /// Under the title; lines.
    pub caption: &'a str,
    /// The box (m).
    pub bounds: Aabb,
    /// Axis that the plane is normal to: 0, 1 or 2.
    pub axis: usize,
    /// Where the plane cuts that axis (m).
    pub position: f64,
    /// Centres of the spheres (m).
    pub centers: &'a [Vec3],
    /// Radii of the spheres (m).
    pub radii: &'a [f64],
    /// Vertices of the pores (m).
    pub points: &'a [Vec3],
    /// The pores, convex.
    pub cells: &'a Cells,
    /// What colours each pore.
    pub values: &'a [f64],
    /// Name of the value.
    pub quantity: &'a str,
    /// SI unit of the value; the picture chooses a prefix.
    pub unit: &'a str,
}

const SOLID: Color = Color(236, 236, 236);
const RIM: Color = Color(120, 120, 120);
const SIDE: f64 = 430.0;
const BAR_WIDTH: f64 = 16.0;

/// Draws the section: y up over x, z up over x, or z up over y.
pub fn section(s: &Section) -> Picture {
    let [right, up] = [[1, 2], [0, 2], [0, 1]][s.axis.min(2)];
    let names = ["*x*", "*y*", "*z*"];
    let (prefix, unit) = axis::prefix(s.bounds.min.abs().max().max(s.bounds.max.abs().max()));
    let label = |axis: usize| format!("{} ({prefix}m)", names[axis]);
    let limits = |axis: usize| [s.bounds.min[axis] / unit, s.bounds.max[axis] / unit];
    let size = s.bounds.size();
    let scale = SIDE / size[right].max(size[up]);
    let (w, h) = (scale * size[right], scale * size[up]);
    // Cut to size below, when it is known what numbers and labels take.
    let mut picture = Picture::new(0.0, 0.0);
    let top = heading(&mut picture, s.title, s.caption) + 8.0;
    let (x_label, y_label) = (label(right), label(up));
    let panel = Panel {
        title: "",
        x: Axis::linear(&x_label).spanning(limits(right)[0], limits(right)[1]),
        y: Axis::linear(&y_label).spanning(limits(up)[0], limits(up)[1]),
        series: &[],
    };
    let area = panel.draw_fitted(&mut picture, (MARGIN, top), (w, h));
    let place = |p: Vec3| {
        let x = area.left + scale * (p[right] - s.bounds.min[right]);
        (x, area.bottom - scale * (p[up] - s.bounds.min[up]))
    };
    let cuts = cut_pores(s, place);
    let range = value_range(&cuts);
    picture.clipped(area, |picture| {
        draw_pores(picture, &cuts, range);
        draw_spheres(picture, s, scale, place);
    });
    picture.shape(Path::rect(area), None, Some(Stroke::solid(INK, 0.8)));
    picture.width = (draw_bar(&mut picture, s, area, range) + MARGIN).ceil();
    picture.height = (area.bottom + 52.0).ceil();
    picture
}

/// The polygons in which the plane cuts pores, with their values.
fn cut_pores(s: &Section, place: impl Fn(Vec3) -> Point) -> Vec<(Vec<Point>, f64)> {
    let cut = |(cell, &value): (&[u32], &f64)| {
        let corners: Vec<Vec3> = cell.iter().map(|&v| s.points[v as usize]).collect();
        let points = plane_points(&corners, s.axis, s.position);
        let hull = hull(points.into_iter().map(&place).collect());
        (hull.len() > 2).then_some((hull, value))
    };
    s.cells.iter().zip(s.values).filter_map(cut).collect()
}

/// Where the lines between any two corners of a convex body meet the plane;
/// the hull of these points is the cut.
pub fn plane_points(corners: &[Vec3], axis: usize, position: f64) -> Vec<Vec3> {
    let mut points = Vec::new();
    for (i, a) in corners.iter().enumerate() {
        for b in &corners[i + 1..] {
            let (da, db) = (a[axis] - position, b[axis] - position);
            if (da <= 0.0) != (db <= 0.0) {
                points.push(a + (b - a) * (da / (da - db)));
            }
        }
    }
    points
}

/// The convex hull of points in a plane, in order around it (Andrew's monotone chain).
pub fn hull(mut points: Vec<Point>) -> Vec<Point> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    points.dedup();
    let turn = |a: Point, b: Point, c: Point| (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0);
    let chain = |points: &mut dyn Iterator<Item = Point>| {
        let mut chain: Vec<Point> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..]
                && turn(a, b, p) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut around = chain(&mut points.iter().copied());
    around.extend(chain(&mut points.iter().rev().copied()));
    around
}

/// Smallest and largest value on show, never the same; zero where the values
/// begin near it.
fn value_range(cuts: &[(Vec<Point>, f64)]) -> [f64; 2] {
    let values = cuts.iter().map(|c| c.1).filter(|v| v.is_finite());
    let [low, high] =
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)]);
    if low > high {
        [0.0, 1.0]
    } else if high - low <= 1e-12 * low.abs().max(high.abs()) {
        [low - 0.5, high + 0.5]
    } else if low > 0.0 && low < 0.15 * (high - low) {
        [0.0, high]
    } else {
        [low, high]
    }
}

fn draw_pores(picture: &mut Picture, cuts: &[(Vec<Point>, f64)], range: [f64; 2]) {
    for (polygon, value) in cuts {
        let color = viridis(Scale::Linear.share(*value, range));
        // The rim in the same colour closes the seams between neighbours.
        let path = Path::polygon(polygon.iter().copied());
        picture.shape(path, Some(color), Some(Stroke::solid(color, 0.4)));
    }
}

fn draw_spheres(picture: &mut Picture, s: &Section, scale: f64, place: impl Fn(Vec3) -> Point) {
    for (&center, &radius) in s.centers.iter().zip(s.radii) {
        let square = radius * radius - (center[s.axis] - s.position).powi(2);
        if square > 0.0 {
            let disc = Path::circle(place(center), scale * square.sqrt());
            picture.shape(disc, Some(SOLID), Some(Stroke::solid(RIM, 0.5)));
        }
    }
}

/// The colours' key, right of the axes; returns where it ends.
fn draw_bar(picture: &mut Picture, s: &Section, area: Rect, [low, high]: [f64; 2]) -> f64 {
    let bar = Rect { left: area.right + 20.0, right: area.right + 20.0 + BAR_WIDTH, ..area };
    let steps = 128;
    let height = |i: i32| bar.bottom - bar.height() * f64::from(i) / f64::from(steps);
    for i in 0..steps {
        // Up to the top, to be painted over by the next: no seams.
        let color = viridis((f64::from(i) + 0.5) / f64::from(steps));
        picture.shape(Path::rect(Rect { bottom: height(i), ..bar }), Some(color), None);
    }
    picture.shape(Path::rect(bar), None, Some(Stroke::solid(INK, 0.8)));
    let (prefix, unit) = axis::prefix(low.abs().max(high.abs()));
    let limits = [low / unit, high / unit];
    let ticks = Ticks::new(Scale::Linear, limits, 8);
    let mut widest: f64 = 0.0;
    for (&v, number) in ticks.at.iter().zip(&ticks.text) {
        let y = bar.bottom - bar.height() * Scale::Linear.share(v, limits);
        picture.line((bar.right, y), (bar.right + 4.0, y), Stroke::solid(INK, 0.8));
        let at = (bar.right + 8.0, y + 0.5 * CAP_HEIGHT * 10.0);
        picture.text(at, number, label_style(10.0, Anchor::Start));
        widest = widest.max(text::width(number, Face::Regular, 10.0));
    }
    let label = format!("{} ({prefix}{})", s.quantity, s.unit);
    let style = Type { upward: true, ..label_style(11.5, Anchor::Middle) };
    let right = bar.right + 8.0 + widest + 18.0;
    picture.text((right, 0.5 * (bar.top + bar.bottom)), &label, style);
    right
}
