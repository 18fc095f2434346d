use super::bus::{HEARTBEAT_LOST, RESTARTED, UNGUARDED};
use super::cansimple::{ERROR_CODES, error_name};
use super::{mit, moteus};
use sinew_session::BusFault;

/// The code of a fault in words, which follow the name of the device where there is one.
#[must_use]
pub fn words(fault: BusFault) -> String {
    match fault {
        BusFault::Missing { expected, got } => format!("{got} of {expected} nodes answered"),
        BusFault::NotReady { code: HEARTBEAT_LOST, .. } => "sends no heartbeat".to_owned(),
        BusFault::NotReady { code: RESTARTED, .. } => {
            "is no longer operational: it has started anew".to_owned()
        }
        BusFault::NotReady { code: UNGUARDED, .. } => {
            "and all others have no watchdog beside this program any more: it has taken their power, or was ended"
                .to_owned()
        }
        BusFault::NotReady { .. } => "does not answer".to_owned(),
        BusFault::Drive { code: 0, .. } => "is not enabled".to_owned(),
        BusFault::Drive { code, .. } if ERROR_CODES.contains(&code) => {
            format!("reports {}", error_name(code))
        }
        BusFault::Drive { code, .. } if moteus::FAULT_CODES.contains(&code) => {
            format!("reports {}", moteus::fault_name(code))
        }
        BusFault::Drive { code, .. } if mit::FAULT_CODES.contains(&code) => {
            format!("reports {}", mit::fault_name(code))
        }
        BusFault::Drive { code, .. } => format!("reports emergency {code:#06x}"),
        BusFault::Lost | BusFault::Late { .. } | BusFault::Stale { .. } => String::new(),
    }
}
