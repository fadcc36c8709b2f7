//! Text as outlines of fonts that the program carries, so that pictures look
//! the same on a machine without any font.

use ttf_parser::gpos::{PairAdjustment, PositioningSubtable};
use ttf_parser::opentype_layout::LayoutTable;
use ttf_parser::{GlyphId, OutlineBuilder, Tag};

use super::picture::{Path, Point, Segment};

/// Inter, Latin-1, Greek and mathematical signs only (see `fonts/OFL.txt`).
const REGULAR: &[u8] = include_bytes!("fonts/Inter-Regular.otf");
const ITALIC: &[u8] = include_bytes!("fonts/Inter-Italic.otf");
const SEMI_BOLD: &[u8] = include_bytes!("fonts/Inter-SemiBold.otf");

/// One of the fonts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Face {
    /// For text.
    Regular,
    /// For symbols.
    Italic,
    /// For titles.
    SemiBold,
}

impl Face {
    fn data(self) -> &'static [u8] {
        match self {
            Face::Regular => REGULAR,
            Face::Italic => ITALIC,
            Face::SemiBold => SEMI_BOLD,
        }
    }
}

/// A line of text, laid out from the origin along its baseline.
///
/// Markup: `*T*` sets a symbol in italics, `_{v}` lowers, `^{2}` raises. What
/// the fonts lack shows as a question mark.
#[derive(Clone, Debug)]
pub struct Layout {
    /// The letters, first letter at the origin, y down.
    pub outline: Path,
    /// Advance to where more text would go on.
    pub width: f64,
    /// The text without its markup.
    pub plain: String,
}

/// Height of a capital letter relative to the size.
pub const CAP_HEIGHT: f64 = 0.727;
const SCRIPT_SIZE: f64 = 0.72;
const LOWER: f64 = 0.22;
const RAISE: f64 = 0.38;

impl Layout {
    /// Lays out a line of markup.
    pub fn new(markup: &str, face: Face, size: f64) -> Layout {
        let mut layout = Layout { outline: Path::default(), width: 0.0, plain: String::new() };
        for run in runs(markup) {
            let face = if run.italic { Face::Italic } else { face };
            let (size, rise) = match run.script {
                Script::None => (size, 0.0),
                Script::Sub => (SCRIPT_SIZE * size, -LOWER * size),
                Script::Super => (SCRIPT_SIZE * size, RAISE * size),
            };
            layout.push(run.text, face, size, rise);
        }
        layout
    }

    fn push(&mut self, text: &str, face: Face, size: f64, rise: f64) {
        // The fonts are part of the program; the tests parse each of them.
        let Ok(font) = ttf_parser::Face::parse(face.data(), 0) else { return };
        let scale = size / f64::from(font.units_per_em());
        let mut previous = None;
        for c in text.chars() {
            let Some(glyph) = font.glyph_index(c).or_else(|| font.glyph_index('?')) else {
                continue;
            };
            if let Some(previous) = previous {
                self.width += scale * f64::from(kerning(&font, previous, glyph));
            }
            let origin = (self.width, -rise);
            font.outline_glyph(
                glyph,
                &mut Outliner { path: &mut self.outline, origin, scale, at: origin },
            );
            self.width += scale * f64::from(font.glyph_hor_advance(glyph).unwrap_or(0));
            previous = Some(glyph);
        }
        self.plain.push_str(text);
    }
}

/// Width of a text.
pub fn width(markup: &str, face: Face, size: f64) -> f64 {
    Layout::new(markup, face, size).width
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Script {
    None,
    Sub,
    Super,
}

struct Run<'a> {
    text: &'a str,
    italic: bool,
    script: Script,
}

/// Splits markup into runs of one style. Braces do not nest.
fn runs(markup: &str) -> Vec<Run<'_>> {
    let mut runs = Vec::new();
    let (mut italic, mut script) = (false, Script::None);
    let mut rest = markup;
    while !rest.is_empty() {
        let end = match script {
            Script::None => ["*", "_{", "^{"].iter().filter_map(|m| rest.find(m)).min(),
            _ => rest.find('}'),
        };
        let (text, tail) = rest.split_at(end.unwrap_or(rest.len()));
        if !text.is_empty() {
            runs.push(Run { text, italic: italic && script == Script::None, script });
        }
        let marks = match tail.as_bytes() {
            [b'*', ..] => {
                italic = !italic;
                1
            }
            [b'_', ..] => {
                script = Script::Sub;
                2
            }
            [b'^', ..] => {
                script = Script::Super;
                2
            }
            [b'}', ..] => {
                script = Script::None;
                1
            }
            _ => 0,
        };
        rest = &tail[marks..];
    }
    runs
}

/// What the font adds to the advance between two glyphs, in its units.
fn kerning(font: &ttf_parser::Face, left: GlyphId, right: GlyphId) -> i16 {
    let Some(table) = font.tables().gpos else { return 0 };
    lookups(&table)
        .filter_map(|i| table.lookups.get(i))
        .find_map(|lookup| {
            (0..lookup.subtables.len())
                .filter_map(|i| lookup.subtables.get::<PositioningSubtable>(i))
                .find_map(|subtable| pair(&subtable, left, right))
        })
        .unwrap_or(0)
}

/// Lookups of the kerning feature (the first script's; all share them).
fn lookups<'a>(table: &LayoutTable<'a>) -> impl Iterator<Item = u16> + use<'a> {
    let kern = table.features.find(Tag::from_bytes(b"kern"));
    kern.into_iter().flat_map(|feature| feature.lookup_indices)
}

fn pair(subtable: &PositioningSubtable, left: GlyphId, right: GlyphId) -> Option<i16> {
    let PositioningSubtable::Pair(pair) = subtable else { return None };
    match pair {
        PairAdjustment::Format1 { coverage, sets } => {
            let (first, _) = sets.get(coverage.get(left)?)?.get(right)?;
            Some(first.x_advance)
        }
        PairAdjustment::Format2 { coverage, classes, matrix } => {
            coverage.get(left)?;
            let (first, _) = matrix.get((classes.0.get(left), classes.1.get(right)))?;
            Some(first.x_advance)
        }
    }
}

/// Collects a glyph's outline in the picture's directions (y down).
struct Outliner<'a> {
    path: &'a mut Path,
    origin: Point,
    scale: f64,
    at: Point,
}

impl Outliner<'_> {
    fn place(&self, x: f32, y: f32) -> Point {
        (self.origin.0 + self.scale * f64::from(x), self.origin.1 - self.scale * f64::from(y))
    }

    fn add(&mut self, segment: Segment, end: Point) {
        self.path.0.push(segment);
        self.at = end;
    }
}

impl OutlineBuilder for Outliner<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        let p = self.place(x, y);
        self.add(Segment::Move(p), p);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let p = self.place(x, y);
        self.add(Segment::Line(p), p);
    }

    fn quad_to(&mut self, cx: f32, cy: f32, x: f32, y: f32) {
        // The cubic curve that is this quadratic one.
        let (c, p, a) = (self.place(cx, cy), self.place(x, y), self.at);
        let toward = |from: Point| {
            (from.0 + 2.0 / 3.0 * (c.0 - from.0), from.1 + 2.0 / 3.0 * (c.1 - from.1))
        };
        self.add(Segment::Curve(toward(a), toward(p), p), p);
    }

    fn curve_to(&mut self, ax: f32, ay: f32, bx: f32, by: f32, x: f32, y: f32) {
        let p = self.place(x, y);
        self.add(Segment::Curve(self.place(ax, ay), self.place(bx, by), p), p);
    }

    fn close(&mut self) {
        self.path.0.push(Segment::Close);
    }
}
