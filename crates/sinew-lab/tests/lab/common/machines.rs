//! Machines of this repository and their motions.

use sinew::description::machine_from_toml;
use sinew::machine::Machine;
use sinew::trajectory::Trajectory;
use sinew_lab::arm::{DesiredMotion, first_infeasibility, plan, plan_tour};

/// A machine of this repository; `SINEW_WITHOUT=load_cells,joint_encoders`, or one of the two, takes these
/// sensors away.
pub(crate) fn machine(name: &str) -> Machine {
    let file = format!("{}/../../models/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&file).unwrap();
    let mut machine = machine_from_toml(name, &text, &mut |_| Err("no other file".into())).unwrap().machine;
    for sensor in std::env::var("SINEW_WITHOUT").unwrap_or_default().split(',').filter(|s| !s.is_empty()) {
        match sensor {
            "load_cells" => machine.muscles.iter_mut().for_each(|muscle| muscle.drive.has_load_cell = false),
            "joint_encoders" => machine.encoders.fill(None),
            other => panic!("SINEW_WITHOUT: {other}: expected load_cells or joint_encoders"),
        }
    }
    machine
}

/// The LM-Arm's paths in turn in 11.5 s, a tour of every other machine.
pub(crate) fn motion(machine: &Machine, seed: u64) -> Trajectory {
    if machine.robot.parts().name == "lm_arm" {
        let path = machine.paths[(seed % 2) as usize].path.clone();
        return plan(machine, &DesiredMotion::ClosedPath(path), Some(11.5)).unwrap();
    }
    plan_tour(machine, None, |trajectory| first_infeasibility(machine, trajectory, 1)).unwrap()
}
