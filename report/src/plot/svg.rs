//! A picture as SVG. Text is drawn as outlines: it needs no font, and the
//! words are in `aria-label`.

use std::fmt::Write;

use super::color::Color;
use super::picture::{Item, Path, Picture, Point, Rect, Segment};

/// The whole file.
pub fn render(picture: &Picture) -> String {
    let (w, h) = (picture.width, picture.height);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" \
         viewBox=\"0 0 {w} {h}\">\n<rect width=\"{w}\" height=\"{h}\" fill=\"#fff\"/>\n"
    );
    let mut clips: Vec<Rect> = Vec::new();
    let mut current: Option<Rect> = None;
    for item in &picture.items {
        if item.clip != current {
            if current.is_some() {
                out.push_str("</g>\n");
            }
            if let Some(area) = item.clip {
                open_clip(&mut out, &mut clips, area);
            }
            current = item.clip;
        }
        push_item(&mut out, item);
    }
    if current.is_some() {
        out.push_str("</g>\n");
    }
    out.push_str("</svg>\n");
    out
}

// Writing to a string cannot fail: the results of `write!` below are dropped.

fn open_clip(out: &mut String, clips: &mut Vec<Rect>, area: Rect) {
    let known = clips.iter().position(|&c| c == area);
    let id = known.unwrap_or_else(|| {
        clips.push(area);
        let id = clips.len() - 1;
        let _ = writeln!(
            out,
            "<clipPath id=\"clip{id}\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/></clipPath>",
            Number(area.left),
            Number(area.top),
            Number(area.width()),
            Number(area.height())
        );
        id
    });
    let _ = writeln!(out, "<g clip-path=\"url(#clip{id})\">");
}

fn push_item(out: &mut String, item: &Item) {
    out.push_str("<path");
    if let Some(text) = &item.text {
        // XML has no place for control characters.
        let text: String = text.chars().filter(|c| !c.is_control()).collect();
        let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
        let _ = write!(out, " aria-label=\"{text}\"");
    }
    match item.fill {
        Some(color) => push_color(out, "fill", color),
        None => out.push_str(" fill=\"none\""),
    }
    if let Some(stroke) = item.stroke {
        push_color(out, "stroke", stroke.color);
        let _ = write!(out, " stroke-width=\"{}\" stroke-linejoin=\"round\"", Number(stroke.width));
        if let Some([dash, gap]) = stroke.dash {
            let _ = write!(out, " stroke-dasharray=\"{} {}\"", Number(dash), Number(gap));
        }
    }
    out.push_str(" d=\"");
    push_path(out, &item.path);
    out.push_str("\"/>\n");
}

fn push_color(out: &mut String, name: &str, Color(r, g, b): Color) {
    let _ = write!(out, " {name}=\"#{r:02x}{g:02x}{b:02x}\"");
}

fn push_path(out: &mut String, path: &Path) {
    let pair = |(x, y): Point| format!("{} {}", Number(x), Number(y));
    for segment in &path.0 {
        let _ = match *segment {
            Segment::Move(p) => write!(out, "M{}", pair(p)),
            Segment::Line(p) => write!(out, "L{}", pair(p)),
            Segment::Curve(a, b, p) => write!(out, "C{} {} {}", pair(a), pair(b), pair(p)),
            Segment::Close => write!(out, "Z"),
        };
    }
}

/// A coordinate to a hundredth of a point, without needless zeros.
struct Number(f64);

impl std::fmt::Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Adding zero turns -0 into 0.
        write!(f, "{}", (100.0 * self.0).round() / 100.0 + 0.0)
    }
}
