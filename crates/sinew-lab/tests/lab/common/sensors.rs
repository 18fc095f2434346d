//! Campaigns of sensors that read something else than what there is, on supervised machines.

use super::faults::error;
use super::supervised::Bench;
use sinew::control::arm::Fault;
use sinew::control::supervisor::{Mode, NamedFault};
use sinew::machine::Machine;
use sinew::random::Random;
use sinew::twin::arm::{Failure, InjectedFault, Sensor, SensorFailure};

/// Time for which a run is observed after a fault that lasts, s, and after one that has ended.
const LASTING: f64 = 8.0;
const AFTER: f64 = 3.0;
/// Rest before the motion, s.
const BEFORE: f64 = 3.0;

/// Ways in which a sensor is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Lie {
    CellOffset,
    CellGain,
    CellDrift,
    CellSaturation,
    CellNoise,
    MotorOffset,
    MotorSlip,
    JointOffset,
    JointSlip,
}

impl Lie {
    pub(crate) const ALL: [Self; 9] = [
        Self::CellOffset,
        Self::CellGain,
        Self::CellDrift,
        Self::CellSaturation,
        Self::CellNoise,
        Self::MotorOffset,
        Self::MotorSlip,
        Self::JointOffset,
        Self::JointSlip,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::CellOffset => "load cell, offset of 0.5 to 15 % of its range",
            Self::CellGain => "load cell, gain of 0.5 to 2",
            Self::CellDrift => "load cell, drift of 0.01 to 1 % of its range per s",
            Self::CellSaturation => "load cell, ends at 0.7 to 1 of its largest tension",
            Self::CellNoise => "load cell, noise of 10 to 30 times its own",
            Self::MotorOffset => "motor encoder, offset of 0.5 to 20 mm",
            Self::MotorSlip => "motor encoder, slip of 0.1 to 3 mm/s",
            Self::JointOffset => "joint encoder, offset of 3 to 1000 counts",
            Self::JointSlip => "joint encoder, slip of 5 to 500 counts per s",
        }
    }

    fn is_of_cell(self) -> bool {
        matches!(
            self,
            Self::CellOffset | Self::CellGain | Self::CellDrift | Self::CellSaturation | Self::CellNoise
        )
    }
}

/// A run with one sensor that is wrong.
#[derive(Debug, Clone)]
#[allow(dead_code, reason = "printed")]
pub(crate) struct LieCase {
    pub(crate) machine: String,
    pub(crate) seed: u64,
    pub(crate) lie: Lie,
    pub(crate) part: String,
    pub(crate) fault: InjectedFault,
    /// First report, s after the fault began.
    pub(crate) reported: Option<(f64, NamedFault)>,
    /// Safe stop, s after it.
    pub(crate) stopped: Option<(f64, NamedFault)>,
    /// Whether the first report and the stop name the sensor, or a group with it.
    pub(crate) named: bool,
    /// Largest error until a stop, over the bound of a completed run; the same without the fault.
    pub(crate) error: f64,
    pub(crate) usual: f64,
}

impl LieCase {
    /// Whether nothing was reported, nor was there need to: the error stays near that without the fault.
    pub(crate) fn is_harmless(&self) -> bool {
        self.reported.is_none() && self.stopped.is_none() && self.error < (1.5 * self.usual).max(0.3)
    }

    /// Above the bound of a completed run without a report.
    pub(crate) fn is_silent(&self) -> bool {
        self.reported.is_none() && self.error > 1.0
    }

    /// Stopped although the machine can go on without the sensor, or by another name.
    pub(crate) fn is_stopped_wrongly(&self) -> bool {
        self.stopped.is_some() && (self.lie.is_of_cell() || !self.named)
    }
}

pub(crate) fn names(failure: Failure, named: NamedFault, crosses: impl Fn(usize, usize) -> bool) -> bool {
    match (failure, named.fault) {
        (
            Failure::Sensor(Sensor::Tension(k), _),
            Fault::TensionSensor(j) | Fault::TensionOrMotorSensor(j),
        )
        | (Failure::Sensor(Sensor::Motor(k), _), Fault::MotorSensor(j) | Fault::TensionOrMotorSensor(j))
        | (Failure::Sensor(Sensor::Motor(k), _), Fault::MotorOrJointSensor(j))
        | (Failure::Sensor(Sensor::Joint(k), _), Fault::JointSensor(j)) => k == j,
        // The group of all encoders of a muscle's joints.
        (Failure::Sensor(Sensor::Joint(k), _), Fault::MotorOrJointSensor(j)) => crosses(j, k),
        _ => false,
    }
}

/// Whether a muscle crosses a joint where the machine starts.
pub(crate) fn crossings(machine: &Machine) -> impl Fn(usize, usize) -> bool {
    let mut body = sinew::muscle::MuscleDynamics::new(&machine.robot).unwrap();
    body.evaluate(&machine.start).unwrap();
    let (arms, joints) = (body.moment_arms().to_vec(), machine.start.len());
    move |muscle, joint| arms[muscle * joints + joint] != 0.0
}

