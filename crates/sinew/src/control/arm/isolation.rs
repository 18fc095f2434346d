use super::correction_history::CorrectionHistory;
use super::gains::{ArmGains, MuscleGains};
use super::open_loop::Copied;
use super::status::{Fault, Symptom};
use crate::machine::DEFAULT_PERIOD;
use crate::muscle::MuscleDynamics;
use alloc::vec;
use alloc::vec::Vec;

/// Tells which sensor of a drive is wrong: load cell, motor encoder or joint encoder.
///
/// ```text
/// r_k = T_k - F_k                      against an observer without load cells              cell + b,  encoder - K m
/// y_k = K_k (x_k - x_k,0)              the same, as the corrected observer has followed it
/// f_k = R_k.(tau_d - tau_d,0)/R_k.R_k  force that the anchor lacks                          cell - b e^-theta
/// lambda = -f_k/(T_o^ - F_o)           1: the far tension without the cell is right; 0: that with it
/// step of a cell    |dT| > 8 s + 0.3 F + K 0.1 mm  and  |T - T^| > h_f
/// noise of a cell   mean |d2T| > 9.8 s max(h/1 ms, 1) + 0.02 F  and  > 1.3 mean |dT|
/// alarm             |y| > h_s for 20 ms  or  |r| > 2.4 h_f for 50 ms;   k has the largest |y|/h_s
/// joint encoder j   the column K R_j explains three quarters of sum (y/h_s)^2, and more than k alone, for 0.1 s
/// load cell k       |T_o^ - F_o| > h_t      after  80 ms   and  lambda > 0.5
/// motor encoder k   |T_o^ - F_o| > 2.5 h_t  after 150 ms   and  lambda <= 0.25 for 0.1 s, no step of T within 2 s
/// else              after 0.3 s one of both: the cell is bridged; where f_k follows r_k for 0.1 s within 1.5 s it is the encoder
/// h_f = 4 s + 0.20 F_m + K (eps l + 0.05 mm + 1.5 e)
/// h_s = 1.6 (6 s + 0.12 F_m + K (2 eps l + 0.06 mm + 3 e))
/// h_t = max(2 s + 0.05 F_o + K 0.02 mm, 1.5 f~)
/// ```
///
/// | symbol | meaning                                                                     | unit   |
/// |--------|-----------------------------------------------------------------------------|--------|
/// | T, T^  | measured and estimated tension at the drive's outlet                          | N      |
/// | F, F_o | tensions at drive and anchor by the open-loop observers                       | N      |
/// | F_m    | the larger of `F` and the mean of both: errors of the stretch are those of the whole cable | N      |
/// | x      | travel by which the load cell has corrected the winch; `x_0` at the copy      | m      |
/// | K, s   | stiffness of the cable, noise of its load cell                                | N/m, N |
/// | R, tau_d | moment arms, torque of the disturbances; `tau_d,0` at the copy               | m, Nm  |
/// | l      | travel of the anchor since the copy, summed over joints without signs           | m      |
/// | eps    | error of the moment arms                                                       | 1      |
/// | e      | lag of the joints' observers at the anchor, forgotten in 0.3 s                 | m      |
/// | f~     | largest deviation of `f_k` from its mean over a second, forgotten in 15 s       | N      |
///
/// While the near end of a cable sticks, its far end does not move: cell and motor encoder cannot be told
/// apart, and the joint does not feel which of them is wrong. A load cell that is bridged is trusted again
/// once it has agreed with its observer for [`AGREEMENT`].
///
/// # Assumes
/// One fault at a time, of a machine as identified. An offset below `h_s`, about 15 N on a cable of 50 N, is
/// found as a step or not at all.
///
/// # Source
/// Structured residuals as in `chow1984`; thresholds from simulated machines without faults.
#[derive(Debug, Clone)]
pub(super) struct Isolation {
    muscles: Vec<Watched>,
    joints: usize,
    /// Whether a joint has an encoder: `[joints]`.
    encoders: Vec<bool>,
    alarm: Option<Alarm>,
    /// Time for which a joint's column has explained the alarm, s: `[joints]`.
    explained_for: Vec<f64>,
    /// Pose in which a cell was bridged: `[muscles x joints]`.
    poses: Vec<f64>,
    history: CorrectionHistory,
    /// `x - x_0` over the history, m: `[muscles]`, and its bounds, N.
    long: Vec<[f64; 2]>,
    /// Time for which a joint's column has explained them, s: `[joints]`; evaluations since the last one.
    long_for: Vec<f64>,
    turn: u32,
}

