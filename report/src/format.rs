//! Numbers as people read them.

use crate::plot::axis::prefix;

/// A quantity with an SI prefix and three digits: 11 kPa, 0.75 mm.
pub fn si(value: f64, unit: &str) -> String {
    let size = value.abs();
    // A value that rounds up to the prefix belongs to it.
    let (prefix, scale) = prefix(size * (1000.0 / 999.5));
    match size {
        0.0 => format!("0 {unit}"),
        1e-12..9.995e11 => format!("{} {prefix}{unit}", three_digits(value / scale)),
        _ => format!("{value:.2e} {unit}"),
    }
}

/// Three significant digits, without trailing zeros behind the point.
pub fn three_digits(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let magnitude = value.abs().log10().floor();
    if !(-4.0..6.0).contains(&magnitude) {
        return format!("{value:.2e}");
    }
    let decimals = (2.0 - magnitude).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// A count with its thousands apart: 119,578.
pub fn count(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A time that passes on the clock: 35 ms, 42 s, 5 min, 3 h.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => si(s, "s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

/// A size in memory.
pub fn bytes(size: f64) -> String {
    si(size, "B")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_read_well() {
        assert_eq!(si(1.1e4, "Pa"), "11 kPa");
        assert_eq!(si(0.00075, "m"), "750 µm");
        assert_eq!(si(-0.01, "m/s"), "-10 mm/s");
        assert_eq!(si(999.99, "s"), "1 ks");
        assert_eq!(si(0.0, "Pa"), "0 Pa");
        assert_eq!(si(1e-15, "m²"), "1.00e-15 m²");
        assert_eq!(si(1e6, "Pa"), "1 MPa");
        assert_eq!(count(1), "1");
        assert_eq!(count(119_578), "119,578");
        assert_eq!(count(1_000_000), "1,000,000");
        assert_eq!(duration(0.035), "35 ms");
        assert_eq!(duration(300.0), "5 min");
        assert_eq!(three_digits(0.05), "0.05");
        assert_eq!(three_digits(2600.0), "2600");
        assert_eq!(three_digits(1234567.0), "1.23e6");
    }
}
