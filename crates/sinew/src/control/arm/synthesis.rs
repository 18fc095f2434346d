use super::gains::{ArmGains, JointGains, MuscleGains};
use super::joint_monitor::JUMP_COUNTS;
use crate::Error;
use crate::drive::{DriveParameters, JointEncoder};
use crate::machine::{Characteristics, ControlRules, JointCharacteristics, Machine, MuscleCharacteristics};
use crate::muscle::MuscleDynamics;
use crate::predictor::CableModel;
use crate::transmission::cable::CableLaw;
use alloc::vec::Vec;

/// Gains, limits and thresholds of a machine by rules from its own numbers, with the characteristics they
/// follow from.
///
/// ```text
/// F_min = T_0 + max(14 sigma, 1.5 T_l e^A),    F_max = T_h e^-A + T_0
/// w = 9.5 rad/s,   w_d = 1.3 w,   zeta = 0.53,   w_o = 58 rad/s
/// kappa = 0.94,   lambda = 5.5,   lambda_i = 4.4 1/s,   c = 60 rad/s
/// t_d,k = min(0.15 s, c/Om_k^2),   lowered until  sum_j B_kj t_d,j <= 2 c   (`shared_damping`)
/// v_max = 0.93 v_d,   a_max = a_d,   a = 0.35 a_d,   a_s = 0.4 a_d,   t_v = 5.6 ms,   x_t = 3.8 mrad r_k,   e_0 = 10 D
/// rest    delta_min = max(5.5 D r_k, 0.0072 G_k),   delta_max = 1.55 delta_min,   speed below 0.05 rad/s r_k,
///         from an error of max(min(0.5 mm, 0.04 r_k), 8 D r_k) to twice as much
/// joint   x_j = max(25 D, 3 tau/(I 3 (r w_o)^2)),   x_max = max(40 D, theta_G/10),
///         x_r,max = max(150 D, 0.4 theta_G),   e_q = max(1300 D, theta_G)
/// winch   encoder: 10 v_d, stands for 30 mrad r_k, 3 ms v_d to 4 ms v_d;   r_v,max = 30 ms v_d
/// cable   load cell: 40 ranges per s;   dT = max(0.38 F_min, 10 sigma);   slack below T_l + 0.14 F_min
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
/// A study on random machines of one to eight joints and on the LM-Arm. What decides is the damping `t_d`: its
/// crossover with the mode of a cable that slides has to stay below that of winch and drive.
pub fn synthesize(
    machine: &Machine,
    models: &[CableModel],
    poses: &[Vec<f64>],
) -> Result<(ArmGains, Characteristics), Error> {
    let laws = models.iter().map(CableModel::law).collect::<Result<Vec<CableLaw>, Error>>()?;
    let (limits, found) = characterize(machine, &laws, poses)?;
    let rules = &machine.rules;
    let resolution = machine.encoders.iter().flatten().map(|encoder| encoder.resolution);
    let resolution = resolution.fold(0.0, f64::max);
    let joints = machine.encoders.iter().zip(&found.joints);
    let rate_gains = rate_gains(rules, &found);
    let muscles = machine.muscles.iter().zip(&found.muscles).zip(limits).zip(rate_gains);
    let gains = ArmGains {
        damping: 0.53,
        observer_bandwidth: rules.observer_bandwidth,
        max_bandwidth_ratio: MAX_BANDWIDTH_RATIO,
        feedback_share: 0.05,
        creep_feedback_share: 0.16,
        slip_filter_time: 0.009,
        rest_time_constant: 0.38,
        joints: joints.map(|(encoder, joint)| of_joint(rules, encoder.as_ref(), joint)).collect(),
        muscles: muscles
            .map(|(((design, muscle), limits), rate_gain)| {
                let gains = of_muscle(rules, &design.drive, muscle, limits, resolution);
                MuscleGains { rate_gain, ..gains }
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
/// `laws: [muscles]`, at the start; `poses: [places][joints]`. A sheath that passes joints counts with its largest bend
/// in these poses.
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
    let working: Vec<f64> =
        limits.iter().zip(laws).map(|([least, _], law)| law.pretension() + WORKING_SHARE * least).collect();
    let mut model = MuscleDynamics::new(&machine.robot)?;
    let found = Characteristics::new(&mut model, laws, &working, poses, machine.attachment_tolerance())?;
    Ok((limits, found))
}

const WORKING_SHARE: f64 = 1.2;

/// Least and largest desired tension at every anchor, N; the first is never above the second: `[muscles]`.
#[must_use]
pub fn tension_limits(machine: &Machine, laws: &[CableLaw]) -> Vec<[f64; 2]> {
    let limits = machine.muscles.iter().zip(laws).map(|(design, law)| {
        let drive = &design.drive;
        let (pretension, angle) = (law.pretension(), law.friction_angle());
        let margin = (14.0 * drive.load_cell.noise).max(1.5 * drive.least_tension * libm::exp(angle));
        let least = design.tension[0].unwrap_or(pretension + margin);
        let most = drive.working_tension() * libm::exp(-angle) + pretension;
        [least, design.tension[1].map_or(most, |limit| limit.min(most)).max(least)]
    });
    limits.collect()
}

fn of_joint(
    rules: &ControlRules,
    encoder: Option<&JointEncoder>,
    joint: &JointCharacteristics,
) -> JointGains {
    let resolution = encoder.map_or(JointEncoder::fourteen_bits().resolution, |encoder| encoder.resolution);
    let band = joint.dead_band;
    // Innovation of an observer at its largest bandwidth where the tensions of one side break away alone.
    let fastest = MAX_BANDWIDTH_RATIO * rules.observer_bandwidth;
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
        tracking_error: (1300.0 * resolution).max(band),
    }
}

/// `t_d` of every muscle, s. Muscles that move the same joints damp the same motion: the rate at which all of them
/// together take the speed of an anchor is limited, beside that of each alone.
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

/// Largest `t_d`, s.
const LONGEST_RATE_GAIN: f64 = 0.15;
/// Rounds in which gains are lowered; the sum converges from above.
const RATE_ITERATIONS: usize = 20;

fn of_muscle(
    rules: &ControlRules,
    drive: &DriveParameters,
    muscle: &MuscleCharacteristics,
    tension: [f64; 2],
    resolution: f64,
) -> MuscleGains {
    // A muscle that moves no joint in these poses keeps finite gains.
    let arm = muscle.arm.max(LEAST_ARM);
    let speed = drive.speed_at(SPEED_SHARE * drive.working_tension());
    let count = resolution * arm;
    let tolerance = (5.5 * count).max(0.0072 * muscle.dead_band);
    MuscleGains {
        position_gain: rules.position_gain,
        rate_gain: 0.0,
        stretch_time_constant: 0.0056,
        winch_deceleration: 0.35 * drive.acceleration,
        max_winch_speed: 0.93 * speed,
        max_winch_acceleration: drive.acceleration,
        stop_deceleration: 0.4 * drive.acceleration,
        presliding_distance: 3.8e-3 * arm,
        pre_travel_gain: rules.pre_travel_gain,
        pre_travel_integral: rules.pre_travel_integral,
        tension,
        rest_tolerance: [tolerance, 1.55 * tolerance],
        rest_error: [(0.04 * arm).min(5e-4).max(8.0 * count), (0.08 * arm).min(1e-3).max(16.0 * count)],
        rest_speed: 0.05 * arm,
        max_motor_rate: 10.0 * speed,
        max_unchanged_travel: (0.03 * arm).clamp(0.003 * speed, 0.004 * speed),
        max_winch_residual: 0.03 * speed,
        max_tension_rate: 40.0 * drive.load_cell.range,
        max_equal_tensions: equal_samples(drive),
        missing_tension: (0.38 * tension[0]).max(10.0 * drive.load_cell.noise),
        least_drive_tension: drive.least_tension,
        slack_tension: drive.least_tension + 0.14 * tension[0],
    }
}

/// `r`, 1: largest growth of the bandwidth of the joints' observers.
const MAX_BANDWIDTH_RATIO: f64 = 5.4;

/// Share of a drive's working tension at which its speed is given.
const SPEED_SHARE: f64 = 0.8;

/// Least moment arm of a muscle, m.
const LEAST_ARM: f64 = 1e-5;

/// Number of equal samples of a load cell that noise produces once in 1e12: each with the probability
/// `r/(2 sqrt(pi) sigma)`.
fn equal_samples(drive: &DriveParameters) -> f64 {
    let cell = &drive.load_cell;
    let probability = cell.resolution / (2.0 * libm::sqrt(core::f64::consts::PI) * cell.noise);
    if probability.is_finite() && probability > 0.0 && probability < 0.9 {
        libm::ceil(libm::log(1e-12) / libm::log(probability)).max(8.0)
    } else {
        1e9
    }
}
