//! Angles without branches, so that the compiler evaluates several at once.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use pulp::Simd;

use super::lanes::Lanes;

/// tan(π/8): above it π/4 is split off.
const TAN_PI_8: f64 = 0.414_213_562_373_095_03;

/// `(atan(t) / t - 1) / t²` as a polynomial in t², fitted by Remez exchange for
/// the smallest relative error of the arctangent on |t| ≤ tan(π/8): 1.3e-18.
const ATAN: [f64; 11] = [
    -0.333_333_333_333_332,
    0.199_999_999_999_532_47,
    -0.142_857_142_801_665_98,
    0.111_111_107_821_566_04,
    -0.090_908_977_252_941_57,
    0.076_920_597_181_374_62,
    -0.066_630_992_113_782_77,
    0.058_478_593_260_841_18,
    -0.050_391_906_538_212_43,
    0.038_062_145_472_080_27,
    -0.017_905_045_403_643_426,
];

/// The angle of each point `(x, y)` with `y ≥ 0` against the x-axis, in [0, π];
/// 0 at the origin. Within three units in the last place of the exact one.
#[inline(always)]
pub(super) fn upper_angle<S: Simd>(y: Lanes<S>, x: Lanes<S>) -> Lanes<S> {
    let simd = y.0;
    let across = x.abs();
    let steep = y.above(across);
    let (low, high) = (steep.choose(across, y), steep.choose(y, across));
    let upper = low.above(TAN_PI_8 * high);
    let (above, below) = (upper.choose(low - high, low), upper.choose(low + high, high));
    // At the origin 0/1 for 0/0.
    let (zero, one) = (Lanes::all(simd, 0.0), Lanes::all(simd, 1.0));
    let t = above / zero.above_or_at(below).choose(one, below);
    let z = t * t;
    let mut series = Lanes::all(simd, ATAN[10]);
    for k in 1..11 {
        series = series * z + Lanes::all(simd, ATAN[10 - k]);
    }
    let rest = t + t * (z * series);
    let angle = upper.choose(Lanes::all(simd, FRAC_PI_4) + rest, rest);
    let angle = steep.choose(Lanes::all(simd, FRAC_PI_2) - angle, angle);
    zero.above(x).choose(Lanes::all(simd, PI) - angle, angle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::Scalar;

    fn upper_angle(y: f64, x: f64) -> f64 {
        super::upper_angle(Lanes::all(Scalar, y), Lanes::all(Scalar, x)).1
    }

    /// The reference is the C library's function, good to one unit.
    #[test]
    fn upper_angle_is_the_two_argument_arctangent() {
        for i in 0..=4000 {
            let turn = PI * f64::from(i) / 4000.0;
            for size in [1e-150, 1e-9, 1.0, 3e7] {
                let (y, x) = (size * turn.sin().abs(), size * turn.cos());
                let exact = y.atan2(x);
                assert!((upper_angle(y, x) - exact).abs() <= 3.0 * f64::EPSILON * exact, "{y} {x}");
            }
        }
    }

    #[test]
    fn upper_angle_at_its_edges() {
        assert_eq!(upper_angle(0.0, 0.0), 0.0);
        assert_eq!(upper_angle(0.0, 2.0), 0.0);
        assert_eq!(upper_angle(0.0, -2.0), PI);
        assert_eq!(upper_angle(2.0, 0.0), FRAC_PI_2);
        assert_eq!(upper_angle(1e-300, 1.0), 1e-300);
        assert!(upper_angle(f64::NAN, 1.0).is_nan());
        assert!(upper_angle(1.0, f64::NAN).is_nan());
    }
}
