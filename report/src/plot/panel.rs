//! One pair of axes with its series.

use super::axis::{Axis, Ticks};
use super::color::{Color, GRID, INK, WHITE};
use super::picture::{Anchor, Path, Picture, Point, Rect, Stroke, Type};
use super::text::{self, CAP_HEIGHT, Face};

/// Sizes in points.
const TICK_SIZE: f64 = 10.0;
const LABEL_SIZE: f64 = 11.5;
const TITLE_SIZE: f64 = 11.5;
const TICK: f64 = 4.0;
const GAP: f64 = 6.0;
/// Room per number along an axis.
const TICK_ROOM: (f64, f64) = (62.0, 42.0);

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mark {
    /// A line.
    Line {
        /// Its width.
        width: f64,
        /// Lengths of dash and gap if it is not solid.
        dash: Option<[f64; 2]>,
    },
    /// Discs.
    Dots {
        /// Their radius.
        radius: f64,
        /// Each is at least so far from the one before (0: every point).
        apart: f64,
    },
}

/// Values to show. A value that is not finite interrupts a line.
#[derive(Clone, Debug)]
pub struct Series<'a> {
    /// Name in the legend (markup); without a name it is in none.
    pub name: Option<String>,
    /// Values along the horizontal axis, in its unit.
    pub x: &'a [f64],
    /// Values along the vertical axis, one for each of `x`.
    pub y: &'a [f64],
    /// Colour of line or dots.
    pub color: Color,
    /// Line or dots.
    pub mark: Mark,
}

/// Axes, series, and a title above them.
pub struct Panel<'a> {
    /// Above the axes; may be empty.
    pub title: &'a str,
    /// The horizontal axis.
    pub x: Axis<'a>,
    /// The vertical axis.
    pub y: Axis<'a>,
    /// What is shown, first below.
    pub series: &'a [Series<'a>],
}

/// Plain text of a size.
pub fn label_style(size: f64, anchor: Anchor) -> Type {
    Type { face: Face::Regular, size, color: INK, anchor, upward: false }
}

/// An axis that knows its place: limits, and the lengths they map to.
struct Placed<'a> {
    axis: Axis<'a>,
    limits: [f64; 2],
    ticks: Ticks,
    ends: [f64; 2],
}

impl<'a> Placed<'a> {
    fn new(axis: Axis<'a>, values: impl Iterator<Item = f64>, room: f64, per_tick: f64) -> Self {
        let limits = axis.limits(values);
        let count = (room / per_tick) as usize;
        let ticks = Ticks::new(axis.scale, limits, count.clamp(2, 10));
        Placed { axis, limits, ticks, ends: [0.0, 1.0] }
    }

    fn place(&self, value: f64) -> f64 {
        let [a, b] = self.ends;
        a + (b - a) * self.axis.scale.share(value, self.limits)
    }
}

/// Room that numbers and labels take around the area inside the axes.
struct Margins {
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

impl<'a> Panel<'a> {
    /// Draws into `room`; returns the area inside the axes.
    pub fn draw(&self, picture: &mut Picture, room: Rect) -> Rect {
        let (x, y) = self.axes((room.width(), room.height()), TICK_ROOM);
        let margins = self.margins(&x, &y);
        let area = Rect {
            left: room.left + margins.left,
            top: room.top + margins.top,
            right: room.right - margins.right,
            bottom: room.bottom - margins.bottom,
        };
        self.draw_in(picture, area, &margins, x, y);
        area
    }

    /// Draws with an area of a given size inside the axes and the upper left
    /// corner of all at `corner`, both axes divided alike; returns the area.
    pub fn draw_fitted(&self, picture: &mut Picture, corner: Point, size: (f64, f64)) -> Rect {
        let (x, y) = self.axes(size, (TICK_ROOM.1, TICK_ROOM.1));
        let margins = self.margins(&x, &y);
        let (left, top) = (corner.0 + margins.left, corner.1 + margins.top);
        let area = Rect { left, top, right: left + size.0, bottom: top + size.1 };
        self.draw_in(picture, area, &margins, x, y);
        area
    }

