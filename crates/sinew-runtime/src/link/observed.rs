use sinew::control::supervisor::{Mode, NamedFault};
use sinew_link::wire::{Field, flags};
use sinew_link::{JointState, MuscleState, Snapshot};
use sinew_session::signals::{Frame, FrameLayout, Kind, Seen, Signal};
use std::sync::Arc;

/// Writes what a cycle has read and commanded into a state, by the table of signals.
#[derive(Debug)]
pub(super) struct Observed {
    frame: Frame,
    /// Signals of the records' fields; none for what is computed here.
    joint: Vec<Option<Signal>>,
    muscle: Vec<Option<Signal>>,
}

impl Observed {
    pub(super) fn new(sizes: [usize; 2]) -> Self {
        let signals = |fields: &[Field]| fields.iter().map(|field| Signal::of_name(field.name)).collect();
        Self {
            // What is sent is known of a real machine, too.
            frame: Frame::new(Arc::new(FrameLayout::new(sizes, false))),
            joint: signals(JointState::FIELDS),
            muscle: signals(MuscleState::FIELDS),
        }
    }

    /// A number that is missing stays as it was; where that is a reading, it is flagged. Nothing is
    /// allocated.
    pub(super) fn write(&mut self, snapshot: &mut Snapshot, period: f64, cycle: &Seen<'_>) {
        let Self { frame, joint: of_joint, muscle: of_muscle } = self;
        frame.fill(cycle);
        snapshot.mode = mode(cycle.command.mode);
        snapshot.fault = cycle.command.fault.map_or([0; 2], fault);
        let mut complete = true;
        let mut write = |k: usize, numbers: &mut [&mut f64], signals: &[Option<Signal>]| {
            for (place, signal) in numbers.iter_mut().zip(signals) {
                let Some(signal) = signal else { continue };
                let number = frame.of(*signal).get(k).copied().unwrap_or(f64::NAN);
                let kept = keep(place, number) || !place.is_finite();
                complete &= kept || signal.row().kind != Kind::Measured;
            }
        };
        for (k, joint) in snapshot.joints_mut().iter_mut().enumerate() {
            let before = joint.joint_estimated;
            write(k, &mut joint.numbers_mut(), of_joint);
            // Without an estimate the encoder's reading.
            if !cycle.command.arm.q[k].is_finite() {
                keep(&mut joint.joint_estimated, cycle.feedback.joint[k]);
            }
            keep(&mut joint.joint_velocity, (joint.joint_estimated - before) / period);
        }
        for (k, muscle) in snapshot.muscles_mut().iter_mut().enumerate() {
            write(k, &mut muscle.numbers_mut(), of_muscle);
        }
        snapshot.flags = if complete { 0 } else { flags::READING_MISSING };
    }
}

/// False where the number is not finite; the one before is kept then.
fn keep(place: &mut f64, number: f64) -> bool {
    if number.is_finite() {
        *place = number;
    }
    number.is_finite()
}

fn mode(mode: Mode) -> sinew_link::Mode {
    sinew_link::Mode::from_number(mode as u8).unwrap_or(sinew_link::Mode::Fault)
}

fn fault(named: NamedFault) -> [u16; 2] {
    [named.code(), named.index().unwrap_or(0) as u16]
}

#[cfg(test)]
mod tests {
    use super::Observed;
    use sinew::control::supervisor::{Mode, Request};

    #[test]
    fn the_link_has_the_names_of_the_table() {
        let observed = Observed::new([1, 1]);
        assert!(observed.muscle.iter().all(Option::is_some));
        assert_eq!(observed.joint.iter().filter(|signal| signal.is_none()).count(), 1, "the rate alone");
    }

    #[test]
    fn codes_on_the_wire_mean_what_the_supervisor_means() {
        assert_eq!(Mode::ALL.len(), sinew_link::Mode::ALL.len());
        for mode in Mode::ALL {
            assert_eq!(super::mode(mode).name(), format!("{mode:?}"));
        }
        assert_eq!(Request::ALL.len(), sinew_link::Request::ALL.len());
        for request in sinew_link::Request::ALL {
            let own = Request::from_number(request.number()).expect("a request of the supervisor");
            assert_eq!(request.name(), format!("{own:?}"));
            assert_eq!(sinew_link::Request::from_number(own as u8), Some(*request));
        }
    }
}
