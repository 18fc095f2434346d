//! A cable discretised: parameters per cell and per node.

use super::elementary::tanh_series;
use super::parameters::CableParameters;
use super::path::{CablePath, NodePlace};
use super::weakening::Weakening;
use crate::error::{Error, non_negative, within};
use alloc::vec::Vec;

/// Largest half friction angle of one node: there the series for `tanh` errs by 2e-5.
pub(super) const LARGEST_HALF_ANGLE: f64 = 0.4;

/// Friction at one node, the same in both directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeLaw {
    /// `mu phi_i / 2`: the part that weakens with speed.
    pub friction: f64,
    /// `-ln(eta) / 2`.
    pub loss: f64,
    /// `mu_v phi_i / 2`, s/m.
    pub viscous: f64,
    /// `d_i`, N s/m.
    pub drag: f64,
}

impl NodeLaw {
    /// `h_i`, 1, without weakening.
    #[must_use]
    pub fn half_angle(&self) -> f64 {
        self.friction + self.loss
    }

    /// `tanh h_i` by the series that the step uses, 1.
    #[must_use]
    pub fn tanh_half(&self) -> f64 {
        tanh_series(self.half_angle())
    }
}

/// A pulley whose wrap may change: its node and its current wrap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PulleyPlace {
    pub(super) node: usize,
    pub(super) wrap: f64,
}

/// One cable, cut into cells and validated: immutable numbers, no state.
///
/// # Example
/// ```
/// use sinew::transmission::cable::{CableLaw, CableParameters, CablePath};
/// let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 12)?;
/// assert_eq!(law.cells(), 12);
/// assert!((law.friction_angle() - 1.054).abs() < 2e-3); // the only combination that the tables identify
/// # Ok::<(), sinew::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct CableLaw {
    pub(super) compliance: Vec<f64>,
    pub(super) nodes: Vec<NodeLaw>,
    pub(super) pulleys: Vec<PulleyPlace>,
    /// Bend of all sheaths, rad, and the fraction of it at every node.
    sheath_bend: f64,
    bend_fractions: Vec<f64>,
    pub(super) friction: f64,
    pub(super) viscous: f64,
    pub(super) pretension: f64,
    pub(super) drag_fade: f64,
    pub(super) weakening: Option<Weakening>,
}

impl CableLaw {
    /// A path with its parameters, cut into `cells`.
    ///
    /// 8 cells for an observer, 12 to 16 for a plant in real time; errors are listed in [`cable`](super).
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names a parameter outside its domain, a number of cells the path does not
    /// allow, or a friction angle that is too large for one node.
    pub fn new(path: &CablePath, parameters: &CableParameters, cells: usize) -> Result<Self, Error> {
        parameters.validate()?;
        let layout = path.layout(cells)?;
        let compliance = layout.cells.iter().map(|cell| {
            let wall = if cell.sheathed { parameters.sheath_compliance } else { 0.0 };
            cell.length * (parameters.compliance + wall)
        });
        let sheathed: f64 = layout.nodes.iter().map(|node| node.sheathed).sum();
        let sheath_bend = path.sheath_bend();
        // A straight sheath bends as one of even curvature.
        let bend_fraction = |node: &NodePlace| match (sheath_bend > 0.0, sheathed > 0.0) {
            (true, _) => node.bend / sheath_bend,
            (false, true) => node.sheathed / sheathed,
            (false, false) => 0.0,
        };
        let drag_per_length = if sheathed > 0.0 { parameters.drag / sheathed } else { 0.0 };
        let nodes = layout.nodes.iter().enumerate().map(|(i, node)| NodeLaw {
            friction: 0.5 * parameters.friction * (node.bend + node.wrap),
            loss: if i == 0 { -0.5 * libm::log(parameters.efficiency) } else { 0.0 },
            viscous: 0.5 * parameters.viscous * (node.bend + node.wrap),
            drag: drag_per_length * node.sheathed,
        });
        let law = Self {
            compliance: compliance.collect(),
            nodes: nodes.collect(),
            pulleys: layout.pulleys.iter().map(|&(node, wrap)| PulleyPlace { node, wrap }).collect(),
            sheath_bend,
            bend_fractions: layout.nodes.iter().map(bend_fraction).collect(),
            friction: parameters.friction,
            viscous: parameters.viscous,
            pretension: parameters.pretension,
            drag_fade: parameters.drag_fade,
            weakening: parameters.weakening.filter(|weakening| weakening.rise > 0.0),
        };
        law.nodes.iter().try_for_each(|node| law.check_angle(node))?;
        for compliance in &law.compliance {
            let sane = (1e-12..=1.0).contains(compliance);
            within("compliance of a cell", "a number in [1e-12, 1] m/N", *compliance, sane)?;
        }
        Ok(law)
    }

