//! The tables of all packets.

use super::table::{Code, Field, Reader, Scalar, Writer, packet, record};

packet! {
    /// Head of every datagram.
    Head {
        magic: [u8; 4], "1", "The characters `SNWL`.";
        version: u8, "1", "Of the protocol: 2.";
        kind: u8, "1", "Kind of the packet.";
        length: u16, "bytes", "Of the datagram with head and tag.";
        session: u64, "1", "The first 8 bytes of `host_nonce`; 0 in Hello, Welcome and Refused.";
        sequence: u64, "1", "Of this sender in this session, from 1, never twice; 0 in Hello, Welcome and Refused.";
        reflected_sequence: u64, "1", "Newest sequence received from the other side; 0 before the first.";
        time_ns: u64, "ns", "When this packet was sent, by the sender's monotonic clock.";
        reflected_time_ns: u64, "ns", "`time_ns` of the packet `reflected_sequence`; 0 before the first.";
        held_ns: u64, "ns", "From the reception of that packet to the sending of this one.";
    }
}

packet! {
    /// A client asks for a session. As long as Welcome, so that no answer is longer than its question.
    Hello {
        client_nonce: [u8; 16], "1", "Random, new for every session.";
        role: u8, "1", "0: to command, 1: to watch.";
        padding: [u8; 87], "1", "Zeros.";
    }
}

packet! {
    /// The host offers a session; it begins with the first valid Command in it, one that watches with the
    /// first Watch.
    Welcome {
        client_nonce: [u8; 16], "1", "That of the Hello.";
        host_nonce: [u8; 16], "1", "Random, new for every session.";
        machine: [u8; 32], "1", "Name of the machine, UTF-8, filled up with zeros.";
        joints: u16, "1", "Independent joints, 0 to 64.";
        muscles: u16, "1", "Muscles, 0 to 128.";
        features: u32, "1", "Bits: 0 lock-step, 1 joints, 2 muscle lengths, 3 tensions, 4 end point \
            (accepted set-points).";
        period_ns: u64, "ns", "Of the control cycle.";
        state_period_ns: u64, "ns", "Of the State packets.";
        playout_delay_ns: u64, "ns", "From the time stamp of a set-point to its effect.";
        timeout_ns: u64, "ns", "Without a valid command: after this the machine holds.";
    }
}

packet! {
    /// The host has no session for this client.
    Refused {
        client_nonce: [u8; 16], "1", "That of the Hello.";
        because: u8, "1", "1: another client has the session, 2: eight watch already.";
        padding: [u8; 7], "1", "Zeros.";
    }
}

packet! {
    /// A mode request and set-points: `points` times a time stamp and `values` numbers follow.
    CommandHead {
        request: u8, "1", "Mode request; the newest command decides.";
        setpoint: u8, "1", "Kind of the set-points; 0 with no values and no points.";
        values: u16, "1", "Numbers per point: joints, muscles or 3.";
        points: u16, "1", "Points that follow, in the order of their time stamps.";
        padding: [u8; 2], "1", "Zeros.";
        advance_to_ns: u64, "ns", "Lock-step: the machine's time up to which it may go; else 0.";
    }
}

packet! {
    /// Beginning of a point; `values` numbers (f64) follow.
    PointHead {
        at_ns: u64, "ns", "Machine time of the point, ascending within a packet; 0: on arrival, one point alone.";
    }
}

