//! Status, faults and commands as numbers of a signal.

use crate::exchange::BusFault;
use sinew::control::arm::{ArmStatus, Symptom};
use sinew::control::supervisor::NamedFault;
use sinew::drive::DriveCommand;

/// Status and fault: 0 following, 1 holding, 2 degraded, 3 stopped; the fault as [`fault_of`] reads it, with
/// the symptom of the supervisor's fault where that is the same.
pub(crate) fn status_code(status: ArmStatus, named: Option<NamedFault>) -> [f64; 2] {
    let code = |fault| {
        let named = named.filter(|named| named.fault == fault);
        fault_code(named.unwrap_or(NamedFault { fault, symptom: Symptom::Unknown }))
    };
    match status {
        ArmStatus::Following => [0.0, 0.0],
        ArmStatus::Holding => [1.0, 0.0],
        ArmStatus::Degraded(fault) => [2.0, code(fault)],
        ArmStatus::Stopped(fault) => [3.0, code(fault)],
    }
}

/// Factor of the number of a fault.
const CODE: f64 = 1000.0;

/// 1000 times the number of the fault plus the index of its muscle or joint.
pub(crate) fn fault_code(named: NamedFault) -> f64 {
    CODE * f64::from(named.code()) + named.index().unwrap_or(0) as f64
}

/// The fault of a number in a column; none for 0 and unknown ones.
#[must_use]
pub fn fault_of(code: f64) -> Option<NamedFault> {
    NamedFault::of_code((code / CODE) as u16, (code % CODE) as usize)
}

/// The status of a code.
#[must_use]
pub fn status_of(status: f64, fault: f64) -> ArmStatus {
    match (status as u32, fault_of(fault)) {
        (1, _) => ArmStatus::Holding,
        (2, Some(named)) => ArmStatus::Degraded(named.fault),
        (3, Some(named)) => ArmStatus::Stopped(named.fault),
        _ => ArmStatus::Following,
    }
}

/// Factors of the numbers in a bus fault's detail.
const SECOND: f64 = 65_536.0;
const THIRD: f64 = SECOND * SECOND;

/// Kind and detail of a bus fault: 0 none, 1 lost, 2 missing, 3 not ready, 4 drive; of a simulation
/// 5 late, 6 stale.
pub(crate) fn bus_code(fault: Option<BusFault>) -> [f64; 2] {
    match fault {
        None => [0.0, 0.0],
        Some(BusFault::Lost) => [1.0, 0.0],
        Some(BusFault::Missing { expected, got }) => [2.0, f64::from(expected) + SECOND * f64::from(got)],
        Some(BusFault::NotReady { device, code, muscle }) => {
            let muscle = muscle.map_or(0.0, |muscle| muscle as f64 + 1.0);
            [3.0, device as f64 + SECOND * f64::from(code) + THIRD * muscle]
        }
        Some(BusFault::Drive { muscle, code }) => [4.0, muscle as f64 + SECOND * f64::from(code)],
        Some(BusFault::Late { by_ns }) => [5.0, f64::from(by_ns)],
        Some(BusFault::Stale { age_us }) => [6.0, f64::from(age_us)],
    }
}

/// The bus fault of a kind and a detail.
#[must_use]
pub fn bus_fault_of(kind: f64, detail: f64) -> Option<BusFault> {
    let (first, rest) = (detail % SECOND, (detail / SECOND).floor());
    let (second, third) = (rest % SECOND, (rest / SECOND).floor());
    Some(match kind as u32 {
        1 => BusFault::Lost,
        2 => BusFault::Missing { expected: first as u16, got: second as u16 },
        3 => BusFault::NotReady {
            device: first as usize,
            code: second as u16,
            muscle: (third >= 1.0).then(|| third as usize - 1),
        },
        4 => BusFault::Drive { muscle: first as usize, code: second as u16 },
        5 => BusFault::Late { by_ns: detail as u32 },
        6 => BusFault::Stale { age_us: detail as u32 },
        _ => return None,
    })
}

/// Kind and up to two numbers of a command.
///
/// | kind | command | numbers |
/// |---|---|---|
/// | 0 | speed of the cable | m/s |
/// | 1 | tension | N; feed-forward of the cable's speed, m/s |
/// | 2 | current | A |
/// | 3, 4 | off, brake | |
#[must_use]
pub fn command_code(command: &DriveCommand) -> [f64; 3] {
    match *command {
        DriveCommand::Velocity(speed) => [0.0, speed, 0.0],
        DriveCommand::Tension { tension, feed } => [1.0, tension, feed],
        DriveCommand::Current(current) => [2.0, current, 0.0],
        DriveCommand::Off => [3.0, 0.0, 0.0],
        DriveCommand::Brake => [4.0, 0.0, 0.0],
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a failing test may panic")]

    use super::*;
    use sinew::control::arm::Fault;

    #[test]
    fn codes_of_faults_lead_back_to_them() {
        for fault in [
            Fault::JointSensor(3),
            Fault::MotorSensor(14),
            Fault::TensionSensor(0),
            Fault::Drive(23),
            Fault::Cable(999),
            Fault::TrackingError(7),
            Fault::Bus,
            Fault::Overheating(14),
            Fault::StaleCommand,
        ] {
            for symptom in [Symptom::Unknown, Symptom::Stuck, Symptom::Jumped, Symptom::Standing] {
                let named = NamedFault { fault, symptom };
                let back = fault_of(fault_code(named)).unwrap();
                assert_eq!((back.fault, back.kind()), (fault, named.kind()));
                let [status, code] = status_code(ArmStatus::Stopped(fault), Some(named));
                assert_eq!(status_of(status, code), ArmStatus::Stopped(fault));
                assert!((code - fault_code(named)).abs() < 1e-9);
            }
            let [_, code] = status_code(
                ArmStatus::Degraded(fault),
                Some(NamedFault { fault: Fault::Slack(30), symptom: Symptom::Lost }),
            );
            assert_eq!(
                fault_of(code).map(|named| named.fault),
                Some(fault),
                "another fault says nothing of it"
            );
        }
        assert_eq!(fault_of(0.0), None);
        let before = fault_of(2014.0).unwrap();
        assert_eq!(
            before,
            NamedFault { fault: Fault::MotorSensor(14), symptom: Symptom::Unknown },
            "no symptom"
        );
        for fault in [
            None,
            Some(BusFault::Lost),
            Some(BusFault::Missing { expected: 90, got: u16::MAX }),
            Some(BusFault::NotReady { device: 31, code: 0x14, muscle: None }),
            Some(BusFault::NotReady { device: 0, code: 0xf00d, muscle: Some(0) }),
            Some(BusFault::Drive { muscle: 14, code: 0x7305 }),
            Some(BusFault::Late { by_ns: 500_000 }),
            Some(BusFault::Stale { age_us: u32::MAX }),
        ] {
            let [kind, detail] = bus_code(fault);
            assert_eq!(bus_fault_of(kind, detail), fault);
        }
    }
}
