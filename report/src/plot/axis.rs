//! Axes: range, ticks, and the numbers at them.

/// How values become lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// Equal differences of equal length.
    Linear,
    /// Decades of equal length; values that are not positive are not shown.
    Log,
}

/// What the user of a chart says about an axis.
#[derive(Clone, Copy, Debug)]
pub struct Axis<'a> {
    /// Quantity and unit, as in `Axial strain (%)`, in the markup of
    /// [`super::text::Layout`].
    pub label: &'a str,
    /// How values become lengths.
    pub scale: Scale,
    /// First and last value; from the data if `None`.
    pub range: Option<[f64; 2]>,
}

impl<'a> Axis<'a> {
    /// A linear axis that shows all data.
    pub fn linear(label: &'a str) -> Axis<'a> {
        Axis { label, scale: Scale::Linear, range: None }
    }

    /// A logarithmic axis that shows all positive data.
    pub fn log(label: &'a str) -> Axis<'a> {
        Axis { label, scale: Scale::Log, range: None }
    }

    /// The same axis from `first` to `last`.
    pub fn spanning(self, first: f64, last: f64) -> Axis<'a> {
        Axis { range: Some([first, last]), ..self }
    }

    /// The values at the axis's ends when it shows these data.
    pub fn limits(&self, values: impl Iterator<Item = f64>) -> [f64; 2] {
        if let Some(range) = self.range {
            return range;
        }
        let shown = values.filter(|v| v.is_finite() && (self.scale == Scale::Linear || *v > 0.0));
        let [low, high] = shown
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
        match self.scale {
            _ if low > high => [self.scale.floor(), 1.0],
            Scale::Linear => widen(low, high),
            Scale::Log if low == high => [low / 2.0, high * 2.0],
            Scale::Log => {
                let margin = (high / low).powf(0.03);
                [low / margin, high * margin]
            }
        }
    }
}

impl Scale {
    /// A lower end for an axis without data.
    fn floor(self) -> f64 {
        match self {
            Scale::Linear => 0.0,
            Scale::Log => 0.1,
        }
    }

    /// Share of the way from the first limit to the last, NaN where there is
    /// none.
    pub fn share(self, value: f64, [first, last]: [f64; 2]) -> f64 {
        match self {
            Scale::Linear => (value - first) / (last - first),
            Scale::Log if value > 0.0 => (value / first).ln() / (last / first).ln(),
            Scale::Log => f64::NAN,
        }
    }
}

/// Some air around the data; zero becomes an end where the data begin near it.
fn widen(low: f64, high: f64) -> [f64; 2] {
    let span = high - low;
    if span <= 1e-12 * low.abs().max(high.abs()) {
        let air = if low == 0.0 { 1.0 } else { 0.1 * low.abs() };
        return [low - air, high + air];
    }
    let air = 0.04 * span;
    let near_zero = |v: f64| v.abs() <= 0.15 * span;
    match (low >= 0.0 && near_zero(low), high <= 0.0 && near_zero(high)) {
        (true, _) => [0.0, high + air],
        (_, true) => [low - air, 0.0],
        _ => [low - air, high + air],
    }
}

/// The ticks of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Ticks {
    /// Values with a number.
    pub at: Vec<f64>,
    /// The numbers, in text markup.
    pub text: Vec<String>,
    /// Values with a small tick only.
    pub minor: Vec<f64>,
    /// All numbers are to be multiplied by ten to this power.
    pub exponent: i32,
}

impl Ticks {
    /// Ticks for about `count` numbers between two limits (in either order).
    pub fn new(scale: Scale, [first, last]: [f64; 2], count: usize) -> Ticks {
        let (low, high) = (first.min(last), first.max(last));
        match scale {
            Scale::Linear => linear(low, high, count),
            Scale::Log => log(low, high, count),
        }
    }
}