/// State of one muscle.
#[derive(Debug, Clone, Copy)]
struct Watched {
    noise: f64,
    stiffness: f64,
    arm_error: f64,
    /// Last two readings, N, newest first; NaN where there are none.
    readings: [f64; 2],
    /// Time since the reading made a step, s: of several noises and of more than a winch can do in a cycle.
    since_step: f64,
    /// Mean first and second difference of the readings, N.
    change: f64,
    roughness: f64,
    /// `F` and `F_m`, N.
    near: f64,
    load: f64,
    /// `h_f`, `h_s`, `h_t`, N.
    fast: f64,
    slow: f64,
    far: f64,
    /// `e`, m.
    lag: f64,
    /// `r`, filtered, and `T_o^ - F_o`, filtered, N.
    residual: f64,
    difference: f64,
    /// `y`, N.
    correction: f64,
    /// `f` without a reference, N, its mean and its largest deviation.
    force: f64,
    mean_force: f64,
    force_deviation: f64,
    /// `f` when a tension began to be missing or a cell was bridged, N.
    force_before: f64,
    slow_for: f64,
    fast_for: f64,
    bridge: Option<Bridge>,
    /// How often it has been bridged.
    bridges: u32,
}

/// A load cell that is not used.
#[derive(Debug, Clone, Copy)]
struct Bridge {
    symptom: Symptom,
    /// Whether the motor encoder may be wrong instead.
    undecided: bool,
    /// Time since it began, and for which the cell has agreed with its observer, s.
    age: f64,
    agreed_for: f64,
}

impl Bridge {
    /// Time for which the cell has to agree, s: longer each time that it has turned out to be false after
    /// all.
    fn agreement(&self, times: u32) -> f64 {
        let once = match self.symptom {
            Symptom::Lost => return SHORT_AGREEMENT,
            Symptom::Jumped => AGREEMENT,
            _ => LONG_AGREEMENT,
        };
        once * f64::from(1_u32 << times.min(6).saturating_sub(1))
    }
}

/// An alarm of one muscle that is not yet decided.
#[derive(Debug, Clone, Copy)]
struct Alarm {
    muscle: usize,
    age: f64,
    /// Time for which the far tension with the cell has been right, s.
    encoder_for: f64,
    /// Whether its cell is bridged on trial.
    on_trial: bool,
}

/// What an evaluation finds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Finding {
    Nothing,
    /// The load cell of a muscle has become untrustworthy: its observer takes the state of its copy.
    Bridge(usize),
    /// The machine stops.
    Stop(Fault),
}

/// What is compared.
#[derive(Debug)]
pub(super) struct Seen<'a> {
    pub(super) body: &'a MuscleDynamics,
    /// Readings of the load cells, N.
    pub(super) tension: &'a [f64],
    /// Corrected estimates at drives and anchors, N.
    pub(super) tension_in: &'a [f64],
    pub(super) tension_out: &'a [f64],
    pub(super) unexplained: &'a [f64],
    /// Whether the profile of a cable is known.
    pub(super) known: &'a [bool],
    pub(super) pose: &'a [f64],
    pub(super) joint_innovation: &'a [f64],
    pub(super) disturbance_torque: &'a [f64],
    pub(super) copy: Option<&'a Copied>,
}