    /// The same with this bend of all its sheaths, rad, distributed as it was.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a negative bend, for a path without a sheath, or for a friction angle that
    /// is too large for one node.
    pub fn with_sheath_bend(mut self, bend: f64) -> Result<Self, Error> {
        self.set_sheath_bend(bend)?;
        Ok(self)
    }

    /// As [`with_sheath_bend`](Self::with_sheath_bend); unchanged where the bend is refused.
    pub(super) fn set_sheath_bend(&mut self, bend: f64) -> Result<(), Error> {
        non_negative("sheath bend", bend)?;
        let sheath = self.bend_fractions.iter().any(|fraction| *fraction > 0.0);
        within("sheath bend", "0 for a path without a sheath", bend, sheath || bend == 0.0)?;
        let change = bend - self.sheath_bend;
        let (friction, viscous) = (0.5 * self.friction * change, 0.5 * self.viscous * change);
        let bent = |node: &NodeLaw, fraction: f64| NodeLaw {
            // Rounding must not leave a negative angle.
            friction: (node.friction + friction * fraction).max(0.0),
            viscous: (node.viscous + viscous * fraction).max(0.0),
            ..*node
        };
        for (node, fraction) in self.nodes.iter().zip(&self.bend_fractions) {
            self.check_angle(&bent(node, *fraction))?;
        }
        for (node, fraction) in self.nodes.iter_mut().zip(&self.bend_fractions) {
            *node = bent(node, *fraction);
        }
        self.sheath_bend = bend;
        Ok(())
    }

    /// Refuses a friction angle beyond the validity of the series for `tanh`.
    pub(super) fn check_angle(&self, node: &NodeLaw) -> Result<(), Error> {
        let rise = self.weakening.map_or(0.0, |weakening| weakening.rise);
        let angle = 2.0 * ((1.0 + rise) * node.friction + node.loss);
        within(
            "friction angle of a node",
            "at most 0.8: less friction, less bend, a strong pulley as a short sheath, or more cells",
            angle,
            angle <= 2.0 * LARGEST_HALF_ANGLE,
        )?;
        Ok(())
    }

    /// Number of cells.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.compliance.len()
    }

    /// Compliance `c_j` of every cell, m/N, drive end first.
    #[must_use]
    pub fn compliance(&self) -> &[f64] {
        &self.compliance
    }

    /// Friction of every node, drive end first; node `i` sits between the cells `i` and `i + 1`.
    #[must_use]
    pub fn nodes(&self) -> &[NodeLaw] {
        &self.nodes
    }

    /// Node and wrap, rad, of the pulley next to the anchor, if there is one.
    #[must_use]
    pub fn last_pulley(&self) -> Option<(usize, f64)> {
        self.pulleys.last().map(|pulley| (pulley.node, pulley.wrap))
    }

    /// Velocity weakening, where friction has one.
    #[must_use]
    pub fn weakening(&self) -> Option<Weakening> {
        self.weakening
    }

    /// `mu phi - ln eta` of the whole path, without weakening: steady sliding changes the tension by the
    /// factor `e` to this power.
    #[must_use]
    pub fn friction_angle(&self) -> f64 {
        self.nodes.iter().map(|node| 2.0 * (node.friction + node.loss)).sum()
    }

    /// Tension ratio between the ends in steady sliding without drag: `e` to the power of the friction angle.
    #[must_use]
    pub fn end_ratio(&self) -> f64 {
        libm::exp(self.friction_angle())
    }

    /// Drag of the whole path, N s/m, and the tension `T_d` below which it fades, N.
    #[must_use]
    pub fn drag(&self) -> [f64; 2] {
        [self.nodes.iter().map(|node| node.drag).sum(), self.drag_fade]
    }

    /// Bend of all sheaths, rad.
    #[must_use]
    pub fn sheath_bend(&self) -> f64 {
        self.sheath_bend
    }

    /// `T_0`, N.
    #[must_use]
    pub fn pretension(&self) -> f64 {
        self.pretension
    }
}