/// Runs of one machine: its faults, and what was reported without one.
pub(crate) fn lies(bench: &Bench, seed: u64, count: usize) -> (Vec<LieCase>, f64, Vec<String>) {
    let machine = &bench.arm.machine;
    let name = machine.robot.parts().name.clone();
    bench.with_session(&[], |mut healthy| {
        let mut reports = Vec::new();
        let mut usual = Vec::new();
        let mut most = vec![0.0_f64; machine.muscles.len()];
        let mut scout = healthy.clone();
        let end = bench.end();
        while scout.time() < end + LASTING + AFTER {
            scout
                .step(|row| {
                    usual.push(error(machine, row));
                    for (most, tension) in most.iter_mut().zip(&row.reading.tension) {
                        *most = most.max(*tension);
                    }
                    if row.fault.is_some() || row.mode != Mode::Run {
                        reports
                            .push(format!("{name} {seed}: {:.3} {:?} {:?}", row.time, row.mode, row.fault));
                    }
                })
                .unwrap();
        }
        let mut sampled = sampled(machine, seed, ([BEFORE + 0.5, end - 0.1], &most), count);
        sampled.sort_by(|a, b| a.1.start.total_cmp(&b.1.start));
        let crosses = crossings(machine);
        let mut cases = Vec::new();
        for (lie, fault) in sampled {
            while healthy.time() < fault.start - 5e-4 {
                healthy.step(|_| {}).unwrap();
            }
            let mut session = healthy.clone().with_faults(&[fault]).unwrap();
            let until = if fault.duration.is_finite() {
                fault.start + fault.duration + AFTER
            } else {
                fault.start + LASTING
            };
            let mut case = LieCase {
                machine: name.clone(),
                seed,
                lie,
                part: String::new(),
                fault,
                reported: None,
                stopped: None,
                named: true,
                error: 0.0,
                usual: 0.0,
            };
            let mut going = true;
            while going && session.time() < until && case.stopped.is_none() {
                let cycle = (session.time() * 1e3).round() as usize;
                case.usual = case.usual.max(usual.get(cycle).copied().unwrap_or(0.0));
                going = session
                    .step(|row| {
                        let since = row.time - fault.start;
                        case.error = case.error.max(error(machine, row));
                        if let Some(found) = row.fault {
                            case.reported = case.reported.or(Some((since, found)));
                        }
                        if row.mode != Mode::Run {
                            case.stopped = case.stopped.or(row.fault.map(|found| (since, found)));
                        }
                    })
                    .unwrap();
            }
            let found = [case.reported, case.stopped];
            case.named = found.into_iter().flatten().all(|(_, found)| names(fault.failure, found, &crosses));
            cases.push(case);
        }
        (cases, end, reports)
    })
}

/// Faults of every kind in turn, at random parts and times, a third of them permanent; `most` are the largest
/// tensions of the motion, N.
pub(crate) fn sampled(
    machine: &Machine,
    seed: u64,
    ([from, to], most): ([f64; 2], &[f64]),
    count: usize,
) -> Vec<(Lie, InjectedFault)> {
    let mut random = Random::new(seed ^ 0x11e5);
    let encoders: Vec<usize> =
        (0..machine.encoders.len()).filter(|k| machine.encoders[*k].is_some()).collect();
    let mut all = Vec::new();
    for k in 0..count {
        let lie = Lie::ALL[(k + seed as usize) % Lie::ALL.len()];
        let mut log = |low: f64, high: f64| low * (high / low).powf(random.unit());
        let muscle = (log(1.0, 2.0).log2() * machine.muscles.len() as f64) as usize % machine.muscles.len();
        let cell = &machine.muscles[muscle].drive.load_cell;
        let size = match lie {
            Lie::CellOffset => log(0.005, 0.15) * cell.range,
            Lie::CellGain => log(0.5, 2.0),
            Lie::CellDrift => log(1e-4, 1e-2) * cell.range,
            Lie::CellSaturation => log(0.7, 1.0) * most[muscle],
            Lie::CellNoise => log(10.0, 30.0) * cell.noise,
            Lie::MotorOffset => log(0.5e-3, 20e-3),
            Lie::MotorSlip => log(0.1e-3, 3e-3),
            Lie::JointOffset => log(3.0, 1000.0),
            Lie::JointSlip => log(5.0, 500.0),
        };
        let duration = if log(1.0, 2.0) < 1.26 { f64::INFINITY } else { log(0.1, 5.0) };
        let side = if log(1.0, 4.0) < 2.0 { -1.0 } else { 1.0 };
        let start = from + log(1.0, 2.0).log2() * (to - from);
        let place = (log(1.0, 2.0).log2() * encoders.len() as f64) as usize;
        let joint = encoders.get(place.min(encoders.len().saturating_sub(1))).copied();
        let count = joint.and_then(|j| machine.encoders[j].map(|e| e.resolution)).unwrap_or(0.0);
        use SensorFailure::{Drift, Gain, Noise, Offset, Saturation};
        let (sensor, failure) = match lie {
            Lie::CellOffset => (Sensor::Tension(muscle), Offset(side * size)),
            Lie::CellGain => (Sensor::Tension(muscle), Gain(size)),
            Lie::CellDrift => (Sensor::Tension(muscle), Drift(side * size)),
            Lie::CellSaturation => (Sensor::Tension(muscle), Saturation(size)),
            Lie::CellNoise => (Sensor::Tension(muscle), Noise(size)),
            Lie::MotorOffset => (Sensor::Motor(muscle), Offset(side * size)),
            Lie::MotorSlip => (Sensor::Motor(muscle), Drift(side * size)),
            Lie::JointOffset => (Sensor::Joint(joint.unwrap_or(0)), Offset(side * size * count)),
            Lie::JointSlip => (Sensor::Joint(joint.unwrap_or(0)), Drift(side * size * count)),
        };
        if joint.is_none() && matches!(sensor, Sensor::Joint(_)) {
            continue;
        }
        let start = (start * 1e3).round() * 1e-3;
        all.push((lie, InjectedFault { start, duration, failure: Failure::Sensor(sensor, failure) }));
    }
    all
}