/// s: time of agreement after which a bridged load cell is used again.
const AGREEMENT: f64 = 0.06;
/// s: the same of a cell that had been silent.
const SHORT_AGREEMENT: f64 = 3e-3;
/// s: the same of a cell that had deviated little by little.
const LONG_AGREEMENT: f64 = 0.6;
/// Fraction of `h_f` within which it agrees.
const AGREEING: f64 = 0.7;
/// Factor of the bounds of lasting deviations over what machines without faults reach.
const MARGIN_OF_BOUNDS: f64 = 1.6;
/// Fraction of its bound from which on a correction makes a load cell suspect.
const SUSPECTED: f64 = 0.3;
/// s: time for which a step of a reading speaks against its load cell.
const STEP_MEMORY: f64 = 2.0;
/// s: persistence of `y` and of `r` until an alarm.
const SLOW_PERSISTENCE: f64 = 0.02;
const FAST_PERSISTENCE: f64 = 0.05;
/// s: filters of `r` and of `T_o^ - F_o`.
const RESIDUAL_FILTER: f64 = 0.02;
const DIFFERENCE_FILTER: f64 = 0.06;
/// s: times in which lag and deviations of the force are forgotten, and over which its mean is taken.
const LAG_MEMORY: f64 = 0.3;
const DEVIATION_MEMORY: f64 = 15.0;
const MEAN_TIME: f64 = 1.0;
/// s: from an alarm to a load cell, to a motor encoder, to a trial, and to its end.
const CELL_AFTER: f64 = 0.08;
const ENCODER_AFTER: f64 = 0.15;
const TRIAL_AFTER: f64 = 0.3;
const TRIAL_ENDS: f64 = 1.8;
/// s: time for which a joint's column has to explain an alarm.
const EXPLAINED_FOR: f64 = 0.1;
/// Fraction of the residuals that it explains, and by how much more than one drive does.
const EXPLAINED: f64 = 0.75;
const MARGIN: f64 = 0.05;
/// Fraction from which a joint may be the reason as well as a drive: of two muscles alike, one alone gives a
/// half.
const EXPLAINED_AS_WELL: f64 = 0.6;
/// `lambda` of a motor encoder, and how long it has to last, s.
const ENCODER_EXPLAINED: f64 = 0.25;
const ENCODER_FOR: f64 = 0.1;
/// Evaluations for one of the history; the same for it, s.
const LONG_TURNS: u32 = 8;
const LONG_EXPLAINED_FOR: f64 = 0.5;
const LONG_EXPLAINED: f64 = 0.85;
/// s: filter of the roughness, and the least number of readings in it: two of them see a single step.
const ROUGHNESS_FILTER: f64 = 0.05;
const ROUGHNESS_READINGS: f64 = 16.0;
/// Mean magnitude of the second difference of white noise of unit deviation: `sqrt(6) sqrt(2/pi)`.
const SECOND_DIFFERENCE: f64 = 1.954_41;
/// Growth of the noise that is a fault at a millisecond. In longer cycles winches move further for one count
/// of an encoder, and light joints vibrate at half the sampling frequency.
const NOISE_GROWTH: f64 = 5.0;
/// Ratio of the second to the first difference above which it is white noise, 1.73 for such noise alone,
/// rather than a cable that vibrates.
const WHITE_RATIO: f64 = 1.3;
/// Fraction of the tension that is no noise.
const ROUGH_FRACTION: f64 = 0.02;
/// Least squared moment arm by which a force is told, m^2.
const MIN_ARM: f64 = 1e-10;

impl Isolation {
    /// With the stiffness of every cable, N/m.
    pub(super) fn new(cable_stiffness: &[f64], gains: &ArmGains) -> Self {
        let joints = gains.joints.len();
        let watched = |(stiffness, gains): (&f64, &MuscleGains)| Watched::new(*stiffness, gains);
        let muscles: Vec<Watched> = cable_stiffness.iter().zip(&gains.muscles).map(watched).collect();
        Self {
            poses: vec![0.0; muscles.len() * joints],
            history: CorrectionHistory::new(muscles.len(), joints),
            long: vec![[0.0; 2]; muscles.len()],
            long_for: vec![0.0; joints],
            turn: 0,
            muscles,
            joints,
            encoders: gains.joints.iter().map(|joint| joint.encoder).collect(),
            alarm: None,
            explained_for: vec![0.0; joints],
        }
    }

    /// Nothing has been seen.
    pub(super) fn restart(&mut self) {
        self.muscles.iter_mut().for_each(Watched::restart);
        self.explained_for.fill(0.0);
        self.long_for.fill(0.0);
        self.history.forget();
        self.alarm = None;
    }

    /// Whether copies of the observers may be made: what is compared holds no fault.
    pub(super) fn is_quiet(&self) -> bool {
        self.alarm.is_none()
    }

    /// The fault of a load cell that is bridged.
    pub(super) fn bridged(&self, muscle: usize) -> Option<(Fault, Symptom)> {
        let bridge = self.muscles[muscle].bridge?;
        let fault =
            if bridge.undecided { Fault::TensionOrMotorSensor(muscle) } else { Fault::TensionSensor(muscle) };
        Some((fault, bridge.symptom))
    }

