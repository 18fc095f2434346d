//! URDF.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sinew::body::Robot;
use sinew::description::{from_toml, from_urdf, to_toml};

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(read) = from_urdf("robot", text, None) else { return };
    let Ok(robot) = Robot::new(read.parts) else { return };
    // What is a robot can be written, and is a robot again.
    let again = from_toml("again", &to_toml(robot.parts())).expect("own output is read");
    assert_eq!(robot.parts().joints.len(), again.parts.joints.len());
    assert_eq!(robot.parts().tendons.len(), again.parts.tendons.len());
});
