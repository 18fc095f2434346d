use super::bus::{TIMED_OUT, WITHOUT_TORQUE};
use super::error::hardware;
use sinew_session::BusFault;

/// The code of a fault in words, which follow the name of the device where there is one.
#[must_use]
pub fn words(fault: BusFault) -> String {
    match fault {
        BusFault::Missing { expected, got } => format!("{got} of {expected} servos answered"),
        BusFault::NotReady { code: WITHOUT_TORQUE, .. } => "has started anew, without torque".to_owned(),
        BusFault::NotReady { code: TIMED_OUT, .. } => {
            "was stopped by its bus watchdog: it heard nothing for too long".to_owned()
        }
        BusFault::NotReady { .. } => "does not answer".to_owned(),
        BusFault::Drive { code, .. } => {
            format!("reports {}", hardware(u8::try_from(code).unwrap_or(u8::MAX)))
        }
        BusFault::Lost | BusFault::Late { .. } | BusFault::Stale { .. } => String::new(),
    }
}
