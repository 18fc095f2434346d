//! Whole numbers in the tables of devices.

/// Whether a number is whole, not negative and at most the largest.
pub(crate) fn is_whole(x: f64, largest: f64) -> bool {
    (0.0..=largest).contains(&x) && x.trunc().to_bits() == x.abs().to_bits()
}
