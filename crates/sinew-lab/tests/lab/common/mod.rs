//! The arm of `models/`; campaigns of faults.

#[allow(dead_code, reason = "not every test uses all of it")]
pub(crate) mod faults;

#[allow(dead_code, reason = "not every test uses all of it")]
pub(crate) mod healthy;

#[allow(dead_code, reason = "not every test uses all of it")]
pub(crate) mod machines;

#[allow(dead_code, reason = "not every test uses all of it")]
pub(crate) mod random_machine;

#[allow(dead_code, reason = "not every test uses all of it")]
pub(crate) mod sensors;

#[allow(dead_code, reason = "not every test uses all of it")]
pub(crate) mod supervised;

use sinew::body::Robot;
use sinew::control::arm::{ArmGains, synthesize};
use sinew::machine::Machine;
use sinew::predictor::CableModel;
use sinew::trajectory::Reference;
use sinew_lab::arm::{DesiredMotion, plan};

#[allow(dead_code, reason = "not every test uses all of it")]
pub(crate) fn lm_arm() -> Robot {
    let text = sinew_models::LM_ARM;
    Robot::new(sinew::description::from_toml("lm_arm.toml", text).unwrap().parts).unwrap()
}

/// The machine of `models/`.
#[allow(dead_code, reason = "not every test uses all of it")]
pub(crate) fn lm_machine() -> Machine {
    read(sinew_models::LM_ARM)
}

/// Every machine of `models/`.
#[allow(dead_code, reason = "not every test uses all of it")]
pub(crate) fn machines() -> [Machine; 8] {
    [
        lm_machine(),
        read(sinew_models::BENCH_JOINT),
        read(sinew_models::PLANAR_LEG),
        read(sinew_models::FINGER),
        read(sinew_models::EXOSUIT_ELBOW),
        read(sinew_models::SURGICAL_WRIST),
        read(sinew_models::SHOULDER),
        read(sinew_models::CHAIN10),
    ]
}

fn read(text: &str) -> Machine {
    sinew::description::machine_from_toml("machine.toml", text, &mut |_| Err("no other file".into()))
        .unwrap()
        .machine
}

/// Its gains for the first of its paths.
#[allow(dead_code, reason = "not every test uses all of it")]
pub(crate) fn gains(models: &[CableModel]) -> ArmGains {
    let machine = lm_machine();
    let path = DesiredMotion::ClosedPath(machine.paths[0].path.clone());
    let motion = plan(&machine, &path, Some(11.5)).unwrap();
    let mut reference = Reference::new(motion.joints());
    let pose = |k: u32| {
        motion.sample(motion.duration() * f64::from(k) / 59.0, &mut reference).unwrap();
        reference.q.clone()
    };
    let poses: Vec<Vec<f64>> = (0..60).map(pose).collect();
    synthesize(&machine, models, &poses).unwrap().0
}