    /// Whether a load cell is bridged.
    pub(super) fn is_bridged(&self, muscle: usize) -> bool {
        self.muscles[muscle].bridge.is_some()
    }

    /// Whether a load cell has been bridged for longer than some time, s.
    pub(super) fn is_bridged_since(&self, muscle: usize, time: f64) -> bool {
        self.muscles[muscle].bridge.is_some_and(|bridge| bridge.age > time)
    }

    /// The minimum tension that a cable may have, N: by its load cell, less what the cell has pulled its
    /// estimate up by since half a minute ago, and without the cell where it has begun to deviate. A drive
    /// does not pay out a cable that is slack, whatever its load cell reads.
    pub(super) fn min_tension(&self, muscle: usize, measured: f64) -> f64 {
        let watched = &self.muscles[muscle];
        let [correction, bound] = self.long[muscle];
        let added = if correction > SUSPECTED * bound { correction } else { 0.0 };
        let minimum = measured - added;
        if watched.ratio() > SUSPECTED { minimum.min(watched.near) } else { minimum }
    }

    /// The sensors that explain a limit that has been passed: those that are under trial; of a slack cable
    /// those of its drive, where its load cell has moved its estimate down since half a minute ago.
    pub(super) fn cause_of(&self, found: Fault) -> Option<Fault> {
        let on_trial = self.muscles.iter().position(|watched| watched.bridge.is_some_and(|b| b.undecided));
        let muscle = match found {
            Fault::Slack(k) => on_trial.or(self.is_drawn_down(k).then_some(k)),
            Fault::Overload(_)
            | Fault::TensionRate(_)
            | Fault::JointRange(_)
            | Fault::TrackingError(_)
            | Fault::Drive(_)
            | Fault::Cable(_) => on_trial,
            _ => None,
        };
        muscle.map(Fault::TensionOrMotorSensor)
    }

    fn is_drawn_down(&self, muscle: usize) -> bool {
        let [correction, bound] = self.long[muscle];
        correction < -SUSPECTED * bound
    }

    /// The tension of a cable begins to be missing.
    pub(super) fn begin_missing(&mut self, muscle: usize) {
        self.muscles[muscle].force_before = self.muscles[muscle].force;
    }

    /// Whether the joint lacks a fraction of the force that the cable of a muscle had at its anchor, N,
    /// before its tension was missing. What a muscle without a moment arm does is not known: its force is
    /// taken as lacking.
    pub(super) fn force_is_lacking(&self, muscle: usize, fraction: f64, tension_out: f64) -> bool {
        let watched = &self.muscles[muscle];
        let lacking = watched.force_before - watched.force;
        lacking.is_nan() || lacking > fraction * tension_out
    }

    /// A reading of a load cell, `h` s after the one before, with its estimate, N: whether it is used.
    /// `agrees` is false for a reading that another check refuses; `pose` is that of the joints.
    pub(super) fn check(&mut self, k: usize, h: f64, measured: f64, estimated: f64, pose: &[f64]) -> bool {
        let watched = &mut self.muscles[k];
        let innovation = measured - estimated;
        let change = measured - watched.readings[0];
        let rough = watched.follow_roughness(h, measured);
        let step = 6.0 * watched.noise + 0.1 * estimated + watched.stiffness * 4e-4;
        watched.since_step = if change.abs() > step { 0.0 } else { watched.since_step + h };
        if let Some(bridge) = &mut watched.bridge {
            bridge.age += h;
            let agrees = innovation.abs() < (AGREEING * watched.fast).min(0.5 * watched.slow) && !rough;
            bridge.agreed_for = if agrees { bridge.agreed_for + h } else { 0.0 };
            let on_trial = self.alarm.is_some_and(|alarm| alarm.muscle == k && alarm.on_trial);
            if bridge.agreed_for > bridge.agreement(watched.bridges) && !on_trial {
                watched.bridge = None;
                self.history.forget();
            }
        } else if innovation.abs() > watched.fast && watched.has_stepped(change, estimated) {
            self.begin_bridge(k, Symptom::of_reading(measured, false), pose);
        } else if rough {
            self.begin_bridge(k, Symptom::Noisy, pose);
        }
        self.muscles[k].bridge.is_none()
    }

