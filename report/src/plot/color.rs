//! Colours that stay apart for colour-blind readers and in grey print.

/// Red, green, blue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Color(pub u8, pub u8, pub u8);

/// The paper.
pub const WHITE: Color = Color(255, 255, 255);
/// Text and axes.
pub const INK: Color = Color(38, 38, 38);
/// Secondary text.
pub const MUTED: Color = Color(105, 105, 105);
/// Grid lines.
pub const GRID: Color = Color(226, 226, 226);
/// Theory.
pub const BLACK: Color = Color(0, 0, 0);

/// For series without an order (Okabe and Ito's palette, the darker ones
/// first; yellow is left out: too faint on white).
pub const SERIES: [Color; 7] = [
    Color(0, 114, 178),
    Color(213, 94, 0),
    Color(0, 158, 115),
    Color(204, 121, 167),
    Color(230, 159, 0),
    Color(86, 180, 233),
    Color(90, 90, 90),
];

/// Ten equidistant colours of the viridis map.
const VIRIDIS: [Color; 10] = [
    Color(68, 1, 84),
    Color(72, 40, 120),
    Color(62, 73, 137),
    Color(49, 104, 142),
    Color(38, 130, 142),
    Color(31, 158, 137),
    Color(53, 183, 121),
    Color(110, 206, 88),
    Color(181, 222, 43),
    Color(253, 231, 37),
];

/// Colour of a share 0 to 1 of an ordered range: dark and blue to light and
/// yellow, evenly in lightness (viridis).
pub fn viridis(share: f64) -> Color {
    let position = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let i = (position as usize).min(VIRIDIS.len() - 2);
    mix(VIRIDIS[i], VIRIDIS[i + 1], position - i as f64)
}

fn mix(a: Color, b: Color, share: f64) -> Color {
    let channel =
        |a: u8, b: u8| (f64::from(a) + share * (f64::from(b) - f64::from(a))).round() as u8;
    Color(channel(a.0, b.0), channel(a.1, b.1), channel(a.2, b.2))
}
