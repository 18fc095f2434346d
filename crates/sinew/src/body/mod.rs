//! The robot's body: joints, tree, kinematics, dynamics.

mod parts;

pub use parts::{
    Actuator, ActuatorKind, Body, Coupling, Joint, JointKind, Key, Parts, Route, Sheath, Site, Station,
    Tendon, Wrap, WrapKind,
};
