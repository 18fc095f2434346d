//! Any bytes as a recording: alone, and as blocks and attachments of a file whose container is in order.
//!
//! Checksums stop nearly every change of a file, so the second way computes them anew.
use sinew_record::{Recording, ros2_tracks};

/// Reads `bytes` as a recording in both ways, and as a bag of ROS 2.
pub fn read_recording(bytes: &[u8]) {
    if let Err(error) = ros2_tracks(bytes) {
        assert!(!error.to_string().is_empty());
    }
    check(bytes);
    check(&enveloped(bytes, 1, &[b"/sinew/cycles"]));
    check(&enveloped(bytes, 2, &[b"/sinew/block", b"/sinew/cycle", b"/sinew/slow"]));
}

/// Whatever is accepted has columns of one length.
fn check(bytes: &[u8]) {
    match Recording::read(bytes) {
        Ok(recording) => {
            for block in recording.blocks() {
                match block {
                    Ok(block) => {
                        assert!(block.fast.iter().all(|column| column.len() == block.count));
                        assert_eq!(block.cycle_checks.len(), block.count);
                    }
                    Err(error) => assert!(!error.to_string().is_empty()),
                }
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// The bytes as the messages of a small machine's recording.
fn enveloped(bytes: &[u8], format: u8, topics: &[&[u8]]) -> Vec<u8> {
    let head = format!(
        r#"{{"format":{format},"program":"","commit":"","simulated":false,"virtual_time":true,"start_ns":0,
        "period_ns":1000000,"stride":20,"machine":"m","muscles":["a"],"joints":[{{"name":"j","unit":"rad"}}],
        "fast":[{{"name":"x:a","coding":{{"exact":[{{"scale":0.1}}]}}}},{{"name":"y","coding":{{"rounded":0.5}}}}],
        "slow":[{{"name":"z","coding":{{"rounded":0.5}}}}]}}"#
    );
    let head = head.as_bytes();
    let mut file = Vec::from(*b"\x89MCAP0\r\n");
    let mut attachment = vec![0; 16];
    text(&mut attachment, b"head.json");
    text(&mut attachment, b"application/json");
    attachment.extend((head.len() as u64).to_le_bytes());
    attachment.extend(head);
    attachment.extend(0_u32.to_le_bytes());
    record(&mut file, 0x09, &attachment);
    let mut records = Vec::new();
    // Parts of the bytes, split where they say.
    let mut rest = bytes;
    for (id, topic) in (1..).zip(topics) {
        let mut channel = vec![id, 0, 0, 0];
        text(&mut channel, topic);
        text(&mut channel, b"protobuf");
        channel.extend(0_u32.to_le_bytes());
        record(&mut records, 0x04, &channel);
        let last = usize::from(id) == topics.len();
        let length = if last { rest.len() } else { rest.split_off_first().map_or(0, |n| usize::from(*n)) };
        let (part, others) = rest.split_at(length.min(rest.len()));
        rest = others;
        let mut message = vec![id, 0];
        message.extend([0; 20]);
        message.extend(part);
        record(&mut records, 0x05, &message);
    }
    let mut chunk = vec![0; 16];
    chunk.extend((records.len() as u64).to_le_bytes());
    chunk.extend(0_u32.to_le_bytes());
    text(&mut chunk, b"");
    chunk.extend((records.len() as u64).to_le_bytes());
    chunk.extend(records);
    record(&mut file, 0x06, &chunk);
    file
}

fn text(to: &mut Vec<u8>, text: &[u8]) {
    to.extend((text.len() as u32).to_le_bytes());
    to.extend(text);
}

fn record(to: &mut Vec<u8>, opcode: u8, body: &[u8]) {
    to.push(opcode);
    to.extend((body.len() as u64).to_le_bytes());
    to.extend(body);
}
