//! Signals of a machine at one time, as the page shows them.

use sinew::control::supervisor::NamedFault;
use sinew_session::signals::{Frame, FrameLayout, Signal, fault_of};
use std::sync::Arc;

/// Signals at one time; NaN where they are not known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Signals {
    /// Time of the frame, s.
    pub(crate) time: f64,
    pub(crate) frame: Frame,
}

impl Signals {
    /// Nothing is known.
    pub(crate) fn unknown(sizes: [usize; 2], simulated: bool) -> Self {
        Self { time: 0.0, frame: Frame::new(Arc::new(FrameLayout::new(sizes, simulated))) }
    }

    /// The pose that is drawn: the true one where it is known, otherwise the estimated one, otherwise the
    /// reference.
    pub(crate) fn pose(&self) -> Option<&[f64]> {
        let all = [Signal::JointTrue, Signal::JointEstimated, Signal::JointReference];
        let known = |q: &&[f64]| !q.is_empty() && q.iter().all(|q| q.is_finite());
        all.into_iter().map(|signal| self.frame.of(signal)).find(known)
    }

    /// The reference of the joints, where it is known.
    pub(crate) fn reference(&self) -> Option<&[f64]> {
        Some(self.frame.of(Signal::JointReference)).filter(|q| q.iter().all(|q| q.is_finite()))
    }

    /// The number of a muscle; NaN where it is not known.
    pub(crate) fn muscle(&self, signal: Signal, muscle: usize) -> f64 {
        self.frame.of(signal).get(muscle).copied().unwrap_or(f64::NAN)
    }

    /// Far tension of a muscle as far as it is known, N.
    pub(crate) fn far_tension(&self, muscle: usize) -> f64 {
        let truth = self.muscle(Signal::TensionOut, muscle);
        if truth.is_finite() { truth } else { self.muscle(Signal::TensionOutEstimated, muscle) }
    }

    /// The numbers of a field that is a signal.
    pub(crate) fn field(&self, name: &str, out: &mut Vec<f64>) {
        match name {
            "time_s" => out.push(self.time),
            "fault" | "fault_index" => {
                let numbers = fault_numbers(fault_of(self.frame.one(Signal::ModeFault)));
                out.push(numbers[usize::from(name == "fault_index")]);
            }
            name => out.extend(Signal::of_name(name).into_iter().flat_map(|signal| self.frame.of(signal))),
        }
    }
}

/// Code of a fault, and index of its muscle or joint.
fn fault_numbers(fault: Option<NamedFault>) -> [f64; 2] {
    fault.map_or([0.0; 2], |fault| [f64::from(fault.code()), fault.index().unwrap_or_default() as f64])
}