#[cfg(test)]
mod tests {
    use super::super::Segment;
    use super::*;
    use alloc::vec;

    fn bench(bend: f64) -> CableLaw {
        let mut segments: Vec<Segment> = CablePath::bench().into();
        segments[1] = Segment::Sheath { length: 0.806, bend, curvature: vec![1.0, 3.0] };
        let parameters = CableParameters { viscous: 0.7, ..CableParameters::bench() };
        CableLaw::new(&CablePath::new(segments).unwrap(), &parameters, 9).unwrap()
    }

    #[test]
    fn a_changed_bend_is_that_of_a_path_built_with_it() {
        for (from, to) in [(1.2, 2.9), (2.9, 1.2), (2.9, 0.0)] {
            let (changed, exact) = (bench(from).with_sheath_bend(to).unwrap(), bench(to));
            assert!((changed.sheath_bend() - to).abs() < 1e-15 && (exact.sheath_bend() - to).abs() < 1e-15);
            assert!((changed.friction_angle() - exact.friction_angle()).abs() < 2e-16);
            for (node, exact) in changed.nodes.iter().zip(&exact.nodes) {
                assert!((node.friction - exact.friction).abs() < 5e-17, "{node:?} {exact:?}");
                assert!((node.viscous - exact.viscous).abs() < 5e-17, "{node:?} {exact:?}");
                assert!(
                    node.loss.to_bits() == exact.loss.to_bits()
                        && node.drag.to_bits() == exact.drag.to_bits()
                );
            }
        }
    }

    #[test]
    fn a_path_without_a_sheath_stays_without_bend_and_a_straight_sheath_bends_evenly() {
        let free = Segment::Free { length: 0.5 };
        let of = |segment: Segment, cells: usize| {
            let path = CablePath::new(vec![free.clone(), segment, free.clone()]).unwrap();
            CableLaw::new(&path, &CableParameters::bench(), cells).unwrap()
        };
        let pulley = of(Segment::Pulley { wrap: 1.0 }, 2);
        assert!(
            pulley.clone().with_sheath_bend(0.1).is_err() && pulley.clone().with_sheath_bend(0.0).is_ok()
        );
        assert!(pulley.with_sheath_bend(-0.1).is_err());
        let sheath = |bend: f64| of(Segment::Sheath { length: 0.8, bend, curvature: vec![] }, 7);
        let (bent, exact) = (sheath(0.0).with_sheath_bend(2.0).unwrap(), sheath(2.0));
        for (node, exact) in bent.nodes.iter().zip(&exact.nodes) {
            assert!((node.friction - exact.friction).abs() < 1e-16);
        }
    }

    #[test]
    fn the_drag_of_the_nodes_is_that_of_the_cable() {
        let [drag, fade] = bench(2.0).drag();
        assert!((drag - 95.0).abs() < 3e-14 && (fade - 5.0).abs() < 1e-15);
    }

    #[test]
    fn a_node_bears_a_friction_angle_of_four_fifths_with_its_loss_and_before_friction_weakens() {
        let over_a_pulley = |friction: f64, efficiency: f64, rise: f64| {
            let free = Segment::Free { length: 0.5 };
            let path = CablePath::new(vec![free.clone(), Segment::Pulley { wrap: 1.0 }, free]).unwrap();
            let weakening = Some(Weakening::rational(rise, 1e-3, 0.01));
            let parameters = CableParameters { friction, efficiency, weakening, ..CableParameters::bench() };
            CableLaw::new(&path, &parameters, 2)
        };
        // -ln 0.9 = 0.105.
        for (friction, efficiency, rise, borne) in [
            (0.79, 1.0, 0.0, true),
            (0.81, 1.0, 0.0, false),
            (0.69, 0.9, 0.0, true),
            (0.70, 0.9, 0.0, false),
            (0.52, 1.0, 0.5, true),
            (0.54, 1.0, 0.5, false),
            (0.45, 0.9, 0.5, true),
            (0.47, 0.9, 0.5, false),
        ] {
            let law = over_a_pulley(friction, efficiency, rise);
            assert_eq!(law.is_ok(), borne, "{friction} {efficiency} {rise}");
        }
    }
}
