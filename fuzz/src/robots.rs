//! Robots and machines: what is accepted can be written, and read again.

use sinew::body::{Parts, Robot};
use sinew::description::machine::FileReference;
use sinew::description::{
    Description, DescriptionError, from_mjcf, from_osim, from_toml, from_urdf, machine_from_toml, machine_of,
    robot_from_toml, to_mjcf, to_toml,
};

/// MJCF.
pub fn read_mjcf(bytes: &[u8]) {
    read_as(bytes, |text| from_mjcf("robot", text, &mut |_| Err("none".to_string())));
}

/// URDF.
pub fn read_urdf(bytes: &[u8]) {
    read_as(bytes, |text| from_urdf("robot", text, None));
}

/// OpenSim's models.
pub fn read_osim(bytes: &[u8]) {
    read_as(bytes, |text| from_osim("robot", text));
}

fn read_as(bytes: &[u8], read: impl Fn(&str) -> Result<Description, DescriptionError>) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(read) = read(text) else { return };
    let Ok(robot) = Robot::new(read.parts) else { return };
    let again = from_toml("again", &to_toml(robot.parts())).expect("own output is read");
    compare(robot.parts(), &again.parts);
}

/// Robots in our own format.
pub fn read_robot_toml(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let Ok(read) = from_toml("robot", text) else { return };
    let Ok(robot) = Robot::new(read.parts) else { return };
    let again = from_mjcf("again", &to_mjcf(robot.parts()), &mut |_| Err("none".to_string()))
        .expect("own output is read");
    compare(robot.parts(), &again.parts);
}

fn compare(first: &Parts, again: &Parts) {
    assert_eq!(first.joints.len(), again.joints.len());
    assert_eq!(first.tendons.len(), again.tendons.len());
}

/// Machine files. What a file names is the file itself, so that the formats of bodies and models are reached,
/// too.
pub fn read_machine(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    // The body begins with the first line that begins with `<`.
    let (machine, body) =
        text.split_once("\n<").map_or((text, text), |(machine, _)| (machine, &text[machine.len() + 1..]));
    let mut read = |_: FileReference<'_>| Ok(body.to_string());
    let lines = machine.lines().count().max(body.lines().count()) + 1;
    match machine_from_toml("machine.toml", machine, &mut read) {
        Ok(read) => {
            read.machine.validate().expect("what is read is valid");
            assert!(!read.settings.is_empty());
            // The body alone is a machine as well, with defaults.
            let robot = robot_from_toml("machine.toml", machine, &mut |_| Ok(body.to_string()))
                .expect("read before")
                .0;
            let described = Description::from_robot(&robot, "body");
            machine_of(described).expect("a machine but for its file");
        }
        Err(error) => assert!(error.line >= 1 && error.line <= lines, "{error}"),
    }
}
