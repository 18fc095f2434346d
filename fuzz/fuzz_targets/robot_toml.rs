//! Robots in our own format.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sinew::body::Robot;
use sinew::description::{from_mjcf, from_toml, to_mjcf};

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(read) = from_toml("robot", text) else { return };
    let Ok(robot) = Robot::new(read.parts) else { return };
    // What is a robot can be written, and is a robot again.
    let again = from_mjcf("again", &to_mjcf(robot.parts()), &mut |_| Err("none".to_string()))
        .expect("own output is read");
    assert_eq!(robot.parts().joints.len(), again.parts.joints.len());
    assert_eq!(robot.parts().tendons.len(), again.parts.tendons.len());
});
