//! One-dimensional consolidation against Terzaghi's theory.

use dempfv::theory::{self, WallLayers};

use super::axis::Axis;
use super::chart::{MARGIN, heading};
use super::color::{BLACK, Color, SERIES, viridis};
use super::panel::{self, Mark, Panel, Series, label_style};
use super::picture::{Anchor, Picture, Rect};
use super::text::Face;

/// What a run has measured; all slices have one entry per time.
#[derive(Clone, Copy, Debug)]
pub struct Consolidation<'a> {
    /// T_v = c_v t / d² with the drainage path d: the height, or half of it where both ends drain.
    pub time_factor: &'a [f64],
    /// Degree of consolidation: settlement over final settlement.
    pub degree: &'a [f64],
    /// Excess pressure at the sealed base, or at the middle of the height where both ends drain,
    /// over the initial excess pressure.
    pub base_pressure: &'a [f64],
    /// The pores at the two ends.
    pub layers: Layers,
    /// Under the title: the specimen, c_v, where it comes from. Lines.
    pub caption: &'a str,
}

/// The layers of pores at the two ends of a specimen.
#[derive(Clone, Copy, Debug)]
pub struct Layers {
    /// Whether both ends drain.
    pub both_ends: bool,
    /// Share of the height in pores that are drained from the start.
    pub drained_share: f64,
    /// Share of the height in pores at a sealed end.
    pub sealed_share: f64,
    /// What both make of Terzaghi's theory.
    pub theory: WallLayers,
}

impl Layers {
    /// Where a height is between the drained layer, 0, and the sealed one or mid-height, 1; beyond
    /// these in the layers.
    fn depth(&self, height: f64) -> f64 {
        let between = 1.0 - self.drained_share - self.sealed_share;
        match self.both_ends {
            true => (1.0 - (1.0 - 2.0 * height).abs() - self.drained_share) / between,
            false => (1.0 - self.drained_share - height) / between,
        }
    }
}

const THEORY: Mark = Mark::Line { width: 1.6, dash: None };
const THEORY_PLAIN: Mark = Mark::Line { width: 1.3, dash: Some([5.0, 3.0]) };
const MEASURED: Mark = Mark::Dots { radius: 3.0, apart: 20.0 };
/// Points of a theory's curve.
const CURVE: usize = 600;

/// Settlement and base pressure against the time factor, with the theory
/// plain and with the layers at the walls counted.
pub fn consolidation(c: &Consolidation) -> Picture {
    let mut picture = Picture::new(900.0, 430.0);
    let top = heading(&mut picture, "Consolidation against Terzaghi’s theory", c.caption);
    let end = c.time_factor.iter().copied().fold(0.0, f64::max).clamp(0.1, 1.5);
    // Dense where the curves are steep.
    let t: Vec<f64> = (0..=CURVE).map(|i| end * (i as f64 / CURVE as f64).powi(3)).collect();
    let Layers { both_ends, theory: layers, .. } = c.layers;
    let curve = |f: &dyn Fn(f64) -> f64| t.iter().map(|&t| f(t)).collect::<Vec<f64>>();
    let settled = curve(&|t| layers.degree(t));
    let settled_plain = curve(&theory::degree_of_consolidation);
    let base = curve(&|t| layers.excess_pressure(1.0, t));
    let base_plain = curve(&|t| theory::excess_pressure(1.0, t));
    let left = compared(c.time_factor, c.degree, &t, &settled_plain, &settled);
    let right = compared(c.time_factor, c.base_pressure, &t, &base_plain, &base);

    let edge = picture.width - MARGIN;
    let legend = panel::legend(&mut picture, &left, MARGIN, edge, top);
    let middle = 0.5 * picture.width;
    let room = |left, right, p: &Picture| Rect {
        left,
        right,
        top: top + legend + 8.0,
        bottom: p.height - MARGIN,
    };
    // Settlement over the logarithm of time, as laboratories draw it.
    let label = match both_ends {
        true => "Time factor *T*_{v} = 4 *c*_{v} *t* / *H*^{2}",
        false => "Time factor *T*_{v} = *c*_{v} *t* / *H*^{2}",
    };
    let first = c.time_factor.iter().copied().fold(end, f64::min).max(1e-3 * end);
    let x = Axis::log(label).spanning(first, end);
    let y = Axis::linear("Degree of consolidation *U*").spanning(0.0, upper(c.degree));
    let area = room(MARGIN, middle - 8.0, &picture);
    Panel { title: "Settlement", x, y, series: &left }.draw(&mut picture, area);
    let (place, title) = match both_ends {
        true => ("Pressure at mid-height", "Pressure at mid-height"),
        false => ("Base pressure", "Pressure at the sealed base"),
    };
    let label_y = format!("{place} / initial excess pressure");
    let y = Axis::linear(&label_y).spanning(0.0, upper(c.base_pressure));
    let x = Axis::linear(label).spanning(0.0, end);
    let area = room(middle + 8.0, edge, &picture);
    Panel { title, x, y, series: &right }.draw(&mut picture, area);
    picture
}