    /// The load cell is not used from now on.
    pub(super) fn begin_bridge(&mut self, k: usize, symptom: Symptom, pose: &[f64]) {
        let n = self.joints;
        self.history.forget();
        self.poses[k * n..(k + 1) * n].copy_from_slice(pose);
        let watched = &mut self.muscles[k];
        watched.force_before = watched.force;
        watched.bridges = watched.bridges.saturating_add(1);
        watched.bridge = Some(Bridge { symptom, undecided: false, age: 0.0, agreed_for: 0.0 });
    }

    /// Evaluates all residuals, `dt` s after the last time.
    pub(super) fn evaluate(&mut self, dt: f64, seen: &Seen<'_>) -> Finding {
        let quiet = self.is_quiet();
        for k in 0..self.muscles.len() {
            let pose = &self.poses[k * self.joints..(k + 1) * self.joints];
            self.muscles[k].follow(dt, k, seen, pose, quiet);
        }
        self.history.follow(dt, seen.unexplained, seen.pose);
        self.turn = (self.turn + 1) % LONG_TURNS;
        if quiet
            && self.turn == 0
            && let Some(joint) = self.slipping_joint(dt * f64::from(LONG_TURNS), seen)
        {
            return Finding::Stop(Fault::JointSensor(joint));
        }
        let Some(copy) = seen.copy else { return Finding::Nothing };
        match self.alarm {
            None => self.raise(seen),
            Some(alarm) => self.decide(dt, alarm, seen, copy),
        }
    }

    /// Whether a muscle's load cell is used and the encoders of all its joints tell where its anchor is.
    fn is_compared(&self, muscle: usize, body: &MuscleDynamics) -> bool {
        let watched = &self.muscles[muscle];
        let used = watched.bridge.is_none() && watched.readings[0].is_finite();
        used && body.crossings(muscle).all(|(joint, _)| self.encoders[joint])
    }

    fn raise(&mut self, seen: &Seen<'_>) -> Finding {
        let free = |k: usize| self.is_compared(k, seen.body) && seen.known[k];
        let raised = (0..self.muscles.len()).any(|k| free(k) && self.muscles[k].is_beyond());
        if raised {
            let most = (0..self.muscles.len())
                .filter(|k| free(*k))
                .max_by(|a, b| self.muscles[*a].ratio().total_cmp(&self.muscles[*b].ratio()));
            self.alarm = most.map(|muscle| Alarm { muscle, age: 0.0, encoder_for: 0.0, on_trial: false });
            self.explained_for.fill(0.0);
        }
        Finding::Nothing
    }

    fn decide(&mut self, dt: f64, mut alarm: Alarm, seen: &Seen<'_>, copy: &Copied) -> Finding {
        alarm.age += dt;
        let k = alarm.muscle;
        if let Some(joint) = self.explaining_joint(dt, seen) {
            self.alarm = None;
            let fault = if alarm.on_trial { Fault::MotorOrJointSensor(k) } else { Fault::JointSensor(joint) };
            return Finding::Stop(fault);
        }
        let watched = &self.muscles[k];
        let force = force_between(seen.body, k, seen.disturbance_torque, &copy.disturbance_torque);
        let (difference, far) = (watched.difference, watched.far);
        let explained = -force / difference;
        let cell = explained.is_nan() || explained > 0.5;
        // The force follows the difference with the lag of the joints' observers.
        let stepped = watched.since_step < STEP_MEMORY;
        let encoder = difference.abs() > 2.5 * far && explained <= ENCODER_EXPLAINED && !stepped;
        if !alarm.on_trial {
            alarm.encoder_for = if encoder { alarm.encoder_for + dt } else { 0.0 };
        }
        self.alarm = Some(alarm);
        if alarm.on_trial {
            return self.end_trial(dt, alarm, force, copy);
        }
        if difference.abs() > far && alarm.age > CELL_AFTER && cell {
            self.alarm = None;
            self.begin_bridge(k, Symptom::Deviating, seen.pose);
            return Finding::Bridge(k);
        }
        if alarm.encoder_for > ENCODER_FOR && alarm.age > ENCODER_AFTER {
            self.alarm = None;
            return Finding::Stop(self.encoder_of(k, seen.body));
        }
        if alarm.age > TRIAL_AFTER && !encoder {
            // What was a short deviation has gone.
            if !self.muscles[k].is_deviating() {
                self.alarm = None;
                return Finding::Nothing;
            }
            self.alarm = Some(Alarm { on_trial: true, encoder_for: 0.0, ..alarm });
            self.begin_bridge(k, Symptom::Deviating, seen.pose);
            if let Some(bridge) = &mut self.muscles[k].bridge {
                bridge.undecided = true;
            }
            return Finding::Bridge(k);
        }
        Finding::Nothing
    }

