//! `std_srvs/Trigger` as the middlewares of ROS 2 put it on topics.

use sinew_record::ros2::Cdr;

/// Bytes with which CycloneDDS' middleware marks a request, and its answer: the client and a number. That of
/// Fast DDS has none, and marks beside the message.
const HEADER: usize = 16;

/// The mark of a request, empty where there is none: a request has one byte beside it.
#[must_use]
pub fn request_header(fields: &[u8]) -> &[u8] {
    match fields.split_at_checked(HEADER) {
        Some((header, [_, ..])) => header,
        _ => &[],
    }
}

/// `std_srvs/Trigger_Response` behind the mark of its request.
#[must_use]
pub fn reply(header: &[u8], success: bool, text: &str) -> Cdr {
    let mut message = Cdr::new();
    header.iter().for_each(|octet| message.u8(*octet));
    message.u8(u8::from(success));
    message.text(text);
    message
}
