//! Packets of known content, byte by byte: they change with the version of the protocol alone.

use sinew_link::client::Greeting;
use sinew_link::host::{Domain, SessionSettings, Sessions};
use sinew_link::wire::Datagram;
use sinew_link::{Command, JointState, Key, Mode, Request, SetpointKind, Setpoints, Snapshot};

/// Writes the packets where `SINEW_LINK_WRITE` is set.
#[test]
fn packets_of_known_content_have_the_recorded_bytes() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden");
    for (name, bytes) in packets() {
        let path = format!("{folder}/{name}.hex");
        let lines: Vec<String> = bytes.chunks(32).map(hex).collect();
        let text = lines.join("\n") + "\n";
        if std::env::var_os("SINEW_LINK_WRITE").is_some() {
            std::fs::write(&path, text).unwrap();
        } else {
            assert_eq!(text, std::fs::read_to_string(&path).unwrap(), "{name}");
        }
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// One packet of every kind, in a session with key and random numbers that count up.
fn packets() -> Vec<(&'static str, Vec<u8>)> {
    let key = Key::new(std::array::from_fn(|k| k as u8));
    let domain = Domain {
        name: "golden".into(),
        joint: vec![[-2.0, 2.0]; 2],
        tension: vec![[0.0, 400.0]; 3],
        end_point: Some([[-1.0, 1.0]; 3]),
        ..Domain::default()
    };
    let random = Box::new(|nonce: &mut [u8; 16]| {
        *nonce = std::array::from_fn(|k| 0x60 + k as u8);
        true
    });
    let mut host = Sessions::new(&key, domain, SessionSettings::default(), random).unwrap();
    let client: std::net::SocketAddr = "127.0.0.1:9".parse().unwrap();
    let greeting = Greeting::new(&key, std::array::from_fn(|k| 0x40 + k as u8));
    let [mut datagram, mut reply] = [Datagram::default(), Datagram::default()];
    let hello = greeting.hello(1000, &mut datagram).to_vec();
    host.receive(&hello, client, 2000, &mut reply, |_, _| true);
    let welcome = reply.bytes().to_vec();
    let mut session = greeting.answer(&welcome).unwrap().unwrap();

    let mut setpoints = Setpoints::new(SetpointKind::Joint, 2);
    assert!(setpoints.push(5_000_000, &[0.5, -0.25]) && setpoints.push(7_000_000, &[0.625, -0.125]));
    let command = Command { request: Request::Run, advance_to_ns: 0, setpoints };
    let command = session.command(&command, 3000, &mut datagram).to_vec();
    host.receive(&command, client, 4000, &mut reply, |_, _| true);

    let mut snapshot = Snapshot::new(2, 3);
    (snapshot.machine_time_ns, snapshot.cycle, snapshot.mode) = (4_000_000, 4, Mode::Run);
    (snapshot.request, snapshot.setpoint, snapshot.queued) = (Request::Run, SetpointKind::Joint, 2);
    snapshot.end_point = [0.1, 0.2, 0.3];
    for (k, joint) in snapshot.joints_mut().iter_mut().enumerate() {
        *joint = JointState { joint_estimated: 0.5 + k as f64, joint_velocity: -0.5, joint_reference: 0.75 };
    }
    for (k, muscle) in snapshot.muscles_mut().iter_mut().enumerate() {
        let known = [40.0 + k as f64, 20.0, 0.015625, -0.5].into_iter().chain(std::iter::repeat(1.5));
        muscle.numbers_mut().into_iter().zip(known).for_each(|(number, known)| *number = known);
    }
    host.state(&snapshot, &mut Some([0, 0]), 5000, &mut datagram).unwrap();
    let state = datagram.bytes().to_vec();
    let mut other = [0; 16];
    other[0] = 1;
    let other = Greeting::new(&key, other).hello(0, &mut datagram).to_vec();
    host.receive(&other, client, 6000, &mut reply, |_, _| true);
    let refused = reply.bytes().to_vec();
    let goodbye = session.goodbye(6000, &mut datagram).to_vec();
    let watching = Greeting::new(&key, [2; 16]).watching();
    let watcher_hello = watching.hello(7000, &mut datagram).to_vec();
    host.receive(&watcher_hello, client, 8000, &mut reply, |_, _| true);
    let mut watcher = watching.answer(reply.bytes()).unwrap().unwrap();
    let watch = watcher.watch(9000, &mut datagram).to_vec();
    vec![
        ("1_hello", hello),
        ("2_welcome", welcome),
        ("3_refused", refused),
        ("4_command", command),
        ("5_state", state),
        ("6_goodbye", goodbye),
        ("7_watch", watch),
        ("7_watch_hello", watcher_hello),
    ]
}
