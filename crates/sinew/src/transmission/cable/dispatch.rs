//! The same step compiled for several instruction sets.
//!
//! The step uses no fused multiply-add and no approximate reciprocal, so all of them compute the same bits.

use super::creep::creep;
use super::lane_group::{Ends, LaneGroup, Motion};
use super::step::advance;
use crate::dispatch::{Arithmetic, InstructionSet, Work};

/// Cables in a group.
pub(super) const LANES: usize = 8;

/// Moves a group of eight.
#[inline]
pub(super) fn advance_on(
    instructions: InstructionSet,
    lanes: &mut LaneGroup<LANES>,
    interval: f64,
    motion: &Motion<LANES>,
    ends: &mut Ends<LANES>,
) {
    instructions.run(Step { lanes, interval, motion, ends });
}

/// Lets a group of eight creep.
#[inline]
pub(super) fn creep_on(instructions: InstructionSet, lanes: &mut LaneGroup<LANES>, interval: f64) {
    instructions.run(Creeping { lanes, interval });
}

struct Creeping<'a> {
    lanes: &'a mut LaneGroup<LANES>,
    interval: f64,
}

impl Work for Creeping<'_> {
    #[inline(always)]
    fn run<A: Arithmetic>(self, _: A) {
        creep(self.lanes, self.interval);
    }
}

struct Step<'a> {
    lanes: &'a mut LaneGroup<LANES>,
    interval: f64,
    motion: &'a Motion<LANES>,
    ends: &'a mut Ends<LANES>,
}

impl Work for Step<'_> {
    #[inline(always)]
    fn run<A: Arithmetic>(self, _: A) {
        advance(self.lanes, self.interval, self.motion, self.ends);
    }
}

#[cfg(test)]
mod tests {
    use super::super::lane_group::Row;
    use super::super::{CableLaw, CableParameters, CablePath, Weakening, WeakeningForm};
    use super::*;
    use std::vec::Vec;

    #[test]
    fn every_instruction_set_computes_the_same_bits() {
        let forms = WeakeningForm::ALL.map(|form| Weakening { form, ..Weakening::rational(0.4, 4e-3, 0.04) });
        for weakening in forms.map(Some).into_iter().chain([None]) {
            let parameters = CableParameters { weakening, ..CableParameters::bench() };
            let law = CableLaw::new(&CablePath::bench(), &parameters, 11).unwrap();
            let run = |set: InstructionSet| -> Vec<u64> {
                let mut lanes = LaneGroup::<LANES>::new(std::slice::from_ref(&law));
                let mut bits = Vec::new();
                for step in 0..4000 {
                    let t = f64::from(step) * 1e-3;
                    let at = |k: usize| (t * (3.0 + k as f64)).sin();
                    let motion = Motion {
                        motor: Row(core::array::from_fn(|k| 4e-4 * at(k) + 1e-5)),
                        anchor: Row(core::array::from_fn(|k| 1e-4 * at(k + 5))),
                    };
                    let mut ends = Ends { near: Row::ZERO, far: Row::ZERO, dissipated: Row::ZERO };
                    advance_on(set, &mut lanes, 1e-3, &motion, &mut ends);
                    bits.extend(ends.near.0.iter().chain(&ends.far.0).map(|x| x.to_bits()));
                }
                assert!(lanes_differ(&bits), "the lanes must differ for the test to mean something");
                bits
            };
            let baseline = run(InstructionSet::Baseline);
            for set in InstructionSet::available() {
                assert!(run(set) == baseline, "{set:?}");
            }
        }
    }

    fn lanes_differ(bits: &[u64]) -> bool {
        let last = &bits[bits.len() - 2 * LANES..];
        last[..LANES].windows(2).all(|pair| pair[0] != pair[1])
    }
}
