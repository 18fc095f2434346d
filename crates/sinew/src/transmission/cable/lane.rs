//! What is done to one lane between steps: initial profiles, queries, changes of a parameter.

use super::lane_group::LaneGroup;
use super::repair::tension_ratio;
use super::travel::{CellView, travel};
use crate::error::{Error, non_negative, positive, within};
use crate::transmission::Sliding;

impl<const N: usize> LaneGroup<N> {
    /// The profile of sliding everywhere in one direction, with tension `far` at the anchor's end of the
    /// cable.
    pub(super) fn settle(&mut self, k: usize, far: f64, sliding: Sliding) {
        let mut tension = far;
        for j in (0..self.next_tension.len()).rev() {
            if j + 1 < self.next_tension.len() {
                tension /= tension_ratio(sliding.sign() * self.nodes[j].tanh_half.0[k]);
            }
            self.next_tension[j].0[k] = tension;
        }
        for (tension, next) in self.tension.iter_mut().zip(&self.next_tension) {
            tension.0[k] = next.0[k];
        }
        self.reset_motion(k);
    }

    /// This tension at the drive's end and a fraction of the friction at every node: 1 as after sliding
    /// toward the motor, -1 away from it, 0 the middle of the dead band. If a stretch is given, the fraction
    /// is found that yields it.
    pub(super) fn set_profile(&mut self, k: usize, near: f64, fraction: f64, stretch: Option<f64>) {
        let mut fraction = fraction;
        if let Some(stretch) = stretch {
            // Stretch falls monotonically with the fraction; thirty bisections leave an interval of 2e-9.
            let (mut low, mut high) = (-1.0, 1.0);
            for _ in 0..30 {
                fraction = 0.5 * (low + high);
                let too_long = self.write_profile(k, near, fraction) > stretch;
                *(if too_long { &mut low } else { &mut high }) = fraction;
            }
        }
        self.write_profile(k, near, fraction);
        self.reset_motion(k);
    }

    /// Tensions of [`set_profile`](Self::set_profile); returns their stretch.
    fn write_profile(&mut self, k: usize, near: f64, fraction: f64) -> f64 {
        let (mut tension, mut stretch) = (near, 0.0);
        for j in 0..self.tension.len() {
            self.tension[j].0[k] = tension;
            stretch += self.compliance[j].0[k] * tension;
            if let Some(node) = self.nodes.get(j) {
                tension *= tension_ratio(fraction * node.tanh_half.0[k]);
            }
        }
        stretch
    }

    /// Whether every node slid in the same direction in the last step.
    pub(super) fn slides_everywhere(&self, k: usize) -> bool {
        let mut slips = self.slip[1..self.tension.len()].iter().map(|row| row.0[k]);
        let first = slips.next().unwrap_or(0.0);
        first != 0.0 && slips.all(|slip| slip * first > 0.0)
    }

    /// Clears displacements and speeds.
    fn reset_motion(&mut self, k: usize) {
        for memory in &mut self.memory {
            memory.speed.0[k] = 0.0;
        }
        for slip in &mut self.slip {
            slip.0[k] = 0.0;
        }
        self.update_stretch_and_energy(k);
    }

    /// Travel of the winch that brings the anchor's end of the cable to `far`, m; see [`travel`].
    pub(super) fn travel_to(&self, k: usize, far: f64, sliding: Sliding) -> f64 {
        let s = sliding.sign();
        let ratio_at = |j: usize| tension_ratio(s * self.nodes[j].tanh_half.0[k]);
        let whole: f64 = (0..self.nodes.len()).map(ratio_at).product();
        let cells = (0..self.tension.len()).scan(1.0, |ratio, j| {
            if j > 0 {
                *ratio *= ratio_at(j - 1);
            }
            Some(CellView {
                tension: self.tension[j].0[k],
                compliance: self.compliance[j].0[k],
                ratio: *ratio,
            })
        });
        travel(cells, far / whole, s)
    }

