//! The topics of a node: one table, from which it publishes and subscribes and the page is written.

use sinew_link::Request;

/// A topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TopicRow {
    /// As ROS names it.
    pub name: &'static str,
    /// Type, package and message.
    pub kind: (&'static str, &'static str),
    /// Whether it is read, where commands are asked for; else it is written.
    pub is_read: bool,
    /// What it is.
    pub about: &'static str,
}

const fn out(name: &'static str, kind: (&'static str, &'static str), about: &'static str) -> TopicRow {
    TopicRow { name, kind, is_read: false, about }
}

const fn read(name: &'static str, kind: (&'static str, &'static str), about: &'static str) -> TopicRow {
    TopicRow { name, kind, is_read: true, about }
}

/// All topics; in the order in which the node keeps them.
pub const TOPICS: [TopicRow; 6] = [
    out(
        "joint_states",
        ("sensor_msgs", "JointState"),
        "independent joints, 500 times a second or once a cycle: positions by their encoders, velocities \
            by the controller's estimates, as efforts the torques of the cables by their estimated tensions",
    ),
    out(
        "sinew/muscle_states",
        ("sensor_msgs", "JointState"),
        "muscles, of every fifth state: lengths (m) and rates (m/s) by the pose, as efforts the estimated \
            tensions at the anchors (N)",
    ),
    out("tf", ("tf2_msgs", "TFMessage"), "frames of the bodies, of every fifth state"),
    out(
        "diagnostics",
        ("diagnostic_msgs", "DiagnosticArray"),
        "mode, status and faults of the supervisor, once a second and where they change; what was refused",
    ),
    read(
        "joint_trajectory",
        ("trajectory_msgs", "JointTrajectory"),
        "all joints along points, in `run`; reliable",
    ),
    read("robot_joint_command", ("sensor_msgs", "JointState"), "positions as set-points, in `run`"),
];

/// Places in the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Topic {
    JointStates,
    MuscleStates,
    Transforms,
    Diagnostics,
    Trajectory,
    Setpoint,
}

impl Topic {
    pub(crate) const fn row(self) -> &'static TopicRow {
        &TOPICS[self as usize]
    }
}

/// Services of type `std_srvs/Trigger` below `sinew/`, and what each asks for.
pub const MODES: [(&str, Request); 5] = [
    ("hold", Request::Hold),
    ("run", Request::Run),
    ("safe_stop", Request::SafeStop),
    ("reset", Request::Reset),
    ("turn_off", Request::TurnOff),
];
