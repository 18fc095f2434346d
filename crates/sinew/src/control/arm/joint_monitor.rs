use super::gains::JointGains;
use super::status::Symptom;

/// Compares a joint's encoder with what its muscles, the reference and the encoder itself imply.
///
/// Between measurements the joint observer is driven by the estimated tensions of the muscles, whose lengths
/// are known from the motor encoders: the cables hold `q^` like springs ([`JointStiffness`]), and the model
/// predicts the next measurements with a small error. Two residuals compare the encoder with the muscles: the
/// innovation, and the change of the disturbances' torque that it needs.
///
/// ```text
/// e = y - q^,    x_r = int q'_r dt,    x_m = (tau_d,0 - tau_d)/k - e        since y last changed
/// x = x_r where |x_r| <= |x_m| and both have one sign, x_m where it is smaller, 0 where the signs differ
/// rejected   |e| > x_j or |d2y| > max(min(10 D, x_j), x_j/4)                             a jump
///            |x| > x_0 and |x_m| > x_max for longer than t_e,  or |x_r| > x_r,max   y unchanged bit for bit
/// returned   for t_c |e| <= x (1 + t_r/t_d) + a and |dy - h q'^| <= s, and |e| <= J/2 where it has
///            jumped by J and not back; x = x_j where y has changed since the rejection, x_c where it has not
/// ```
///
/// | symbol   | meaning                                                                     | unit    |
/// |----------|-----------------------------------------------------------------------------|---------|
/// | y, q^    | measured and predicted angle                                                  | rad     |
/// | x_r, x_m | motion by the reference and by the muscles since the output last changed       | rad     |
/// | tau_d, tau_d,0 | torque of the disturbances at the joint, now and when the output last changed | Nm    |
/// | k        | stiffness of the joint, [`JointStiffness`]                                   | Nm/rad  |
/// | d^_0     | disturbance of the joint's observer when the output last changed               | rad/s^2 |
/// | x_max, x_r,max | those of [`JointGains`], at least `x_l`; before the joint has gone `x_max` and `x_d` since its reference turned at least `theta_G/4`, and `1.25 theta_G` | rad |
/// | theta_G, x_d | dead band of the joint; what it hides of a light joint, `min(x_j, 1.25 theta_G)` | rad |
/// | x_l      | `x_d` of a light joint, whose `x_j` is above 25 counts of its encoder, 0 of another     | rad     |
/// | x_j      | [`JointGains`]                                                    | rad     |
/// | t_r, t_d | time since the rejection, [`DRIFT_TIME`] of the prediction                     | s       |
/// | t_e      | [`innovation_time`](Self::innovation_time): the innovation of a joint that breaks away or vibrates is over by then | s |
/// | d2y      | second difference of y: a joint that breaks away takes its speed in more than one cycle | rad |
/// | x_c      | `x_j`, at most 25 counts of the encoder                                      | rad     |
/// | x_0, s   | `x_l`, at least five counts of the encoder, `0.7 x_max` where that is above 70; two counts and an eighth of `x_j`                  | rad     |
/// | a        | `|x_r|` before the rejection: an encoder that was stuck returns with a jump      | rad     |
///
/// While an encoder is rejected, the observer continues on its model: over 0.2 s its error stays below 4 mrad
/// (150 losses on five arms). Where the output was unchanged, the observer has followed it: it continues from
/// `q^ + x` with `d^_0`.
///
/// # Source
/// Analytical redundancy as in `chow1984`; thresholds from fault-free runs of the twin.
///
/// [`JointStiffness`]: super::joint_stiffness::JointStiffness
#[derive(Debug, Clone, Copy)]
pub(super) struct JointMonitor {
    /// Factor of all tolerances, 1.
    scale: f64,
    /// `t_e`, s: time constant of the joint's observer.
    innovation_time: f64,
    /// Last measurement, rad.
    previous: f64,
    unchanged: Unchanged,
    /// Difference of the last two measurements, rad.
    step: f64,
    /// `t_r`, s.
    pub(super) rejected_for: f64,
    /// `a`, rad.
    allowance: f64,
    /// Whether the output has changed since the rejection.
    changed: bool,
    /// Time for which the samples have agreed since the rejection, s.
    agreeing_for: f64,
    /// Whether it was rejected because its output was unchanged.
    stood: bool,
    /// Sum of the jumps since the rejection, that which led to it included, rad.
    offset: f64,
    started: bool,
    turn: Turn,
}

