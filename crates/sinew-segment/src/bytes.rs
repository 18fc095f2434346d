//! Little-endian numbers in octets. What lies outside of a slice reads as zero and is not written.

pub(crate) fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes(array(bytes, at))
}

pub(crate) fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(array(bytes, at))
}

pub(crate) fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(array(bytes, at))
}

/// Up to eight octets as an unsigned number.
pub(crate) fn unsigned(bytes: &[u8]) -> u64 {
    bytes.iter().take(8).rev().fold(0, |sum, byte| sum << 8 | u64::from(*byte))
}

/// Up to eight octets as a signed number.
pub(crate) fn signed(bytes: &[u8]) -> i64 {
    let unused = 64 - 8 * bytes.len().clamp(1, 8) as u32;
    ((unsigned(bytes) << unused) as i64) >> unused
}

pub(crate) fn put(bytes: &mut [u8], at: usize, value: &[u8]) {
    if let Some(place) = bytes.get_mut(at..at + value.len()) {
        place.copy_from_slice(value);
    }
}

fn array<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    let mut value = [0; N];
    if let Some(found) = bytes.get(at..at + N) {
        value.copy_from_slice(found);
    }
    value
}

/// Copies `count` bits; bit 0 is the least significant of the first octet. Bits outside of either slice are
/// left out.
pub(crate) fn copy_bits(from: &[u8], from_bit: usize, to: &mut [u8], to_bit: usize, count: usize) {
    if (from_bit | to_bit | count).is_multiple_of(8) {
        let (a, b, n) = (from_bit / 8, to_bit / 8, count / 8);
        if let (Some(source), Some(target)) = (from.get(a..a + n), to.get_mut(b..b + n)) {
            target.copy_from_slice(source);
            return;
        }
    }
    for bit in 0..count {
        let (a, b) = (from_bit + bit, to_bit + bit);
        if let (Some(source), Some(target)) = (from.get(a / 8), to.get_mut(b / 8)) {
            let mask = 1 << (b % 8);
            *target = if source >> (a % 8) & 1 == 1 { *target | mask } else { *target & !mask };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_sign_at_every_width() {
        assert_eq!(signed(&[0xff]), -1);
        assert_eq!(signed(&[0xff, 0x7f]), 0x7fff);
        assert_eq!(signed(&[0, 0, 0x80]), -0x80_0000);
        assert_eq!(signed(&[0xfe, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff]), -2);
        assert_eq!(signed(&[]), 0);
        assert_eq!(u16_at(&[1], 0), 0);
    }

    #[test]
    fn bits_move_across_octets_and_leave_the_others_alone() {
        let mut to = [0xff, 0x00];
        copy_bits(&[0b1010_0000], 5, &mut to, 6, 3);
        assert_eq!(to, [0b0111_1111, 0b1]);
        copy_bits(&[1, 2, 3], 8, &mut to, 0, 16);
        assert_eq!(to, [2, 3]);
        copy_bits(&[0xff], 0, &mut to, 12, 8);
        assert_eq!(to, [2, 0xf3]);
    }
}
