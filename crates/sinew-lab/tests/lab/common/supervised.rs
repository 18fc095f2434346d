//! Campaigns of single faults on supervised machines: detection, safe stop, recovery.

use sinew::control::supervisor::{FaultKind, Mode, NamedFault, Request};
use sinew::machine::Machine;
use sinew::random::Random;
use sinew::trajectory::Trajectory;
use sinew::twin::arm::{ExchangeFailure, Failure, InjectedFault, Sensor, SensorFailure};
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{CalibratedArm, PreparedRun, TrackingTask};
use sinew_lab::experiment::TrackRow;
use sinew_lab::experiment::arm::TrackSession;
use sinew_session::{BusFault, Exchange};

/// Control cycle of the machines of this campaign, s.
const STEP: f64 = sinew::machine::DEFAULT_PERIOD;

/// Rest after the motion: time for a safe stop and for the recovery, s.
const AFTER: f64 = 90.0;
/// Rest before it, s.
const BEFORE: f64 = 3.0;
/// Time within which a fault is found or has no effect, s.
const OBSERVED: f64 = 8.0;
/// Time within which a machine is released or holds again, s.
const RECOVERY: f64 = 40.0;

/// Time in which the winches have come to rest after a stop, s.
const BRAKING: f64 = 0.25;
/// Time for which a load has to keep the tension above its limit, s: twice the time after which it is a
/// fault.
const OVERLOAD: f64 = 0.02;

/// Kinds of faults that are injected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Injection {
    CableBreak,
    SlackAfterBreak,
    Overload,
    Jam,
    NoPower,
    MotorLost,
    MotorStuck,
    MotorJump,
    JointLost,
    JointStuck,
    JointJump,
    LoadCellLost,
    LoadCellStuck,
    DriveReport,
    LostCycles,
    LateCycles,
    StaleCommand,
}

impl Injection {
    pub(crate) const ALL: [Self; 17] = [
        Self::CableBreak,
        Self::SlackAfterBreak,
        Self::Overload,
        Self::Jam,
        Self::NoPower,
        Self::MotorLost,
        Self::MotorStuck,
        Self::MotorJump,
        Self::JointLost,
        Self::JointStuck,
        Self::JointJump,
        Self::LoadCellLost,
        Self::LoadCellStuck,
        Self::DriveReport,
        Self::LostCycles,
        Self::LateCycles,
        Self::StaleCommand,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::CableBreak => "cable breaks",
            Self::SlackAfterBreak => "broken cable at the start: slack",
            Self::Overload => "load above the limit of tension",
            Self::Jam => "winch jams",
            Self::NoPower => "amplifier without power",
            Self::MotorLost => "motor encoder lost",
            Self::MotorStuck => "motor encoder stuck",
            Self::MotorJump => "motor encoder jumps",
            Self::JointLost => "joint encoder lost",
            Self::JointStuck => "joint encoder stuck",
            Self::JointJump => "joint encoder jumps",
            Self::LoadCellLost => "load cell lost",
            Self::LoadCellStuck => "load cell stuck",
            Self::DriveReport => "drive reports a fault",
            Self::LostCycles => "cycles lost for good",
            Self::LateCycles => "cycles late by half a period",
            Self::StaleCommand => "no new command",
        }
    }

    /// Names that are right.
    fn expected(self) -> &'static [FaultKind] {
        match self {
            Self::CableBreak | Self::SlackAfterBreak => &[FaultKind::CableBreak],
            // A load that moves the limb away before the tension is above its limit is an error of tracking.
            Self::Overload => &[FaultKind::Overload, FaultKind::TrackingError],
            Self::Jam => &[FaultKind::Jam],
            Self::NoPower => &[FaultKind::Jam, FaultKind::DriveFault],
            Self::MotorLost | Self::JointLost | Self::LoadCellLost => &[FaultKind::SensorLost],
            Self::MotorStuck | Self::JointStuck | Self::LoadCellStuck => &[FaultKind::SensorStuck],
            Self::MotorJump | Self::JointJump => &[FaultKind::EncoderJump],
            Self::DriveReport => &[FaultKind::DriveFault],
            Self::LostCycles => &[FaultKind::LostCycles],
            Self::LateCycles => &[FaultKind::LateCycles],
            Self::StaleCommand => &[FaultKind::StaleCommand],
        }
    }

    /// Whether the machine goes on.
    fn goes_on(self) -> bool {
        matches!(self, Self::LoadCellLost | Self::LoadCellStuck | Self::StaleCommand)
    }
}