/// Where the reference of a joint last turned.
#[derive(Debug, Clone, Copy)]
struct Turn {
    /// Direction of the reference since then, 1 or -1; 0 before it has moved.
    side: f64,
    /// Measurement, rad.
    at: f64,
}

impl Turn {
    const NONE: Self = Self { side: 0.0, at: f64::NAN };

    fn follow(&mut self, measured: f64, reference_speed: f64) {
        if reference_speed * self.side < 0.0 || (self.side == 0.0 && reference_speed != 0.0) {
            *self = Self { side: reference_speed.signum(), at: measured };
        }
    }

    /// How far a joint has followed since then, rad.
    fn followed(&self, measured: f64) -> f64 {
        (measured - self.at) * self.side
    }
}

/// State of a joint since its encoder's output last changed.
#[derive(Debug, Clone, Copy, Default)]
struct Unchanged {
    /// `x_r`, rad.
    reference: f64,
    /// `x`, rad.
    implied: f64,
    /// `tau_d,0`, Nm; NaN before the second measurement: at the first nothing is known of the disturbances.
    torque: f64,
    /// `d^_0`, rad/s^2.
    disturbance: f64,
    /// Time for which muscles and reference have contradicted it, s.
    contradicted_for: f64,
}

impl Unchanged {
    /// At a change of the output.
    fn since_now(predicted: &JointPrediction<'_>) -> Self {
        Self { torque: predicted.torque, disturbance: predicted.disturbance, ..Self::default() }
    }
}

/// Outcome of a comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum EncoderCheck {
    /// The joint has no encoder.
    Absent,
    /// Accepted.
    Accepted,
    /// Rejected, first sample: the estimate moves by an angle, rad, and its disturbance, rad/s^2, is
    /// replaced.
    Withdrawn {
        /// `x`, rad.
        shift: f64,
        /// `d^_0`, rad/s^2.
        disturbance: f64,
    },
    /// Rejected again.
    Rejected,
    /// Accepted again: the estimated angle starts from the measurement.
    Returned,
}

/// What a measurement is compared with.
#[derive(Debug, Clone, Copy)]
pub(super) struct JointPrediction<'a> {
    /// `q^`, rad.
    pub(super) angle: f64,
    /// `q'^`, rad/s.
    pub(super) speed: f64,
    /// `d^`, rad/s^2.
    pub(super) disturbance: f64,
    /// `tau_d`, Nm.
    pub(super) torque: f64,
    /// `q_r`, rad.
    pub(super) reference: f64,
    /// `q'_r`, rad/s.
    pub(super) reference_speed: f64,
    /// Thresholds of the joint.
    pub(super) gains: &'a JointGains,
    /// `k`, Nm/rad.
    pub(super) stiffness: f64,
    /// Whether the winches follow speeds, so that the joint follows its reference.
    pub(super) winches_move: bool,
}

/// Counts of the encoder that no joint jumps within a cycle but one that breaks away.
pub(super) const JUMP_COUNTS: f64 = 25.0;
/// Counts by which a reading may change beside the change before, 1: more kicks the joint's observer.
const STEP_COUNTS: f64 = 10.0;
/// `t_c`, s, and two samples at least.
const CONSISTENT_TIME: f64 = 0.004;
/// s: tolerance of times that are sums of cycles.
const ROUNDING: f64 = 1e-9;
/// Fraction of the jumps that may be left where an encoder returns without one.
const RETURNED_FRACTION: f64 = 0.5;
/// `t_d`, s: the error of the prediction grows by `x` in this time.
const DRIFT_TIME: f64 = 0.15;

/// Fraction of `x_max` by which the reference has to have moved, too, where `x_max` is larger than this
/// number of counts: a joint lags by as much within a large dead band.
const MIN_FRACTION: f64 = 0.7;
const LARGE_LAG_COUNTS: f64 = 100.0;

/// Fraction of its dead band by which a joint may stand away from its muscles where it turns.
const TURNING_FRACTION: f64 = 0.25;
/// The dead band of a machine as built over that of the design, at most.
const WIDEST_BAND: f64 = 1.25;

/// Travel below which an output may stay unchanged, rad: five counts of the encoder.
fn min_travel(gains: &JointGains) -> f64 {
    5.0 * gains.resolution
}

/// `x_d`, rad.
fn hidden_travel(gains: &JointGains) -> f64 {
    gains.jump.min(WIDEST_BAND * gains.dead_band)
}

/// `x_l`: `x_d` of a light joint, whose jump when it breaks away is larger than what its encoder tells; 0 of
/// another, rad.
fn hidden_by_friction(gains: &JointGains) -> f64 {
    if gains.jump > 1.001 * JUMP_COUNTS * gains.resolution { hidden_travel(gains) } else { 0.0 }
}

