//! The twin under a controller, cycle by cycle; a whole tracking run.

use crate::Answer;
use crate::geometry::machine;
use serde::Deserialize;
use serde_json::json;
use sinew::control::arm::{
    ActuationMode, ArmController, ArmMeasurement, CableStateSource, PreviewedReference, resting_tensions,
    synthesize,
};
use sinew::trajectory::Reference;
use sinew::twin::arm::{ArmSpecimen, ArmTwin};
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{
    CalibratedArm, TrackingTask, Verified, first_infeasibility, plan_tour, track_arm, verify,
};
use sinew_lab::experiment::oracle_models;

/// The tour of a machine on a specimen of a seed, cables as designed in the controller.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Simulate {
    machine: String,
    seed: u64,
    cycles: u32,
}

impl Simulate {
    pub(crate) fn answer(&self) -> Answer {
        let machine = machine(&self.machine)?;
        let trajectory = plan_tour(&machine, None, |t| first_infeasibility(&machine, t, 1))?;
        let design = ArmSpecimen::nominal(&machine)?;
        let models = oracle_models(&design);
        let (gains, _) = synthesize(&machine, &models, &machine.poses(40)?)?;
        let limits = gains.tension_limits();
        let mode = ActuationMode::WinchSpeed(CableStateSource::Observer);
        let mut controller = ArmController::new(&machine.robot, &models, gains, mode)?;
        controller = controller.with_sheath_bends(&machine.sheath_bends()?)?;
        let specimen = ArmSpecimen::sampled_around(&design, &machine, self.seed)?;
        let tensions = resting_tensions(&specimen.robot, &machine.start, &limits)?;
        let mut twin = ArmTwin::new(&specimen, &machine.start, &tensions, self.seed)?;
        let joints = machine.start.len();
        let (mut current, mut previewed) = (Reference::new(joints), Reference::new(joints));
        for cycle in 0..self.cycles {
            let time = f64::from(cycle) * 1e-3;
            trajectory.sample(time, &mut current)?;
            trajectory.sample(time + 0.12, &mut previewed)?;
            let reading = twin.reading().clone();
            let measurement =
                ArmMeasurement { motor: &reading.motor, tension: &reading.tension, joint: &reading.joint };
            let reference =
                PreviewedReference { current: &current, previewed: &previewed, repeat_time: None };
            let command = controller.step(1e-3, &measurement, &reference)?;
            let drives = command.drives.to_vec();
            twin.step(&drives, 1e-3)?;
        }
        let truth = twin.truth();
        let anchors: Vec<f64> = truth.cables.iter().map(|cable| cable.tension_out).collect();
        Ok(json!({ "q": truth.q, "v": truth.v, "tension_out": anchors, "duration": trajectory.duration() }))
    }
}

/// A verified tracking run along the tour of a machine.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Track {
    machine: String,
    seed: u64,
}

impl Track {
    pub(crate) fn answer(&self) -> Answer {
        let mut machine = machine(&self.machine)?;
        let trajectory = plan_tour(&machine, None, |t| first_infeasibility(&machine, t, 1))?;
        let motion = verify(&machine, &trajectory, 1)?;
        match motion.verified {
            Verified::Tracks(rules) | Verified::Inaccurate(rules, _) => machine.rules = rules,
            Verified::Fails(reason) => return Err(reason.into()),
        }
        let arm = CalibratedArm::new(&machine, self.seed)?.with_normal_errors(motion.joint_errors);
        let task = TrackingTask {
            trajectory: &trajectory,
            repeats: 1,
            learning: true,
            final_rest: 0.0,
            faults: &[],
            gains: None,
            trace_interval: 0.01,
        };
        let result = track_arm(&arm, CompensationVariant::Observer, &task)?;
        let last = result.trace.last().ok_or("no row")?;
        let mut columns: serde_json::Map<_, _> =
            last.columns().map(|(name, numbers)| (name.to_owned(), json!(numbers))).collect();
        columns.insert("time_s".to_owned(), json!(last.time_s));
        Ok(json!({ "numbers": result.numbers, "last": columns, "rows": result.trace.len() }))
    }
}
