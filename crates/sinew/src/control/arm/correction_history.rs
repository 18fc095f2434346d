use alloc::vec;
use alloc::vec::Vec;

/// By how much the load cells had corrected the winches some seconds ago, and in which pose.
///
/// A joint encoder that slips slowly is not seen within the second or two of the open-loop observers; half a
/// minute of corrections shows it, because all muscles of the joint agree on it.
#[derive(Debug, Clone)]
pub(super) struct CorrectionHistory {
    /// Corrections of the winches, m: `[SNAPSHOTS x muscles]`; poses, rad or m: `[SNAPSHOTS x joints]`.
    corrections: Vec<f64>,
    poses: Vec<f64>,
    muscles: usize,
    joints: usize,
    taken: usize,
    since: f64,
}

/// Snapshots that are kept, and the time between two of them, s.
const SNAPSHOTS: usize = 16;
const SPACING: f64 = 2.0;

impl CorrectionHistory {
    pub(super) fn new(muscles: usize, joints: usize) -> Self {
        Self {
            corrections: vec![0.0; SNAPSHOTS * muscles],
            poses: vec![0.0; SNAPSHOTS * joints],
            muscles,
            joints,
            taken: 0,
            since: 0.0,
        }
    }

    /// Nothing is known of the past.
    pub(super) fn forget(&mut self) {
        (self.taken, self.since) = (0, 0.0);
    }

    /// Takes a snapshot whenever one is due, `dt` s after the last call.
    pub(super) fn follow(&mut self, dt: f64, corrections: &[f64], pose: &[f64]) {
        self.since += dt;
        if self.taken > 0 && self.since < SPACING {
            return;
        }
        self.since = 0.0;
        let (at, m, n) = (self.taken % SNAPSHOTS, self.muscles, self.joints);
        self.corrections[at * m..(at + 1) * m].copy_from_slice(corrections);
        self.poses[at * n..(at + 1) * n].copy_from_slice(pose);
        self.taken += 1;
    }

    /// The oldest corrections and their pose, once there are two snapshots.
    pub(super) fn oldest(&self) -> Option<(&[f64], &[f64])> {
        let oldest = match self.taken {
            0 | 1 => return None,
            taken if taken <= SNAPSHOTS => 0,
            taken => taken % SNAPSHOTS,
        };
        let (m, n) = (self.muscles, self.joints);
        Some((&self.corrections[oldest * m..(oldest + 1) * m], &self.poses[oldest * n..(oldest + 1) * n]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_snapshot_is_half_a_minute_old_once_there_are_enough() {
        let mut history = CorrectionHistory::new(2, 1);
        assert_eq!(history.oldest(), None);
        for step in 0..200_u32 {
            let time = 0.5 * f64::from(step);
            history.follow(0.5, &[time, -time], &[2.0 * time]);
            if let Some((corrections, pose)) = history.oldest() {
                let age = time - corrections[0];
                assert!(age <= 32.0 && (time < 32.0 || age >= 30.0), "{time}: {age}");
                assert!((pose[0] - 2.0 * corrections[0]).abs() < 1e-12);
                assert!((corrections[0] + corrections[1]).abs() < 1e-12);
            } else {
                assert!(time < 2.0, "{time}");
            }
        }
        history.forget();
        assert_eq!(history.oldest(), None);
    }
}
