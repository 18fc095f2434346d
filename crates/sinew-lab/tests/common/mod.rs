//! The arm of `models/`; campaigns of faults.

#[allow(dead_code, reason = "not every test uses all of it")]
pub(crate) mod faults;

use sinew::body::Robot;

pub(crate) fn lm_arm() -> Robot {
    let text = include_str!("../../../../models/lm_arm.toml");
    Robot::new(sinew::description::from_toml("lm_arm.toml", text).unwrap().parts).unwrap()
}