/// A run with one fault.
#[derive(Debug, Clone)]
#[allow(dead_code, reason = "printed")]
pub(crate) struct Case {
    pub(crate) machine: String,
    pub(crate) seed: u64,
    pub(crate) injection: Injection,
    pub(crate) part: usize,
    pub(crate) start: f64,
    /// First report, s after the fault; the fault.
    pub(crate) reported: Option<(f64, NamedFault)>,
    /// Begin of the safe stop, s after the fault, and its fault.
    pub(crate) stopped: Option<(f64, NamedFault)>,
    /// From there to the mode `fault`, s.
    pub(crate) let_down: Option<f64>,
    /// Whether the name is right.
    pub(crate) named: bool,
    /// Largest true speed of a joint from [`BRAKING`] after the stop on, over the largest of the motion
    /// before.
    pub(crate) speed: f64,
    /// The same in rad/s or m/s.
    pub(crate) fall: f64,
    /// Largest tension at a drive over its limit.
    pub(crate) tension: f64,
    /// Whether it holds again after a reset, where it can.
    pub(crate) recovered: Option<bool>,
    /// Of a recovery with a broken cable: the fault that ended it.
    pub(crate) again: Option<FaultKind>,
}

/// What happened without a fault.
#[derive(Debug, Default, Clone)]
pub(crate) struct Healthy {
    pub(crate) seconds: f64,
    pub(crate) reports: Vec<String>,
    /// Mean error of the joints over the motion, with complete exchanges and with one in a thousand lost.
    pub(crate) errors: [f64; 2],
}

/// A machine as built with its motion.
pub(crate) struct Bench {
    pub(crate) arm: CalibratedArm,
    pub(crate) trajectory: Trajectory,
    seed: u64,
    pub(crate) repeats: u32,
}

impl Bench {
    pub(crate) fn new(machine: &Machine, trajectory: Trajectory, seed: u64) -> Self {
        // Twice the motion, so that it goes on after a fault: a sensor that sticks at rest shows nothing
        // false.
        Self { arm: CalibratedArm::new(machine, seed).unwrap(), trajectory, seed, repeats: 2 }
    }

