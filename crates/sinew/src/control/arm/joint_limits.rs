use super::gains::ArmGains;
use super::synthesis::synthesize;
use crate::Error;
use crate::machine::{Characteristics, DesignChange, Machine};
use crate::predictor::CableModel;
use alloc::vec::Vec;

/// Changes of a design that bear on the accuracy of its joints.
pub const ACCURACY_CHANGES: [DesignChange; 4] = [
    DesignChange::FasterWinch,
    DesignChange::StifferCable,
    DesignChange::LessBend,
    DesignChange::FinerEncoder,
];

/// Numbers that limit how accurately a joint is tracked, from its gains and characteristics.
///
/// ```text
/// t_G  = max_k G_k/v_max,k              the winches cross the dead band; delays the loop by w t_G at its bandwidth
/// x_f  = (beta_0 + beta_c) theta_G      part of the dead band that feedforward leaves to feedback at creep speed
/// x_r  = min_k delta_min,k/r_kj         position error at which the first winch moves at rest
/// zeta = min_k sum_i B_ki t_d,i/(2 Om_k)    damping ratio of the cables' modes by the winches
/// ```
///
/// over the muscles `k` whose largest moment arm about the joint, `r_kj`, is at least a tenth of that of the
/// strongest.
///
/// | symbol | meaning                                                | unit         |
/// |--------|--------------------------------------------------------|--------------|
/// | G_k, theta_G, B, Om_k | [`Characteristics`]                     | m, rad or m, 1/s^2, rad/s |
/// | v_max, beta, delta_min, t_d, w | [`ArmGains`]                   | m/s, 1, m, s, rad/s |
///
/// # Source
/// Our own: the terms of the rules at [`synthesize`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointFigures {
    /// `t_G`, s.
    pub crossing: f64,
    /// The muscle that takes longest.
    pub slowest: usize,
    /// `x_f`, rad or m.
    pub friction: f64,
    /// `x_r`, rad or m.
    pub rest: f64,
    /// `zeta`, 1.
    pub damping: f64,
}

/// What limits a joint most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitedBy {
    /// No muscle moves it.
    NoMuscle,
    /// It has no encoder: its position follows from the stretch of its cables.
    NoEncoder,
    /// The time in which the winches cross the dead band: it takes half a radian or more of the loop's phase
    /// at its bandwidth.
    Crossing,
    /// Uncertain friction: `x_f > x_r`.
    Friction,
    /// The tolerance at rest: `x_r >= x_f`.
    Rest,
}

/// What limits one joint, and what each change of the design does to it.
#[derive(Debug, Clone, PartialEq)]
pub struct JointLimit {
    /// What limits it.
    pub limited_by: LimitedBy,
    /// As designed; none without a muscle.
    pub figures: Option<JointFigures>,
    /// After each of [`ACCURACY_CHANGES`].
    pub changed: Vec<(DesignChange, JointFigures)>,
}

/// Phase that the crossing may take at the bandwidth before it limits a joint, rad.
const CROSSING_PHASE: f64 = 0.5;
/// Least moment arm of a muscle that counts, relative to the largest about the joint.
const MIN_ARM: f64 = 0.1;
/// Smallest relative decrease of the limiting number that counts as a help.
const MIN_HELP: f64 = 0.1;

impl JointFigures {
    /// Of one joint; none where no muscle moves it.
    #[must_use]
    pub fn new(gains: &ArmGains, found: &Characteristics, joint: usize) -> Option<Self> {
        let (m, n) = (found.muscles.len(), found.joints.len());
        let arm = |k: usize| found.arms[k * n + joint];
        let strongest = (0..m).map(arm).fold(0.0, f64::max);
        let muscles = || (0..m).filter(|&k| strongest > 0.0 && arm(k) >= MIN_ARM * strongest);
        let crossing = |k: usize| found.muscles[k].dead_band / gains.muscles[k].max_winch_speed;
        let slowest = muscles().max_by(|&a, &b| crossing(a).total_cmp(&crossing(b)))?;
        let damping = |k: usize| {
            let rates = found.interaction[k * m..(k + 1) * m].iter().zip(&gains.muscles);
            rates.map(|(b, muscle)| b * muscle.rate_gain).sum::<f64>() / (2.0 * found.muscles[k].mode)
        };
        let fraction = gains.feedback_fraction + gains.creep_feedback_fraction;
        Some(Self {
            crossing: crossing(slowest),
            slowest,
            friction: fraction * found.joints[joint].dead_band,
            rest: muscles()
                .map(|k| gains.muscles[k].rest_tolerance[0] / arm(k))
                .fold(f64::INFINITY, f64::min),
            damping: muscles().map(damping).fold(f64::INFINITY, f64::min),
        })
    }