    /// Sets the wrap of one pulley.
    pub(super) fn set_wrap(&mut self, k: usize, pulley: usize, wrap: f64) -> Result<(), Error> {
        non_negative("wrap", wrap)?;
        let law = &mut self.laws[k];
        let count = law.pulleys.len();
        within("pulley", "below the number of pulleys of the path", pulley as f64, pulley < count)?;
        let place = law.pulleys[pulley];
        let mut node = law.nodes[place.node];
        // Rounding must not leave a negative angle at zero wrap.
        node.friction = (node.friction + 0.5 * law.friction * (wrap - place.wrap)).max(0.0);
        node.viscous = (node.viscous + 0.5 * law.viscous * (wrap - place.wrap)).max(0.0);
        law.check_angle(&node)?;
        law.nodes[place.node] = node;
        law.pulleys[pulley].wrap = wrap;
        self.refresh(k, place.node);
        Ok(())
    }

    /// Sets the bend of all sheaths.
    pub(super) fn set_sheath_bend(&mut self, k: usize, bend: f64) -> Result<(), Error> {
        self.laws[k].set_sheath_bend(bend)?;
        for node in 0..self.nodes.len() {
            self.refresh(k, node);
        }
        Ok(())
    }

    /// Multiplies the drag of a lane as built by a factor.
    pub(super) fn scale_drag(&mut self, k: usize, factor: f64) -> Result<(), Error> {
        non_negative("drag factor", factor)?;
        self.drag_factor.0[k] = factor;
        Ok(())
    }

    /// Multiplies the compliance of a lane as built by a factor. Its cells keep their lengths, so that
    /// tensions fall as the compliance grows.
    pub(super) fn scale_compliance(&mut self, k: usize, factor: f64) -> Result<(), Error> {
        positive("compliance factor", factor)?;
        let cells = self.tension.iter_mut().zip(&mut self.compliance).zip(&mut self.stiffness);
        for (((tension, compliance), stiffness), built) in cells.zip(&self.laws[k].compliance) {
            let scaled = factor * built;
            tension.0[k] *= compliance.0[k] / scaled;
            (compliance.0[k], stiffness.0[k]) = (scaled, 1.0 / scaled);
        }
        let stretch = self.stretch.0[k];
        self.update_stretch_and_energy(k);
        // The same but for rounding; of a slack cable it is the slack.
        self.stretch.0[k] = stretch;
        Ok(())
    }

    /// Writes the numbers from which the next step of a lane follows.
    pub(super) fn save(&self, k: usize, state: &mut [f64]) {
        let m = self.tension.len();
        let (totals, rest) = state.split_at_mut(2);
        let (tensions, rest) = rest.split_at_mut(m);
        let (slips, speeds) = rest.split_at_mut(m - 1);
        totals.copy_from_slice(&[self.stretch.0[k], self.energy.0[k]]);
        for (saved, row) in tensions.iter_mut().zip(&self.tension) {
            *saved = row.0[k];
        }
        for (saved, row) in slips.iter_mut().zip(&self.slip[1..m]) {
            *saved = row.0[k];
        }
        // Other groups may have speeds that this one lacks.
        speeds.fill(0.0);
        for (saved, memory) in speeds.iter_mut().zip(&self.memory) {
            *saved = memory.speed.0[k];
        }
    }

