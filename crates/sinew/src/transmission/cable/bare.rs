//! For tests: cables of chosen compliances over pulleys of chosen friction, and the motion of one end by
//! bisection.

use super::law::CableLaw;
use super::parameters::CableParameters;
use super::path::{CablePath, Segment};
use alloc::vec;
use alloc::vec::Vec;

/// Compliance of the cables, 1/N.
const COMPLIANCE: f64 = 1e-4;

/// Free cable between pulleys without drag, efficiency and pretension: `compliance: [cells]`, m/N,
/// `half_angle: [cells - 1]`.
pub(super) fn law(compliance: &[f64], half_angle: &[f64]) -> CableLaw {
    let mut segments = vec![Segment::Free { length: compliance[0] / COMPLIANCE }];
    for (c, h) in compliance[1..].iter().zip(half_angle) {
        segments.push(Segment::Pulley { wrap: 2.0 * h });
        segments.push(Segment::Free { length: c / COMPLIANCE });
    }
    let parameters = CableParameters {
        friction: 1.0,
        efficiency: 1.0,
        drag: 0.0,
        pretension: 0.0,
        compliance: COMPLIANCE,
        ..CableParameters::bench()
    };
    CableLaw::new(&CablePath::new(segments).unwrap(), &parameters, compliance.len()).unwrap()
}

/// Tensions after the end in front has moved by `distance`, m, while the other is held: positive pulls.
///
/// A cell slides where the tension that reaches it from the end exceeds its own; where the end yields, where
/// it falls below. The tension of the end is found by bisection. Returns its sweep's tensions.
pub(super) fn swept(tension: &[f64], compliance: &[f64], half_angle: &[f64], distance: f64) -> Vec<f64> {
    let s = distance.signum();
    let profile = |end: f64| -> Vec<f64> {
        let mut arriving = end;
        let mut after = Vec::new();
        for (j, own) in tension.iter().enumerate() {
            if j > 0 {
                arriving *= libm::exp(-2.0 * s * half_angle[j - 1]);
            }
            after.push(if s > 0.0 { own.max(arriving) } else { own.min(arriving) });
        }
        after
    };
    let travelled = |end: f64| -> f64 {
        profile(end)
            .iter()
            .zip(tension)
            .zip(compliance)
            .map(|((after, before), c)| c * (after - before))
            .sum()
    };
    let (mut low, mut high) = (0.0, 1e6);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        *(if travelled(middle) < distance { &mut low } else { &mut high }) = middle;
    }
    profile(high)
}

/// Numbers that look random, the same in every run.
pub(super) struct Random(pub(super) u64);

impl Random {
    /// The next one, in `[low, high)`.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// So many of them.
    pub(super) fn many(&mut self, count: usize, low: f64, high: f64) -> Vec<f64> {
        (0..count).map(|_| self.between(low, high)).collect()
    }
}