    pub(crate) fn with_session<T>(
        &self,
        faults: &[InjectedFault],
        see: impl FnOnce(TrackSession<'_>) -> T,
    ) -> T {
        let task = TrackingTask {
            trajectory: &self.trajectory,
            repeats: self.repeats,
            learning: false,
            final_rest: AFTER,
            faults,
            gains: None,
            trace_interval: 1.0,
        };
        let prepared = PreparedRun::new(&self.arm, CompensationVariant::Observer, &task).unwrap();
        let run = prepared.run();
        see(TrackSession::supervised(&run, prepared.supervisor().unwrap()).unwrap())
    }

    /// Duration of the motion with the rest before, s.
    pub(crate) fn end(&self) -> f64 {
        BEFORE + self.trajectory.duration() * f64::from(self.repeats)
    }

    /// Single faults, `per_kind` of each, at random times while the machine is tracked; each branches off one
    /// run without a fault.
    pub(crate) fn faults(&self, per_kind: usize) -> (Vec<Case>, Healthy) {
        let mut random = Random::new(self.seed ^ 0x5afe);
        let robot = &self.arm.machine.robot;
        let muscles = self.arm.machine.muscles.len();
        let those = |count: usize, has: &dyn Fn(usize) -> bool| (0..count).filter(|k| has(*k)).collect();
        let all: Vec<usize> = those(muscles, &|_| true);
        let cells: Vec<usize> = those(muscles, &|k| self.arm.machine.muscles[k].drive.has_load_cell);
        let encoders = &self.arm.machine.encoders;
        let encoders: Vec<usize> = those(encoders.len(), &|k| encoders[k].is_some());
        let mut sampled: Vec<(f64, Injection, usize)> = Vec::new();
        for injection in Injection::ALL {
            for _ in 0..per_kind {
                let start = BEFORE + 0.5 + random.unit() * (self.end() - OBSERVED - BEFORE - 0.5);
                let of = match injection {
                    Injection::JointLost | Injection::JointStuck | Injection::JointJump => &encoders,
                    Injection::LoadCellLost | Injection::LoadCellStuck => &cells,
                    _ => &all,
                };
                if !of.is_empty() {
                    let part = of[(random.unit() * of.len() as f64) as usize % of.len()];
                    sampled.push(((start * 1e3).round() * 1e-3, injection, part));
                }
            }
        }
        sampled.sort_by(|a, b| a.0.total_cmp(&b.0));
        let name = robot.parts().name.clone();
        self.with_session(&[], |mut healthy| {
            let mut max_speed = 0.0_f64;
            let mut cases = Vec::new();
            // The largest tensions of the motion, for limits that a task sets.
            let mut peaks = vec![0.0_f64; muscles];
            let mut scout = healthy.clone();
            let mut result = Healthy { seconds: self.end(), ..Healthy::default() };
            while scout.time() < self.end() {
                scout
                    .step(|row| {
                        for (peak, cable) in peaks.iter_mut().zip(row.truth.cables) {
                            *peak = peak.max(cable.tension_in);
                        }
                        max_speed = row.truth.v.iter().fold(max_speed, |most, v| most.max(v.abs()));
                        if row.mode != Mode::Run || row.fault.is_some() {
                            result
                                .reports
                                .push(format!("{name} {}: {:.3} {:?}", self.seed, row.time, row.fault));
                        }
                    })
                    .unwrap();
            }
            result.errors[0] = mean_error(&scout);
            let mut lossy = healthy.clone();
            let mut lost = Random::new(self.seed ^ 0x105e);
            while lossy.time() < self.end() {
                let fault = (lost.unit() < 1e-3).then_some(BusFault::Lost);
                lossy.set_exchange(Some(Exchange { fault }));
                lossy
                    .step(|row| {
                        if row.mode != Mode::Run {
                            result.reports.push(format!(
                                "{name} {}: one in 1000 lost: {:.3} {:?}",
                                self.seed, row.time, row.fault
                            ));
                        }
                    })
                    .unwrap();
            }
            result.errors[1] = mean_error(&lossy);
            for (start, injection, part) in sampled {
                while healthy.time() < start - 0.5 * STEP {
                    healthy.step(|_| {}).unwrap();
                }
                let mut case = self.case(&healthy, (injection, part, start), &peaks);
                case.speed = case.fall / max_speed.max(1e-9);
                cases.push(case);
            }
            (cases, result)
        })
    }

    fn case(
        &self,
        healthy: &TrackSession<'_>,
        (injection, part, start): (Injection, usize, f64),
        peaks: &[f64],
    ) -> Case {
        let machine = &self.arm.machine;
        let name = machine.robot.parts().name.clone();
        let mut session = healthy.clone();
        let mut limits = session.supervisor().limits().clone();
        let failure = match injection {
            Injection::CableBreak | Injection::SlackAfterBreak => Failure::Cable(part),
            Injection::Overload => {
                limits.muscles[part].tension = 1.1 * peaks[part];
                self.overload(healthy, (part, start), peaks[part])
            }
            Injection::Jam => Failure::Winch(part),
            Injection::NoPower => Failure::Amplifier(part),
            Injection::MotorLost => Failure::Sensor(Sensor::Motor(part), SensorFailure::NotANumber),
            Injection::MotorStuck => Failure::Sensor(Sensor::Motor(part), SensorFailure::Stuck),
            Injection::MotorJump => Failure::Sensor(Sensor::Motor(part), SensorFailure::Offset(0.02)),
            Injection::JointLost => Failure::Sensor(Sensor::Joint(part), SensorFailure::NotANumber),
            Injection::JointStuck => Failure::Sensor(Sensor::Joint(part), SensorFailure::Stuck),
            Injection::JointJump => Failure::Sensor(Sensor::Joint(part), SensorFailure::Offset(0.3)),
            Injection::LoadCellLost => Failure::Sensor(Sensor::Tension(part), SensorFailure::NotANumber),
            Injection::LoadCellStuck => Failure::Sensor(Sensor::Tension(part), SensorFailure::Stuck),
            Injection::DriveReport => Failure::Amplifier(part),
            Injection::LostCycles => Failure::Exchange(ExchangeFailure::Lost),
            Injection::LateCycles => Failure::Exchange(ExchangeFailure::Late),
            Injection::StaleCommand => Failure::Exchange(ExchangeFailure::Stale),
        };
        let own = session.supervisor().limits().clone();
        let ratio: Vec<f64> = limits.muscles.iter().map(|limit| limit.tension).collect();
        session = session.with_limits(limits).unwrap();
        session = session.with_faults(&[InjectedFault { start, duration: f64::INFINITY, failure }]).unwrap();
        let mut case = Case {
            machine: name,
            seed: self.seed,
            injection,
            part,
            start,
            reported: None,
            stopped: None,
            let_down: None,
            named: false,
            speed: 0.0,
            fall: 0.0,
            tension: 0.0,
            recovered: None,
            again: None,
        };
        if injection == Injection::DriveReport {
            session.set_exchange(Some(Exchange { fault: Some(BusFault::Drive { muscle: part, code: 0 }) }));
        }
        let mut mode = Mode::Run;
        let until = start + OBSERVED;
        let mut end = until;
        let mut began = false;
        while session.time() < end && mode != Mode::Fault {
            // Loss for good ends when the drives have stopped: the readings come back.
            if injection == Injection::LostCycles && session.time() > start + 0.5 {
                session.set_exchange(Some(Exchange::default()));
            }
            let going = session
                .step(|row| {
                    // A load counts from the cycle on in which it raises the tension above its limit.
                    if injection == Injection::Overload && !began && case.reported.is_none() {
                        began = row.truth.cables[part].tension_in > ratio[part];
                        case.start = if began { row.time } else { start };
                    }
                    let since = row.time - case.start;
                    if let Some(fault) = row.fault {
                        case.reported = case.reported.or(Some((since, fault)));
                    }
                    if row.mode == Mode::SafeStop && case.stopped.is_none() {
                        case.stopped = row.fault.map(|fault| (since, fault));
                        end = row.time + RECOVERY;
                    }
                    if case.stopped.is_some_and(|(stopped, _)| since > stopped + BRAKING) {
                        case.fall = row.truth.v.iter().fold(case.fall, |most, v| most.max(v.abs()));
                    }
                    if row.mode == Mode::Fault {
                        case.let_down = case.stopped.map(|(stopped, _)| since - stopped);
                    }
                    case.tension = tension_over(row, &ratio).max(case.tension);
                    mode = row.mode;
                })
                .unwrap();
            if !going {
                break;
            }
        }
        let judged = case.stopped.or(case.reported).map(|(_, fault)| fault);
        let right_part = judged.is_some_and(|fault| {
            // An error of tracking is that of a joint, a load was aimed at a muscle.
            let of_joint = injection == Injection::Overload && fault.kind() == FaultKind::TrackingError;
            of_joint || fault.index().is_none_or(|index| index == part)
        });
        case.named = right_part && judged.is_some_and(|fault| injection.expected().contains(&fault.kind()));
        if injection.goes_on() {
            case.recovered = Some(mode != Mode::SafeStop && mode != Mode::Fault);
        } else if mode == Mode::Fault {
            let broken = matches!(injection, Injection::CableBreak | Injection::SlackAfterBreak);
            let session = session.with_limits(own).unwrap();
            case.recover(session, broken);
        }
        case
    }

    /// The smallest of some loads that raises the tension of a muscle, at its drive, above its limit of 1.1
    /// times the peak of the motion and keeps it there, or that ends the run by another fault before.
    fn overload(&self, healthy: &TrackSession<'_>, (muscle, start): (usize, f64), peak: f64) -> Failure {
        let machine = &self.arm.machine;
        let mut body = sinew::muscle::MuscleDynamics::new(&machine.robot).unwrap();
        body.evaluate(healthy.plant().truth().q).unwrap();
        let n = machine.start.len();
        let arms = &body.moment_arms()[muscle * n..(muscle + 1) * n];
        let (joint, arm) = arms.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap();
        // tau = R^T T: the push takes the opposite direction of the muscle's torque.
        let load = |fraction: f64| Failure::Push { joint, torque: -arm * fraction * peak };
        let overloads = |failure: &Failure| {
            let fault = InjectedFault { start, duration: f64::INFINITY, failure: *failure };
            let mut session = healthy.clone().with_faults(&[fault]).unwrap();
            let (mut above, mut longest, mut running) = (0.0_f64, 0.0_f64, true);
            while running && session.time() < start + OBSERVED && longest < OVERLOAD {
                running = session
                    .step(|row| {
                        let over = row.truth.cables[muscle].tension_in > 1.1 * peak;
                        above = if over { above + STEP } else { 0.0 };
                        longest = longest.max(above);
                        running = row.mode == Mode::Run;
                    })
                    .unwrap()
                    && running;
            }
            longest >= OVERLOAD || !running
        };
        let fractions = (0..16).map(|k| 1.6 * 1.1_f64.powi(k));
        fractions
            .map(load)
            .find(overloads)
            .expect("a load of seven times the peak is too much for every muscle")
    }
}

impl Case {
    /// Reset, pretension, hold.
    fn recover(&mut self, session: TrackSession<'_>, broken: bool) {
        let keep = if broken { self.part } else { usize::MAX };
        let mut session = session.with_faults(&[]).unwrap();
        session.set_exchange(None);
        let start = session.time();
        let (mut held, mut again) = (0.0, None);
        while session.time() < start + RECOVERY && held < 1.0 && again.is_none() {
            session.ask(if session.time() < start + 0.002 { Request::Reset } else { Request::Hold });
            let going = session
                .step(|row| {
                    if row.mode == Mode::Hold {
                        held += STEP;
                    }
                    if matches!(row.mode, Mode::SafeStop) {
                        again = row.fault;
                    }
                })
                .unwrap();
            if !going {
                break;
            }
        }
        if again.is_none() && held < 1.0 {
            let reading = session.plant().reading();
            eprintln!(
                "{} {:?}: {:?} T {:?} q {:?} drives {:?}",
                self.machine,
                self.injection,
                session.supervisor().mode(),
                reading.tension,
                reading.joint,
                session.plant().truth().drives.iter().map(|d| (d.speed, d.fault)).collect::<Vec<_>>()
            );
        }
        self.again = again.map(NamedFault::kind);
        self.recovered = Some(if broken {
            again.is_some_and(|fault| fault.kind() == FaultKind::Slack && fault.index() == Some(keep))
        } else {
            held >= 1.0
        });
    }
}

fn tension_over(row: &TrackRow<'_>, limits: &[f64]) -> f64 {
    let cables = row.truth.cables.iter().zip(limits);
    cables.map(|(cable, limit)| cable.tension_in / limit).fold(0.0, f64::max)
}

/// Mean magnitude of the joints' errors over the motion, over the joints.
fn mean_error(session: &TrackSession<'_>) -> f64 {
    let summary = session.clone().finish();
    summary.joint_error.iter().map(|error| error.mean).sum::<f64>() / summary.joint_error.len() as f64
}

/// One hour and more of the same motion with wear of one cable.
#[derive(Debug)]
#[allow(dead_code, reason = "printed")]
pub(crate) struct Worn {
    /// What was found first: s, kind, muscle, fraction, standard error, forecast in s.
    pub(crate) found: Option<(f64, FaultKind, usize, f64, f64, f64)>,
    /// Mean error of the joints in windows of five minutes, over that of the first.
    pub(crate) errors: Vec<f64>,
    /// That of the window in which the wear was found.
    pub(crate) error_when_found: Option<f64>,
    /// Whether the machine was stopped.
    pub(crate) stopped: Option<NamedFault>,
    /// Largest drift of friction, stiffness and pretension of any cable at the end.
    pub(crate) drift: [f64; 3],
}

impl Bench {
    /// Tracks for this many seconds with these failures, or to the end of the window in which wear is found.
    pub(crate) fn wears(&mut self, seconds: f64, faults: &[InjectedFault]) -> Worn {
        const WINDOW: f64 = 120.0;
        // Windows before the wear begins.
        const HEALTHY: usize = 7;
        self.repeats = (seconds / self.trajectory.duration()).ceil() as u32;
        self.with_session(faults, |mut session| {
            let mut worn = Worn {
                found: None,
                errors: Vec::new(),
                error_when_found: None,
                stopped: None,
                drift: [0.0; 3],
            };
            let (mut sum, mut count, mut next) = (0.0, 0.0, BEFORE + WINDOW);
            while session.time() < BEFORE + seconds && worn.stopped.is_none() {
                session
                    .step(|row| {
                        if row.mode == Mode::SafeStop {
                            worn.stopped = row.fault;
                        }
                        if row.repeat.is_some() {
                            sum += row.joint_error.iter().map(|error| error.abs()).sum::<f64>();
                            count += row.joint_error.len() as f64;
                        }
                    })
                    .unwrap();
                let health = session.supervisor().health();
                if worn.found.is_none() {
                    worn.found = health.iter().enumerate().find_map(|(muscle, health)| {
                        let kind = health.found()?;
                        let drift = match kind {
                            FaultKind::FrictionDrift => health.friction,
                            FaultKind::StiffnessDrift => health.stiffness,
                            _ => health.pretension,
                        };
                        Some((session.time(), kind, muscle, drift.fraction, drift.error, drift.remaining))
                    });
                }
                if session.time() > next {
                    worn.errors.push(sum / count);
                    (sum, count, next) = (0.0, 0.0, next + WINDOW);
                    if worn.found.is_some() {
                        break;
                    }
                }
            }
            let healthy = &worn.errors[..worn.errors.len().min(HEALTHY)];
            let healthy = healthy.iter().sum::<f64>() / healthy.len() as f64;
            worn.errors.iter_mut().for_each(|error| *error = (1e3 * *error / healthy).round() * 1e-3);
            worn.error_when_found = worn.found.and(worn.errors.last().copied());
            for health in session.supervisor().health() {
                let drifts = [health.friction, health.stiffness, health.pretension];
                for (most, drift) in worn.drift.iter_mut().zip(drifts) {
                    if drift.fraction.abs() > most.abs() {
                        *most = drift.fraction;
                    }
                }
            }
            worn
        })
    }
}
