//! The search for one group's multipliers: what is tried, with which kernel, on which instruction set.

use super::block::Block;
use super::newton::{Outcome, Work};
use super::pattern::FEW;
use super::rows::{Dense, LANES, Rows, Sparse, Wide};
use super::softened::Soft;
use crate::dispatch::{self, Arithmetic, InstructionSet};

/// A group's problem and all that its search works on.
pub(super) struct Search<'a> {
    pub(super) work: &'a mut Work,
    pub(super) block: Block<'a, Sparse<'a>>,
    /// Its arms row by row, and whether every one is kept.
    pub(super) arms: &'a [f64],
    pub(super) whole: bool,
    pub(super) lambda: &'a mut [f64],
    pub(super) soft: Soft<'a>,
    /// Steps allowed, and taken.
    pub(super) most: u32,
    pub(super) steps: &'a mut u32,
}

impl Search<'_> {
    /// Multipliers and tensions, but where they need more digits.
    #[inline(always)]
    pub(super) fn run(mut self, instructions: InstructionSet) -> Outcome {
        // Where the last torque was out of reach, the next one likely is.
        if *self.soft.known && self.approach() == Outcome::Reached {
            return Outcome::Reached;
        }
        *self.soft.known = false;
        match self.ascend(instructions) {
            Outcome::Reached if self.work.is_sharp(self.lambda) => Outcome::Reached,
            Outcome::Reached => Outcome::Unreached,
            Outcome::Unreached => {
                self.soft.lambda.copy_from_slice(self.lambda);
                self.approach()
            }
        }
    }

    /// The wanted torque. Few joints take the plain instructions: wide registers cost more there than they give.
    #[inline(always)]
    fn ascend(&mut self, instructions: InstructionSet) -> Outcome {
        match self.block.joints() {
            1 => self.ascend_few::<1>(),
            2 => self.ascend_few::<2>(),
            FEW => self.ascend_few::<FEW>(),
            _ => {
                let mut outcome = Outcome::Unreached;
                instructions.run(Ascent(self, &mut outcome));
                outcome
            }
        }
    }

    #[inline(always)]
    fn ascend_few<const N: usize>(&mut self) -> Outcome {
        let block = self.block.with(Dense::<N>::new(self.arms));
        self.work.ascend_few(&block, self.lambda, self.most, self.steps)
    }

    #[inline(always)]
    fn ascend_many<R: Rows>(&mut self, rows: R) -> Outcome {
        self.work.ascend(&self.block.with(rows), self.lambda, self.most, self.steps)
    }

    /// The closest torque, aside from the usual way and on plain instructions: it is rare, and its code is long.
    #[inline(never)]
    fn approach(&mut self) -> Outcome {
        let (joints, arms) = (self.block.joints(), self.arms);
        match (self.whole, joints) {
            (true, 1) => self.approach_with(Dense::<1>::new(arms)),
            (true, 2) => self.approach_with(Dense::<2>::new(arms)),
            (true, FEW) => self.approach_with(Dense::<FEW>::new(arms)),
            (true, _) => self.approach_with(Wide::new(joints, arms)),
            (false, _) => self.approach_with(self.block.rows),
        }
    }

    #[inline(always)]
    fn approach_with<R: Rows>(&mut self, rows: R) -> Outcome {
        self.work.approach(&self.block.with(rows), self.lambda, &mut self.soft, self.steps)
    }
}

/// [`Search::ascend`] for many joints on an instruction set. Nothing fuses or reorders: every machine gets the same bits.
struct Ascent<'a, 'b>(&'a mut Search<'b>, &'a mut Outcome);

impl dispatch::Work for Ascent<'_, '_> {
    #[inline(always)]
    fn run<A: Arithmetic>(self, _: A) {
        let Self(search, outcome) = self;
        let (joints, arms) = (search.block.joints(), search.arms);
        // As many joints as an arm, a hand or a platform has are worth code of their own; rows are filled up with zeros.
        *outcome = match (search.whole, joints / LANES) {
            (false, _) => search.ascend_many(search.block.rows),
            (true, 1) => search.ascend_few::<4>(),
            (true, 2) => search.ascend_few::<8>(),
            (true, _) => search.ascend_many(Wide::new(joints, arms)),
        };
    }
}
