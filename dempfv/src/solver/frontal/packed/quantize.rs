//! Cube roots of multipliers as whole numbers of 16 bits, or of 8 in steps that are fitted to a
//! column.

/// Roots are whole numbers below this one.
pub(super) const ROOT_LEVELS: f32 = 65536.0;

/// Size of the largest multiplier of a column, as it is kept: the cube of the largest
/// root.
pub(super) const SCALED_MAX: f32 = 0.999_954_2;

/// Multipliers from here down are none: their roots are far below one.
const NEGLIGIBLE_ENTRY: f32 = 1e-20;

/// What a half of a word is added to: a number in single precision whose last bit is one,
/// and so the sum's bits are the number's or'ed with the half's. The root is the sum times
/// the scale and the offset added.
pub const CODE_BASE: f32 = 8_388_608.0;
pub const ROOT_SCALE: f32 = 1.0 / ROOT_LEVELS;
pub const ROOT_OFFSET: f32 = -CODE_BASE * ROOT_SCALE;

/// Blocks of a column whose multipliers are no larger have 8 bits an entry, see [`step_of`]. With
/// larger ones a correction leaves more, and a third becomes more frequent.
pub(super) const EIGHT_BIT_LIMIT: f32 = 5e-4;

/// Steps of the roots of 8-bit blocks, from 2⁻¹⁰ down in steps of their own: single
/// precision with three binary digits, of which this is the first.
const STEP_BASE: u32 = (127 - 10) << 3;

/// The step of a 8-bit block by its byte; roots are up to 255 of them.
#[inline(always)]
pub fn step_of(byte: u32) -> f32 {
    f32::from_bits((STEP_BASE - byte) << 20)
}

/// The byte of the smallest step that is enough for multipliers up to this one. Blocks of zeros
/// have that of [`NEGLIGIBLE_ENTRY`]: cubes of smaller steps times a solve's values leave the
/// range in which processors are fast.
pub(super) fn step_for(largest: f32) -> u32 {
    let least = (largest.max(NEGLIGIBLE_ENTRY).cbrt() / 255.0).to_bits();
    STEP_BASE - least.div_ceil(1 << 20)
}

/// The root of a multiplier to the nearest whole number.
#[inline(always)]
pub(super) fn encode(multiplier: f32) -> u32 {
    let multiplier = multiplier.max(NEGLIGIBLE_ENTRY);
    // A third of the exponent and its bias: within 7 %, of which each of Halley's steps
    // leaves less than the cube.
    let mut root = f32::from_bits(multiplier.to_bits() / 3 + 0x2a51_1cd0);
    for _ in 0..2 {
        let cube = root * root * root;
        root *= (cube + 2.0 * multiplier) / (2.0 * cube + multiplier);
    }
    (root * ROOT_LEVELS + CODE_BASE).to_bits() - CODE_BASE.to_bits()
}

#[inline(always)]
pub(super) fn decode(code: u32) -> f32 {
    let root = f32::from_bits(CODE_BASE.to_bits() | code) * ROOT_SCALE + ROOT_OFFSET;
    root * root * root
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every whole number is the root of the multiplier that it stands for; and a multiplier in
    /// between becomes one of the two beside it, whose roots differ from its own by half a
    /// unit at most, but for round-off.
    #[test]
    fn roots_are_rounded_to_the_nearest() {
        for root in 0..ROOT_LEVELS as u32 {
            assert_eq!(encode(decode(root)), root);
            let between = (f64::from(root) + 0.4) / f64::from(ROOT_LEVELS);
            let above = (f64::from(root) + 0.6) / f64::from(ROOT_LEVELS);
            assert_eq!(encode(between.powi(3) as f32), root);
            assert_eq!(encode(above.powi(3) as f32), root + 1);
        }
        assert_eq!(encode(SCALED_MAX), ROOT_LEVELS as u32 - 1);
        assert_eq!(encode(0.0), 0);
    }

    /// The step of a 8-bit block is large enough for its largest multiplier, and an eighth
    /// larger than that needs at most; its byte is one.
    #[test]
    fn steps_fit() {
        for k in 0..160 {
            let largest = EIGHT_BIT_LIMIT * 0.8f32.powi(k);
            let byte = step_for(largest);
            let (step, root) = (step_of(byte), largest.cbrt());
            assert!(root <= 255.4 * step && root >= 226.0 * step && byte < 256, "{largest}");
        }
        assert_eq!(step_for(0.0), step_for(NEGLIGIBLE_ENTRY));
        // What is multiplied by it stays a normal number, unless it is as small as that.
        assert!(step_of(step_for(0.0)).powi(3) > 1e-28);
    }
}
