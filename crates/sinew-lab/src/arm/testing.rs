//! Machines for unit tests.

use sinew::machine::Machine;

pub(super) fn lm_arm() -> Machine {
    machine("lm_arm.toml", include_str!("../../../../models/lm_arm.toml"))
}

/// One joint between two muscles, tracked in joint space.
pub(super) fn bench_joint() -> Machine {
    machine("bench_joint.toml", include_str!("../../../../models/bench_joint.toml"))
}

fn machine(name: &str, text: &str) -> Machine {
    sinew::description::machine_from_toml(name, text, &mut |_| Err("no other file".into())).unwrap().machine
}