    /// A cell that is bridged on trial: the anchor's force tells whether the motor encoder is wrong instead.
    fn end_trial(&mut self, dt: f64, mut alarm: Alarm, force: f64, copy: &Copied) -> Finding {
        let k = alarm.muscle;
        let watched = &mut self.muscles[k];
        let fraction = copy.tension_out[k] / copy.tension_in[k].max(watched.noise).max(1e-9);
        let follows = watched.since_step > STEP_MEMORY
            && force * watched.residual > 0.0
            && force.abs() > watched.far
            && force.abs() > 0.5 * watched.residual.abs() * fraction;
        let agreed = watched.bridge.is_some_and(|bridge| bridge.agreed_for > LONG_AGREEMENT);
        alarm.encoder_for = if follows { alarm.encoder_for + dt } else { 0.0 };
        self.alarm = Some(alarm);
        if alarm.encoder_for > ENCODER_FOR {
            self.alarm = None;
            return Finding::Stop(Fault::MotorSensor(k));
        }
        // What the joint has not told by then stays a group, until the cell agrees again.
        if alarm.age > TRIAL_ENDS || agreed {
            self.alarm = None;
        }
        Finding::Nothing
    }

    /// The joint whose encoder explains the corrections of all muscles better than one drive does, for long
    /// enough.
    fn explaining_joint(&mut self, dt: f64, seen: &Seen<'_>) -> Option<usize> {
        let mut found = None;
        for joint in 0..self.joints {
            let explains = self.column_explains(joint, seen.body, EXPLAINED, |k| {
                (self.muscles[k].correction, self.muscles[k].slow)
            });
            self.explained_for[joint] = if explains { self.explained_for[joint] + dt } else { 0.0 };
            if self.explained_for[joint] > EXPLAINED_FOR {
                found = found.or(Some(joint));
            }
        }
        found
    }

    /// The same over half a minute, in which an encoder may slip slowly.
    fn slipping_joint(&mut self, dt: f64, seen: &Seen<'_>) -> Option<usize> {
        let (before, pose) = self.history.oldest()?;
        let mut total = 0.0;
        for (k, watched) in self.muscles.iter().enumerate() {
            let travel: f64 =
                seen.body.crossings(k).map(|(j, arm)| (arm * (seen.pose[j] - pose[j])).abs()).sum();
            let correction = watched.stiffness * (seen.unexplained[k] - before[k]);
            // Several muscles that agree need no margin.
            let bound = watched.slow_bound(2.0 * travel) / MARGIN_OF_BOUNDS;
            self.long[k] = [correction, bound];
            if self.is_compared(k, seen.body) && seen.known[k] {
                total += correction * correction / (bound * bound);
            }
        }
        let mut found = None;
        for joint in 0..self.joints {
            let explains = total > 1.0
                && self.column_explains(joint, seen.body, LONG_EXPLAINED, |k| {
                    let [correction, bound] = self.long[k];
                    (correction, bound)
                });
            self.long_for[joint] = if explains { self.long_for[joint] + dt } else { 0.0 };
            if self.long_for[joint] > LONG_EXPLAINED_FOR {
                found = found.or(Some(joint));
            }
        }
        found
    }

    /// The motor encoder of a muscle; together with the encoders of its joints where one of those explains
    /// the corrections as well.
    fn encoder_of(&self, muscle: usize, body: &MuscleDynamics) -> Fault {
        let joint = body.crossings(muscle).any(|(joint, _)| {
            let [explained, ..] =
                self.explanation(joint, body, |k| (self.muscles[k].correction, self.muscles[k].slow));
            explained > EXPLAINED_AS_WELL
        });
        if joint { Fault::MotorOrJointSensor(muscle) } else { Fault::MotorSensor(muscle) }
    }

