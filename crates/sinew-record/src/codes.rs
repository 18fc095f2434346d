//! Status and faults as numbers of a column.

use sinew::control::arm::{ArmStatus, Fault};
use sinew_runtime::bus::BusFault;

/// Status and fault: 0 following, 1 holding, 2 degraded, 3 stopped; 1000 times the kind of the fault plus the index of
/// its muscle or joint, see [`fault_of`].
pub(crate) fn status_code(status: ArmStatus) -> [f64; 2] {
    match status {
        ArmStatus::Following => [0.0, 0.0],
        ArmStatus::Holding => [1.0, 0.0],
        ArmStatus::Degraded(fault) => [2.0, fault_code(fault)],
        ArmStatus::Stopped(fault) => [3.0, fault_code(fault)],
    }
}

const FAULT_KIND: f64 = 1000.0;

pub(crate) fn fault_code(fault: Fault) -> f64 {
    let (kind, index) = match fault {
        Fault::JointSensor(k) => (1.0, k),
        Fault::MotorSensor(k) => (2.0, k),
        Fault::TensionSensor(k) => (3.0, k),
        Fault::Drive(k) => (4.0, k),
        Fault::Cable(k) => (5.0, k),
        Fault::TrackingError(k) => (6.0, k),
        Fault::Bus => (7.0, 0),
        Fault::Slack(k) => (8.0, k),
        Fault::Overload(k) => (9.0, k),
        Fault::TensionRate(k) => (10.0, k),
        Fault::Overspeed(k) => (11.0, k),
        Fault::Travel(k) => (12.0, k),
        Fault::Overheating(k) => (13.0, k),
        Fault::JointRange(k) => (14.0, k),
        Fault::LateCycles => (15.0, 0),
        Fault::StaleCommand => (16.0, 0),
        Fault::TensionOrMotorSensor(k) => (17.0, k),
        Fault::MotorOrJointSensor(k) => (18.0, k),
    };
    FAULT_KIND * kind + index as f64
}

/// The fault of a code; none for 0 and unknown ones.
#[must_use]
pub fn fault_of(code: f64) -> Option<Fault> {
    let index = (code % FAULT_KIND) as usize;
    Some(match (code / FAULT_KIND) as u32 {
        1 => Fault::JointSensor(index),
        2 => Fault::MotorSensor(index),
        3 => Fault::TensionSensor(index),
        4 => Fault::Drive(index),
        5 => Fault::Cable(index),
        6 => Fault::TrackingError(index),
        7 => Fault::Bus,
        8 => Fault::Slack(index),
        9 => Fault::Overload(index),
        10 => Fault::TensionRate(index),
        11 => Fault::Overspeed(index),
        12 => Fault::Travel(index),
        13 => Fault::Overheating(index),
        14 => Fault::JointRange(index),
        15 => Fault::LateCycles,
        16 => Fault::StaleCommand,
        17 => Fault::TensionOrMotorSensor(index),
        18 => Fault::MotorOrJointSensor(index),
        _ => return None,
    })
}

/// The status of a code.
#[must_use]
pub fn status_of(status: f64, fault: f64) -> ArmStatus {
    match (status as u32, fault_of(fault)) {
        (1, _) => ArmStatus::Holding,
        (2, Some(fault)) => ArmStatus::Degraded(fault),
        (3, Some(fault)) => ArmStatus::Stopped(fault),
        _ => ArmStatus::Following,
    }
}

/// Factors of the numbers in a bus fault's detail.
const SECOND: f64 = 65_536.0;
const THIRD: f64 = SECOND * SECOND;

/// Kind and detail of a bus fault: 0 none, 1 lost, 2 working counter, 3 not operational, 4 drive; of a simulation
/// 5 late, 6 stale.
pub(crate) fn bus_code(fault: Option<BusFault>) -> [f64; 2] {
    match fault {
        None => [0.0, 0.0],
        Some(BusFault::Lost) => [1.0, 0.0],
        Some(BusFault::WorkingCounter { expected, got }) => {
            [2.0, f64::from(expected) + SECOND * f64::from(got)]
        }
        Some(BusFault::NotOperational { device, state, muscle }) => {
            let muscle = muscle.map_or(0.0, |muscle| muscle as f64 + 1.0);
            [3.0, device as f64 + SECOND * f64::from(state) + THIRD * muscle]
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
        2 => BusFault::WorkingCounter { expected: first as u16, got: second as u16 },
        3 => BusFault::NotOperational {
            device: first as usize,
            state: second as u8,
            muscle: (third >= 1.0).then(|| third as usize - 1),
        },
        4 => BusFault::Drive { muscle: first as usize, code: second as u16 },
        5 => BusFault::Late { by_ns: detail as u32 },
        6 => BusFault::Stale { age_us: detail as u32 },
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
            assert_eq!(fault_of(fault_code(fault)), Some(fault));
            let [status, code] = status_code(ArmStatus::Stopped(fault));
            assert_eq!(status_of(status, code), ArmStatus::Stopped(fault));
        }
        assert_eq!(fault_of(0.0), None);
        for fault in [
            None,
            Some(BusFault::Lost),
            Some(BusFault::WorkingCounter { expected: 90, got: u16::MAX }),
            Some(BusFault::NotOperational { device: 31, state: 0x14, muscle: None }),
            Some(BusFault::NotOperational { device: 0, state: 4, muscle: Some(0) }),
            Some(BusFault::Drive { muscle: 14, code: 0x7305 }),
            Some(BusFault::Late { by_ns: 500_000 }),
            Some(BusFault::Stale { age_us: u32::MAX }),
        ] {
            let [kind, detail] = bus_code(fault);
            assert_eq!(bus_fault_of(kind, detail), fault);
        }
    }
}
