//! Rice codes: the quotient by a power of two in unary, the remainder in bits.
//!
//! ```text
//! u = (2 x) xor (x >> 63)        x = 0, -1, 1, -2, .. -> u = 0, 1, 2, 3, ..
//! u = q 2^k + r                  q times 1, one 0, k bits of r
//! q >= 24                        24 times 1, 64 bits of u
//! ```
//!
//! # Source
//! Rice, R. F. (1979), Some practical universal noiseless coding techniques, JPL 79-22; the escape is our own.

/// Quotient from which a number is written in full.
const ESCAPE: u32 = 24;
/// Largest parameter.
pub(crate) const MAX_PARAMETER: u32 = 48;

/// Signed to unsigned, small magnitudes first.
#[inline]
pub(crate) fn zigzag(x: i64) -> u64 {
    ((x << 1) ^ (x >> 63)).cast_unsigned()
}

fn from_zigzag(u: u64) -> i64 {
    (u >> 1).cast_signed() ^ -((u & 1).cast_signed())
}

/// Length of the code of a number, bits.
pub(crate) fn length(u: u64, parameter: u32) -> u64 {
    let quotient = u >> parameter;
    if quotient >= u64::from(ESCAPE) { u64::from(ESCAPE) + 64 } else { quotient + 1 + u64::from(parameter) }
}

/// Writes bits, the first one into the highest bit of the first byte.
#[derive(Debug, Default)]
pub(crate) struct BitWriter {
    bytes: Vec<u8>,
    pending: u128,
    count: u32,
}

impl BitWriter {
    fn push(&mut self, bits: u64, count: u32) {
        self.pending = (self.pending << count) | u128::from(bits);
        self.count += count;
        while self.count >= 8 {
            self.count -= 8;
            self.bytes.push((self.pending >> self.count) as u8);
        }
    }

    /// Writes a number.
    pub(crate) fn write(&mut self, x: i64, parameter: u32) {
        let u = zigzag(x);
        let quotient = u >> parameter;
        if quotient >= u64::from(ESCAPE) {
            self.push((1 << ESCAPE) - 1, ESCAPE);
            self.push(u, 64);
        } else {
            let ones = quotient as u32;
            self.push(((1_u64 << ones) - 1) << 1, ones + 1);
            self.push(u & ((1 << parameter) - 1), parameter);
        }
    }

    /// The bytes, the last one filled up with zeros.
    pub(crate) fn finish(mut self) -> Vec<u8> {
        if self.count > 0 {
            let fill = 8 - self.count;
            self.push(0, fill);
        }
        self.bytes
    }
}

/// Reads what [`BitWriter`] has written.
#[derive(Debug)]
pub(crate) struct BitReader<'a> {
    bytes: &'a [u8],
    place: u64,
}

impl<'a> BitReader<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, place: 0 }
    }

    fn bit(&mut self) -> Option<u64> {
        let byte = *self.bytes.get(usize::try_from(self.place / 8).ok()?)?;
        let bit = (byte >> (7 - self.place % 8)) & 1;
        self.place += 1;
        Some(u64::from(bit))
    }

    fn bits(&mut self, count: u32) -> Option<u64> {
        let mut value = 0;
        for _ in 0..count {
            value = (value << 1) | self.bit()?;
        }
        Some(value)
    }

    /// The next number; none after the end.
    pub(crate) fn read(&mut self, parameter: u32) -> Option<i64> {
        let mut ones = 0;
        while ones < ESCAPE && self.bit()? == 1 {
            ones += 1;
        }
        if ones == ESCAPE {
            return Some(from_zigzag(self.bits(64)?));
        }
        let remainder = self.bits(parameter)?;
        Some(from_zigzag((u64::from(ones) << parameter) | remainder))
    }
}