    /// Whether an error of a joint's encoder, the column `K R_j`, explains a fraction of the corrections,
    /// each with its bound, N, and more than any drive alone does.
    fn column_explains(
        &self,
        joint: usize,
        body: &MuscleDynamics,
        fraction: f64,
        correction: impl Fn(usize) -> (f64, f64),
    ) -> bool {
        let [explained, alone, largest] = self.explanation(joint, body, correction);
        // One muscle alone does not tell its drive from a joint.
        largest < 1.0 - MARGIN && explained > fraction && explained > alone + MARGIN
    }

    /// Fraction of the corrections that the column `K R_j` explains, the most that one drive does, and the
    /// largest fraction of one muscle in the column.
    fn explanation(
        &self,
        joint: usize,
        body: &MuscleDynamics,
        correction: impl Fn(usize) -> (f64, f64),
    ) -> [f64; 3] {
        let (mut product, mut square, mut largest, mut total, mut alone) = (0.0, 0.0, 0.0_f64, 0.0, 0.0_f64);
        for (k, watched) in self.muscles.iter().enumerate().filter(|(k, _)| self.is_compared(*k, body)) {
            let arm = body.crossings(k).find(|(j, _)| *j == joint).map_or(0.0, |(_, arm)| arm);
            let (correction, bound) = correction(k);
            let (column, ratio) = (watched.stiffness * arm / bound, correction / bound);
            product += column * ratio;
            square += column * column;
            largest = largest.max(column * column);
            total += ratio * ratio;
            alone = alone.max(ratio * ratio);
        }
        // Below the bounds there is nothing but noise to explain.
        let explained = if total > 1.0 { product * product / (square * total) } else { 0.0 };
        [explained, alone / total, largest / square]
    }
}

/// `R_k.(tau - tau_0)/R_k.R_k`, N; NaN without a moment arm.
fn force_between(body: &MuscleDynamics, muscle: usize, torque: &[f64], before: &[f64]) -> f64 {
    let (mut product, mut square) = (0.0, 0.0);
    for (joint, arm) in body.crossings(muscle) {
        product += arm * (torque[joint] - before[joint]);
        square += arm * arm;
    }
    if square > MIN_ARM { product / square } else { f64::NAN }
}

impl Watched {
    fn new(stiffness: f64, gains: &MuscleGains) -> Self {
        Self::unseen(stiffness, gains.load_cell_noise, gains.moment_arm_error)
    }

    /// Before the first reading.
    fn unseen(stiffness: f64, noise: f64, arm_error: f64) -> Self {
        Self {
            noise,
            stiffness,
            arm_error,
            readings: [f64::NAN; 2],
            since_step: f64::INFINITY,
            change: 0.0,
            roughness: SECOND_DIFFERENCE * noise,
            near: 0.0,
            load: 0.0,
            fast: f64::INFINITY,
            slow: f64::INFINITY,
            far: f64::INFINITY,
            lag: 0.0,
            residual: 0.0,
            difference: 0.0,
            correction: 0.0,
            force: f64::NAN,
            mean_force: f64::NAN,
            force_deviation: 0.0,
            force_before: f64::NAN,
            slow_for: 0.0,
            fast_for: 0.0,
            bridge: None,
            bridges: 0,
        }
    }

    fn restart(&mut self) {
        *self = Self::unseen(self.stiffness, self.noise, self.arm_error);
    }

    /// Whether a change of the reading, N, is no cable's. A reading after a gap has no change: it has to
    /// agree with its estimate.
    fn has_stepped(&self, change: f64, estimated: f64) -> bool {
        let limit = 8.0 * self.noise + 0.3 * estimated + self.stiffness * 1e-4;
        change.abs() > limit || change.is_nan()
    }

    /// Follows the roughness of the readings; whether it is that of a cell whose noise has grown.
    fn follow_roughness(&mut self, h: f64, measured: f64) -> bool {
        let [last, before] = self.readings;
        self.readings = [measured, last];
        let second = (measured - 2.0 * last + before).abs();
        let growth = NOISE_GROWTH * (h / DEFAULT_PERIOD).max(1.0);
        let limit = SECOND_DIFFERENCE * growth * self.noise + ROUGH_FRACTION * self.near;
        // A single step is not noise.
        if second.is_finite() {
            let first = (measured - last).abs();
            let fraction = (h / ROUGHNESS_FILTER).min(1.0 / ROUGHNESS_READINGS);
            self.change += fraction * (first.min(4.0 * limit) - self.change);
            self.roughness += fraction * (second.min(4.0 * limit) - self.roughness);
        }
        self.roughness > limit && self.roughness > WHITE_RATIO * self.change
    }

