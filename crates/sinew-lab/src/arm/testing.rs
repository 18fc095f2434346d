//! Machines for unit tests.

use sinew::machine::Machine;

pub(super) fn lm_arm() -> Machine {
    machine("lm_arm.toml", sinew_models::LM_ARM)
}

/// One joint between two muscles, tracked in joint space.
pub(super) fn bench_joint() -> Machine {
    machine("bench_joint.toml", sinew_models::BENCH_JOINT)
}

fn machine(name: &str, text: &str) -> Machine {
    sinew::description::machine_from_toml(name, text, &mut |_| Err("no other file".into())).unwrap().machine
}
