//! Machine files. What a file names is the file itself, so that the formats of bodies and models are reached, too.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sinew::description::{machine_from_toml, machine_of, robot_from_toml};

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    // The body begins with the first line that begins with `<`.
    let (machine, body) =
        text.split_once("\n<").map_or((text, text), |(machine, _)| (machine, &text[machine.len() + 1..]));
    let mut read = |_: sinew::description::machine::FileReference<'_>| Ok(body.to_string());
    let lines = machine.lines().count().max(body.lines().count()) + 1;
    match machine_from_toml("machine.toml", machine, &mut read) {
        Ok(read) => {
            read.machine.validate().expect("what is read is valid");
            assert!(!read.settings.is_empty());
            // The body alone is a machine as well, with defaults.
            let robot = robot_from_toml("machine.toml", machine, &mut |_| Ok(body.to_string()))
                .expect("read before")
                .0;
            let described = sinew::description::Description::of(&robot, "body");
            machine_of(described).expect("a machine but for its file");
        }
        Err(error) => assert!(error.line >= 1 && error.line <= lines, "{error}"),
    }
});
