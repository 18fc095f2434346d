use crate::arm::{CalibratedArm, PreparedRun, TrackingTask, stop_reason};
use crate::experiment::TrackRow;
use crate::experiment::arm::TrackSession;
use crate::{CompensationVariant, Error};
use sinew::body::Poses;
use sinew::machine::Marker;
use sinew::trajectory::Trajectory;
use sinew::twin::camera::{Camera, CameraParameters};
use sinew_identify::geometry::{CableReadings, Frame, Readings};

/// What was read and seen on a motion of the twin.
#[derive(Debug, Clone)]
pub struct Flight {
    /// By the encoders, every 10 ms.
    pub readings: Readings,
    /// Of the cables at the same times.
    pub cables: CableReadings,
    /// By the camera.
    pub frames: Vec<Frame>,
    /// What stopped the motion before its end.
    pub stopped: Option<String>,
}

const INTERVAL_S: f64 = 0.01;

/// Moves a sampled machine along a motion, and watches it with a camera; simulated.
///
/// # Errors
/// As [`PreparedRun::new`] and [`TrackSession::step`].
pub fn fly(
    arm: &CalibratedArm,
    trajectory: &Trajectory,
    markers: &[Marker],
    camera: CameraParameters,
    seed: u64,
) -> Result<Flight, Error> {
    let task = TrackingTask {
        trajectory,
        repeats: 1,
        learning: false,
        final_rest: 1.0,
        faults: &[],
        gains: None,
        trace_interval: 1.0,
    };
    let prepared = PreparedRun::new(arm, CompensationVariant::Observer, &task)?;
    let run = prepared.run();
    let mut session = TrackSession::supervised(&run, prepared.supervisor()?)?;
    let mut camera = Camera::new(camera, markers, seed)?;
    let robot = &arm.specimen.robot;
    let (mut poses, mut seen, mut readings) = (Poses::new(robot), Vec::new(), Readings::default());
    let (mut failed, mut cables) = (None, CableReadings::default());
    let mut see = |row: &TrackRow<'_>| {
        if row.time >= readings.time.len() as f64 * INTERVAL_S {
            readings.time.push(row.time);
            readings.joint.push(row.reading.joint.clone());
            cables.position.push(row.reading.motor.clone());
            cables.tension_in.push(row.reading.tension.clone());
            cables.tension_out.push(row.command.estimated_tension.to_vec());
        }
        if camera.is_due(row.time) {
            let q = robot.pose_from_independent(row.truth.q);
            match q.and_then(|q| robot.bent_kinematics(&q, &mut poses)) {
                Ok(()) => camera.expose(row.time, robot, &poses, &mut seen),
                Err(error) => failed = Some(error),
            }
        }
    };
    while session.step(&mut see)? {}
    failed.map_or(Ok(()), Err)?;
    let summary = session.finish();
    let frame = |seen: sinew::twin::camera::Sighting| Frame {
        time: seen.time,
        marker: seen.marker,
        position: seen.position,
    };
    let fault = summary.stopped.map(|(_, fault)| stop_reason(fault, summary.threshold, &arm.machine.robot));
    let lost = || summary.plant_failed.map(|_| "motion faster than the cables allow".to_owned());
    let stopped = fault.or_else(lost);
    Ok(Flight { readings, cables, frames: seen.into_iter().map(frame).collect(), stopped })
}
