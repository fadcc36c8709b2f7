//! A chart of lines with one pair of axes.

use super::axis::Axis;
use super::color::{INK, MUTED};
use super::panel::{self, Panel, Series};
use super::picture::{Anchor, Picture, Rect, Type};
use super::text::Face;

/// Margin of a picture, and the size of its title and caption.
pub const MARGIN: f64 = 14.0;
const TITLE_SIZE: f64 = 15.0;
const CAPTION_SIZE: f64 = 10.5;

/// Several series over one pair of axes, with a legend above them.
pub fn xy(title: &str, caption: &str, x: Axis, y: Axis, series: &[Series]) -> Picture {
    let mut picture = Picture::new(640.0, 420.0);
    let top = heading(&mut picture, title, caption);
    let (left, right) = (MARGIN, picture.width - MARGIN);
    let legend = panel::legend(&mut picture, series, left, right, top);
    let room = Rect { left, top: top + legend + 6.0, right, bottom: picture.height - MARGIN };
    Panel { title: "", x, y, series }.draw(&mut picture, room);
    picture
}

/// Panels beside each other, with one legend for all above them.
pub fn row(title: &str, caption: &str, panels: &[Panel]) -> Picture {
    const EACH: f64 = 440.0;
    let count = panels.len().max(1) as f64;
    let mut picture = Picture::new((EACH * count).max(640.0), 420.0);
    let top = heading(&mut picture, title, caption);
    let (left, right) = (MARGIN, picture.width - MARGIN);
    let named: Vec<Series> = panels.iter().flat_map(|p| p.series.iter().cloned()).collect();
    let legend = panel::legend(&mut picture, &named, left, right, top);
    let each = (right - left) / count;
    for (i, panel) in panels.iter().enumerate() {
        let start = left + each * i as f64;
        let room = Rect {
            left: start,
            top: top + legend + 8.0,
            right: start + each - 1.2 * MARGIN,
            bottom: picture.height - MARGIN,
        };
        panel.draw(&mut picture, room);
    }
    picture
}

/// Sets title and caption; returns the height where the rest begins.
pub fn heading(picture: &mut Picture, title: &str, caption: &str) -> f64 {
    let style = Type {
        face: Face::SemiBold,
        size: TITLE_SIZE,
        color: INK,
        anchor: Anchor::Start,
        upward: false,
    };
    let mut y = MARGIN + TITLE_SIZE;
    picture.text((MARGIN, y), title, style);
    for line in caption.lines() {
        y += 1.6 * CAPTION_SIZE;
        let style = Type { face: Face::Regular, size: CAPTION_SIZE, color: MUTED, ..style };
        picture.text((MARGIN, y), line, style);
    }
    y + 0.7 * CAPTION_SIZE
}