    fn axes(&self, size: (f64, f64), per_tick: (f64, f64)) -> (Placed<'a>, Placed<'a>) {
        let x = self.series.iter().flat_map(|s| s.x).copied();
        let y = self.series.iter().flat_map(|s| s.y).copied();
        (Placed::new(self.x, x, size.0, per_tick.0), Placed::new(self.y, y, size.1, per_tick.1))
    }

    fn margins(&self, x: &Placed, y: &Placed) -> Margins {
        let width = |text: &String| text::width(text, Face::Regular, TICK_SIZE);
        let numbers = y.ticks.text.iter().map(width).fold(0.0, f64::max);
        let above = if self.title.is_empty() { 0.5 * TICK_SIZE } else { 2.0 * TITLE_SIZE };
        let factor = if y.ticks.exponent == 0 { 0.0 } else { 2.0 * TICK_SIZE };
        Margins {
            left: LABEL_SIZE + GAP + numbers + GAP + TICK,
            top: above.max(factor),
            right: x.ticks.text.last().map_or(0.0, |t| 0.5 * width(t)),
            bottom: 1.3 * LABEL_SIZE + TICK_SIZE + 2.0 * GAP + TICK,
        }
    }

    fn draw_in(
        &self,
        picture: &mut Picture,
        area: Rect,
        margins: &Margins,
        mut x: Placed,
        mut y: Placed,
    ) {
        x.ends = [area.left, area.right];
        y.ends = [area.bottom, area.top];
        draw_grid(picture, area, &x, &y);
        for series in self.series {
            let points = series.x.iter().zip(series.y).map(|(&a, &b)| (x.place(a), y.place(b)));
            draw_series(picture, series, area, points);
        }
        draw_frame(picture, area, &x, &y);
        self.draw_labels(picture, area, margins);
    }

    fn draw_labels(&self, picture: &mut Picture, area: Rect, margins: &Margins) {
        let middle = (0.5 * (area.left + area.right), 0.5 * (area.top + area.bottom));
        let style = label_style(LABEL_SIZE, Anchor::Middle);
        picture.text(
            (middle.0, area.bottom + margins.bottom - 0.4 * LABEL_SIZE),
            self.x.label,
            style,
        );
        let upward = Type { upward: true, ..style };
        picture.text((area.left - margins.left + LABEL_SIZE, middle.1), self.y.label, upward);
        let title = Type { face: Face::SemiBold, anchor: Anchor::Start, size: TITLE_SIZE, ..style };
        picture.text((area.left, area.top - 0.8 * TITLE_SIZE), self.title, title);
    }
}

fn draw_grid(picture: &mut Picture, area: Rect, x: &Placed, y: &Placed) {
    let stroke = Stroke::solid(GRID, 0.7);
    for &v in &x.ticks.at {
        picture.line((x.place(v), area.top), (x.place(v), area.bottom), stroke);
    }
    for &v in &y.ticks.at {
        picture.line((area.left, y.place(v)), (area.right, y.place(v)), stroke);
    }
}

/// Axis lines left and below, ticks and numbers.
fn draw_frame(picture: &mut Picture, area: Rect, x: &Placed, y: &Placed) {
    let stroke = Stroke::solid(INK, 0.8);
    picture.line((area.left, area.bottom), (area.right, area.bottom), stroke);
    picture.line((area.left, area.top), (area.left, area.bottom), stroke);
    for (ticks, length) in [(&x.ticks.at, TICK), (&x.ticks.minor, 0.5 * TICK)] {
        for &v in ticks {
            picture.line((x.place(v), area.bottom), (x.place(v), area.bottom + length), stroke);
        }
    }
    for (ticks, length) in [(&y.ticks.at, TICK), (&y.ticks.minor, 0.5 * TICK)] {
        for &v in ticks {
            picture.line((area.left - length, y.place(v)), (area.left, y.place(v)), stroke);
        }
    }
    let below = area.bottom + TICK + 0.6 * GAP + CAP_HEIGHT * TICK_SIZE;
    for (&v, number) in x.ticks.at.iter().zip(&x.ticks.text) {
        picture.text((x.place(v), below), number, label_style(TICK_SIZE, Anchor::Middle));
    }
    for (&v, number) in y.ticks.at.iter().zip(&y.ticks.text) {
        let at = (area.left - TICK - 0.6 * GAP, y.place(v) + 0.5 * CAP_HEIGHT * TICK_SIZE);
        picture.text(at, number, label_style(TICK_SIZE, Anchor::End));
    }
    let factor = |ticks: &Ticks| format!("×10^{{{}}}", ticks.exponent).replace('-', "−");
    if x.ticks.exponent != 0 {
        let at = (area.right, below + 1.5 * TICK_SIZE);
        picture.text(at, &factor(&x.ticks), label_style(TICK_SIZE, Anchor::End));
    }
    if y.ticks.exponent != 0 {
        let at = (area.left - TICK, area.top - 0.8 * TICK_SIZE);
        picture.text(at, &factor(&y.ticks), label_style(TICK_SIZE, Anchor::End));
    }
}

fn draw_series(
    picture: &mut Picture,
    series: &Series,
    area: Rect,
    points: impl Iterator<Item = Point>,
) {
    // A line along an edge keeps its width, a dot there stays whole.
    let near = Rect {
        left: area.left - 1.0,
        top: area.top - 1.0,
        right: area.right + 1.0,
        bottom: area.bottom + 1.0,
    };
    match series.mark {
        Mark::Line { width, dash } => picture.clipped(near, |picture| {
            let stroke = Stroke { color: series.color, width, dash };
            let points: Vec<_> = points.collect();
            for piece in points.split(|p| !(p.0.is_finite() && p.1.is_finite())) {
                picture.shape(Path::polyline(thin_out(piece)), None, Some(stroke));
            }
        }),
        Mark::Dots { radius, apart } => {
            let mut last: Option<Point> = None;
            for p in points.filter(|&p| near.contains(p)) {
                if last.is_none_or(|q| distance(p, q) >= apart) {
                    last = Some(p);
                    dot(picture, p, radius, series.color);
                }
            }
        }
    }
}

fn dot(picture: &mut Picture, at: Point, radius: f64, color: Color) {
    let rim = Stroke::solid(WHITE, 0.25 * radius);
    picture.shape(Path::circle(at, radius), Some(color), Some(rim));
}

/// Leaves out points closer than a fifth of a point to the last one kept: a
/// history of a million steps draws like one of a thousand.
fn thin_out(points: &[Point]) -> Vec<Point> {
    let mut kept: Vec<Point> = Vec::new();
    for (i, &p) in points.iter().enumerate() {
        if i + 1 == points.len() || kept.last().is_none_or(|&q| distance(p, q) > 0.2) {
            kept.push(p);
        }
    }
    kept
}

fn distance(a: Point, b: Point) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}