/// Largest second difference of a reading that moves, rad.
fn max_second_difference(gains: &JointGains) -> f64 {
    gains.jump.min(STEP_COUNTS * gains.resolution).max(0.25 * gains.jump)
}

/// `x_c`, rad.
fn min_jump(gains: &JointGains) -> f64 {
    gains.jump.min(JUMP_COUNTS * gains.resolution)
}

impl JointMonitor {
    /// With all tolerances multiplied by `scale`, behind an observer with this time constant, s.
    pub(super) fn new(scale: f64, innovation_time: f64) -> Self {
        Self {
            scale,
            innovation_time,
            previous: f64::NAN,
            unchanged: Unchanged { torque: f64::NAN, ..Unchanged::default() },
            step: 0.0,
            rejected_for: 0.0,
            allowance: 0.0,
            changed: false,
            agreeing_for: 0.0,
            stood: false,
            offset: 0.0,
            started: false,
            turn: Turn::NONE,
        }
    }

    /// The next measurement is the first.
    pub(super) fn restart(&mut self) {
        *self = Self::new(self.scale, self.innovation_time);
    }

    /// How the encoder behaves while it is rejected.
    pub(super) fn symptom(&self) -> Symptom {
        Symptom::of_reading(self.previous, self.stood)
    }

    /// Compares a measurement, `h` s after the one before, with its prediction.
    pub(super) fn update(&mut self, h: f64, measured: f64, predicted: &JointPrediction<'_>) -> EncoderCheck {
        let unchanged = measured.to_bits() == self.previous.to_bits();
        let step = if self.started { measured - self.previous } else { 0.0 };
        let second_difference = step - self.step;
        (self.previous, self.step) = (measured, step);
        self.turn.follow(measured, predicted.reference_speed);
        if !core::mem::replace(&mut self.started, true) {
            return self.first(h, (measured - predicted.reference).abs() <= predicted.gains.tracking_error);
        }
        let before = self.unchanged;
        if unchanged && !self.unchanged.torque.is_nan() {
            self.unchanged.reference += h * predicted.reference_speed;
        } else {
            self.unchanged = Unchanged::since_now(predicted);
        }
        let e = measured - predicted.angle;
        if self.rejected_for > 0.0 {
            self.changed |= !unchanged;
            if second_difference.abs() > self.scale * max_second_difference(predicted.gains) {
                self.offset += second_difference;
            }
            return self.examine_return(h, e, step, predicted);
        }
        if !unchanged {
            let gains = predicted.gains;
            let near = e.abs() <= self.scale * gains.jump;
            let smooth = second_difference.abs() <= self.scale * max_second_difference(gains);
            self.stood = false;
            if near && smooth {
                return EncoderCheck::Accepted;
            }
            self.offset = if smooth || second_difference.is_nan() { 0.0 } else { second_difference };
            return self.withdraw(h, before);
        }
        if self.is_contradicted(h, e, predicted) {
            (self.stood, self.offset) = (true, 0.0);
            self.withdraw(h, self.unchanged)
        } else {
            EncoderCheck::Accepted
        }
    }

    fn first(&mut self, h: f64, accepted: bool) -> EncoderCheck {
        if accepted {
            return EncoderCheck::Accepted;
        }
        self.rejected_for = h;
        EncoderCheck::Rejected
    }

    /// Whether muscles and reference have contradicted an unchanged output for long enough; evaluates `x`.
    fn is_contradicted(&mut self, h: f64, e: f64, predicted: &JointPrediction<'_>) -> bool {
        let by_muscles = (self.unchanged.torque - predicted.torque) / predicted.stiffness - e;
        let by_reference = self.unchanged.reference;
        let one_sign = by_muscles * by_reference > 0.0;
        self.unchanged.implied =
            if one_sign { by_reference.signum() * by_muscles.abs().min(by_reference.abs()) } else { 0.0 };
        let gains = predicted.gains;
        let [most, farthest] = self.limits(gains);
        let large = most > LARGE_LAG_COUNTS * gains.resolution;
        let least =
            if large { MIN_FRACTION * most } else { min_travel(gains).max(hidden_by_friction(gains)) };
        let moved = self.unchanged.implied.abs() > self.scale * least && by_muscles.abs() > self.scale * most;
        self.unchanged.contradicted_for = if moved { self.unchanged.contradicted_for + h } else { 0.0 };
        let lasting = self.unchanged.contradicted_for > self.innovation_time;
        lasting || (predicted.winches_move && by_reference.abs() > farthest)
    }

