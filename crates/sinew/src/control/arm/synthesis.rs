use super::allowed_feedback::allowed_feedback;
use super::gains::{ArmGains, EndPointGains, JointGains, MuscleGains};
use super::joint_monitor::JUMP_COUNTS;
use super::margins::WinchLag;
use super::pace::Pace;
use crate::Error;
use crate::body::IndependentKinematics;
use crate::body::vector::norm;
use crate::drive::{DriveParameters, JointEncoder};
use crate::machine::{Characteristics, ControlRules, JointCharacteristics, Machine, MuscleCharacteristics};
use crate::muscle::MuscleDynamics;
use crate::predictor::CableModel;
use crate::transmission::cable::CableLaw;
use alloc::vec::Vec;

/// Sources in whose documentation the rules' formulas stand, each with a title: for reports that print
/// them, so that they are written down once.
pub const RULE_SOURCES: [(&str, &str); 4] = [
    ("Rules", include_str!("synthesis.rs")),
    ("Feedback that damping and period allow", include_str!("allowed_feedback.rs")),
    ("What they follow from", include_str!("../../machine/characteristics.rs")),
    ("What limits a joint", include_str!("joint_limits.rs")),
];

/// Gains, limits and thresholds of a machine by rules from its own numbers, with the characteristics they
/// follow from.
///
/// ```text
/// F_min = T_0 + max(14 sigma, 1.5 T_l e^A),    F_max = T_h e^-A + T_0
/// w = 9.5 rad/s,   w_d = 1.3 w,   zeta = 0.53,   w_o = 58 rad/s
/// kappa = 0.94,   lambda = l_k <= 5.5,   lambda_i = 4.4 1/s,   c = 60 rad/s
/// observer  the load cell corrects by K_k 1/s at most, by a tenth of its model's gain at least
/// t_d,k = min(0.15 s, c/Om_k^2),   lowered until  sum_j B_kj t_d,j <= 2 c   (`shared_damping`)
/// v_max = 0.93 v_d,   a_max = a_d,   a = 0.35 a_d,   a_s = 0.4 a_d,   t_v = 5.6 ms,   x_t = 3.8 mrad r_k,   e_0 = 10 D
/// rest    delta_min = max(5.5 D r_k, 0.0072 G_k),   delta_max = 1.55 delta_min,   speed below 0.05 rad/s r_k,
///         from an error of max(min(0.5 mm, 0.04 r_k), 8 D r_k) to twice as much
/// joint   x_j = max(25 D, 3 tau/(I 3 (r w_o)^2)),   x_max = max(40 D, theta_G/10),
///         x_r,max = max(150 D, 0.4 theta_G),   e_q = max(1300 D, theta_G)
/// winch   encoder: 10 v_d, stands for 30 mrad r_k, 3 ms v_d to 4 ms v_d;   r_v,max = 30 ms v_d
/// end     none unless asked for;   u_max = 0.1 max sum_j |J_j| theta_G,j of all poses
/// cable   load cell: 40 ranges per s;   dT = max(0.38 F_min, 10 sigma);   slack below T_l + 0.14 F_min
///         eps = max(0.015, 0.8 a/r_k) + a_r
/// ```
///
/// | symbol   | meaning                                                                  | unit      |
/// |----------|--------------------------------------------------------------------------|-----------|
/// | sigma    | noise of the load cell                                                     | N         |
/// | T_0, A   | pretension and friction angle of the cable                                  | N, 1      |
/// | T_l, T_h | tension below which the drive does not pay out; its working tension           | N         |
/// | v_d, a_d | speed of the drive at 0.8 of its working tension, its acceleration limit | m/s, m/s^2 |
/// | D, r_k   | resolution of the joints' encoders; largest moment arm of the muscle           | rad, m    |
/// | x_j .. r_v,max, dT | thresholds of fault detection, [`JointGains`] and [`MuscleGains`]          |           |
/// | a, a_r   | tolerance of the moment arms, [`Machine::moment_arm_tolerance`]               | m, 1      |
/// | l_k, K_k | what the damping of the joints and the period allow; `l_k` is 5.5 for most machines | 1, 1/s   |
/// | Om_k, B, G_k, theta_G, tau, I | [`Characteristics`]                                                 | rad/s, 1/s^2, rad |
///
/// The numbers are [`ControlRules`] where a user may want to change them.
///
/// # Shapes
/// `models: [muscles]`, as designed or identified; `poses: [places][joints]`, of the motion.
///
/// # Errors
/// As [`Characteristics::new`] and [`CableModel::law`].
///
/// # Source
/// A study on random machines of one to eight joints and on the LM-Arm. What decides is the damping `t_d`:
/// its crossover with the mode of a cable that slides has to stay below that of winch and drive.
pub fn synthesize(
    machine: &Machine,
    models: &[CableModel],
    poses: &[Vec<f64>],
) -> Result<(ArmGains, Characteristics), Error> {
    let laws = models.iter().map(CableModel::law).collect::<Result<Vec<CableLaw>, Error>>()?;
    let (limits, found) = characterize(machine, &laws, poses)?;
    let pace = Pace::from_machine(machine);
    let rules = &pace.rules;
    let resolution = machine.encoders.iter().flatten().map(|encoder| encoder.resolution);
    let (resolution, arms) = (resolution.fold(0.0, f64::max), machine.moment_arm_tolerance());
    let joints = machine.encoders.iter().zip(&found.joints);
    let rate_gains = rate_gains(rules, &found);
    let winch = WinchLag { time_constant: pace.stretch_time_constant, dead_time: machine.dead_time() };
    let allowed = allowed_feedback(&found, &winch, rules, pace.period);
    let gains = ArmGains {
        damping: 0.53,
        observer_bandwidth: rules.observer_bandwidth,
        max_bandwidth_ratio: pace.max_bandwidth_ratio,
        feedback_fraction: 0.05,
        creep_feedback_fraction: 0.16,
        slip_filter_time: 0.009,
        rest_time_constant: 0.38,
        end_point: end_point(rules, machine, &found, poses)?,
        joints: joints.map(|(encoder, joint)| of_joint(&pace, encoder.as_ref(), joint)).collect(),
        muscles: (0..models.len())
            .map(|k| {
                let (design, muscle, allowed) = (&machine.muscles[k], &found.muscles[k], allowed[k]);
                let gains = of_muscle(&pace, &design.drive, muscle, limits[k], (resolution, arms));
                // The model's error at the largest tension. Up to a limit that is the drive's alone no motion
                // goes.
                let most = design.tension[1].map_or(0.0, |_| limits[k][1]);
                let correction = muscle.compliance * allowed.correction / models[k].correction;
                MuscleGains {
                    rate_gain: rate_gains[k],
                    missing_tension: gains.missing_tension.max(MODEL_ERROR * most),
                    backlash_gain: allowed.backlash_gain,
                    correction_fraction: correction.clamp(LEAST_CORRECTION, 1.0),
                    ..gains
                }
            })
            .collect(),
    };
    gains.validate(laws.len(), machine.encoders.len())?;
    Ok((gains, found))
}

