//! Files that come with Sinew, as text: cable-driven machines, the catalogue of motors, reducers, winches
//! and cords, and a hand without tendons. Use them as examples and in tests; a program that takes machines
//! by name looks them up in [`MACHINES`].

#![no_std]

/// The LM-Arm: seven joints and fifteen cables, of the size of a man's right arm.
pub const LM_ARM: &str = include_str!("lm_arm.toml");
/// One joint between two cables, as on a bench.
pub const BENCH_JOINT: &str = include_str!("bench_joint.toml");
/// A leg of two joints and four cables, two of which cross both.
pub const PLANAR_LEG: &str = include_str!("planar_leg.toml");
/// An index finger of four joints and five cables.
pub const FINGER: &str = include_str!("finger.toml");
/// An index finger that one cable closes over three joints, against springs.
pub const SPRING_FINGER: &str = include_str!("spring_finger.toml");
/// Two opposed fingers of eight joints and ten serial servos, without load cells or joint encoders.
pub const TWO_FINGER_HAND: &str = include_str!("two_finger_hand.toml");
/// The elbow of a soft exosuit, between two cables.
pub const EXOSUIT_ELBOW: &str = include_str!("exosuit_elbow.toml");
/// The wrist of a surgical instrument: roll, pitch and yaw by six cables.
pub const SURGICAL_WRIST: &str = include_str!("surgical_wrist.toml");
/// A shoulder of three joints and eight cables.
pub const SHOULDER: &str = include_str!("shoulder.toml");
/// A hanging chain of ten joints and twenty-four cables.
pub const CHAIN10: &str = include_str!("chain10.toml");
/// Motors, reducers, winches and cords, each number with its source or called assumed.
pub const MOTORS: &str = include_str!("motors.toml");
/// A hand of joints alone, in URDF.
pub const HAND_URDF: &str = include_str!("hand.urdf");

/// All machines: name and file.
pub const MACHINES: [(&str, &str); 10] = [
    ("lm_arm", LM_ARM),
    ("bench_joint", BENCH_JOINT),
    ("planar_leg", PLANAR_LEG),
    ("finger", FINGER),
    ("spring_finger", SPRING_FINGER),
    ("two_finger_hand", TWO_FINGER_HAND),
    ("exosuit_elbow", EXOSUIT_ELBOW),
    ("surgical_wrist", SURGICAL_WRIST),
    ("shoulder", SHOULDER),
    ("chain10", CHAIN10),
];