    /// `x_max` and `x_r,max`, rad: a joint whose reference has turned stands until its cables have crossed
    /// their dead bands, and friction decides when. A light one hardly resists them, so that all of its dead
    /// band is open.
    fn limits(&self, gains: &JointGains) -> [f64; 2] {
        let hidden = hidden_travel(gains);
        if self.turn.followed(self.previous) > gains.implied.max(hidden) {
            let hidden = hidden_by_friction(gains);
            [gains.implied.max(hidden), gains.reference_travel.max(hidden)]
        } else {
            let most = gains.implied.max(TURNING_FRACTION * gains.dead_band).max(hidden);
            [most, gains.reference_travel.max(WIDEST_BAND * gains.dead_band)]
        }
    }

    fn withdraw(&mut self, h: f64, from: Unchanged) -> EncoderCheck {
        (self.rejected_for, self.changed, self.agreeing_for) = (h, false, 0.0);
        self.allowance = from.reference.abs();
        EncoderCheck::Withdrawn { shift: from.implied, disturbance: from.disturbance }
    }

    fn examine_return(&mut self, h: f64, e: f64, step: f64, predicted: &JointPrediction<'_>) -> EncoderCheck {
        self.rejected_for += h;
        let growth = 1.0 + self.rejected_for / DRIFT_TIME;
        let gains = predicted.gains;
        let jump = if self.changed { gains.jump } else { min_jump(gains) };
        let near = e.abs() <= self.scale * jump * growth + self.allowance;
        let steady = (step - h * predicted.speed).abs() <= 2.0 * gains.resolution + 0.125 * gains.jump;
        let alive = self.unchanged.reference.abs() < min_travel(predicted.gains);
        // What has jumped away has to jump back, or to come far nearer to the prediction than it was.
        let off = self.offset.abs();
        let back = off <= self.scale * max_second_difference(gains) || e.abs() <= RETURNED_FRACTION * off;
        let agrees = near && steady && alive && back;
        self.agreeing_for = if agrees { self.agreeing_for + h } else { 0.0 };
        if self.agreeing_for < CONSISTENT_TIME.max(2.0 * h) - ROUNDING {
            return EncoderCheck::Rejected;
        }
        self.rejected_for = 0.0;
        self.unchanged = Unchanged::since_now(predicted);
        EncoderCheck::Returned
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: f64 = 1e-3;
    /// Ten cycles.
    const INNOVATION_TIME: f64 = 0.0095;
    /// Cycles from the first contradiction to the last that it takes.
    const LATER: u32 = 9;
    const GAINS: JointGains = JointGains {
        bandwidth: 10.0,
        disturbance_bandwidth: 13.0,
        innovation_threshold: 4e-3,
        encoder: true,
        resolution: 4e-4,
        jump: 7.5e-3,
        implied: 0.016,
        reference_travel: 0.06,
        dead_band: 0.15,
        tracking_error: 0.5,
    };
    /// A joint at 0.3 rad/s that follows its reference.
    const MOVING: JointPrediction<'_> = JointPrediction {
        angle: 0.5,
        speed: 0.3,
        disturbance: -1.0,
        torque: -1.0,
        reference: 0.5,
        reference_speed: 0.3,
        gains: &GAINS,
        stiffness: 200.0,
        winches_move: true,
    };

    /// A monitor that has accepted `MOVING` once.
    fn started() -> JointMonitor {
        let mut monitor = JointMonitor::new(1.0, INNOVATION_TIME);
        assert_eq!(monitor.update(H, 0.5, &MOVING), EncoderCheck::Accepted);
        monitor
    }

    #[test]
    fn a_false_zero_is_never_accepted_however_long_it_lasts() {
        let mut monitor = started();
        for k in 1..1000 {
            // The prediction stays in 0.4 to 0.6 rad.
            let angle = 0.5 + 0.1 * libm::sin(3.0 * H * f64::from(k));
            let check = monitor.update(H, 0.0, &JointPrediction { angle, ..MOVING });
            assert!(
                matches!(check, EncoderCheck::Rejected | EncoderCheck::Withdrawn { .. }),
                "{k} {check:?}"
            );
        }
        assert!((monitor.rejected_for - 0.999).abs() < 1e-9);
    }

