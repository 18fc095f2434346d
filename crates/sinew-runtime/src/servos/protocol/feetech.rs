//! Packets of Feetech servos, which are those of Dynamixel protocol 1.0.
//!
//! ```text
//! ff ff | id | length | instruction, of an answer its error | parameters | checksum
//! ```
//!
//! The length counts from the instruction on; the checksum is the inverted sum of all octets behind the
//! header. Addresses have one octet. Source: Feetech's protocol handbook and its SDK.

const HEADER: [u8; 2] = [0xff; 2];
/// Header, identifier and length.
const HEAD: usize = 4;

pub(super) fn encode(out: &mut Vec<u8>, id: u8, instruction: u8, parts: &[&[u8]]) {
    let start = out.len();
    let length = 2 + parts.iter().map(|part| part.len()).sum::<usize>();
    out.extend(HEADER);
    out.extend([id, u8::try_from(length).unwrap_or(u8::MAX), instruction]);
    parts.iter().for_each(|part| out.extend(*part));
    out.push(checksum(&out[start + HEADER.len()..]));
}

fn checksum(octets: &[u8]) -> u8 {
    !octets.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet))
}

/// The next packet behind `start`, which is moved behind it: identifier, instruction or error, and where its
/// parameters are; none until it is complete.
pub(super) fn next(octets: &[u8], start: &mut usize) -> Option<(u8, u8, [usize; 2])> {
    loop {
        let rest = octets.get(*start..)?;
        let Some(at) = rest.windows(HEADER.len()).position(|octets| octets == HEADER) else {
            // The last one may be the beginning of a header.
            *start += rest.len().saturating_sub(HEADER.len() - 1);
            return None;
        };
        *start += at;
        let [_, _, id, length] = *octets.get(*start..)?.first_chunk()?;
        let end = *start + HEAD + usize::from(length);
        if id != 0xff && length >= 2 {
            let (given, packet) = octets.get(*start + HEADER.len()..end)?.split_last()?;
            if *given == checksum(packet) {
                let from = *start + HEAD;
                *start = end;
                return Some((id, octets[from], [from + 1, end - 1]));
            }
        }
        *start += 1;
    }
}
