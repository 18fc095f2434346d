//! An arm drawn from a seed, calibrated muscle by muscle, and tracked along a path.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use sinew::body::Robot;
use sinew::trajectory::{EndPointPath, JointPath, Loop, Redundancy, TimeLaw, Trajectory};
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{CalibratedArm, TrackingTask, initial_pose, track_arm};

fn lm_arm() -> Robot {
    let text = include_str!("../../../models/lm_arm.toml");
    Robot::new(sinew::description::from_toml("lm_arm.toml", text).unwrap().parts).unwrap()
}

#[test]
fn a_calibrated_arm_tracks_its_path_and_the_identified_parameters_are_near_the_true_ones() {
    let robot = lm_arm();
    let site = robot.site("endpoint").unwrap();
    let path = EndPointPath::lm_arm(Loop::Sine);
    let joints = JointPath::resolve(&robot, site, &path, &Redundancy::lm_arm(), 720).unwrap();
    let law = TimeLaw::new(2.0 * std::f64::consts::PI, 5.75).unwrap();
    let trajectory = Trajectory::AlongPath { joints, law };
    let arm = CalibratedArm::new(&robot, &initial_pose(&trajectory).unwrap(), 1).unwrap();
    for (model, cable) in arm.models.iter().zip(&arm.specimen.cables) {
        let truth = cable.parameters.friction * cable.path.angle() - cable.parameters.efficiency.ln();
        let angle = model.law().unwrap().friction_angle();
        assert!((angle - truth).abs() < 0.02 * truth, "{angle} {truth}");
        // Measured: 0.92 N on one cable, 0.31 N on the others. The fit keeps another speed and lag of the
        // weakening than the plant's.
        assert!((model.parameters.pretension - cable.parameters.pretension).abs() < 1.2);
        assert!(
            (model.parameters.friction - cable.parameters.friction).abs() > 1e-9,
            "copied from the plant"
        );
    }
    let task = TrackingTask {
        trajectory: &trajectory,
        site,
        repeats: 1,
        learning: true,
        final_rest: 0.0,
        faults: &[],
        trace_interval: 0.01,
    };
    let observed = track_arm(&arm, CompensationVariant::Observer, &task).unwrap();
    let numbers = &observed.numbers;
    assert!(numbers.end_point_error_m.mean < 4e-3 && numbers.end_point_error_m.max < 11e-3, "{numbers:?}");
    assert!(numbers.muscle_length_error_m.mean < 0.11e-3 && numbers.per_muscle.len() == 15);
    assert_eq!(observed.trace.len(), 875);
    let lost = track_arm(&arm, CompensationVariant::None, &task).unwrap().numbers;
    assert!(lost.end_point_error_m.mean > 5.0 * numbers.end_point_error_m.mean && lost.stopped_s.is_some());
    assert!(serde_json::to_string(&lost).unwrap().contains("\"per_muscle\":["));
}