    /// Residuals and bounds of muscle `k`; `bridged_in` is the pose in which its cell was bridged.
    fn follow(&mut self, dt: f64, k: usize, seen: &Seen<'_>, bridged_in: &[f64], quiet: bool) {
        let (near, far) = match (self.bridge, seen.copy) {
            (None, Some(copy)) => (copy.tension_in[k], copy.tension_out[k]),
            _ => (seen.tension_in[k], seen.tension_out[k]),
        };
        let from = match (self.bridge, seen.copy) {
            (Some(_), _) => bridged_in,
            (None, Some(copy)) => &copy.pose,
            (None, None) => seen.pose,
        };
        let (mut lag, mut travel, mut product, mut square) = (0.0, 0.0, 0.0, 0.0);
        for (joint, arm) in seen.body.crossings(k) {
            lag += (arm * seen.joint_innovation[joint]).abs();
            travel += (arm * (seen.pose[joint] - from[joint])).abs();
            product += arm * seen.disturbance_torque[joint];
            square += arm * arm;
        }
        self.lag = (self.lag * (1.0 - dt / LAG_MEMORY)).max(lag);
        self.force = if square > MIN_ARM { product / square } else { f64::NAN };
        if self.force.is_finite() {
            if self.mean_force.is_nan() {
                self.mean_force = self.force;
            }
            self.mean_force += dt / MEAN_TIME * (self.force - self.mean_force);
            if quiet && self.bridge.is_none() {
                let deviation = (self.force - self.mean_force).abs();
                self.force_deviation = (self.force_deviation * (1.0 - dt / DEVIATION_MEMORY)).max(deviation);
            }
        }
        (self.near, self.load) = (near, near.max(0.5 * (near + far)));
        let (s, stiffness, eps) = (self.noise, self.stiffness, self.arm_error);
        self.fast = 4.0 * s + 0.2 * self.load + stiffness * (eps * travel + 5e-5 + 1.5 * self.lag);
        self.slow = self.slow_bound(travel);
        self.far = (2.0 * s + 0.05 * far + stiffness * 2e-5).max(1.5 * self.force_deviation);
        let residual = seen.tension[k] - near;
        if residual.is_finite() && self.readings[0].is_finite() {
            self.residual += (dt / RESIDUAL_FILTER).min(1.0) * (residual - self.residual);
        }
        let (mut difference, mut correction) = (0.0, 0.0);
        if let (None, Some(copy)) = (self.bridge, seen.copy) {
            difference = seen.tension_out[k] - copy.tension_out[k];
            correction = stiffness * (seen.unexplained[k] - copy.unexplained[k]);
        }
        self.difference += (dt / DIFFERENCE_FILTER).min(1.0) * (difference - self.difference);
        self.correction = correction;
        let beyond = |for_s: f64, holds: bool| if holds { for_s + dt } else { 0.0 };
        self.slow_for = beyond(self.slow_for, self.correction.abs() > self.slow);
        self.fast_for = beyond(self.fast_for, self.residual.abs() > 1.5 * MARGIN_OF_BOUNDS * self.fast);
    }

    /// `h_s` after a travel of the anchor, m.
    fn slow_bound(&self, travel: f64) -> f64 {
        let geometry = 2.0 * self.arm_error * travel + 6e-5 + 3.0 * self.lag;
        MARGIN_OF_BOUNDS * (6.0 * self.noise + 0.12 * self.load + self.stiffness * geometry)
    }

    fn ratio(&self) -> f64 {
        self.correction.abs() / self.slow
    }

    /// Whether it has deviated for long enough.
    fn is_beyond(&self) -> bool {
        self.slow_for > SLOW_PERSISTENCE || self.fast_for > FAST_PERSISTENCE
    }

    /// Whether it deviates now.
    fn is_deviating(&self) -> bool {
        self.slow_for > 0.0 || self.fast_for > 0.0
    }
}

#[cfg(test)]
mod tests;