/// Limits of the desired tensions, as [`tension_limits`], and the characteristics of a machine at its working
/// tensions, `T_0 + 1.2 F_min`, with moment arms that are off by the tolerance of the attachments.
///
/// # Shapes
/// `laws: [muscles]`, at the start; `poses: [places][joints]`. A sheath that passes joints counts with its
/// largest bend in these poses.
///
/// # Errors
/// As [`Characteristics::new`].
pub fn characterize(
    machine: &Machine,
    laws: &[CableLaw],
    poses: &[Vec<f64>],
) -> Result<(Vec<[f64; 2]>, Characteristics), Error> {
    let laws = &machine.laws_at_largest_bend(laws, poses)?;
    let limits = tension_limits(machine, laws);
    let working: Vec<f64> = limits
        .iter()
        .zip(laws)
        .map(|([least, _], law)| law.pretension() + WORKING_FRACTION * least)
        .collect();
    let mut model = MuscleDynamics::new(&machine.robot)?;
    let found = Characteristics::new(&mut model, laws, &working, poses, machine.moment_arm_tolerance().0)?;
    Ok((limits, found))
}

const WORKING_FRACTION: f64 = 1.2;

/// Smallest and largest desired tension at every anchor, N; the first is never above the second: `[muscles]`.
#[must_use]
pub fn tension_limits(machine: &Machine, laws: &[CableLaw]) -> Vec<[f64; 2]> {
    let limits = machine.muscles.iter().zip(laws).map(|(design, law)| {
        let drive = &design.drive;
        let (pretension, angle) = (law.pretension(), law.friction_angle());
        let margin = (14.0 * drive.load_cell.noise).max(1.5 * drive.min_tension * libm::exp(angle));
        let least = design.tension[0].unwrap_or(pretension + margin);
        let most = drive.working_tension() * libm::exp(-angle) + pretension;
        [least, design.tension[1].map_or(most, |limit| limit.min(most)).max(least)]
    });
    limits.collect()
}

