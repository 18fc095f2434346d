use crate::topics::Topic;
use sinew::machine::Machine;
use sinew_record::ros2::{Cdr, Level, Messages, pose};
use sinew_record::{Circumstances, Error, Head};
use sinew_session::signals::{Frame, Signal};
use std::time::{SystemTime, UNIX_EPOCH};

/// Frames of the control cycle as messages.
pub(crate) struct Outgoing {
    messages: Messages,
    /// Whether the start is known.
    started: bool,
    count: u64,
    /// Estimated pose and time of the frame before, ns.
    before: Option<(u64, Vec<f64>)>,
    /// Bits of the state that was told last, and when, ns.
    told: Option<([u64; STATE.len()], u64)>,
}

/// What a change of is told at once.
const STATE: [Signal; 4] = [Signal::Status, Signal::Fault, Signal::Mode, Signal::ModeFault];
/// Without a change it is told so often, ns.
const TELL: u64 = 1_000_000_000;
/// States from one with frames and muscles to the next.
const SLOW: u64 = 5;

impl Outgoing {
    pub(crate) fn new(machine: &Machine, simulated: bool) -> Result<Self, Error> {
        let circumstances = Circumstances {
            program: env!("CARGO_PKG_VERSION").to_owned(),
            commit: String::new(),
            simulated,
            virtual_time: false,
            start_ns: 0,
            period_ns: machine.period_ns(),
        };
        let messages = Messages::new(machine, Head::new(machine, circumstances))?;
        Ok(Self { messages, started: false, count: 0, before: None, told: None })
    }

    /// All messages of a frame, in turn.
    pub(crate) fn frame(&mut self, frame: &Frame, mut send: impl FnMut(Topic, &Cdr)) -> Result<(), Error> {
        let since = (frame.one(Signal::Deadline).max(0.0) * 1e3).round() as u64;
        if !self.started {
            self.messages.set_start((since_1970() as u64).saturating_sub(since));
            self.started = true;
        }
        let pose = pose(|signal| frame.of(signal).to_vec());
        let estimated = frame.of(Signal::JointEstimated).to_vec();
        let velocity = self.velocity(since, &estimated);
        let tension = frame.of(Signal::TensionOutEstimated);
        send(Topic::JointStates, &self.messages.joint_states(since, [&pose, &velocity, tension])?);
        if self.count.is_multiple_of(SLOW) {
            send(Topic::MuscleStates, &self.messages.muscle_states(since, [&pose, &velocity, tension])?);
            if let Some(message) = self.messages.transforms(since, &pose)? {
                send(Topic::Transforms, &message);
            }
        }
        self.count += 1;
        let state = STATE.map(|signal| frame.one(signal).to_bits());
        if self.told.is_none_or(|(told, at)| told != state || since.saturating_sub(at) >= TELL) {
            self.told = Some((state, since));
            send(Topic::Diagnostics, &self.messages.supervisor(since, |signal| frame.one(signal)));
        }
        Ok(())
    }

    /// What was refused, as a diagnostic.
    pub(crate) fn refused(&self, text: &str) -> Cdr {
        let since = (since_1970() as u64).saturating_sub(self.messages.head().start_ns);
        self.messages.notice(since, "commands", Level::Warn, text)
    }

    /// Names of the independent joints, in their order.
    pub(crate) fn joints(&self) -> Vec<String> {
        self.messages.head().joints.iter().map(|joint| joint.name.clone()).collect()
    }

    /// Change of the estimates since the frame before, per s; NaN in the first.
    fn velocity(&mut self, since: u64, estimated: &[f64]) -> Vec<f64> {
        let before = self.before.replace((since, estimated.to_vec()));
        match before {
            Some((then, pose)) if since > then => {
                let seconds = (since - then) as f64 * 1e-9;
                estimated.iter().zip(pose).map(|(now, then)| (now - then) / seconds).collect()
            }
            _ => vec![f64::NAN; estimated.len()],
        }
    }
}

/// ns since 1970.
pub(crate) fn since_1970() -> i64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos() as i64)
}
