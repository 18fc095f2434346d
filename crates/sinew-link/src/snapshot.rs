//! State of the machine, as it is sent.

pub use crate::wire::{JointState, MuscleState};
use crate::wire::{MAX_DATAGRAM, MAX_JOINTS, MAX_MUSCLES, MIN_DATAGRAM, Reader, StateHead, Writer};
use crate::{Mode, Rejection, Request, SetpointKind};

/// State of the machine in one control cycle, in memory of fixed size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Snapshot {
    /// Since the control cycle began, ns.
    pub machine_time_ns: u64,
    /// Number of the control cycle, from 0.
    pub cycle: u64,
    /// Operating mode.
    pub mode: Mode,
    /// Newest request that was taken.
    pub request: Request,
    /// Set-points that are followed.
    pub setpoint: SetpointKind,
    /// Bits of [`wire::flags`](crate::wire::flags).
    pub flags: u8,
    /// Code of the fault, 0 for none, and the index of the joint or muscle concerned.
    pub fault: [u16; 2],
    /// Points that wait for their time.
    pub queued: u16,
    /// Points dropped because their time had passed or there was no room.
    pub late: u64,
    /// End point in the world, m.
    pub end_point: [f64; 3],
    joints: usize,
    muscles: usize,
    joint: [JointState; MAX_JOINTS],
    muscle: [MuscleState; MAX_MUSCLES],
}

impl Default for Snapshot {
    fn default() -> Self {
        Self::new(0, 0)
    }
}

/// Bytes for the records of one datagram.
const RECORD_BYTES: usize = MAX_DATAGRAM - MIN_DATAGRAM - StateHead::SIZE;

impl Snapshot {
    /// Nothing is known, for at most [`MAX_JOINTS`] and [`MAX_MUSCLES`].
    #[must_use]
    pub fn new(joints: usize, muscles: usize) -> Self {
        Self {
            machine_time_ns: 0,
            cycle: 0,
            mode: Mode::Off,
            request: Request::None,
            setpoint: SetpointKind::None,
            flags: 0,
            fault: [0; 2],
            queued: 0,
            late: 0,
            end_point: [0.0; 3],
            joints: joints.min(MAX_JOINTS),
            muscles: muscles.min(MAX_MUSCLES),
            joint: [JointState::default(); MAX_JOINTS],
            muscle: [MuscleState::default(); MAX_MUSCLES],
        }
    }

    /// States of the joints.
    #[must_use]
    pub fn joints(&self) -> &[JointState] {
        &self.joint[..self.joints]
    }

    /// States of the joints, to be set.
    pub fn joints_mut(&mut self) -> &mut [JointState] {
        &mut self.joint[..self.joints]
    }

    /// States of the muscles.
    #[must_use]
    pub fn muscles(&self) -> &[MuscleState] {
        &self.muscle[..self.muscles]
    }

    /// States of the muscles, to be set.
    pub fn muscles_mut(&mut self) -> &mut [MuscleState] {
        &mut self.muscle[..self.muscles]
    }

    /// Number of datagrams.
    #[must_use]
    pub fn parts(&self) -> usize {
        let (mut part, mut at) = (0, [0, 0]);
        while part == 0 || at != [self.joints, self.muscles] {
            at = self.end_of_part(at);
            part += 1;
        }
        part
    }

    /// First joint and muscle of the part after the one that begins here.
    fn end_of_part(&self, [joint, muscle]: [usize; 2]) -> [usize; 2] {
        let joints = (self.joints - joint).min(RECORD_BYTES / JointState::SIZE);
        let room = RECORD_BYTES - joints * JointState::SIZE;
        let muscles = if joint + joints == self.joints { room / MuscleState::SIZE } else { 0 };
        [joint + joints, muscle + muscles.min(self.muscles - muscle)]
    }