    #[test]
    fn a_jump_that_a_break_away_could_reach_only_in_several_cycles_is_rejected() {
        let gains = JointGains { jump: 0.2, ..GAINS };
        let light = JointPrediction { gains: &gains, ..MOVING };
        let after = |samples: [f64; 3]| {
            let mut monitor = started();
            samples.map(|y| monitor.update(H, y, &light) == EncoderCheck::Accepted)
        };
        assert_eq!(after([0.4, 0.4, 0.4]), [false; 3]);
        assert_eq!(after([0.46, 0.39, 0.35]), [true; 3]);
        assert_eq!(after([0.46, 0.39, 0.28]), [true, true, false]);
    }

    #[test]
    fn a_return_takes_consecutive_samples_that_agree_with_the_prediction_and_with_each_other() {
        let near = GAINS.jump;
        let after = |samples: &[f64]| {
            let mut monitor = started();
            assert!(matches!(monitor.update(H, f64::NAN, &MOVING), EncoderCheck::Withdrawn { .. }));
            samples.iter().map(|y| monitor.update(H, *y, &MOVING)).collect::<alloc::vec::Vec<_>>()
        };
        let smooth = [0.5, 0.5003, 0.5006, 0.5009, 0.5012];
        assert_eq!(
            after(&smooth)[2..],
            [EncoderCheck::Rejected, EncoderCheck::Rejected, EncoderCheck::Returned]
        );
        // One sample off, however little, starts the count anew; so does one beyond the tolerance.
        let off = [0.5, 0.5003, 0.5036, 0.5039, 0.5042];
        let far = smooth.map(|y| y + 1.2 * near);
        for samples in [off, far, [0.0; 5], [f64::NAN; 5]] {
            assert!(after(&samples).iter().all(|check| *check == EncoderCheck::Rejected), "{samples:?}");
        }
    }

    #[test]
    fn an_unchanged_output_is_rejected_only_where_muscles_and_reference_imply_motion_in_one_direction() {
        let until_rejected = |change: f64, reference_speed: f64| {
            let mut monitor = following(1.0, 1.0, &GAINS);
            (1..190).find_map(|k| {
                let torque = -1.0 + change * f64::from(k);
                let predicted = JointPrediction { torque, disturbance: torque, reference_speed, ..MOVING };
                match monitor.update(H, 0.5003, &predicted) {
                    EncoderCheck::Withdrawn { shift, disturbance } => Some((k, shift, disturbance)),
                    _ => None,
                }
            })
        };
        // tau_d falls by k x: the muscles imply +0.5 mrad per cycle, the reference +0.3.
        let (cycles, shift, disturbance) = until_rejected(-0.1, 0.3).unwrap();
        assert!((30 + LATER..36 + LATER).contains(&cycles) && (disturbance + 1.0).abs() < 1e-12, "{cycles}");
        assert!((shift - 3e-4 * f64::from(cycles)).abs() < 1e-9, "{shift}");
        // At rest, against the reference, and without a residual nothing is rejected before x_r,max.
        assert_eq!(until_rejected(-0.1, 0.0), None);
        assert_eq!(until_rejected(0.1, 0.3), None);
        assert_eq!(until_rejected(0.0, 0.3), None);
        // Without a residual, x_r,max is the limit.
        assert!(until_rejected(0.0, 0.4).is_some());
    }

    /// Whether one cycle that moves by `step`, in rad, is accepted.
    fn accepts_step(step: f64, gains: JointGains) -> bool {
        let mut monitor = started();
        let predicted = JointPrediction { gains: &gains, ..MOVING };
        monitor.update(H, 0.5 + step, &predicted) == EncoderCheck::Accepted
    }

    #[test]
    fn a_second_difference_may_be_ten_counts_or_a_quarter_of_a_jump_whichever_is_larger() {
        for side in [1.0, -1.0] {
            // 4 mrad by the counts, 2.5 mrad by the jump.
            let gains = JointGains { jump: 0.01, ..GAINS };
            assert!(accepts_step(3.9e-3 * side, gains) && !accepts_step(4.1e-3 * side, gains));
            // 4 mrad by the counts, 15 mrad by the jump.
            let gains = JointGains { jump: 0.06, ..GAINS };
            assert!(accepts_step(14.9e-3 * side, gains) && !accepts_step(15.1e-3 * side, gains));
            // A jump of less than ten counts is itself the limit.
            let gains = JointGains { jump: 3e-3, ..GAINS };
            assert!(accepts_step(2.9e-3 * side, gains) && !accepts_step(3.1e-3 * side, gains));
        }
    }

