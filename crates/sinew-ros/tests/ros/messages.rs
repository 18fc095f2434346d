//! What messages say, and what is wrong with them.

use proptest::prelude::*;
use sinew_record::ros2::{Cdr, CdrReader, Level, Messages};
use sinew_record::{Circumstances, Head};
use sinew_ros::{Refusal, Trajectory, reply, request_header, setpoint};

/// `rosbags` 0.11.9, `serialize_cdr` with the types of Jazzy: joints knee and hip, two points, the second
/// with velocities, accelerations and efforts.
const TRAJECTORY: &str = "00010000070000000900000005000000626173650000000002000000050000006b6e65650000000004000000686970000200000002000000000000009a9999999999b93f9a9999999999c9bf000000000000000000000000000000000065cd1d02000000333333333333d33f9a9999999999d93f0200000000000000000000000000f03f000000000000f0bf02000000000000000000000000000000000000000000e03f02000000000000000000000000000040000000000000084001000000fa000000";
/// The same of a `JointState` with names and positions.
const SETPOINT: &str = "0001000005000000060000000100000000000000020000000400000068697000050000006b6e6565000000000200000000000000000000000000d03f000000000000e0bf0000000000000000";
/// The same of a `DiagnosticArray`.
const NOTICE: &str = "000100000100000002000000010000000000000001000000010000001000000073696e65773a20636f6d6d616e647300420000006a6f696e745f7472616a6563746f727920726566757365643a20706f696e74733a206578706563746564206174206c65617374206f6e652c20676f74206e6f6e650000001500000053494d554c4154454420706c616e61725f6c65670000000000000000";

fn octets(text: &str) -> Vec<u8> {
    (0..text.len() / 2).map(|k| u8::from_str_radix(&text[2 * k..2 * k + 2], 16).unwrap()).collect()
}

fn joints() -> Vec<String> {
    ["hip", "knee"].map(str::to_owned).to_vec()
}

const RANGES: [[f64; 2]; 2] = [[-1.0, 1.0], [-2.0, 2.0]];

/// A point: positions, velocities, and the time, s and ns.
pub(crate) type Point<'a> = (&'a [f64], &'a [f64], [i32; 2]);

