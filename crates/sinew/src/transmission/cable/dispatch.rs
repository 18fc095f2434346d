//! The same step compiled for several instruction sets, and the choice of one when the program runs.
//!
//! No instruction set may round differently: the step uses no fused multiply-add and no approximate
//! reciprocal, so every machine computes the same bits.

use super::lanes::{Ends, Lanes, Motion};
use super::step::advance;

/// Cables in a group.
pub(super) const LANES: usize = 8;

/// What this processor can do, found out once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum InstructionSet {
    /// Whatever every processor of this architecture has.
    Baseline,
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    Avx2,
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    Avx512,
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
cpufeatures::new!(has_avx2, "avx2");
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
cpufeatures::new!(has_avx512, "avx512f", "avx512dq", "avx512vl");

impl InstructionSet {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    pub(super) fn detect() -> Self {
        if has_avx512::get() {
            Self::Avx512
        } else if has_avx2::get() {
            Self::Avx2
        } else {
            Self::Baseline
        }
    }

    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    pub(super) fn detect() -> Self {
        Self::Baseline
    }

    /// Moves a group of eight.
    #[inline]
    pub(super) fn advance(
        self,
        lanes: &mut Lanes<LANES>,
        interval: f64,
        motion: &Motion<LANES>,
        ends: &mut Ends<LANES>,
    ) {
        match self {
            Self::Baseline => baseline(lanes, interval, motion, ends),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            #[expect(
                unsafe_code,
                reason = "a function for an instruction set may be called only where it exists"
            )]
            // SAFETY: these variants are made by `detect` alone, after the processor and the operating
            // system have said that the instructions are there (tests ask the same before they make one).
            // Nothing else about these functions is unsafe.
            Self::Avx2 | Self::Avx512 => unsafe {
                if self == Self::Avx2 {
                    avx2(lanes, interval, motion, ends);
                } else {
                    avx512(lanes, interval, motion, ends);
                }
            },
        }
    }
}

fn baseline(lanes: &mut Lanes<LANES>, interval: f64, motion: &Motion<LANES>, ends: &mut Ends<LANES>) {
    advance(lanes, interval, motion, ends);
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
#[target_feature(enable = "avx2")]
fn avx2(lanes: &mut Lanes<LANES>, interval: f64, motion: &Motion<LANES>, ends: &mut Ends<LANES>) {
    advance(lanes, interval, motion, ends);
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
#[target_feature(enable = "avx512f,avx512dq,avx512vl")]
fn avx512(lanes: &mut Lanes<LANES>, interval: f64, motion: &Motion<LANES>, ends: &mut Ends<LANES>) {
    advance(lanes, interval, motion, ends);
}

#[cfg(test)]
mod tests {
    use super::super::lanes::Row;
    use super::super::{CableLaw, CableParameters, Path, Weakening};
    use super::*;
    use std::vec::Vec;

    /// Every instruction set of this machine.
    fn available() -> Vec<InstructionSet> {
        let mut sets = std::vec![InstructionSet::Baseline];
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        {
            sets.extend(has_avx2::get().then_some(InstructionSet::Avx2));
            sets.extend(has_avx512::get().then_some(InstructionSet::Avx512));
        }
        sets
    }

    #[test]
    fn every_instruction_set_computes_the_same_bits() {
        let weakening = Some(Weakening { rise: 0.4, speed: 4e-3, lag: 0.04 });
        for weakening in [None, weakening] {
            let parameters = CableParameters { weakening, ..CableParameters::bench() };
            let law = CableLaw::new(&Path::bench(), &parameters, 11).unwrap();
            let run = |set: InstructionSet| -> Vec<u64> {
                let mut lanes = Lanes::<LANES>::new(std::slice::from_ref(&law));
                let mut bits = Vec::new();
                for step in 0..4000 {
                    let t = f64::from(step) * 1e-3;
                    let at = |k: usize| (t * (3.0 + k as f64)).sin();
                    let motion = Motion {
                        motor: Row(core::array::from_fn(|k| 4e-4 * at(k) + 1e-5)),
                        anchor: Row(core::array::from_fn(|k| 1e-4 * at(k + 5))),
                    };
                    let mut ends = Ends { near: Row::ZERO, far: Row::ZERO, dissipated: Row::ZERO };
                    set.advance(&mut lanes, 1e-3, &motion, &mut ends);
                    bits.extend(ends.near.0.iter().chain(&ends.far.0).map(|x| x.to_bits()));
                }
                assert!(ends_differ(&bits), "the lanes did different things");
                bits
            };
            let baseline = run(InstructionSet::Baseline);
            for set in available() {
                assert!(run(set) == baseline, "{set:?}");
            }
        }
    }

    fn ends_differ(bits: &[u64]) -> bool {
        let last = &bits[bits.len() - 2 * LANES..];
        last[..LANES].windows(2).all(|pair| pair[0] != pair[1])
    }
}