    /// Outcomes of samples after an encoder gave nothing for a number of cycles, while the joint is predicted
    /// to stand at 0.5 rad.
    fn after_loss(lost_cycles: u32, gains: JointGains, samples: &[f64]) -> alloc::vec::Vec<EncoderCheck> {
        let standing = JointPrediction { speed: 0.0, reference_speed: 0.0, gains: &gains, ..MOVING };
        let mut monitor = started();
        (0..lost_cycles).for_each(|_| {
            monitor.update(H, f64::NAN, &standing);
        });
        samples.iter().map(|y| monitor.update(H, *y, &standing)).collect()
    }

    /// A living output about an angle: samples that differ by a count. The first follows no number, and does
    /// not agree.
    fn living(angle: f64) -> [f64; 5] {
        core::array::from_fn(|k| angle + if k % 2 == 0 { 0.0 } else { GAINS.resolution })
    }

    fn returns(checks: &[EncoderCheck]) -> bool {
        checks.last() == Some(&EncoderCheck::Returned)
    }

    #[test]
    fn the_error_allowed_at_a_return_grows_with_the_time_of_the_loss() {
        // 0.15 s: the prediction is off by a jump; with the loss itself, two are allowed.
        for side in [1.0, -1.0] {
            let after = |fraction: f64| after_loss(150, GAINS, &living(0.5 + side * fraction * GAINS.jump));
            assert!(returns(&after(1.9)) && !returns(&after(2.15)));
            let after = |fraction: f64| after_loss(15, GAINS, &living(0.5 + side * fraction * GAINS.jump));
            assert!(returns(&after(1.0)) && !returns(&after(1.25)));
        }
    }

    #[test]
    fn an_output_that_has_changed_since_its_loss_may_return_within_a_jump() {
        // 25 counts are 10 mrad.
        let gains = JointGains { jump: 0.2, ..GAINS };
        for lost_cycles in [1, 2] {
            assert!(returns(&after_loss(lost_cycles, gains, &living(0.65))), "{lost_cycles}");
        }
        // Still the output that was rejected: within 25 counts it may be accepted, beyond it is the false
        // one.
        let standing = JointPrediction { speed: 0.0, reference_speed: 0.0, gains: &gains, ..MOVING };
        for (angle, accepted) in [(0.509, true), (0.53, false)] {
            let mut monitor = started();
            assert!(matches!(monitor.update(H, 0.8, &standing), EncoderCheck::Withdrawn { .. }));
            let predicted = JointPrediction { angle: 0.8 - (angle - 0.5), ..standing };
            let last =
                (0..5).map(|_| monitor.update(H, 0.8, &predicted)).find(|c| *c == EncoderCheck::Returned);
            assert_eq!(last.is_some(), accepted, "{angle}");
        }
    }

    #[test]
    fn samples_of_a_return_differ_as_the_speed_says_within_two_counts_and_an_eighth_of_a_jump() {
        // 2 D + x_j/8 = 1.74 mrad, about 3 mrad per cycle.
        for side in [1.0, -1.0] {
            let speed = 3.0 * side;
            let returned = |off: f64| {
                let mut monitor = started();
                monitor.update(H, f64::NAN, &MOVING);
                let mut last = EncoderCheck::Rejected;
                for k in 0..5 {
                    let angle = 0.5 + speed * H * f64::from(k);
                    let predicted = JointPrediction { angle, speed, reference_speed: speed, ..MOVING };
                    last = monitor.update(H, angle + off * f64::from(k), &predicted);
                }
                last == EncoderCheck::Returned
            };
            for off in [1.0, -1.0] {
                assert!(returned(0.0) && returned(1.6e-3 * off) && !returned(1.9e-3 * off), "{side} {off}");
            }
        }
    }

    #[test]
    fn a_stuck_encoder_returns_from_as_far_as_the_reference_has_gone_meanwhile() {
        let gains = JointGains { reference_travel: 0.03015, dead_band: 0.0, ..GAINS };
        let mut stuck = started();
        let moving = JointPrediction { gains: &gains, ..MOVING };
        // 0.3 mrad per cycle against 30.15 mrad.
        let rejected =
            (1..200).find(|_| matches!(stuck.update(H, 0.5, &moving), EncoderCheck::Withdrawn { .. }));
        assert_eq!(rejected, Some(102));
        let standing = JointPrediction { speed: 0.0, reference_speed: 0.0, gains: &gains, ..MOVING };
        for side in [1.0, -1.0] {
            // 30.3 mrad, and a jump that has grown by less than a tenth.
            for (off, expected) in [(0.036, true), (0.040, false)] {
                let mut monitor = stuck;
                let checks = living(0.5 + side * off).map(|y| monitor.update(H, y, &standing));
                assert_eq!(returns(&checks), expected, "{off} {checks:?}");
            }
        }
    }

