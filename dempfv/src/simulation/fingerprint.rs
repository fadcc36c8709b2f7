//! A hash of numbers, of their very bits.

/// FNV-1a, 64 bits.
pub(super) fn fingerprint(numbers: impl Iterator<Item = f64>) -> u64 {
    numbers.flat_map(|x| x.to_bits().to_le_bytes()).fold(0xcbf2_9ce4_8422_2325u64, |h, byte| {
        (h ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}
