use sinew_session::BusFault;

/// The code of a fault in words, which follow the name of the device where there is one.
#[must_use]
pub fn words(fault: BusFault) -> String {
    match fault {
        BusFault::Missing { expected, got } => format!("working counter {got} instead of {expected}"),
        BusFault::NotReady { code, .. } => format!("is in state {code:#x} instead of OP (0x8)"),
        BusFault::Drive { code, .. } => format!("reports error code {code:#06x}"),
        BusFault::Lost | BusFault::Late { .. } | BusFault::Stale { .. } => String::new(),
    }
}
