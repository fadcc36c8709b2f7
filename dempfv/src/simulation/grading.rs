//! The grading of spheres as they are.

use serde::Serialize;

/// Diameters by mass: `d50_m` is the one that half of the mass is finer than.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Grading {
    /// The smallest diameter (m).
    pub smallest_m: f64,
    /// A tenth of the mass is in finer spheres (m).
    pub d10_m: f64,
    /// Three tenths are (m).
    pub d30_m: f64,
    /// Half is (m).
    pub d50_m: f64,
    /// Six tenths are (m).
    pub d60_m: f64,
    /// Nine tenths are (m).
    pub d90_m: f64,
    /// The largest diameter (m).
    pub largest_m: f64,
    /// Coefficient of uniformity d60/d10 (1).
    pub uniformity: f64,
    /// Coefficient of curvature d30² / (d10 d60) (1).
    pub curvature: f64,
    /// The sizes, where there are no more than [`Grading::MOST_CLASSES`]; else none.
    pub classes: Vec<GradingClass>,
}

/// Spheres of one size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GradingClass {
    /// Their diameter (m).
    pub diameter_m: f64,
    /// Their number.
    pub spheres: u64,
    /// Their share of the mass (1).
    pub mass_share: f64,
}

impl Grading {
    /// More sizes than these are no classes.
    pub const MOST_CLASSES: usize = 12;

    /// Of spheres with these radii (m), of one density; `None` without a sphere.
    ///
    /// ```
    /// use dempfv::simulation::Grading;
    /// let grading = Grading::of(&[2.0, 1.0, 1.0]).unwrap();
    /// assert_eq!((grading.d10_m, grading.d50_m, grading.classes.len()), (2.0, 4.0, 2));
    /// assert_eq!(grading.classes[0].mass_share, 0.2);
    /// ```
    pub fn of(radius: &[f64]) -> Option<Grading> {
        let mut diameter: Vec<f64> = radius.iter().map(|r| 2.0 * r).collect();
        diameter.sort_by(f64::total_cmp);
        let (&smallest_m, &largest_m) = (diameter.first()?, diameter.last()?);
        let total: f64 = diameter.iter().map(|d| d.powi(3)).sum();
        let at = |share: f64| {
            let mut finer = 0.0;
            let reached = |d: &&f64| {
                finer += d.powi(3);
                finer >= share * total
            };
            diameter.iter().find(reached).copied().unwrap_or(largest_m)
        };
        let [d10_m, d30_m, d50_m, d60_m, d90_m] = [0.1, 0.3, 0.5, 0.6, 0.9].map(at);
        let all = diameter.chunk_by(|a, b| a == b);
        let class = |alike: &[f64]| {
            let (diameter_m, spheres) = (alike[0], alike.len() as u64);
            GradingClass {
                diameter_m,
                spheres,
                mass_share: spheres as f64 * diameter_m.powi(3) / total,
            }
        };
        let classes = match all.clone().count() <= Grading::MOST_CLASSES {
            true => all.map(class).collect(),
            false => vec![],
        };
        Some(Grading {
            smallest_m,
            d10_m,
            d30_m,
            d50_m,
            d60_m,
            d90_m,
            largest_m,
            uniformity: d60_m / d10_m,
            curvature: d30_m * d30_m / (d10_m * d60_m),
            classes,
        })
    }
}
