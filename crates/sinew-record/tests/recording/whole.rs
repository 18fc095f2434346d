//! What is recorded comes back.

use crate::common::Setup;
use sinew_record::Recording;

#[test]
fn every_reading_comes_back_to_the_bit() {
    let setup = Setup::new("planar_leg", 1);
    let (bytes, seen) = setup.recorded();
    let recording = Recording::read(&bytes).unwrap();
    assert!(recording.complete && recording.cut_off == 0);
    assert_eq!(recording.text("note.txt").unwrap(), "beside the cycles");
    let column = |name: &str| recording.head.fast.iter().position(|column| column.name == name).unwrap();
    let (muscles, joints) = (&recording.head.muscles, &recording.head.joints);
    let mut cycle = 0;
    for block in recording.blocks() {
        let block = block.unwrap();
        assert_eq!(block.first as usize, cycle);
        for row in 0..block.count {
            let bits = |names: Vec<String>| -> Vec<u64> {
                names.iter().map(|name| block.fast[column(name)][row].to_bits()).collect()
            };
            let of = |what: &str| muscles.iter().map(|name| format!("{what}:{name}")).collect();
            let found = &seen[cycle];
            assert_eq!(bits(of("position_in_m")), found.position, "cycle {cycle}");
            assert_eq!(bits(of("tension_in_n")), found.tension, "cycle {cycle}");
            let of_joints =
                joints.iter().map(|joint| format!("joint_{}:{}", joint.unit, joint.name)).collect();
            assert_eq!(bits(of_joints), found.joint, "cycle {cycle}");
            cycle += 1;
        }
    }
    assert_eq!(cycle, seen.len());
    assert_eq!(seen.len(), 2500);
}

#[test]
fn the_same_run_gives_the_same_bytes() {
    let setup = Setup::new("bench_joint", 3);
    assert_eq!(setup.recorded().0, setup.recorded().0);
}

#[test]
fn readings_take_few_bytes() {
    // Two muscles and a joint: noise of 3 bits in a load cell, encoders of 1 to 3 bits.
    let setup = Setup::new("bench_joint", 1);
    let (bytes, seen) = setup.recorded();
    let recording = Recording::read(&bytes).unwrap();
    let raw = 8 * (recording.head.fast.len() + recording.head.slow.len() / 20) * seen.len();
    let attachments = bytes.len() - bytes.len().min(60_000);
    assert!(attachments < raw / 8, "{} of {raw} bytes", bytes.len());
}

#[test]
fn another_reader_of_the_container_finds_the_same_messages() {
    let setup = Setup::new("bench_joint", 1);
    let (bytes, seen) = setup.recorded();
    let mut counts = std::collections::BTreeMap::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        *counts.entry(message.unwrap().channel.topic.clone()).or_insert(0) += 1;
    }
    assert_eq!(counts["/sinew/block"], seen.len().div_ceil(500));
    assert_eq!(counts["/sinew/cycle"], seen.len());
    assert_eq!(counts["/sinew/slow"], seen.len() / 20);
    assert_eq!(counts["/tf"], seen.len().div_ceil(200));
    assert!(counts["/sinew/log"] >= 2 && counts["/sinew/scene"] >= 2, "{counts:?}");
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    assert_eq!(summary.attachment_indexes.len(), 2);
}