fn of_joint(
    Pace { rules, max_bandwidth_ratio, .. }: &Pace,
    encoder: Option<&JointEncoder>,
    joint: &JointCharacteristics,
) -> JointGains {
    let resolution = encoder.map_or(JointEncoder::fourteen_bits().resolution, |encoder| encoder.resolution);
    let band = joint.dead_band;
    // Innovation of an observer at its largest bandwidth where the tensions of one side break away alone.
    let fastest = max_bandwidth_ratio * rules.observer_bandwidth;
    let break_away = joint.torque / joint.inertia / (3.0 * fastest * fastest);
    JointGains {
        bandwidth: rules.bandwidth,
        disturbance_bandwidth: 1.3 * rules.bandwidth,
        innovation_threshold: 10.0 * resolution,
        encoder: encoder.is_some(),
        resolution,
        jump: (JUMP_COUNTS * resolution).max(3.0 * break_away),
        implied: (40.0 * resolution).max(0.1 * band),
        reference_travel: (150.0 * resolution).max(0.4 * band),
        dead_band: band,
        tracking_error: (1300.0 * resolution).max(band),
    }
}

/// Of the machine's end point; none for a task of the joints.
fn end_point(
    rules: &ControlRules,
    machine: &Machine,
    found: &Characteristics,
    poses: &[Vec<f64>],
) -> Result<Option<EndPointGains>, Error> {
    let Some(site) = machine.task.site().filter(|_| rules.end_point_integral > 0.0) else { return Ok(None) };
    let mut kinematics = IndependentKinematics::new(&machine.robot);
    let mut largest: f64 = 0.0;
    for pose in poses {
        kinematics.evaluate(&machine.robot, pose)?;
        kinematics.site(&machine.robot, site)?;
        let column = |joint: usize| norm(core::array::from_fn(|k| kinematics.rows[k * pose.len() + joint]));
        let moved = found.joints.iter().enumerate().map(|(j, joint)| column(j) * joint.dead_band);
        largest = largest.max(moved.sum());
    }
    let largest = (END_POINT_FRACTION * largest).max(f64::MIN_POSITIVE);
    Ok(Some(EndPointGains { site, rate: rules.end_point_integral, largest }))
}