    /// A monitor of a joint that has followed its reference over 60 mrad to 0.5003 rad, since it turned.
    fn following(scale: f64, side: f64, gains: &JointGains) -> JointMonitor {
        let mut monitor = JointMonitor::new(scale, INNOVATION_TIME);
        for k in 0..=200 {
            let angle = 0.5003 + side * 3e-4 * (f64::from(k) - 200.0);
            let predicted = JointPrediction { angle, reference_speed: 0.3 * side, gains, ..MOVING };
            assert_eq!(monitor.update(H, angle, &predicted), EncoderCheck::Accepted, "{k}");
        }
        monitor
    }

    /// Cycles until an output that stands at 0.5 rad is rejected; in cycle `k` the joint is predicted at an
    /// angle under a torque of the disturbances, while the reference moves.
    fn rejected_after(
        reference_speed: f64,
        gains: JointGains,
        state: impl Fn(f64) -> [f64; 2],
    ) -> Option<(u32, EncoderCheck)> {
        let mut monitor = following(1.0, reference_speed.signum(), &gains);
        (1..1000).find_map(|k| {
            let [angle, torque] = state(f64::from(k));
            let predicted = JointPrediction { angle, torque, reference_speed, gains: &gains, ..MOVING };
            let check = monitor.update(H, 0.5003, &predicted);
            matches!(check, EncoderCheck::Withdrawn { .. }).then_some((k, check))
        })
    }

    #[test]
    fn the_estimate_that_moves_away_counts_as_motion_by_the_muscles_in_either_direction() {
        for side in [1.0, -1.0] {
            // 0.49 mrad per cycle by the estimate against x_max = 16 mrad, 0.301 by the reference.
            let (cycles, check) =
                rejected_after(0.301 * side, GAINS, |k| [0.5003 + 4.9e-4 * side * k, -1.0]).unwrap();
            assert_eq!(cycles, 33 + LATER);
            let EncoderCheck::Withdrawn { shift, .. } = check else { unreachable!() };
            assert!(
                (shift - side * 3.01e-4 * f64::from(33 + LATER)).abs() < 1e-12,
                "the smaller of both: {shift}"
            );
            // Both fractions together: half by the estimate and half by a torque at 200 Nm/rad.
            let both = |k: f64| [0.5003 + 2.45e-4 * side * k, -1.0 - 0.049 * side * k];
            assert_eq!(rejected_after(0.301 * side, GAINS, both).unwrap().0, 33 + LATER);
            // They cancel where the torque says the opposite: only x_r,max is left, 60 mrad.
            let neither = |k: f64| [0.5003 + 2.45e-4 * side * k, -1.0 + 0.049 * side * k];
            assert_eq!(rejected_after(0.301 * side, GAINS, neither).unwrap().0, 200);
            // Against the reference, however strong, the muscles alone decide nothing.
            let against = |k: f64| [0.5003 - 5e-3 * side * k, -1.0];
            assert_eq!(rejected_after(0.301 * side, GAINS, against).unwrap().0, 200);
        }
    }

    #[test]
    fn in_a_large_dead_band_the_reference_has_to_go_most_of_the_way_of_the_muscles() {
        // x_max is 125 counts: 0.7 of it is 35 mrad.
        let gains = JointGains { implied: 0.05, reference_travel: 1.0, ..GAINS };
        let far = |_: f64| [0.6003, -1.0];
        let (cycles, _) = rejected_after(0.3, gains, far).unwrap();
        assert_eq!(cycles, 117 + LATER, "35 mrad at 0.3 mrad per cycle");
        // Of 50 counts, five suffice; of a light joint what the dead band hides, and five counts where there
        // is none.
        let small = JointGains { implied: 0.02, ..gains };
        let (cycles, _) = rejected_after(0.3, small, far).unwrap();
        assert_eq!(cycles, 7 + LATER, "2 mrad at 0.3 mrad per cycle");
        let light = JointGains { jump: 0.0125, ..small };
        for (dead_band, expected) in [(0.15, 42), (0.004, 17), (0.0, 7)] {
            let (cycles, _) = rejected_after(0.3, JointGains { dead_band, ..light }, far).unwrap();
            assert_eq!(cycles, expected + LATER, "12.5, 5 and 2 mrad at 0.3 mrad per cycle");
        }
        // Twice the tolerance is twice the way.
        let mut wide = following(2.0, 1.0, &gains);
        let predicted = JointPrediction { angle: 0.7, gains: &gains, ..MOVING };
        let cycles = (1..1000).find(|_| wide.update(H, 0.5003, &predicted) != EncoderCheck::Accepted);
        assert_eq!(cycles, Some(234 + LATER));
    }