    /// The number that a limit is about; none for a limit without one.
    #[must_use]
    pub fn limiting(&self, limit: LimitedBy) -> Option<f64> {
        match limit {
            LimitedBy::NoMuscle => None,
            LimitedBy::Crossing => Some(self.crossing),
            LimitedBy::NoEncoder | LimitedBy::Friction => Some(self.friction),
            LimitedBy::Rest => Some(self.rest),
        }
    }
}

impl JointLimit {
    /// Whether a change lowers the limiting number by a tenth or more.
    #[must_use]
    pub fn is_helped_by(&self, after: &JointFigures) -> bool {
        let before = self.figures.and_then(|figures| figures.limiting(self.limited_by));
        let pair = before.zip(after.limiting(self.limited_by));
        pair.is_some_and(|(before, after)| after <= (1.0 - MIN_HELP) * before)
    }
}

/// What limits every joint of a machine with its gains by the rules, and what each change of the design does
/// to it, found by evaluating the rules again: `[joints]`.
///
/// # Shapes
/// `models: [muscles]`, as designed or identified; `poses: [places][joints]`.
///
/// # Errors
/// As [`synthesize`].
pub fn joint_limits(
    machine: &Machine,
    models: &[CableModel],
    poses: &[Vec<f64>],
) -> Result<Vec<JointLimit>, Error> {
    let (gains, found) = synthesize(machine, models, poses)?;
    let mut limits = Vec::new();
    for (joint, own) in gains.joints.iter().enumerate() {
        let figures = JointFigures::new(&gains, &found, joint);
        let limited_by = figures.map_or(LimitedBy::NoMuscle, |figures| match own.encoder {
            false => LimitedBy::NoEncoder,
            true if own.bandwidth * figures.crossing >= CROSSING_PHASE => LimitedBy::Crossing,
            true if figures.friction > figures.rest => LimitedBy::Friction,
            true => LimitedBy::Rest,
        });
        limits.push(JointLimit { limited_by, figures, changed: Vec::new() });
    }
    for change in ACCURACY_CHANGES {
        let models: Vec<CableModel> =
            models.iter().map(|model| change.of_cable(model)).collect::<Result<_, Error>>()?;
        let (gains, found) = synthesize(&machine.with(change)?, &models, poses)?;
        for (joint, limit) in limits.iter_mut().enumerate() {
            limit.changed.extend(JointFigures::new(&gains, &found, joint).map(|figures| (change, figures)));
        }
    }
    Ok(limits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{JointCharacteristics, MuscleCharacteristics};

    fn lever() -> Machine {
        Machine::from_robot(&crate::muscle::tests::robots::chain(false)).unwrap()
    }

    /// With cables of this many times the bench's compliance.
    fn limited(machine: &Machine, compliance: f64) -> Vec<JointLimit> {
        let mut model = CableModel::bench();
        model.parameters.compliance *= compliance;
        joint_limits(machine, &[model.clone(), model.clone(), model], &machine.poses(8).unwrap()).unwrap()
    }

    fn helps(limit: &JointLimit) -> Vec<DesignChange> {
        limit
            .changed
            .iter()
            .filter(|(_, after)| limit.is_helped_by(after))
            .map(|(change, _)| *change)
            .collect()
    }

    #[test]
    fn a_slow_winch_across_a_long_cable_limits_by_its_crossing_which_a_faster_winch_shortens() {
        let limits = limited(&lever(), 20.0);
        let last = limits.last().unwrap();
        assert_eq!(last.limited_by, LimitedBy::Crossing);
        let helps = helps(last);
        assert!(helps.contains(&DesignChange::FasterWinch) && helps.contains(&DesignChange::StifferCable));
        assert!(!helps.contains(&DesignChange::FinerEncoder));
        // Half the compliance is half the dead band at the same speed.
        let stiffer = last.changed.iter().find(|(change, _)| *change == DesignChange::StifferCable).unwrap();
        assert!((stiffer.1.crossing / last.figures.unwrap().crossing - 0.5).abs() < 1e-9);
    }

    #[test]
    fn a_coarse_encoder_limits_by_the_tolerance_at_rest_which_a_finer_one_alone_lowers() {
        let mut machine = lever();
        machine.encoders.iter_mut().flatten().for_each(|encoder| encoder.resolution = 0.02);
        for limit in limited(&machine, 0.01) {
            assert_eq!(limit.limited_by, LimitedBy::Rest);
            assert_eq!(helps(&limit), [DesignChange::FinerEncoder]);
        }
    }

    #[test]
    fn a_joint_without_an_encoder_is_limited_by_that() {
        let mut machine = lever();
        machine.encoders[1] = None;
        let limits = limited(&machine, 1.0);
        assert_eq!(limits[1].limited_by, LimitedBy::NoEncoder);
        assert!(limits.iter().all(|limit| limit.changed.len() == ACCURACY_CHANGES.len()));
    }

    #[test]
    fn a_fine_encoder_leaves_uncertain_friction_as_the_limit() {
        let mut machine = lever();
        machine.encoders.iter_mut().flatten().for_each(|encoder| encoder.resolution = 1e-6);
        for limit in limited(&machine, 0.01) {
            let figures = limit.figures.unwrap();
            assert!(figures.friction > figures.rest, "{figures:?}");
            assert_eq!(limit.limited_by, LimitedBy::Friction);
            assert!(helps(&limit).contains(&DesignChange::StifferCable));
            assert!(!helps(&limit).contains(&DesignChange::FinerEncoder));
        }
    }

    /// Three muscles and two joints; the last muscle has little of an arm about the first joint.
    fn by_hand() -> (ArmGains, Characteristics) {
        let muscle =
            |dead_band: f64, mode: f64| MuscleCharacteristics { dead_band, mode, ..Default::default() };
        let joint = |dead_band: f64| JointCharacteristics { dead_band, ..Default::default() };
        let found = Characteristics {
            muscles: [muscle(4e-3, 20.0), muscle(6e-3, 40.0), muscle(9e-3, 5.0)].to_vec(),
            joints: [joint(0.2), joint(0.5)].to_vec(),
            arms: [0.03, 0.01, 0.02, 0.04, 0.002, 0.05].to_vec(),
            interaction: [400.0, 60.0, 7.0, 80.0, 1600.0, 90.0, 1.0, 2.0, 25.0].to_vec(),
            stuck_mode: 0.0,
            damping_rate: 0.0,
        };
        let mut gains = ArmGains::for_tests(3, 2);
        (gains.feedback_fraction, gains.creep_feedback_fraction) = (0.05, 0.2);
        for (k, muscle) in gains.muscles.iter_mut().enumerate() {
            muscle.max_winch_speed = [0.1, 0.3, 0.05][k];
            muscle.rate_gain = [0.02, 0.05, 0.15][k];
            muscle.rest_tolerance[0] = [9e-5, 3e-5, 1e-6][k];
        }
        (gains, found)
    }

    #[test]
    fn the_figures_of_a_joint_are_those_of_the_worst_muscle_that_counts_about_it() {
        let (gains, found) = by_hand();
        let figures = JointFigures::new(&gains, &found, 0).unwrap();
        // Muscle 0: 4 mm at 0.1 m/s against 6 mm at 0.3 m/s; muscle 2 has a fifteenth of the strongest arm.
        assert_eq!(figures.slowest, 0);
        assert!((figures.crossing - 0.04).abs() < 1e-15);
        assert!((figures.friction - 0.25 * 0.2).abs() < 1e-15);
        // 90 um at 30 mm against 30 um at 20 mm.
        assert!((figures.rest - 1.5e-3).abs() < 1e-15);
        let first: f64 = (400.0 * 0.02 + 60.0 * 0.05 + 7.0 * 0.15) / 40.0;
        let second = (80.0 * 0.02 + 1600.0 * 0.05 + 90.0 * 0.15) / 80.0;
        assert!((figures.damping - first.min(second)).abs() < 1e-14, "{first} {second}");
        // About the second joint all three count, and the last decides.
        let figures = JointFigures::new(&gains, &found, 1).unwrap();
        assert_eq!(figures.slowest, 2);
        assert!((figures.crossing - 0.18).abs() < 1e-15 && (figures.friction - 0.125).abs() < 1e-15);
        assert!((figures.rest - 2e-5).abs() < 1e-17, "1 um at 50 mm: {}", figures.rest);
        let third = (1.0 * 0.02 + 2.0 * 0.05 + 25.0 * 0.15) / 10.0;
        assert!((figures.damping - first.min(second).min(third)).abs() < 1e-14, "{third}");
    }

    #[test]
    fn the_second_muscle_decides_the_damping_where_its_winch_damps_least() {
        let (mut gains, found) = by_hand();
        gains.muscles[1].rate_gain = 1e-3;
        let figures = JointFigures::new(&gains, &found, 0).unwrap();
        let second = (80.0 * 0.02 + 1600.0 * 1e-3 + 90.0 * 0.15) / 80.0;
        assert!((figures.damping - second).abs() < 1e-14, "{figures:?} {second}");
    }

    #[test]
    fn a_joint_that_no_muscle_moves_has_no_figures() {
        let (gains, mut found) = by_hand();
        for row in found.arms.chunks_exact_mut(2) {
            row[1] = 0.0;
        }
        assert!(JointFigures::new(&gains, &found, 1).is_none());
        assert!(JointFigures::new(&gains, &found, 0).is_some());
    }
}