fn linear(low: f64, high: f64, count: usize) -> Ticks {
    let rough = (high - low) / count.max(1) as f64;
    let decade = 10_f64.powf(rough.log10().floor());
    let mantissa = [1.0, 2.0, 2.5, 5.0, 10.0].into_iter().find(|m| m * decade >= 0.999 * rough);
    let mantissa = mantissa.unwrap_or(10.0);
    let step = mantissa * decade;
    let at = multiples(step, low, high);
    let size = low.abs().max(high.abs());
    let exponent = match size.log10().floor() as i32 {
        e if (-3..5).contains(&e) => 0,
        e => 3 * e.div_euclid(3),
    };
    let unit = 10_f64.powi(exponent);
    // Digits after the point that tell neighbours apart.
    let digits = -((step / unit).log10() + 1e-9).floor() + if mantissa == 2.5 { 1.0 } else { 0.0 };
    let text = at.iter().map(|v| number(v / unit, digits.max(0.0) as usize)).collect();
    let parts = if mantissa == 2.0 { 4.0 } else { 5.0 };
    Ticks { text, minor: multiples(step / parts, low, high), at, exponent }
}

/// Multiples of a step within limits, with a little tolerance at their ends.
fn multiples(step: f64, low: f64, high: f64) -> Vec<f64> {
    let first = (low / step - 1e-6).ceil() as i64;
    let last = (high / step + 1e-6).floor() as i64;
    (first..=last).map(|i| i as f64 * step).collect()
}

fn log(low: f64, high: f64, count: usize) -> Ticks {
    let tolerance = 1.0 + 1e-9;
    let inside = |v: &f64| *v >= low / tolerance && *v <= high * tolerance;
    let first = low.log10().floor() as i32;
    let last = high.log10().ceil() as i32;
    let decades = |mantissas: &[f64], every: usize| -> Vec<f64> {
        let powers = (first..=last).filter(|k| k.rem_euclid(every as i32) == 0);
        powers
            .flat_map(|k| mantissas.iter().map(move |m| m * 10_f64.powi(k)))
            .filter(inside)
            .collect()
    };
    let every = ((last - first) as usize).div_ceil(count.max(1)).max(1);
    let mut at = decades(&[1.0], every);
    if at.len() < 3 {
        at = decades(&[1.0, 2.0, 5.0], 1);
    }
    let plain = at.iter().all(|v| (1e-3..1e5).contains(&(v * tolerance)));
    let text = at.iter().map(|&v| if plain { shortest(v) } else { power(v) }).collect();
    let minor = if every == 1 { (1..10).map(f64::from).collect() } else { vec![1.0] };
    Ticks { text, minor: decades(&minor, 1), at, exponent: 0 }
}

fn power(value: f64) -> String {
    let k = (value.log10() + 1e-9).floor();
    let mantissa = (value / 10_f64.powf(k)).round();
    let factor = if mantissa == 1.0 { String::new() } else { format!("{mantissa}·") };
    minus(format!("{factor}10^{{{k}}}"))
}

/// Decimals beyond which no digit of a double is left.
const MOST_DECIMALS: usize = 340;

/// A number with a true minus sign and a fixed number of decimals.
pub fn number(value: f64, digits: usize) -> String {
    // The formatter refuses more than 65,535.
    let digits = digits.min(MOST_DECIMALS);
    minus(format!("{:.digits$}", value + 0.0))
}

/// A number with few, but enough decimals.
pub fn shortest(value: f64) -> String {
    minus(format!("{}", value as f32))
}

fn minus(text: String) -> String {
    text.replace('-', "−")
}

/// The engineering prefix that brings a size to between 1 and 1000, and its
/// factor.
pub fn prefix(size: f64) -> (&'static str, f64) {
    const PREFIXES: [(&str, f64); 9] = [
        ("p", 1e-12),
        ("n", 1e-9),
        ("µ", 1e-6),
        ("m", 1e-3),
        ("", 1.0),
        ("k", 1e3),
        ("M", 1e6),
        ("G", 1e9),
        ("T", 1e12),
    ];
    let fitting = PREFIXES.into_iter().rev().find(|(_, factor)| size.abs() >= *factor);
    // Zero, and what is below them all, has no prefix.
    fitting.unwrap_or(("", 1.0))
}
