//! The largest errors of a run, with the state of the machine at each.

use super::track_row::TrackRow;
use sinew::control::tension::Status;

/// Number of errors that are kept.
const KEPT: usize = 3;
/// Smallest time between two of them, s.
const APART_S: f64 = 1.0;
/// Speed of a reference above which it has a direction, rad/s or m/s.
const MOVING: f64 = 1e-6;

/// One of the largest errors of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorPeak {
    /// Distance of the end point from its reference, m. For a machine without an end point: the largest joint
    /// error as a fraction of the joint's range, 1; a joint without limits counts as 0.
    pub size: f64,
    /// Time of the peak, s.
    pub time: f64,
    /// Reference of the end point, the true one, and where it is if every encoder reads its reference, m; NaN
    /// without one.
    pub points: [[f64; 3]; 3],
    /// Reference, truth and estimate of every joint, rad or m: `[joints]`.
    pub joints: Vec<[f64; 3]>,
    /// True coordinates minus those in which every encoder reads its reference, rad or m: `[joints]`.
    pub joint_error: Vec<f64>,
    /// When the reference of every joint last reversed, s; NaN before: `[joints]`.
    pub reversed: Vec<f64>,
    /// Whether the tension distribution gave the torque within the limits of the tensions; false also where
    /// it did not converge.
    pub feasible: bool,
}

/// The largest errors so far.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ErrorPeaks {
    slots: Vec<ErrorPeak>,
    /// Range of every joint, rad or m: `[joints]`.
    ranges: Vec<f64>,
    /// Direction of every joint's reference.
    direction: Vec<f64>,
    reversed: Vec<f64>,
}

impl ErrorPeaks {
    /// `ranges: [joints]`, rad or m.
    pub(super) fn new(ranges: Vec<f64>) -> Self {
        let joints = ranges.len();
        let empty = ErrorPeak {
            size: 0.0,
            time: f64::NEG_INFINITY,
            points: [[f64::NAN; 3]; 3],
            joints: vec![[f64::NAN; 3]; joints],
            joint_error: vec![0.0; joints],
            reversed: vec![f64::NAN; joints],
            feasible: true,
        };
        let slots = vec![empty; KEPT];
        Self { slots, ranges, direction: vec![0.0; joints], reversed: vec![f64::NAN; joints] }
    }

    /// Records a control cycle; `distance`, m, is NaN without an end point. An error that keeps growing moves
    /// its slot along and counts once.
    pub(super) fn record(&mut self, row: &TrackRow<'_>, distance: f64) {
        for (k, v) in row.reference.v.iter().enumerate().filter(|(_, v)| v.abs() > MOVING) {
            if v * self.direction[k] < 0.0 {
                self.reversed[k] = row.time;
            }
            self.direction[k] = v.signum();
        }
        let size = if distance.is_finite() {
            distance
        } else {
            let fractions =
                row.joint_error.iter().zip(&self.ranges).map(|(error, range)| error.abs() / range);
            fractions.filter(|fraction| fraction.is_finite()).fold(0.0, f64::max)
        };
        let slots = self.slots.iter().enumerate();
        let near = slots.clone().find(|(_, slot)| (row.time - slot.time).abs() < APART_S);
        let least = || slots.min_by(|a, b| a.1.size.total_cmp(&b.1.size));
        let Some(index) = near.or_else(least).map(|(index, _)| index) else { return };
        let slot = &mut self.slots[index];
        if size > slot.size {
            (slot.size, slot.time) = (size, row.time);
            slot.points = [row.reference_point, row.end_point, row.encoder_point];
            let values = row.reference.q.iter().zip(row.truth.q).zip(row.command.q);
            for (joint, ((reference, truth), estimate)) in slot.joints.iter_mut().zip(values) {
                *joint = [*reference, *truth, *estimate];
            }
            slot.joint_error.copy_from_slice(row.joint_error);
            slot.reversed.copy_from_slice(&self.reversed);
            slot.feasible = row.command.distribution == Status::Optimal;
        }
    }

    /// Largest first, none within a second of a larger one.
    pub(super) fn sorted(&self) -> Vec<ErrorPeak> {
        let mut slots: Vec<ErrorPeak> = self.slots.iter().filter(|slot| slot.size > 0.0).cloned().collect();
        slots.sort_by(|a, b| b.size.total_cmp(&a.size));
        let mut kept: Vec<ErrorPeak> = Vec::new();
        for slot in slots {
            if kept.iter().all(|other| (other.time - slot.time).abs() >= APART_S) {
                kept.push(slot);
            }
        }
        kept
    }
}
