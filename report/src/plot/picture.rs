//! A picture as a list of filled and stroked paths; `svg` and
//! `png` render the same list.

use super::color::Color;
use super::text::{self, Face};

/// A point of the picture: x to the right, y down, in points (1/72 inch).
pub type Point = (f64, f64);

/// An upright rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    /// Smallest x.
    pub left: f64,
    /// Smallest y (y points down).
    pub top: f64,
    /// Largest x.
    pub right: f64,
    /// Largest y.
    pub bottom: f64,
}

impl Rect {
    /// Extent in x.
    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    /// Extent in y.
    pub fn height(&self) -> f64 {
        self.bottom - self.top
    }

    /// True for a point inside or on the rim.
    pub fn contains(&self, (x, y): Point) -> bool {
        (self.left..=self.right).contains(&x) && (self.top..=self.bottom).contains(&y)
    }
}

/// A step of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Segment {
    /// Begins a piece.
    Move(Point),
    /// A straight line to a point.
    Line(Point),
    /// A cubic curve: two controls, then the end.
    Curve(Point, Point, Point),
    /// A straight line to where the piece began.
    Close,
}

/// An outline, open or closed, of one or more pieces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Path(pub Vec<Segment>);

impl Path {
    /// A chain of straight lines.
    pub fn polyline(points: impl IntoIterator<Item = Point>) -> Path {
        let mut points = points.into_iter();
        let first = points.next().map(Segment::Move);
        Path(first.into_iter().chain(points.map(Segment::Line)).collect())
    }

    /// A chain of straight lines back to its first point.
    pub fn polygon(points: impl IntoIterator<Item = Point>) -> Path {
        let mut path = Path::polyline(points);
        path.0.push(Segment::Close);
        path
    }

    /// The rim of a rectangle.
    pub fn rect(r: Rect) -> Path {
        Path::polygon([(r.left, r.top), (r.right, r.top), (r.right, r.bottom), (r.left, r.bottom)])
    }

    /// Four cubic curves; off a true circle by 3e-4 of the radius.
    pub fn circle((x, y): Point, r: f64) -> Path {
        let k = 0.552_284_75 * r;
        Path(vec![
            Segment::Move((x + r, y)),
            Segment::Curve((x + r, y + k), (x + k, y + r), (x, y + r)),
            Segment::Curve((x - k, y + r), (x - r, y + k), (x - r, y)),
            Segment::Curve((x - r, y - k), (x - k, y - r), (x, y - r)),
            Segment::Curve((x + k, y - r), (x + r, y - k), (x + r, y)),
            Segment::Close,
        ])
    }

    /// The path with every point mapped.
    pub fn map(&self, f: impl Fn(Point) -> Point) -> Path {
        let mapped = self.0.iter().map(|s| match *s {
            Segment::Move(p) => Segment::Move(f(p)),
            Segment::Line(p) => Segment::Line(f(p)),
            Segment::Curve(a, b, p) => Segment::Curve(f(a), f(b), f(p)),
            Segment::Close => Segment::Close,
        });
        Path(mapped.collect())
    }
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Its colour.
    pub color: Color,
    /// Its width, half to each side of the path.
    pub width: f64,
    /// Lengths of a dash and of the gap after it.
    pub dash: Option<[f64; 2]>,
}

impl Stroke {
    /// A line without gaps.
    pub fn solid(color: Color, width: f64) -> Stroke {
        Stroke { color, width, dash: None }
    }
}

/// One path and what to do with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// What is drawn.
    pub path: Path,
    /// Colour inside, if any.
    pub fill: Option<Color>,
    /// Line along the path, if any.
    pub stroke: Option<Stroke>,
    /// Nothing shows outside this area.
    pub clip: Option<Rect>,
    /// The text that the path shows, for readers that cannot see it.
    pub text: Option<String>,
}

/// Which point of a text is at the given place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Anchor {
    /// Where the text begins.
    Start,
    /// Half its width.
    Middle,
    /// Where the text ends.
    End,
}

/// How a text is set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Type {
    /// The font.
    pub face: Face,
    /// Size of the font in points.
    pub size: f64,
    /// Colour of the letters.
    pub color: Color,
    /// What of the text is at the place.
    pub anchor: Anchor,
    /// Read from bottom to top.
    pub upward: bool,
}

/// A sheet and what has been drawn on it so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Extent in x, in points.
    pub width: f64,
    /// Extent in y, in points.
    pub height: f64,
    /// What is drawn, first below.
    pub items: Vec<Item>,
    clip: Option<Rect>,
}

impl Picture {
    /// An empty sheet.
    pub fn new(width: f64, height: f64) -> Picture {
        Picture { width, height, items: Vec::new(), clip: None }
    }

    /// Draws with what lies outside `area` cut off.
    pub fn clipped(&mut self, area: Rect, draw: impl FnOnce(&mut Picture)) {
        let outer = self.clip.replace(area);
        draw(self);
        self.clip = outer;
    }

    /// Draws a path, filled or stroked or both.
    pub fn shape(&mut self, path: Path, fill: Option<Color>, stroke: Option<Stroke>) {
        self.items.push(Item { path, fill, stroke, clip: self.clip, text: None });
    }

    /// Draws a straight line.
    pub fn line(&mut self, from: Point, to: Point, stroke: Stroke) {
        self.shape(Path::polyline([from, to]), None, Some(stroke));
    }

    /// Sets a text (in the markup of [`text::Layout`]) with its baseline at
    /// `at`; returns its width.
    pub fn text(&mut self, at: Point, markup: &str, style: Type) -> f64 {
        let layout = text::Layout::new(markup, style.face, style.size);
        let shift = match style.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -0.5 * layout.width,
            Anchor::End => -layout.width,
        };
        let path = layout.outline.map(|(x, y)| {
            let (x, y) = if style.upward { (y, -(x + shift)) } else { (x + shift, y) };
            (at.0 + x, at.1 + y)
        });
        let text = Some(layout.plain);
        self.items.push(Item {
            path,
            fill: Some(style.color),
            stroke: None,
            clip: self.clip,
            text,
        });
        layout.width
    }
}
