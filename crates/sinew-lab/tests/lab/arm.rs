//! An arm sampled from a seed, calibrated muscle by muscle, and tracked along a path.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::common;

use common::lm_machine;
use sinew::predictor::CableModel;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{CalibratedArm, DesiredMotion, TrackingTask, plan, track_arm};

#[test]
fn a_calibrated_arm_tracks_its_path_and_the_identified_parameters_are_near_the_true_ones() {
    let machine = lm_machine();
    let path = machine.paths[0].path.clone();
    let trajectory = plan(&machine, &DesiredMotion::ClosedPath(path), Some(11.5)).unwrap();
    let arm = CalibratedArm::new(&machine, 1).unwrap();
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
        repeats: 1,
        learning: true,
        final_rest: 0.0,
        faults: &[],
        gains: None,
        trace_interval: 0.01,
    };
    let observed = track_arm(&arm, CompensationVariant::Observer, &task).unwrap();
    let numbers = &observed.numbers;
    assert!(numbers.end_point_error_m.mean < 4e-3 && numbers.end_point_error_m.max < 11e-3, "{numbers:?}");
    assert!(numbers.muscle_length_error_m.mean < 0.11e-3 && numbers.per_muscle.len() == 15);
    assert_eq!(observed.trace.len(), 1450);
    let lost = track_arm(&arm, CompensationVariant::None, &task).unwrap().numbers;
    assert!(lost.end_point_error_m.mean > 5.0 * numbers.end_point_error_m.mean && lost.stopped_s.is_some());
    assert!(serde_json::to_string(&lost).unwrap().contains("\"length_error_per_muscle_m\":["));
}

#[test]
fn a_cable_that_was_identified_before_is_not_calibrated_again() {
    let mut machine = lm_machine();
    for (k, muscle) in machine.muscles.iter_mut().enumerate() {
        let path = muscle.path(0.1, 0.5).unwrap();
        let correction = 1e-3 + 1e-5 * k as f64;
        muscle.model = Some(CableModel { path, correction, ..CableModel::bench() });
    }
    let arm = CalibratedArm::new(&machine, 1).unwrap();
    assert!(
        arm.models.iter().zip(&machine.muscles).all(|(model, muscle)| Some(model) == muscle.model.as_ref())
    );
}
