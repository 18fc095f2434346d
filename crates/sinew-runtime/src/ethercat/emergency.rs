//! Emergencies among the answers of mailboxes.

/// Header of Ethernet and of EtherCAT, of a datagram, and its working counter, octets.
const FRAME_HEADER: usize = 16;
const DATAGRAM_HEADER: usize = 10;
const COUNTER: usize = 2;
/// Command of a read at a configured station address.
const FPRD: u8 = 4;
/// Bit of a datagram's length field: another one follows.
const MORE: u16 = 1 << 15;
/// Header of a mailbox and of CoE; type of a mailbox and service of CoE, ETG.1000.6.
const MAILBOX_HEADER: usize = 6;
const EMERGENCY_SIZE: u16 = 10;
const COE: u8 = 3;
const EMERGENCY: u8 = 1;

/// Whether a frame that has come back holds an emergency that was read from a mailbox.
///
/// A device may send one between a request and its answer, which is read next. ethercrab 0.7 ends the program
/// where it finds one in place of an answer; where the frame counts as lost, it reads again and finds the
/// answer. What the device has to say is in its state and its error code (object 0x603F), too.
pub(super) fn is_in(frame: &[u8]) -> bool {
    let mut rest = frame.get(FRAME_HEADER..).unwrap_or_default();
    while let Some((header, after)) = rest.split_at_checked(DATAGRAM_HEADER) {
        let length = u16::from_le_bytes([header[6], header[7]]);
        let octets = usize::from(length & 0x07ff);
        let Some((data, after)) = after.split_at_checked(octets + COUNTER) else { return false };
        let (data, counter) = data.split_at(octets);
        if header[0] == FPRD && counter == [1, 0] && is_emergency(data) {
            return true;
        }
        if length & MORE == 0 {
            return false;
        }
        rest = after;
    }
    false
}

fn is_emergency(mailbox: &[u8]) -> bool {
    let Some((header, content)) = mailbox.split_at_checked(MAILBOX_HEADER) else { return false };
    u16::from_le_bytes([header[0], header[1]]) == EMERGENCY_SIZE
        && header[5] & 0x0f == COE
        && content.len() >= usize::from(EMERGENCY_SIZE)
        && content[1] >> 4 == EMERGENCY
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame with one datagram per content, read at station 0x1001.
    fn frame(contents: &[&[u8]]) -> Vec<u8> {
        let mut frame = vec![0; FRAME_HEADER];
        for (k, content) in contents.iter().enumerate() {
            let more = if k + 1 < contents.len() { MORE } else { 0 };
            frame.extend([FPRD, 0, 0x01, 0x10, 0x80, 0x10]);
            frame.extend((content.len() as u16 | more).to_le_bytes());
            frame.extend([0, 0]);
            frame.extend_from_slice(content);
            frame.extend([1, 0]);
        }
        frame
    }

    #[test]
    fn emergencies_are_told_from_answers_and_from_damaged_frames() {
        let mut emergency = [0; 32];
        emergency[..16].copy_from_slice(&[10, 0, 1, 16, 0, 0x13, 0, 0x10, 0x10, 0x32, 4, 1, 2, 3, 4, 5]);
        let mut answer = emergency;
        answer[7] = 0x30;
        assert!(is_in(&frame(&[&emergency])) && is_in(&frame(&[&answer, &emergency])));
        assert!(!is_in(&frame(&[&answer])) && !is_in(&frame(&[&emergency[..12]])));
        let whole = frame(&[&answer, &emergency]);
        assert!((0..whole.len()).all(|length| !is_in(&whole[..length])));
        let mut unread = frame(&[&emergency]);
        let counter = unread.len() - COUNTER;
        unread[counter] = 0;
        assert!(!is_in(&unread));
    }
}