packet! {
    /// State of the machine: `joint_count` records of joints, then `muscle_count` records of muscles follow.
    /// What does not fit in one datagram comes in several of the same cycle.
    StateHead {
        machine_time_ns: u64, "ns", "Since the control cycle began; on virtual time, that one.";
        cycle: u64, "1", "Number of the control cycle, from 0.";
        mode: u8, "1", "Operating mode.";
        request: u8, "1", "Newest mode request that was taken.";
        setpoint: u8, "1", "Kind of the set-points that are followed; 0: none.";
        flags: u8, "1", "Bits: 0 waits for `advance_to_ns`, 1 commands have timed out, 2 set-points are \
            limited, 3 a reading is missing and shown as last read. What has never been known is not a number.";
        fault: u16, "1", "Code of the fault, see the list of faults; 0: none.";
        fault_index: u16, "1", "Index of the joint or muscle that the code counts; else 0.";
        queued: u16, "1", "Points that wait for their time.";
        last_rejection: u8, "1", "Reason for which the content of a packet of this session was last \
            rejected; 0: none. It stays.";
        joint_size: u16, "bytes", "Of the record of a joint; whoever knows fewer numbers skips the rest.";
        muscle_size: u16, "bytes", "Of the record of a muscle, alike.";
        padding: [u8; 1], "1", "Zero.";
        accepted: u64, "1", "Packets of this session that have arrived, each counted once: with its tag, \
            unseen and in order of time, whatever its content.";
        lost: u64, "1", "Packets of this session that have not arrived: the newest sequence number less \
            `accepted`.";
        rejected: u64, "1", "Packets from anyone rejected since the host's start.";
        late: u64, "1", "Points dropped because their time had passed or 256 were waiting, since the \
            host's start.";
        end_point: [f64; 3], "m", "End point in the world; zeros where the machine has none.";
        joints: u16, "1", "Joints of the machine.";
        muscles: u16, "1", "Muscles of the machine.";
        first_joint: u16, "1", "Index of the first joint in this datagram.";
        joint_count: u16, "1", "Joints in this datagram.";
        first_muscle: u16, "1", "Index of the first muscle in this datagram.";
        muscle_count: u16, "1", "Muscles in this datagram.";
    }
}

record! {
    /// State of a joint: signals of the table in docs/recording.md, and a rate.
    JointState {
        joint_estimated: "rad or m", "Estimated coordinate; its encoder's without an estimate.";
        joint_velocity: "rad/s or m/s", "Its rate.";
        joint_reference: "rad or m", "Coordinate that is followed.";
    }
}

record! {
    /// State of a muscle: signals of the table in docs/recording.md.
    MuscleState {
        tension_in_n: "N", "At the drive, measured.";
        tension_out_estimated_n: "N", "At the anchor, estimated.";
        position_in_m: "m", "Position of the cable at the drive, + toward the motor.";
        command: "m/s, N or A", "Of the drive: speed toward the motor, tension or current.";
        current_a: "A", "Of the motor.";
        temperature_degc: "degC", "Of the motor.";
        setpoint_age_us: "us", "Of the set-point that the drive follows.";
    }
}

/// Kind of a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Client to host: asks for a session.
    Hello = 1,
    /// Host to client: offers a session.
    Welcome = 2,
    /// Host to client: there is none.
    Refused = 3,
    /// Client to host: requests and set-points.
    Command = 4,
    /// Host to client: state.
    State = 5,
    /// Client to host: the session ends. No body.
    Goodbye = 6,
    /// Client to host, of a session that watches: a sign of life. No body.
    Watch = 7,
}

impl Kind {
    /// All kinds, in the order of their numbers.
    pub const ALL: [Self; 7] =
        [Self::Hello, Self::Welcome, Self::Refused, Self::Command, Self::State, Self::Goodbye, Self::Watch];

    /// The kind of a number.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| *kind as u8 == number)
    }

    pub(crate) fn code(self) -> Code {
        Code {
            number: self as u8,
            name: ["Hello", "Welcome", "Refused", "Command", "State", "Goodbye", "Watch"][self as usize - 1],
        }
    }
}

/// Accepted set-points and lock-step, bits of [`Welcome::features`].
pub mod features {
    /// The machine's time advances as the client asks.
    pub const LOCK_STEP: u32 = 1;
    /// Joint set-points.
    pub const JOINT: u32 = 1 << 1;
    /// Muscle lengths.
    pub const MUSCLE_LENGTH: u32 = 1 << 2;
    /// Tensions.
    pub const TENSION: u32 = 1 << 3;
    /// End-point set-points.
    pub const END_POINT: u32 = 1 << 4;
}

/// Bits of [`StateHead::flags`].
pub mod flags {
    /// The cycle waits for the client to advance time.
    pub const WAITING: u8 = 1;
    /// No valid command has come for longer than the time-out.
    pub const TIMED_OUT: u8 = 1 << 1;
    /// The set-points are beyond a limit of the machine and followed as far as it allows.
    pub const LIMITED: u8 = 1 << 2;
    /// A reading is missing in this cycle; the last one is shown.
    pub const READING_MISSING: u8 = 1 << 3;
}
