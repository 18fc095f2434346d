//! A frame: the numbers of all signals of one cycle.

use super::table::{Axis, Kind, Seen, Signal};
use std::ops::Range;
use std::sync::Arc;

/// Places of the signals of a machine in a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameLayout {
    muscles: usize,
    joints: usize,
    simulated: bool,
    /// Where every signal begins, and the end: `[signals + 1]`.
    starts: Vec<usize>,
}

impl FrameLayout {
    /// Of a machine; one that is not simulated has no truth.
    #[must_use]
    pub fn new([muscles, joints]: [usize; 2], simulated: bool) -> Self {
        let mut starts = vec![0];
        let mut end = 0;
        for signal in Signal::ALL {
            end += match signal.row() {
                row if row.kind == Kind::Truth && !simulated => 0,
                row if row.axis == Axis::Joint => joints,
                row if row.axis == Axis::Muscle => muscles,
                _ => 1,
            };
            starts.push(end);
        }
        Self { muscles, joints, simulated, starts }
    }

    /// Muscles and joints.
    #[must_use]
    pub fn sizes(&self) -> [usize; 2] {
        [self.muscles, self.joints]
    }

    /// Whether the machine is simulated.
    #[must_use]
    pub fn is_simulated(&self) -> bool {
        self.simulated
    }

    /// Numbers of a frame.
    #[must_use]
    pub fn words(&self) -> usize {
        self.starts.last().copied().unwrap_or(0)
    }

    /// Place of a signal; empty where the machine has nothing of it.
    #[must_use]
    pub fn place(&self, signal: Signal) -> Range<usize> {
        self.starts[signal as usize]..self.starts[signal as usize + 1]
    }

    /// The numbers of a signal in a frame.
    #[must_use]
    pub fn of<'a>(&self, signal: Signal, words: &'a [f64]) -> &'a [f64] {
        words.get(self.place(signal)).unwrap_or_default()
    }

    /// Writes the signals of a cycle; NaN where there is no number. Nothing is allocated.
    ///
    /// # Shapes
    /// `words: [words()]`.
    pub fn fill(&self, words: &mut [f64], cycle: &Seen<'_>) {
        words.fill(f64::NAN);
        for signal in Signal::ALL {
            if let Some(out) = words.get_mut(self.place(*signal)).filter(|out| !out.is_empty()) {
                (signal.row().fill)(cycle, out);
            }
        }
    }
}

/// All signals of one cycle; NaN is missing.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    layout: Arc<FrameLayout>,
    words: Vec<f64>,
}

impl Frame {
    /// Nothing is known.
    #[must_use]
    pub fn new(layout: Arc<FrameLayout>) -> Self {
        Self { words: vec![f64::NAN; layout.words()], layout }
    }

    /// Its layout.
    #[must_use]
    pub fn layout(&self) -> &Arc<FrameLayout> {
        &self.layout
    }

    /// Takes the signals of a cycle. Nothing is allocated.
    pub fn fill(&mut self, cycle: &Seen<'_>) {
        self.layout.fill(&mut self.words, cycle);
    }

    /// All numbers, in the order of the layout.
    pub fn words_mut(&mut self) -> &mut [f64] {
        &mut self.words
    }

    /// The numbers of a signal: one, or `[joints]` or `[muscles]`; none where the machine has nothing of it.
    #[must_use]
    pub fn of(&self, signal: Signal) -> &[f64] {
        self.layout.of(signal, &self.words)
    }

    /// The same, to be set.
    pub fn of_mut(&mut self, signal: Signal) -> &mut [f64] {
        self.words.get_mut(self.layout.place(signal)).unwrap_or_default()
    }

    /// The number of a signal of the cycle; NaN where it is missing.
    #[must_use]
    pub fn one(&self, signal: Signal) -> f64 {
        self.of(signal).first().copied().unwrap_or(f64::NAN)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signals_stand_behind_each_other_and_a_real_machine_has_no_truth() {
        for simulated in [false, true] {
            let layout = FrameLayout::new([15, 7], simulated);
            let mut end = 0;
            for signal in Signal::ALL {
                let (place, row) = (layout.place(*signal), signal.row());
                assert_eq!(place.start, end, "{row:?}");
                let expected = match row.axis {
                    Axis::Cycle => 1,
                    Axis::Joint => 7,
                    Axis::Muscle => 15,
                };
                let empty = row.kind == Kind::Truth && !simulated;
                assert_eq!(place.len(), if empty { 0 } else { expected }, "{row:?}");
                assert_eq!(Signal::of_name(row.name), Some(*signal), "no name stands twice");
                end = place.end;
            }
            assert_eq!(layout.words(), end);
            assert!(Frame::new(Arc::new(layout)).one(Signal::Mode).is_nan());
        }
    }
}