pub(crate) fn trajectory(stamp: u64, names: &[&str], points: &[Point<'_>]) -> Vec<u8> {
    let mut message = Cdr::new();
    message.header(stamp, "");
    message.texts(names.iter().copied());
    message.length(points.len());
    for (positions, velocities, [seconds, ns]) in points {
        message.f64s(positions);
        message.f64s(velocities);
        message.f64s(&[]);
        message.f64s(&[]);
        // A time has two numbers of 32 bits; those of a negative one are the same octets.
        message.length(seconds.cast_unsigned() as usize);
        message.length(ns.cast_unsigned() as usize);
    }
    message.bytes().to_vec()
}

pub(crate) fn state(names: &[&str], positions: &[f64]) -> Vec<u8> {
    let mut message = Cdr::new();
    message.header(0, "");
    message.texts(names.iter().copied());
    message.f64s(positions);
    message.f64s(&[]);
    message.f64s(&[]);
    message.bytes().to_vec()
}

fn read(bytes: &[u8]) -> Result<Trajectory, Refusal> {
    Trajectory::read(CdrReader::new(bytes).unwrap(), &joints(), &RANGES)
}

#[test]
fn messages_of_another_program_are_read_in_the_order_of_the_machine() {
    let bytes = octets(TRAJECTORY);
    let found = read(&bytes).unwrap();
    let stamp = 7_000_000_009;
    let expected =
        Trajectory { stamp, times: vec![500_000_000, 1_000_000_250], numbers: vec![-0.2, 0.1, 0.4, 0.3] };
    assert_eq!(found, expected);
    assert_eq!(found.point(1), Some((1_000_000_250, &[0.4, 0.3][..])));
    let bytes = octets(SETPOINT);
    let found = setpoint(CdrReader::new(&bytes).unwrap(), &joints(), &RANGES).unwrap();
    assert_eq!(found, [0.25, -0.5]);
}

#[test]
fn a_notice_has_the_octets_of_another_program() {
    let machine = crate::common::machine("planar_leg");
    let circumstances = Circumstances {
        program: String::new(),
        commit: String::new(),
        simulated: true,
        virtual_time: false,
        start_ns: 1_000_000_000,
        period_ns: machine.period_ns(),
    };
    let messages = Messages::new(&machine, Head::new(&machine, circumstances)).unwrap();
    let text = "joint_trajectory refused: points: expected at least one, got none";
    assert_eq!(messages.notice(2, "commands", Level::Warn, text).bytes(), octets(NOTICE));
}

#[test]
fn what_is_wrong_with_a_trajectory_is_named() {
    let both = ["hip", "knee"];
    let fine: Point<'_> = (&[0.1, 0.2], &[], [1, 0]);
    let nan = f64::NAN;
    let cases: [(&[&str], &[Point<'_>], &str); 14] = [
        (&["hip"], &[fine], "joint_names: expected each once: hip, knee, got hip"),
        (&["hip", "hip"], &[fine], "joint_names: expected each once: hip, knee, got hip, hip"),
        (&["hip", "knee", "toe"], &[fine], "got hip, knee, toe"),
        (&[], &[fine], "got none"),
        (&both, &[], "points: expected at least one, got none"),
        (&both, &[(&[0.1], &[], [1, 0])], "points[0].positions: expected 2 numbers, got 1"),
        (&both, &[fine, (&[nan, 0.0], &[], [2, 0])], "points[1].positions of hip: expected -1 to 1, got NaN"),
        (&both, &[(&[0.0, 2.1], &[], [1, 0])], "points[0].positions of knee: expected -2 to 2, got 2.1"),
        (&both, &[(&[0.0, f64::INFINITY], &[], [1, 0])], "of knee: expected -2 to 2, got inf"),
        (&both, &[(&[0.0, 0.0], &[1.0], [1, 0])], "points[0].velocities: expected none or 2 numbers, got 1"),
        (&both, &[(&[0.0, 0.0], &[1.0, nan], [1, 0])], "velocities: expected finite numbers, got NaN"),
        (&both, &[fine, fine], "points[1].time_from_start: expected more than the 1 s of the point before"),
        (&both, &[fine, (&[0.0, 0.0], &[], [0, 999_999_999])], "points[1].time_from_start: expected more"),
        (&both, &[(&[0.0, 0.0], &[], [-1, 0])], "points[0].time_from_start: expected 0 s or more"),
    ];
    for (names, points, expected) in cases {
        let text = read(&trajectory(0, names, points)).unwrap_err().to_string();
        assert!(text.contains(expected), "{text}\n{expected}");
    }
    let set = |names: &[&str], positions: &[f64]| {
        let bytes = state(names, positions);
        setpoint(CdrReader::new(&bytes).unwrap(), &joints(), &RANGES).map_err(|refusal| refusal.to_string())
    };
    assert_eq!(set(&["knee", "hip"], &[0.3, 0.1]).unwrap(), [0.1, 0.3]);
    assert!(set(&both, &[]).unwrap_err().contains("position: expected 2 numbers, got 0"));
    assert!(set(&both, &[1.5, 0.0]).unwrap_err().contains("position of hip: expected -1 to 1, got 1.5"));
}

#[test]
fn a_request_is_answered_as_its_middleware_marks_it() {
    assert_eq!(request_header(&[0]), [0; 0]);
    assert_eq!(request_header(&[0; 16]), [0; 0], "a mark without a request");
    let mark: Vec<u8> = (1..=16).collect();
    let request = [&mark[..], &[0]].concat();
    assert_eq!(request_header(&request), mark);
    let answer = reply(&mark, true, "so");
    let mut answer = CdrReader::of_fields(answer.fields(), true);
    assert!(answer.f64().is_some() && answer.f64().is_some(), "the mark");
    // One byte and three that fill up, then the text.
    assert_eq!((answer.length().map(|x| x & 0xff), answer.text()), (Some(1), Some("so")));
    assert_eq!(reply(&[], false, "").fields(), [0, 0, 0, 0, 1, 0, 0, 0, 0]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn damaged_messages_are_one_refusal_or_within_the_ranges(
        which in any::<bool>(),
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..8),
        cut in any::<prop::sample::Index>(),
    ) {
        let mut bytes = octets(if which { TRAJECTORY } else { SETPOINT });
        for (place, value) in damage {
            let place = place.index(bytes.len());
            bytes[place] = value;
        }
        bytes.truncate(4 + cut.index(bytes.len()));
        let Some(message) = CdrReader::new(&bytes) else { return Ok(()) };
        let found = if which {
            Trajectory::read(message, &joints(), &RANGES).map(|found| {
                assert!(found.times.windows(2).all(|pair| pair[0] < pair[1]));
                found.numbers
            })
        } else {
            setpoint(message, &joints(), &RANGES)
        };
        match found {
            Ok(numbers) => {
                let inside = |(x, [low, high]): (&f64, &[f64; 2])| low <= x && x <= high;
                prop_assert!(numbers.iter().zip(RANGES.iter().cycle()).all(inside));
            }
            Err(refusal) => prop_assert_eq!(refusal.to_string().lines().count(), 1),
        }
    }
}

const BEGIN: &str = "<!-- topics -->\n";
const END: &str = "<!-- end of topics -->\n";

/// Writes the table where `SINEW_ROS_WRITE` is set.
#[test]
fn the_table_of_the_documentation_is_that_of_the_code() {
    let mut table = "| topic | type | | |\n|---|---|---|---|\n".to_owned();
    for row in sinew_ros::TOPICS {
        let ((package, message), way) = (row.kind, if row.is_read { "read" } else { "written" });
        table += &format!("| `/{}` | `{package}/{message}` | {way} | {} |\n", row.name, row.about);
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/ros.md");
    let page = std::fs::read_to_string(path).unwrap();
    let (before, rest) = page.split_once(BEGIN).expect("the mark before the table");
    let (written, after) = rest.split_once(END).expect("the mark after the table");
    if std::env::var_os("SINEW_ROS_WRITE").is_some() {
        std::fs::write(path, format!("{before}{BEGIN}\n{table}\n{END}{after}")).unwrap();
        return;
    }
    assert_eq!(written.trim(), table.trim(), "run this test with SINEW_ROS_WRITE=1");
    for (mode, _) in sinew_ros::MODES {
        assert!(page.contains(&format!("`/sinew/{mode}`")), "{mode}");
    }
}
