//! Outermost keys of a robot file, and those that make it a machine file.

/// Keys of a robot file.
pub(in crate::description) const ROBOT_KEYS: [&str; 12] = [
    "name",
    "gravity_m_per_s2",
    "body",
    "joint",
    "site",
    "wrap",
    "geom",
    "muscle",
    "spring",
    "coupling",
    "actuator",
    "key",
];

/// Further keys of a machine file, which say nothing about the robot itself.
pub(in crate::description) const MACHINE_KEYS: [&str; 18] = [
    "muscles",
    "start",
    "period_s",
    "pose",
    "task",
    "redundancy",
    "path",
    "every_transmission",
    "transmission",
    "drive",
    "every_joint_encoder",
    "joint_encoder",
    "travel",
    "device",
    "payload",
    "tolerances",
    "control",
    "safety",
];
