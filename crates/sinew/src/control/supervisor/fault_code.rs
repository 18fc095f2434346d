//! Numbers of faults: one list for the link, recordings and the page.
//!
//! ```text
//! code = 100 symptom + part        404: the drive of a muscle stands, its winch is jammed
//! ```

use super::fault_kind::FaultKind;
use super::signals::NamedFault;
use crate::control::arm::{Fault, Symptom};
use alloc::format;
use alloc::string::String;

/// What an index counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counted {
    /// Independent joints.
    Joint,
    /// Muscles.
    Muscle,
    /// Nothing: the fault is one of the whole machine.
    None,
}

impl Counted {
    /// In words of documents and files; none where nothing is counted.
    #[must_use]
    pub const fn name(self) -> Option<&'static str> {
        match self {
            Self::Joint => Some("joint"),
            Self::Muscle => Some("muscle"),
            Self::None => None,
        }
    }
}

/// A number that a fault has in packets, recordings and states of the page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaultCode {
    /// The number.
    pub number: u16,
    /// The kind.
    pub kind: FaultKind,
    /// The part that is at fault, or whose limit is passed.
    pub part: &'static str,
    /// What its index counts.
    pub counted: Counted,
}

/// Part, what its index counts, and its fault.
type Part = (&'static str, Counted, fn(usize) -> Fault);

/// Parts by their numbers, from 1 on.
const PARTS: [Part; 18] = [
    ("joint encoder", Counted::Joint, Fault::JointSensor),
    ("motor encoder", Counted::Muscle, Fault::MotorSensor),
    ("load cell", Counted::Muscle, Fault::TensionSensor),
    ("drive", Counted::Muscle, Fault::Drive),
    ("cable", Counted::Muscle, Fault::Cable),
    ("joint", Counted::Joint, Fault::TrackingError),
    ("bus", Counted::None, |_| Fault::Bus),
    ("cable", Counted::Muscle, Fault::Slack),
    ("cable", Counted::Muscle, Fault::Overload),
    ("cable", Counted::Muscle, Fault::TensionRate),
    ("winch", Counted::Muscle, Fault::Overspeed),
    ("winch", Counted::Muscle, Fault::Travel),
    ("motor", Counted::Muscle, Fault::Overheating),
    ("joint", Counted::Joint, Fault::JointRange),
    ("control cycle", Counted::None, |_| Fault::LateCycles),
    ("command", Counted::None, |_| Fault::StaleCommand),
    ("load cell or motor encoder", Counted::Muscle, Fault::TensionOrMotorSensor),
    ("motor encoder or joint encoder", Counted::Muscle, Fault::MotorOrJointSensor),
];

/// Symptoms by their numbers.
const SYMPTOMS: [Symptom; 6] =
    [Symptom::Unknown, Symptom::Lost, Symptom::Stuck, Symptom::Jumped, Symptom::Standing, Symptom::Deviating];
/// Factor of the symptom.
const SYMPTOM: u16 = 100;

/// Number of a fault among [`PARTS`].
fn part_of(fault: Fault) -> u16 {
    match fault {
        Fault::JointSensor(_) => 1,
        Fault::MotorSensor(_) => 2,
        Fault::TensionSensor(_) => 3,
        Fault::Drive(_) => 4,
        Fault::Cable(_) => 5,
        Fault::TrackingError(_) => 6,
        Fault::Bus => 7,
        Fault::Slack(_) => 8,
        Fault::Overload(_) => 9,
        Fault::TensionRate(_) => 10,
        Fault::Overspeed(_) => 11,
        Fault::Travel(_) => 12,
        Fault::Overheating(_) => 13,
        Fault::JointRange(_) => 14,
        Fault::LateCycles => 15,
        Fault::StaleCommand => 16,
        Fault::TensionOrMotorSensor(_) => 17,
        Fault::MotorOrJointSensor(_) => 18,
    }
}

impl NamedFault {
    /// Its number; faults of the same part and kind have the same one.
    #[must_use]
    pub fn code(self) -> u16 {
        let symptom = match self.kind() {
            FaultKind::SensorLost => 1,
            FaultKind::SensorStuck => 2,
            FaultKind::EncoderJump => 3,
            FaultKind::Jam => 4,
            FaultKind::SensorDeviation => 5,
            _ => 0,
        };
        SYMPTOM * symptom + part_of(self.fault)
    }

    /// The fault of a number, of the part with this index; none for 0 and numbers without meaning. Of a
    /// sensor without a symptom, as earlier recordings have it, no more is known.
    #[must_use]
    pub fn of_code(code: u16, index: usize) -> Option<Self> {
        let (_, _, fault) = PARTS.get(usize::from(code % SYMPTOM).checked_sub(1)?)?;
        let symptom = *SYMPTOMS.get(usize::from(code / SYMPTOM))?;
        let named = Self { fault: fault(index), symptom };
        (symptom == Symptom::Unknown || named.code() == code).then_some(named)
    }
}

impl FaultCode {
    /// All numbers, in their order.
    pub fn all() -> impl Iterator<Item = Self> {
        let numbers = (0..SYMPTOMS.len() as u16)
            .flat_map(|symptom| (1..=PARTS.len() as u16).map(move |part| SYMPTOM * symptom + part));
        numbers.filter_map(|number| {
            let named = NamedFault::of_code(number, 0).filter(|named| named.code() == number)?;
            let (part, counted, _) = PARTS[usize::from(number % SYMPTOM) - 1];
            Some(Self { number, kind: named.kind(), part, counted })
        })
    }
}

/// All numbers as a table in Markdown.
#[must_use]
pub fn fault_codes_markdown() -> String {
    let mut text = String::from("| code | fault | part | its index counts |\n|---|---|---|---|\n");
    for FaultCode { number, kind, part, counted } in FaultCode::all() {
        let counted = counted.name().map_or_else(|| String::from("nothing: 0"), |name| format!("{name}s"));
        text += &format!("| {number} | `{}` | {part} | {counted} |\n", kind.name());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    const ALL_SYMPTOMS: [Symptom; 8] = [
        Symptom::Unknown,
        Symptom::Lost,
        Symptom::Stuck,
        Symptom::Jumped,
        Symptom::Standing,
        Symptom::Deviating,
        Symptom::Noisy,
        Symptom::Reported,
    ];

    #[test]
    fn a_code_leads_back_to_part_index_and_kind() {
        for (place, (_, counted, fault)) in PARTS.into_iter().enumerate() {
            for (index, symptom) in [0, 7, 127].into_iter().flat_map(|k| ALL_SYMPTOMS.map(|s| (k, s))) {
                let named = NamedFault { fault: fault(index), symptom };
                assert_eq!(usize::from(part_of(named.fault)), place + 1);
                let back = NamedFault::of_code(named.code(), index).expect("a code of the list");
                assert_eq!((back.fault, back.kind()), (named.fault, named.kind()));
                assert!(
                    FaultCode::all().any(|code| code.number == named.code() && code.kind == named.kind())
                );
                assert_eq!(named.index(), (counted != Counted::None).then_some(index));
            }
        }
    }

    #[test]
    fn no_two_faults_share_a_code_and_other_numbers_mean_nothing() {
        let all: Vec<FaultCode> = FaultCode::all().collect();
        assert_eq!(all.len(), 28, "three sensors in four ways, two groups, a drive in two, twelve others");
        for (place, code) in all.iter().enumerate() {
            let alike = |other: &FaultCode| {
                other.number == code.number || other.kind == code.kind && other.part == code.part
            };
            assert!(!all[..place].iter().any(alike), "{code:?}");
        }
        for number in 0..=u16::MAX {
            let meant = all.iter().any(|code| code.number == number);
            assert_eq!(
                NamedFault::of_code(number, 0).is_some(),
                meant || (1..4).contains(&number) || (17..19).contains(&number),
                "{number}"
            );
        }
    }
}