/// Length of the sample before a legend's name, and room between entries.
const SAMPLE: f64 = 26.0;
const LEGEND_SIZE: f64 = 10.5;
const LEGEND_LINE: f64 = 1.6 * LEGEND_SIZE;

/// Sets the names of series in lines from `left` to `right`, the first line
/// at `top`; returns the height used. A legend outside the axes covers no data.
pub fn legend(picture: &mut Picture, series: &[Series], left: f64, right: f64, top: f64) -> f64 {
    let (mut x, mut y) = (left, top + LEGEND_LINE);
    let named = series.iter().filter_map(|s| s.name.as_ref().map(|name| (s, name)));
    let mut any = false;
    for (series, name) in named {
        let width = SAMPLE + GAP + text::width(name, Face::Regular, LEGEND_SIZE);
        if any && x + width > right {
            (x, y) = (left, y + LEGEND_LINE);
        }
        any = true;
        let middle = y - 0.5 * CAP_HEIGHT * LEGEND_SIZE;
        sample(picture, series, (x, middle));
        picture.text((x + SAMPLE + GAP, y), name, label_style(LEGEND_SIZE, Anchor::Start));
        x += width + 3.5 * GAP;
    }
    if any { y - top + 0.4 * LEGEND_SIZE } else { 0.0 }
}

/// What a series looks like, from a point to the right.
pub fn sample(picture: &mut Picture, series: &Series, (x, y): Point) {
    match series.mark {
        Mark::Line { width, dash } => {
            picture.line((x, y), (x + SAMPLE, y), Stroke { color: series.color, width, dash });
        }
        Mark::Dots { radius, .. } => dot(picture, (x + 0.5 * SAMPLE, y), radius, series.color),
    }
}
