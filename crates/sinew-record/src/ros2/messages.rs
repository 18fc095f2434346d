//! The messages of a machine's cycles: what a bag holds and what a node publishes.

use super::cdr::Cdr;
use super::placed::Placed;
use crate::error::Error;
use crate::head::Head;
use crate::recorder::level;
use crate::view::View;
use sinew::machine::Machine;
use sinew_session::signals::{Axis, Kind, Signal, status_of};

/// Writes the messages of a machine, with its names and kinematics.
pub struct Messages {
    head: Head,
    view: View,
}

/// Levels of `diagnostic_msgs/DiagnosticStatus`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Level {
    /// As it should be.
    Ok = 0,
    /// To be looked at.
    Warn = 1,
    /// Wrong.
    Error = 2,
}

/// Levels of `foxglove.Log` begin with this one, for information.
const INFORMATION: i32 = 2;

impl std::fmt::Debug for Messages {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "messages of {}", self.head.machine)
    }
}

impl Messages {
    /// Of a machine, with the names and the start of a head.
    ///
    /// # Errors
    /// [`Error::Physics`] for a machine whose kinematics cannot be evaluated.
    pub fn new(machine: &Machine, head: Head) -> Result<Self, Error> {
        Ok(Self { head, view: View::new(machine)? })
    }

    /// What it was made with.
    #[must_use]
    pub fn head(&self) -> &Head {
        &self.head
    }

    /// Moves the start, ns since 1970.
    pub fn set_start(&mut self, start_ns: u64) {
        self.head.start_ns = start_ns;
    }

    /// A message with a header, `since` ns after the start.
    pub(super) fn begin(&self, since: u64) -> Cdr {
        let mut message = Cdr::new();
        message.header(self.head.start_ns + since, "");
        message
    }

    pub(super) fn joint_names(&self, message: &mut Cdr) {
        message.texts(self.head.joints.iter().map(|joint| joint.name.as_str()));
    }

    pub(super) fn muscle_names(&self, message: &mut Cdr) {
        message.texts(self.head.muscles.iter().map(String::as_str));
    }

    /// `sensor_msgs/JointState` of the joints, with the torques of the cables on them; NaN where pose or
    /// tension is not known.
    ///
    /// # Shapes
    /// `pose, velocity: [joints]`, rad or m, per s, the latter possibly empty; `tension: [muscles]` at the
    /// anchors, N.
    ///
    /// # Errors
    /// [`Error::Physics`] for numbers of another machine.
    pub fn joint_states(&mut self, since: u64, [pose, velocity, tension]: [&[f64]; 3]) -> Result<Cdr, Error> {
        let mut effort = vec![f64::NAN; pose.len()];
        if is_known(pose) && tension.len() == self.head.muscles.len() {
            self.view.torques(pose, tension, &mut effort)?;
        }
        let mut message = self.begin(since);
        self.joint_names(&mut message);
        [pose, velocity, &effort].into_iter().for_each(|numbers| message.f64s(numbers));
        Ok(message)
    }

    /// `sensor_msgs/JointState` of the muscles: lengths and their rates by the pose, m and m/s, as efforts
    /// tensions at the anchors, N; NaN where the pose is not known.
    ///
    /// # Shapes
    /// As [`joint_states`](Self::joint_states).
    ///
    /// # Errors
    /// [`Error::Physics`] for numbers of another machine.
    pub fn muscle_states(
        &mut self,
        since: u64,
        [pose, velocity, tension]: [&[f64]; 3],
    ) -> Result<Cdr, Error> {
        let unknown = vec![f64::NAN; self.head.muscles.len()];
        let [length, rate] =
            if is_known(pose) { self.view.lengths(pose, velocity)? } else { [unknown.clone(), unknown] };
        let mut message = self.begin(since);
        self.muscle_names(&mut message);
        [&length, &rate, tension].into_iter().for_each(|numbers| message.f64s(numbers));
        Ok(message)
    }

    /// `tf2_msgs/TFMessage` of the bodies; none where the pose is not known.
    ///
    /// # Shapes
    /// `pose: [joints]`, rad or m.
    ///
    /// # Errors
    /// [`Error::Physics`] for a pose of another machine.
    pub fn transforms(&mut self, since: u64, pose: &[f64]) -> Result<Option<Cdr>, Error> {
        if !is_known(pose) {
            return Ok(None);
        }
        let ns = self.head.start_ns + since;
        let transforms = self.view.transforms(pose, ns, true)?.transforms;
        let mut message = Cdr::new();
        message.length(transforms.len());
        for transform in &transforms {
            let (place, turn) =
                (transform.translation.unwrap_or_default(), transform.rotation.unwrap_or_default());
            let placed = Placed {
                ns: ns as i64,
                frame: &transform.parent_frame_id,
                child: &transform.child_frame_id,
                position: [place.x, place.y, place.z],
                quaternion: [turn.x, turn.y, turn.z, turn.w],
            };
            placed.write(&mut message);
        }
        Ok(Some(message))
    }

    /// `diagnostic_msgs/DiagnosticArray` of the supervisor, by the signals of a cycle; `one` gives the number
    /// of a signal, NaN where it is missing.
    #[must_use]
    pub fn supervisor(&self, since: u64, one: impl Fn(Signal) -> f64) -> Cdr {
        let status = status_of(one(Signal::Status), one(Signal::Fault));
        let (mode, fault) = (one(Signal::Mode), one(Signal::ModeFault));
        let level = if mode >= 5.0 && fault > 0.0 {
            Level::Error
        } else {
            match level(status) - INFORMATION {
                0 => Level::Ok,
                1 => Level::Warn,
                _ => Level::Error,
            }
        };
        let of_cycle =
            |signal: &&Signal| signal.row().axis == Axis::Cycle && signal.row().kind == Kind::State;
        let values: Vec<Signal> = Signal::ALL.iter().filter(of_cycle).copied().collect();
        let mut message =
            self.diagnostic(since, "supervisor", level, &self.head.mode_name(mode, fault, status));
        message.length(values.len());
        for signal in values {
            message.text(signal.row().name);
            message.text(&one(signal).to_string());
        }
        message
    }

    /// `diagnostic_msgs/DiagnosticArray` with one status, of a part of this program, without values.
    #[must_use]
    pub fn notice(&self, since: u64, part: &str, level: Level, text: &str) -> Cdr {
        let mut message = self.diagnostic(since, part, level, text);
        message.length(0);
        message
    }

    /// The same before its values.
    fn diagnostic(&self, since: u64, part: &str, level: Level, text: &str) -> Cdr {
        let machine = &self.head.machine;
        let hardware = if self.head.simulated { format!("SIMULATED {machine}") } else { machine.clone() };
        let mut message = self.begin(since);
        message.length(1);
        message.u8(level as u8);
        message.text(&format!("sinew: {part}"));
        message.text(text);
        message.text(&hardware);
        message
    }
}

fn is_known(pose: &[f64]) -> bool {
    pose.iter().all(|q| q.is_finite())
}

/// The pose that the joint encoders read, that of the controller where there is none, rad or m: `[joints]`.
#[must_use]
pub fn pose(of: impl Fn(Signal) -> Vec<f64>) -> Vec<f64> {
    let (mut pose, estimated) = (of(Signal::Joint), of(Signal::JointEstimated));
    let missing = pose.iter_mut().zip(estimated).filter(|(q, _)| !q.is_finite());
    missing.for_each(|(q, estimate)| *q = estimate);
    pose
}