    /// Writes the part that begins at a joint and muscle; returns where the next one begins, none after the
    /// last.
    pub(crate) fn write(
        &self,
        from: [usize; 2],
        counts: &StateCounts,
        writer: &mut Writer<'_>,
    ) -> Option<Option<[usize; 2]>> {
        let to = self.end_of_part(from);
        let head = StateHead {
            machine_time_ns: self.machine_time_ns,
            cycle: self.cycle,
            mode: self.mode.number(),
            request: self.request.number(),
            setpoint: self.setpoint.number(),
            flags: self.flags,
            fault: self.fault[0],
            fault_index: self.fault[1],
            queued: self.queued,
            last_rejection: counts.last_rejection.map_or(0, Rejection::number),
            joint_size: JointState::SIZE as u16,
            muscle_size: MuscleState::SIZE as u16,
            padding: [0],
            accepted: counts.accepted,
            lost: counts.lost,
            rejected: counts.rejected,
            late: self.late,
            end_point: self.end_point,
            joints: self.joints as u16,
            muscles: self.muscles as u16,
            first_joint: from[0] as u16,
            joint_count: (to[0] - from[0]) as u16,
            first_muscle: from[1] as u16,
            muscle_count: (to[1] - from[1]) as u16,
        };
        head.write(writer)?;
        for joint in &self.joint[from[0]..to[0]] {
            joint.write(writer)?;
        }
        for muscle in &self.muscle[from[1]..to[1]] {
            muscle.write(writer)?;
        }
        Some((to != [self.joints, self.muscles]).then_some(to))
    }

    /// Takes one part of a state over into this one; true where it was the last part.
    ///
    /// # Errors
    /// The first reason for which the part is rejected; nothing is changed then.
    pub(crate) fn read(&mut self, reader: &mut Reader<'_>) -> Result<(StateCounts, bool), Rejection> {
        let head = StateHead::read(reader).ok_or(Rejection::Length)?;
        let mut next = *self;
        (next.joints, next.muscles) = (usize::from(head.joints), usize::from(head.muscles));
        let [joints, muscles] = [
            [head.first_joint, head.joint_count, head.joints],
            [head.first_muscle, head.muscle_count, head.muscles],
        ]
        .map(|[first, count, all]| {
            let (first, end) = (usize::from(first), usize::from(first) + usize::from(count));
            (end <= usize::from(all)).then_some(first..end)
        });
        let (Some(joints), Some(muscles)) = (joints, muscles) else { return Err(Rejection::Count) };
        if next.joints > MAX_JOINTS || next.muscles > MAX_MUSCLES {
            return Err(Rejection::Count);
        }
        let last = joints.end == next.joints && muscles.end == next.muscles;
        for joint in &mut next.joint[joints] {
            *joint = JointState::read_from(reader, head.joint_size).ok_or(Rejection::Length)?;
        }
        for muscle in &mut next.muscle[muscles] {
            *muscle = MuscleState::read_from(reader, head.muscle_size).ok_or(Rejection::Length)?;
        }
        if !reader.is_empty() {
            return Err(Rejection::Length);
        }
        next.mode = Mode::from_number(head.mode).ok_or(Rejection::Code)?;
        next.request = Request::from_number(head.request).ok_or(Rejection::Code)?;
        next.setpoint = SetpointKind::from_number(head.setpoint).ok_or(Rejection::Code)?;
        if head.padding != [0] {
            return Err(Rejection::Code);
        }
        (next.machine_time_ns, next.cycle) = (head.machine_time_ns, head.cycle);
        (next.flags, next.fault) = (head.flags, [head.fault, head.fault_index]);
        (next.queued, next.late, next.end_point) = (head.queued, head.late, head.end_point);
        if !next.end_point.iter().all(|x| x.is_finite()) {
            return Err(Rejection::NonFinite);
        }
        *self = next;
        let counts = StateCounts {
            accepted: head.accepted,
            lost: head.lost,
            rejected: head.rejected,
            last_rejection: Rejection::from_number(head.last_rejection),
        };
        Ok((counts, last))
    }
}

/// What the host says of the packets that it received.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StateCounts {
    /// Of this session, arrived with their tag, whatever their content.
    pub accepted: u64,
    /// Of this session, not arrived.
    pub lost: u64,
    /// Of anyone, rejected.
    pub rejected: u64,
    /// Reason for which the content of a packet of this session was last rejected.
    pub last_rejection: Option<Rejection>,
}
