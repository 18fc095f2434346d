//! The LM-Arm for unit tests.

use sinew::machine::Machine;

pub(super) fn lm_arm() -> Machine {
    let text = include_str!("../../../../models/lm_arm.toml");
    sinew::description::machine_from_toml("lm_arm.toml", text, &mut |_| Err("no other file".into()))
        .unwrap()
        .machine
}