/// Upper end of an axis of shares: a little above 1, or above the data if they
/// overshoot.
fn upper(values: &[f64]) -> f64 {
    0.04 + values.iter().copied().filter(|v| v.is_finite()).fold(1.0, f64::max).min(2.0)
}

/// The measured series above the theory, plain and with the layers at the walls.
fn compared<'a>(
    x: &'a [f64],
    measured: &'a [f64],
    t: &'a [f64],
    plain: &'a [f64],
    layered: &'a [f64],
) -> Vec<Series<'a>> {
    let series =
        |name: &str, x, y, color, mark| Series { name: Some(name.into()), x, y, color, mark };
    vec![
        series("theory, plain", t, plain, BLACK, THEORY_PLAIN),
        series("theory, layers at the walls counted", t, layered, BLACK, THEORY),
        series("simulated", x, measured, SERIES[0], MEASURED),
    ]
}

/// Pressure over height at one time.
#[derive(Clone, Copy, Debug)]
pub struct Profile<'a> {
    /// Time factor T_v with the whole drainage path.
    pub time_factor: f64,
    /// Height over the layer's height: 1 at the drained top, 0 at the base.
    pub height: &'a [f64],
    /// Mean excess pressure at that height over the initial excess pressure.
    pub pressure: &'a [f64],
}

/// Height against excess pressure at several times, with the theory (the
/// drained layer at the top, or half of it at each end).
pub fn profiles(profiles: &[Profile], layers: &Layers, caption: &str) -> Picture {
    let mut picture = Picture::new(620.0, 520.0);
    let top = heading(&mut picture, "Excess pore pressure over the height", caption);
    let height: Vec<f64> = (0..=200).map(|i| f64::from(i) / 200.0).collect();
    let at = |p: &Profile| {
        let pressure = |&h: &f64| layers.theory.excess_pressure(layers.depth(h), p.time_factor);
        height.iter().map(pressure).collect()
    };
    let theory: Vec<Vec<f64>> = profiles.iter().map(at).collect();
    let color = |i: usize| viridis(0.87 * i as f64 / (profiles.len().max(2) - 1) as f64);
    let mut series: Vec<Series> = (theory.iter().enumerate())
        .map(|(i, p)| Series { name: None, x: p, y: &height, color: color(i), mark: THEORY })
        .collect();
    let dots = Mark::Dots { radius: 3.2, apart: 0.0 };
    series.extend((profiles.iter().enumerate()).map(|(i, p)| Series {
        name: None,
        x: p.pressure,
        y: p.height,
        color: color(i),
        mark: dots,
    }));
    let room = Rect {
        left: MARGIN,
        top: top + 8.0,
        right: picture.width - 130.0,
        bottom: picture.height - MARGIN,
    };
    let measured: Vec<f64> = profiles.iter().flat_map(|p| p.pressure).copied().collect();
    let area = Panel {
        title: "",
        x: Axis::linear("Excess pressure / initial excess pressure")
            .spanning(0.0, upper(&measured)),
        y: Axis::linear("Height / height of the layer").spanning(0.0, 1.0),
        series: &series,
    }
    .draw(&mut picture, room);
    let colors: Vec<Color> = (0..profiles.len()).map(color).collect();
    profile_legend(&mut picture, profiles, &colors, (area.right + 18.0, area.top + 10.0));
    picture
}

/// A column beside the axes: what lines and dots are, then the times.
fn profile_legend(
    picture: &mut Picture,
    profiles: &[Profile],
    colors: &[Color],
    (x, mut y): (f64, f64),
) {
    let style = label_style(10.5, Anchor::Start);
    let mut entry = |y: f64, mark: Mark, color: Color, name: &str| {
        let series = Series { name: None, x: &[], y: &[], color, mark };
        panel::sample(picture, &series, (x, y - 3.8));
        picture.text((x + 33.0, y), name, style);
    };
    let dots = Mark::Dots { radius: 3.2, apart: 0.0 };
    entry(y, dots, Color(90, 90, 90), "simulated");
    entry(y + 18.0, THEORY, Color(90, 90, 90), "theory");
    y += 52.0;
    picture.text(
        (x, y),
        "Time factor *T*_{v}",
        super::picture::Type { face: Face::SemiBold, ..style },
    );
    for (profile, &color) in profiles.iter().zip(colors) {
        y += 18.0;
        let series = Series { name: None, x: &[], y: &[], color, mark: THEORY };
        panel::sample(picture, &series, (x, y - 3.8));
        panel::sample(picture, &Series { mark: dots, ..series }, (x, y - 3.8));
        let name = super::axis::shortest((profile.time_factor * 1e4).round() / 1e4);
        picture.text((x + 33.0, y), &name, style);
    }
}
