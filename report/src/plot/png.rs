//! A picture as PNG.

use tiny_skia::{
    FillRule, LineCap, LineJoin, Mask, Paint, PathBuilder, Pixmap, Stroke, StrokeDash, Transform,
};

use super::color::Color;
use super::picture::{Path, Picture, Rect, Segment};

/// Pixels per point: sharp on screens of high density and in print (144 dpi).
pub const PIXELS_PER_POINT: f32 = 2.0;

/// The whole file; `None` for a picture without area or beyond memory.
pub fn render(picture: &Picture) -> Option<Vec<u8>> {
    let pixels = |points: f64| (points as f32 * PIXELS_PER_POINT).ceil() as u32;
    let mut pixmap = Pixmap::new(pixels(picture.width), pixels(picture.height))?;
    pixmap.fill(tiny_skia::Color::WHITE);
    let transform = Transform::from_scale(PIXELS_PER_POINT, PIXELS_PER_POINT);
    let mut clip: Option<(Rect, Mask)> = None;
    for item in &picture.items {
        let Some(path) = outline(&item.path) else { continue };
        match item.clip {
            Some(area) if clip.as_ref().is_none_or(|(a, _)| *a != area) => {
                let mut mask = Mask::new(pixmap.width(), pixmap.height())?;
                mask.fill_path(&outline(&Path::rect(area))?, FillRule::Winding, true, transform);
                clip = Some((area, mask));
            }
            _ => {}
        }
        let mask = item.clip.and(clip.as_ref()).map(|(_, mask)| mask);
        if let Some(color) = item.fill {
            pixmap.fill_path(&path, &paint(color), FillRule::Winding, transform, mask);
        }
        if let Some(s) = item.stroke {
            let stroke = Stroke {
                width: s.width as f32,
                line_cap: LineCap::Butt,
                line_join: LineJoin::Round,
                dash: s.dash.and_then(|d| StrokeDash::new(d.map(|l| l as f32).to_vec(), 0.0)),
                ..Stroke::default()
            };
            pixmap.stroke_path(&path, &paint(s.color), &stroke, transform, mask);
        }
    }
    pixmap.encode_png().ok()
}

fn paint(Color(r, g, b): Color) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, 255);
    paint
}

fn outline(path: &Path) -> Option<tiny_skia::Path> {
    let mut out = PathBuilder::new();
    for segment in &path.0 {
        match *segment {
            Segment::Move((x, y)) => out.move_to(x as f32, y as f32),
            Segment::Line((x, y)) => out.line_to(x as f32, y as f32),
            Segment::Curve(a, b, p) => {
                out.cubic_to(a.0 as f32, a.1 as f32, b.0 as f32, b.1 as f32, p.0 as f32, p.1 as f32)
            }
            Segment::Close => out.close(),
        }
    }
    out.finish()
}