/// `t_d` of every muscle, s. Muscles that move the same joints damp the same motion: the rate at which all of
/// them together take the speed of an anchor is limited, beside that of each alone.
fn rate_gains(rules: &ControlRules, found: &Characteristics) -> Vec<f64> {
    let m = found.muscles.len();
    let alone = |muscle: &MuscleCharacteristics| {
        f64::min(LONGEST_RATE_GAIN, rules.damping_crossover / (muscle.mode * muscle.mode).max(1e-9))
    };
    let mut gains: Vec<f64> = found.muscles.iter().map(alone).collect();
    for _ in 0..RATE_ITERATIONS {
        let rates = found.interaction.chunks_exact(m.max(1));
        let rates: Vec<f64> = rates.map(|row| row.iter().zip(&gains).map(|(b, t)| b * t).sum()).collect();
        for (gain, rate) in gains.iter_mut().zip(rates) {
            *gain *= (rules.shared_damping * rules.damping_crossover / rate.max(1e-9)).min(1.0);
        }
    }
    gains
}

/// `u_max` over the travel of the end point within the dead bands of all joints.
const END_POINT_FRACTION: f64 = 0.1;
/// Largest `t_d`, s.
const LONGEST_RATE_GAIN: f64 = 0.15;
/// Rounds in which gains are lowered; the sum converges from above.
const RATE_ITERATIONS: usize = 20;

fn of_muscle(
    Pace { rules, period, stretch_time_constant, .. }: &Pace,
    drive: &DriveParameters,
    muscle: &MuscleCharacteristics,
    tension: [f64; 2],
    (resolution, (arm_error, relative)): (f64, (f64, f64)),
) -> MuscleGains {
    // A muscle that moves no joint in these poses keeps finite gains.
    let arm = muscle.arm.max(MIN_ARM);
    let speed = drive.speed_at(SPEED_FRACTION * drive.working_tension());
    let count = resolution * arm;
    let tolerance = (5.5 * count).max(0.0072 * muscle.dead_band);
    MuscleGains {
        position_gain: rules.position_gain,
        rate_gain: 0.0,
        stretch_time_constant: *stretch_time_constant,
        winch_deceleration: 0.35 * drive.acceleration,
        max_winch_speed: 0.93 * speed,
        max_winch_acceleration: drive.acceleration,
        stop_deceleration: 0.4 * drive.acceleration,
        presliding_distance: 3.8e-3 * arm,
        backlash_gain: rules.backlash_gain,
        backlash_integral: rules.backlash_integral,
        correction_fraction: 1.0,
        tension,
        rest_tolerance: [tolerance, 1.55 * tolerance],
        rest_error: [(0.04 * arm).min(5e-4).max(8.0 * count), (0.08 * arm).min(1e-3).max(16.0 * count)],
        rest_speed: 0.05 * arm,
        max_motor_rate: 10.0 * speed,
        max_unchanged_travel: (0.03 * arm).clamp((0.002 + period) * speed, (0.003 + period) * speed),
        reversal_travel: drive.reversal_travel(),
        max_winch_residual: 0.03 * speed,
        max_tension_rate: 40.0 * drive.load_cell.range,
        max_equal_tensions: equal_samples(drive, *period),
        missing_tension: (0.38 * tension[0]).max(10.0 * drive.load_cell.noise),
        min_drive_tension: drive.min_tension,
        slack_tension: drive.min_tension + 0.14 * tension[0],
        load_cell: drive.has_load_cell,
        load_cell_noise: drive.load_cell.noise,
        moment_arm_error: MIN_ARM_ERROR.max(ARM_FRACTION * arm_error / arm) + relative,
    }
}

/// Least fraction of the correction by the load cell, which follows wear and temperature.
const LEAST_CORRECTION: f64 = 0.1;

/// Relative error of an estimated tension.
const MODEL_ERROR: f64 = 0.02;

/// Fraction of a drive's working tension at which its speed is given.
const SPEED_FRACTION: f64 = 0.8;

/// Smallest relative error of a moment arm, and the fraction of a tolerance that is one.
const MIN_ARM_ERROR: f64 = 0.015;
const ARM_FRACTION: f64 = 0.8;

