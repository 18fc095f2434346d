//! Errors of a run against the truth of its plant, cycle by cycle.

use super::run::TrackRun;
use super::track_row::TrackRow;
use super::track_summary::{TrackSummary, slack_below};
use super::tracking_errors::TrackingErrors;
use sinew::Error;
use sinew::control::supervisor::Supervisor;
use sinew::twin::arm::ArmTwin;
use sinew_session::signals::{FrameLayout, Seen};
use std::sync::Arc;

/// Evaluates a run on a simulated plant, whatever stands between plant and controller.
#[derive(Debug, Clone)]
pub struct Evaluation<'a> {
    errors: TrackingErrors<'a>,
    summary: TrackSummary,
    /// N: `[muscles]`.
    pretension: Vec<f64>,
    layout: Arc<FrameLayout>,
}

impl<'a> Evaluation<'a> {
    /// Before the first control cycle.
    ///
    /// # Errors
    /// As [`MuscleDynamics::new`](sinew::muscle::MuscleDynamics::new).
    pub fn new(run: &TrackRun<'a>) -> Result<Self, Error> {
        let pretension: Vec<f64> =
            run.specimen.cables.iter().map(|cable| cable.parameters.pretension).collect();
        let least = run.tension_limits.iter().map(|[least, _]| *least);
        let slack_below = least.zip(&pretension).map(|(least, pretension)| slack_below(least, *pretension));
        let parts = run.robot.parts();
        let ranges = run.robot.independent_joints().into_iter().map(|joint| parts.joints[joint].range);
        let ranges = ranges.map(|range| range.map_or(f64::INFINITY, |[low, high]| high - low));
        Ok(Self {
            errors: TrackingErrors::new(run.specimen, run.robot, run.site)?,
            summary: TrackSummary::new(slack_below.collect(), ranges.collect(), run.specimen.period),
            layout: Arc::new(FrameLayout::new(
                [pretension.len(), run.robot.independent_joints().len()],
                true,
            )),
            pretension,
        })
    }

    /// Records one control cycle of a simulated machine: the reference, the command and the plant's state
    /// before the command takes effect.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for a pose of another robot.
    pub fn record<'row>(
        &'row mut self,
        cycle: &'row Seen<'row>,
        arm: &'row ArmTwin,
    ) -> Result<TrackRow<'row>, Error> {
        let Self { errors, summary, pretension, layout } = self;
        let Seen { moment, reference, command, .. } = cycle;
        let truth = arm.truth();
        errors.evaluate(&reference.q, truth.q, command.arm.desired_tension)?;
        let row = TrackRow {
            time: moment.time,
            repeat: moment.repeat,
            rested: moment.rested,
            reference,
            reference_point: errors.reference_point,
            end_point: errors.end_point,
            encoder_point: errors.encoder_point,
            joint_error: &errors.joint_error,
            pretension,
            length: &errors.length,
            length_error: &errors.length_error,
            closure_error: &errors.closure_error,
            off_manifold: &errors.off_manifold,
            command: &command.arm,
            mode: command.mode,
            fault: command.fault,
            reading: arm.reading(),
            truth,
            cycle,
            layout,
        };
        summary.record(&row);
        Ok(row)
    }

    /// Records that the integration of the plant failed at a time, s.
    pub fn plant_failed(&mut self, time: f64) {
        self.summary.plant_failed = Some(time);
    }

    /// The errors so far.
    #[must_use]
    pub fn summary(&self) -> &TrackSummary {
        &self.summary
    }

    /// The errors of the run under a supervisor.
    #[must_use]
    pub fn finish(mut self, supervisor: &Supervisor) -> TrackSummary {
        self.summary.health = supervisor.health().to_vec();
        self.summary.threshold = self.summary.stopped.and_then(|(_, fault)| supervisor.threshold(fault));
        self.summary
    }
}
