//! The arm of `models/`.

use sinew::body::Robot;

pub(crate) fn lm_arm() -> Robot {
    let text = include_str!("../../../../models/lm_arm.toml");
    Robot::new(sinew::description::from_toml("lm_arm.toml", text).unwrap().parts).unwrap()
}