/// Least moment arm of a muscle, m.
const MIN_ARM: f64 = 1e-5;

/// Number of equal samples of a load cell that noise produces once in 1e12: each with the probability
/// `r/(2 sqrt(pi) sigma)`; at least those of 8 ms, and four. What noise does is a number of samples whatever
/// their period.
fn equal_samples(drive: &DriveParameters, period: f64) -> f64 {
    let cell = &drive.load_cell;
    let probability = cell.resolution / (2.0 * libm::sqrt(core::f64::consts::PI) * cell.noise);
    if probability.is_finite() && probability > 0.0 && probability < 0.9 {
        libm::ceil(libm::log(1e-12) / libm::log(probability)).max((0.008 / period).max(4.0))
    } else {
        1e9
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::LoadCell;
    use alloc::vec;

    /// Three joints with a muscle each.
    fn lever() -> Machine {
        Machine::from_robot(&crate::muscle::tests::robots::chain(false)).unwrap()
    }

    fn laws() -> Vec<CableLaw> {
        vec![CableModel::bench().law().unwrap(); 3]
    }

    fn assert_near(found: &[f64], expected: &[f64]) {
        assert_eq!(found.len(), expected.len());
        let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-12 * b.abs();
        assert!(found.iter().zip(expected).all(near), "{found:?}\n{expected:?}");
    }

    #[test]
    fn between_its_limits_a_tension_leaves_the_drive_its_margins_at_the_other_end_of_the_cable() {
        let (mut machine, laws) = (lever(), laws());
        machine.muscles[0].drive.load_cell.noise = 2.0;
        machine.muscles[1].drive.load_cell.noise = 0.0;
        machine.muscles[1].drive.min_tension = 20.0;
        let limits = tension_limits(&machine, &laws);
        let pretension = laws[0].pretension();
        assert_near(&[limits[0][0]], &[pretension + 14.0 * 2.0]);
        // The drive's end at 1 nm/s. Paying out, the drive keeps half more than the tension below which it
        // would not; winding in, it works.
        let drive = |far: f64, velocity: f64| laws[0].sliding(far, velocity, 1.0, 0.0).unwrap().tension_in;
        let least = drive(limits[1][0], -1e-9);
        assert!((least / 30.0 - 1.0).abs() < 4e-9, "{least}");
        for (design, [_, most]) in machine.muscles.iter().zip(limits) {
            let working = drive(most, 1e-9);
            assert!((working / design.drive.working_tension() - 1.0).abs() < 4e-9, "{working}");
        }
    }

    #[test]
    fn given_tensions_count_where_the_drive_reaches_them_and_the_largest_is_never_below_the_least() {
        let (mut machine, laws) = (lever(), laws());
        let reached = tension_limits(&machine, &laws)[0][1];
        machine.muscles[0].tension = [Some(30.0), Some(100.0)];
        machine.muscles[1].tension = [Some(30.0), Some(2.0 * reached)];
        machine.muscles[2].tension = [Some(2.0 * reached), None];
        let limits = tension_limits(&machine, &laws);
        assert_near(&limits[0], &[30.0, 100.0]);
        assert_near(&limits[1], &[30.0, reached]);
        assert_near(&limits[2], &[2.0 * reached; 2]);
    }

    #[test]
    fn a_machine_is_characterized_a_fifth_above_its_least_tensions_beyond_the_pretension() {
        let (machine, laws) = (lever(), laws());
        let (limits, found) = characterize(&machine, &laws, core::slice::from_ref(&machine.start)).unwrap();
        assert_eq!(limits, tension_limits(&machine, &laws));
        for ((muscle, law), [least, _]) in found.muscles.iter().zip(&laws).zip(limits) {
            assert_near(&[muscle.tension], &[law.pretension() + 1.2 * least]);
        }
    }

    fn joint_thresholds(resolution: f64, joint: &JointCharacteristics) -> [f64; 5] {
        let rules = ControlRules { observer_bandwidth: 50.0, ..ControlRules::default() };
        let encoder = JointEncoder { resolution, ..JointEncoder::slide() };
        let gains = of_joint(&Pace::new(&rules, 1e-3, 0.0), Some(&encoder), joint);
        assert!(gains.encoder);
        assert_near(&[gains.resolution], &[resolution]);
        [gains.innovation_threshold, gains.jump, gains.implied, gains.reference_travel, gains.tracking_error]
    }

    #[test]
    fn thresholds_of_a_joint_are_counts_of_a_coarse_encoder_and_shares_of_a_wide_dead_band() {
        let joint = JointCharacteristics { dead_band: 0.2, arm: 0.03, torque: 6.0, inertia: 0.5 };
        let coarse = joint_thresholds(0.1, &joint);
        assert_near(&coarse, &[1.0, 2.5, 4.0, 15.0, 130.0]);
        let fine = joint_thresholds(1e-7, &joint);
        // 6 Nm on 0.5 kg m^2 through an observer of three equal poles at 5.4 times 50 rad/s.
        let break_away = 6.0 / 0.5 / (3.0 * 270.0 * 270.0);
        assert_near(&fine, &[1e-6, 3.0 * break_away, 0.02, 0.08, 0.2]);
    }

    #[test]
    fn the_disturbance_of_a_joint_is_compensated_a_little_faster_than_its_bandwidth() {
        let rules = ControlRules { bandwidth: 7.0, ..ControlRules::default() };
        let joint = JointCharacteristics { dead_band: 0.2, arm: 0.03, torque: 6.0, inertia: 0.5 };
        let pace = Pace::new(&rules, 1e-3, 0.0);
        let gains = of_joint(&pace, None, &joint);
        assert_near(&[gains.bandwidth, gains.disturbance_bandwidth], &[7.0, 9.1]);
        // A joint without an encoder is judged as with the usual one.
        let usual = of_joint(&pace, Some(&JointEncoder::fourteen_bits()), &joint);
        assert!(!gains.encoder);
        assert_eq!(JointGains { encoder: true, ..gains }, usual);
    }

    /// `t_d` of muscles with these modes, rad/s, and interactions, 1/s^2.
    fn damping(rules: &ControlRules, modes: &[f64], interaction: &[f64]) -> Vec<f64> {
        let muscle = |mode: &f64| MuscleCharacteristics { mode: *mode, ..MuscleCharacteristics::default() };
        let found = Characteristics {
            muscles: modes.iter().map(muscle).collect(),
            joints: vec![],
            arms: vec![],
            interaction: interaction.to_vec(),
            stuck_mode: 0.0,
            damping_rate: 0.0,
        };
        rate_gains(rules, &found)
    }

    #[test]
    fn damping_alone_crosses_over_at_its_limit_or_has_the_longest_gain() {
        let rules = ControlRules { damping_crossover: 40.0, ..ControlRules::default() };
        let gains = damping(&rules, &[0.0, 10.0, 20.0, 100.0, 200.0], &[0.0; 25]);
        assert_near(&gains, &[0.15, 0.15, 0.1, 4e-3, 1e-3]);
    }

    #[test]
    fn muscles_side_by_side_share_the_damping_that_they_may_have_together() {
        // Each alone takes the speed of an anchor at 60/s; four together at 240/s, of which these rules allow
        // a part.
        let rules = |shared_damping| ControlRules { shared_damping, ..ControlRules::default() };
        for (shared, fraction) in [(0.5, 0.125), (2.0, 0.5), (5.0, 1.0)] {
            let gains = damping(&rules(shared), &[200.0; 4], &[4e4; 16]);
            assert_near(&gains, &[fraction * 60.0 / 4e4; 4]);
        }
        // Muscles of different strength, one of which is alone: no sum above the limit, and not far below it.
        let interaction = [4e4, 9e4, 0.0, 4e4, 9e4, 0.0, 0.0, 0.0, 100.0];
        let gains = damping(&rules(0.8), &[200.0, 300.0, 10.0], &interaction);
        let rate = 4e4 * gains[0] + 9e4 * gains[1];
        assert!((rate / 48.0 - 1.0).abs() < 1e-12 && (gains[2] - 0.15).abs() < 1e-12, "{rate} {gains:?}");
    }

    #[test]
    fn a_machine_gets_the_damping_of_its_muscles_and_limits_of_its_tensions() {
        let machine = lever();
        let models = vec![CableModel::bench(); 3];
        let poses = machine.poses(4).unwrap();
        let (gains, found) = synthesize(&machine, &models, &poses).unwrap();
        let damping: Vec<f64> = gains.muscles.iter().map(|muscle| muscle.rate_gain).collect();
        assert_near(&damping, &rate_gains(&machine.rules, &found));
        assert!(damping.iter().all(|gain| *gain > 0.0), "{damping:?}");
        assert_eq!(gains.tension_limits(), tension_limits(&machine, &laws()));
    }

    /// `F_min = 20 N`; compliance and tension of the cable are not read.
    fn muscle_gains(drive: &DriveParameters, arm: f64, dead_band: f64, resolution: f64) -> MuscleGains {
        let rules = ControlRules {
            position_gain: 0.8,
            backlash_gain: 5.0,
            backlash_integral: 4.0,
            ..ControlRules::default()
        };
        let muscle = MuscleCharacteristics { arm, dead_band, ..MuscleCharacteristics::default() };
        of_muscle(&Pace::new(&rules, 1e-3, 0.0), drive, &muscle, [20.0, 150.0], (resolution, (1e-3, 0.0)))
    }

    #[test]
    fn limits_of_a_winch_are_shares_of_what_its_drive_does_at_four_fifths_of_its_working_tension() {
        let drive = DriveParameters { acceleration: 4.0, ..DriveParameters::mc_am() };
        let speed = drive.speed_at(0.8 * drive.working_tension());
        let gains = muscle_gains(&drive, 0.01, 0.01, 1e-6);
        assert_near(&[gains.max_winch_speed, gains.max_motor_rate], &[0.93 * speed, 10.0 * speed]);
        assert_near(&[gains.max_winch_residual], &[0.03 * speed]);
        assert_near(&[gains.winch_deceleration, gains.stop_deceleration], &[1.4, 1.6]);
        assert_near(&[gains.max_winch_acceleration, gains.max_tension_rate], &[4.0, 40e3]);
        assert_near(&[gains.position_gain, gains.backlash_gain, gains.backlash_integral], &[0.8, 5.0, 4.0]);
        // 30 mrad of the moment arm, but of 3 ms to 4 ms of travel.
        for (milliseconds, expected) in [(2.0, 3.0), (3.5, 3.5), (5.0, 4.0)] {
            let gains = muscle_gains(&drive, milliseconds * 1e-3 * speed / 0.03, 0.01, 1e-6);
            assert_near(&[gains.max_unchanged_travel], &[expected * 1e-3 * speed]);
        }
    }

    #[test]
    fn tolerances_at_rest_are_counts_of_a_coarse_encoder_else_shares_of_moment_arm_and_dead_band() {
        let at_rest = |arm: f64, resolution: f64| {
            let gains = muscle_gains(&DriveParameters::mc_am(), arm, 0.01, resolution);
            [gains.rest_tolerance, gains.rest_error].concat()
        };
        assert_near(&at_rest(0.01, 1e-9), &[7.2e-5, 1.55 * 7.2e-5, 4e-4, 8e-4]);
        // 0.5 mm and 1 mm of a long arm.
        assert_near(&at_rest(0.05, 1e-9), &[7.2e-5, 1.55 * 7.2e-5, 5e-4, 1e-3]);
        // A count of 0.2 mm.
        assert_near(&at_rest(0.01, 0.02), &[1.1e-3, 1.55 * 1.1e-3, 1.6e-3, 3.2e-3]);
        let gains = muscle_gains(&DriveParameters::mc_am(), 0.01, 0.01, 1e-9);
        assert_near(&[gains.rest_speed, gains.presliding_distance], &[5e-4, 3.8e-5]);
        // A muscle that moves nothing has the gains of one with an arm of 10 um.
        let idle = |arm: f64| muscle_gains(&DriveParameters::mc_am(), arm, 0.01, 1e-9);
        assert_eq!(idle(0.0), idle(1e-5));
    }

    #[test]
    fn a_missing_tension_exceeds_the_noise_and_a_slack_cable_the_tension_at_which_its_drive_stops() {
        let at = |noise: f64| {
            let load_cell = LoadCell { noise, ..LoadCell::one_kilonewton() };
            let drive = DriveParameters { load_cell, min_tension: 2.0, ..DriveParameters::mc_am() };
            let gains = muscle_gains(&drive, 0.01, 0.01, 1e-6);
            [gains.missing_tension, gains.min_drive_tension, gains.slack_tension]
        };
        assert_near(&at(0.4), &[0.38 * 20.0, 2.0, 2.0 + 0.14 * 20.0]);
        assert_near(&at(1.5), &[15.0, 2.0, 2.0 + 0.14 * 20.0]);
    }

    #[test]
    fn a_tension_that_the_machine_states_is_missing_above_the_error_of_the_model_at_it() {
        let missing = |stated: [Option<f64>; 2]| {
            let mut machine = lever();
            machine.muscles[0].tension = stated;
            machine.muscles[0].drive.load_cell.noise = 1e-3;
            let (gains, _) =
                synthesize(&machine, &vec![CableModel::bench(); 3], &machine.poses(4).unwrap()).unwrap();
            gains.muscles[0].missing_tension
        };
        assert_near(&[missing([Some(3.0), Some(100.0)]), missing([Some(30.0), Some(100.0)])], &[2.0, 11.4]);
        assert_near(&[missing([Some(3.0), None])], &[1.14]);
    }

    /// Probability that two readings of a load cell are equal, summed over its counts.
    fn equal(cell: &LoadCell) -> f64 {
        let below = |x: f64| 0.5 * (1.0 + libm::erf(x * cell.resolution / cell.noise / libm::sqrt(2.0)));
        let count = |k: i32| below(f64::from(k) + 0.5) - below(f64::from(k) - 0.5);
        (-1000..=1000).map(|k| count(k) * count(k)).sum()
    }

    #[test]
    fn a_load_cell_repeats_itself_by_noise_once_in_a_million_million_samples() {
        let samples = |noise: f64, resolution: f64| {
            let load_cell = LoadCell { noise, resolution, ..LoadCell::one_kilonewton() };
            (equal_samples(&DriveParameters { load_cell, ..DriveParameters::mc_am() }, 1e-3), load_cell)
        };
        for (noise, resolution) in [(0.4, 0.05), (0.4, 0.1), (0.4, 0.2), (0.1, 0.1), (2.0, 0.3)] {
            let (found, cell) = samples(noise, resolution);
            let needed = (1..).find(|n| libm::pow(equal(&cell), f64::from(*n)) <= 1e-12).unwrap_or(0);
            assert!((found - f64::from(needed)).abs() < 1e-12, "{noise} {resolution}: {found} {needed}");
        }
        // At least 8; without noise or counts, or where a count swallows the noise, no number tells.
        assert!((samples(0.4, 1e-3).0 - 8.0).abs() < 1e-12);
        for (noise, resolution) in [(0.0, 0.05), (0.4, 0.0), (0.0, 0.0), (0.1, 0.4), (0.1, 0.33)] {
            assert!(samples(noise, resolution).0 > 1e8, "{noise} {resolution}");
        }
    }
}