    /// Reads what [`save`](Self::save) wrote.
    pub(super) fn restore(&mut self, k: usize, state: &[f64]) {
        let m = self.tension.len();
        let (totals, rest) = state.split_at(2);
        let (tensions, rest) = rest.split_at(m);
        let (slips, speeds) = rest.split_at(m - 1);
        (self.stretch.0[k], self.energy.0[k]) = (totals[0], totals[1]);
        for (saved, row) in tensions.iter().zip(&mut self.tension) {
            row.0[k] = *saved;
        }
        for (saved, row) in slips.iter().zip(&mut self.slip[1..m]) {
            row.0[k] = *saved;
        }
        for (saved, memory) in speeds.iter().zip(&mut self.memory) {
            memory.speed.0[k] = *saved;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bare::law;
    use super::super::lane_group::Row;
    use super::super::{CableLaw, CableParameters, CablePath, Segment};
    use super::*;
    use alloc::vec;

    #[test]
    fn a_cable_slides_everywhere_where_all_its_nodes_move_the_same_way() {
        let mut lanes = LaneGroup::<1>::new(&[law(&[1e-4; 4], &[0.1; 3])]);
        for (slips, everywhere) in [
            ([1e-4, 2e-5, 3e-4], true),
            ([-1e-4, -2e-5, -3e-4], true),
            ([1e-4, -2e-5, 3e-4], false),
            ([-1e-4, -2e-5, 3e-4], false),
            ([1e-4, 2e-5, 0.0], false),
            ([0.0, 2e-5, 3e-4], false),
            ([0.0; 3], false),
        ] {
            // What the ends do does not count.
            lanes.slip[0] = Row([-1.0]);
            for (row, slip) in lanes.slip[1..4].iter_mut().zip(slips) {
                row.0[0] = slip;
            }
            assert_eq!(lanes.slides_everywhere(0), everywhere, "{slips:?}");
        }
    }

    #[test]
    fn a_changed_wrap_is_that_of_a_path_built_with_it() {
        let built = |wraps: [f64; 3]| {
            let mut segments = vec![Segment::Free { length: 0.2 }];
            segments.push(Segment::Sheath { length: 0.3, bend: 0.6, curvature: vec![] });
            // Two pulleys share a node with the end of the sheath.
            segments.extend([Segment::Pulley { wrap: wraps[0] }, Segment::Pulley { wrap: wraps[1] }]);
            segments.extend([Segment::Free { length: 0.1 }, Segment::Pulley { wrap: wraps[2] }]);
            segments.push(Segment::Free { length: 0.4 });
            let parameters = CableParameters { friction: 0.1, viscous: 0.7, ..CableParameters::bench() };
            CableLaw::new(&CablePath::new(segments).unwrap(), &parameters, 6).unwrap()
        };
        let mut lanes = LaneGroup::<2>::new(&[built([0.5, 0.8, 1.1])]);
        let untouched = lanes.clone();
        lanes.set_wrap(1, 1, 1.4).unwrap();
        lanes.set_wrap(1, 2, 0.3).unwrap();
        let exact = LaneGroup::<2>::new(&[built([0.5, 1.4, 0.3])]);
        for ((node, exact), untouched) in lanes.nodes.iter().zip(&exact.nodes).zip(&untouched.nodes) {
            assert!((node.half_angle.0[1] - exact.half_angle.0[1]).abs() < 3e-17);
            assert!((node.tanh_half.0[1] - exact.tanh_half.0[1]).abs() < 3e-17);
            assert!((node.viscous.0[1] - exact.viscous.0[1]).abs() < 2e-16);
            assert_eq!(node.half_angle.0[0].to_bits(), untouched.half_angle.0[0].to_bits());
            assert_eq!(node.viscous.0[0].to_bits(), untouched.viscous.0[0].to_bits());
        }
        // Without any wrap nothing is left, whatever was set in between.
        lanes.set_wrap(1, 2, 0.0).unwrap();
        let last = lanes.nodes[4];
        assert!(last.half_angle.0[1].abs() < 1e-16 && last.viscous.0[1].abs() < 1e-16);
        assert!(lanes.set_wrap(1, 3, 0.1).is_err() && lanes.set_wrap(1, 0, -0.1).is_err());
        assert!(lanes.set_wrap(1, 0, 20.0).is_err());
        assert!((lanes.laws[1].friction_angle() - built([0.5, 1.4, 0.0]).friction_angle()).abs() < 1e-16);
    }

    #[test]
    fn a_cable_that_becomes_more_compliant_keeps_its_lengths_and_loses_tension() {
        let compliance = [2e-4, 1e-4, 5e-4];
        let mut lanes = LaneGroup::<1>::new(&[law(&compliance, &[0.1, 0.2])]);
        lanes.settle(0, 30.0, Sliding::TowardMotor);
        let before = lanes.clone();
        // The factor is on what was built, not on what was set before.
        for factor in [2.5, 1.25, 0.4] {
            lanes.scale_compliance(0, factor).unwrap();
            for (j, built) in compliance.iter().enumerate() {
                assert!((lanes.compliance[j].0[0] / built - factor).abs() < 1e-15);
                assert!((lanes.stiffness[j].0[0] * built * factor - 1.0).abs() < 2e-16);
                assert!((lanes.tension[j].0[0] * factor / before.tension[j].0[0] - 1.0).abs() < 4e-16);
            }
            assert!((lanes.stretch.0[0] - before.stretch.0[0]).abs() < 1e-18);
            assert!((lanes.energy.0[0] * factor / before.energy.0[0] - 1.0).abs() < 1e-15);
        }
        assert!(lanes.scale_compliance(0, 0.0).is_err());
    }
}