    #[test]
    fn a_contradiction_that_ends_within_the_observers_time_is_that_of_a_joint_that_vibrates() {
        let gains = JointGains { reference_travel: 1.0, ..GAINS };
        let states_for = |cycles: u32, pause: u32| {
            let away = move |k: f64| [if k as u32 % (cycles + pause) < cycles { 0.6 } else { 0.5003 }, -1.0];
            rejected_after(0.3, gains, away).is_some()
        };
        assert!(!states_for(LATER, 1) && states_for(LATER + 1, 1));
    }

    #[test]
    fn a_joint_whose_reference_has_turned_may_stand_for_a_quarter_of_its_dead_band() {
        // Of 200 mrad: 50 mrad where it has turned, else 16; by the reference alone 250 mrad, else 80.
        let gains = JointGains { reference_travel: 0.08, dead_band: 0.2, ..GAINS };
        for side in [1.0, -1.0] {
            let rejected = |turned: bool, off: f64| {
                let mut monitor = following(1.0, if turned { -side } else { side }, &gains);
                let angle = 0.5003 + side * off;
                let predicted =
                    JointPrediction { angle, reference_speed: 0.3 * side, gains: &gains, ..MOVING };
                // Its reference goes 60 mrad.
                (1..200).any(|_| monitor.update(H, 0.5003, &predicted) != EncoderCheck::Accepted)
            };
            let alone = |turned: bool| {
                let mut monitor = following(1.0, if turned { -side } else { side }, &gains);
                let predicted =
                    JointPrediction { angle: 0.5003, reference_speed: 0.3 * side, gains: &gains, ..MOVING };
                (1..1000).find(|_| monitor.update(H, 0.5003, &predicted) != EncoderCheck::Accepted)
            };
            assert_eq!((alone(false), alone(true)), (Some(267), Some(834)), "{side}");
            assert!(!rejected(false, 0.015) && rejected(false, 0.017), "{side}");
            assert!(!rejected(true, 0.049) && rejected(true, 0.051), "{side}");
        }
    }

    #[test]
    fn a_restarted_monitor_judges_as_a_new_one_with_its_tolerance() {
        for scale in [1.0, 2.5] {
            let mut used = JointMonitor::new(scale, INNOVATION_TIME);
            for k in 0..50 {
                used.update(H, if k < 20 { 0.5 } else { 0.9 }, &MOVING);
            }
            assert!(used.rejected_for > 0.0);
            used.restart();
            let mut new = JointMonitor::new(scale, INNOVATION_TIME);
            for y in [0.9, 0.9, 0.512, 0.512, 0.5, 0.5003, 0.5006, 0.5009, 0.5012, f64::NAN] {
                assert_eq!(used.update(H, y, &MOVING), new.update(H, y, &MOVING), "{y}");
                assert!((used.rejected_for - new.rejected_for).abs() < 1e-18);
                assert_eq!(used.symptom(), new.symptom());
            }
        }
    }

    #[test]
    fn an_encoder_that_reads_the_same_from_the_start_is_compared_with_the_disturbance_the_arm_starts_with() {
        // Unknown at the first measurement; then -4 Nm, which are 20 mrad against x_max = 16 mrad.
        let gains = JointGains { dead_band: 0.0, ..GAINS };
        let unknown = JointPrediction { torque: 0.0, disturbance: 0.0, gains: &gains, ..MOVING };
        let known = JointPrediction { torque: -4.0, disturbance: -30.0, gains: &gains, ..MOVING };
        let mut monitor = JointMonitor::new(1.0, INNOVATION_TIME);
        assert_eq!(monitor.update(H, 0.5, &unknown), EncoderCheck::Accepted);
        for k in 1..200 {
            assert_eq!(monitor.update(H, 0.5, &known), EncoderCheck::Accepted, "{k}");
        }
        // Stuck in the end, it leaves the estimate with that disturbance.
        let last: alloc::vec::Vec<_> = (0..4).map(|_| monitor.update(H, 0.5, &known)).collect();
        let withdrawn = |check: &EncoderCheck| match check {
            EncoderCheck::Withdrawn { disturbance, .. } => Some(*disturbance),
            _ => None,
        };
        let disturbance = last.iter().find_map(withdrawn).unwrap();
        assert!((disturbance + 30.0).abs() < 1e-12, "{last:?}");
    }
}
