//! Random numbers from a seed, the same on every machine, for sensor noise and for drawing specimens; evenly
//! spread points for searches and samples.

use alloc::vec::Vec;

/// splitmix64: one 64-bit state, any seed.
///
/// # Example
/// ```
/// use sinew::random::Random;
/// let (mut a, mut b) = (Random::new(7), Random::new(7));
/// assert_eq!(a.unit().to_bits(), b.unit().to_bits());
/// assert!((0.0..1.0).contains(&a.unit()));
/// ```
///
/// # Source
/// `steele2014`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Random(u64);

impl Random {
    /// A generator from a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// 64 random bits.
    #[inline(always)]
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    #[inline]
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Approximately normal with mean 0 and standard deviation 1: the sum of eight uniform 16-bit numbers,
    /// within +-4.9.
    #[inline(always)]
    pub fn normal(&mut self) -> f64 {
        let mut sum = 0;
        for bits in [self.bits(), self.bits()] {
            for shift in [0, 16, 32, 48] {
                sum += (bits >> shift & 0xffff) as u32;
            }
        }
        // The variance of the sum is 8/12 of the squared width.
        const SCALE: f64 = 1.224_744_871_391_589 / 65_536.0;
        (f64::from(sum) - 4.0 * 65_535.0) * SCALE
    }
}

/// Points that fill the unit cube evenly, without end.
///
/// ```text
/// x_i(k) = frac(1/2 + k a^-(i+1)),    a^(n+1) = a + 1
/// ```
///
/// # Example
/// ```
/// use sinew::random::EvenPoints;
/// let points: Vec<Vec<f64>> = EvenPoints::new(2).take(100).collect();
/// let corner = points.iter().filter(|x| x[0] < 0.5 && x[1] < 0.5).count();
/// assert!((24..=26).contains(&corner) && points[0] == [0.5, 0.5]);
/// ```
///
/// # Source
/// `roberts2018`: generalised golden ratio.
#[derive(Debug, Clone, PartialEq)]
pub struct EvenPoints {
    steps: Vec<f64>,
    k: usize,
}

impl EvenPoints {
    /// From the middle of a cube of `dimensions`.
    #[must_use]
    pub fn new(dimensions: usize) -> Self {
        let mut ratio = 2.0_f64;
        for _ in 0..60 {
            ratio = libm::pow(1.0 + ratio, 1.0 / (dimensions as f64 + 1.0));
        }
        Self { steps: (0..dimensions).map(|i| libm::pow(ratio, -(i as f64 + 1.0))).collect(), k: 0 }
    }
}

impl Iterator for EvenPoints {
    type Item = Vec<f64>;

    fn next(&mut self) -> Option<Vec<f64>> {
        let k = self.k as f64;
        self.k += 1;
        Some(self.steps.iter().map(|step| (0.5 + k * step) % 1.0).collect())
    }

    fn nth(&mut self, n: usize) -> Option<Vec<f64>> {
        self.k += n;
        self.next()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_numbers_have_mean_zero_and_variance_one() {
        let mut random = Random::new(1);
        let n = 200_000;
        let (mut sum, mut squares, mut fourths) = (0.0, 0.0, 0.0);
        for _ in 0..n {
            let x = random.normal();
            assert!(x.abs() < 5.0);
            (sum, squares, fourths) = (sum + x, squares + x * x, fourths + x.powi(4));
        }
        let n = f64::from(n);
        assert!((sum / n).abs() < 0.01 && (squares / n - 1.0).abs() < 0.01, "{sum} {squares}");
        // Kurtosis of a normal distribution is 3, of the sum of eight uniform ones 2.85.
        assert!((fourths / n - 2.85).abs() < 0.1, "{fourths}");
    }
}
