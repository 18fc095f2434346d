//! The server over loopback: what viewers get, what they may ask for, and who is refused.

use serde_json::{Value, json};
use sinew::body::Poses;
use sinew::control::arm::resting_tensions;
use sinew::control::supervisor::{Limits, Mode, Supervisor};
use sinew::machine::Machine;
use sinew::twin::arm::{ArmSpecimen, ArmTwin, Failure};
use sinew_lab::arm::{designed_controller, plan_tour};
use sinew_live::{
    Choices, Command, Conditions, Server, ServerSettings, SimulationParts, SimulationSource, Source, Stage,
};
use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::sync::Arc;
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

/// Machines of a design, on tours.
struct Designs {
    machine: Machine,
}

impl SimulationSource for Designs {
    fn choices(&self) -> Choices {
        let tension_limits = vec![[1.0, 100.0]; self.machine.muscles.len()];
        Choices {
            paths: vec!["tour".to_owned()],
            variants: vec!["observer".to_owned()],
            tension_limits,
            failures: vec![("cable:{}", "cable breaks")],
        }
    }

    fn prepare(&mut self, conditions: &Conditions) -> Result<SimulationParts, String> {
        if conditions.path != "tour" {
            return Err(format!("there is no path `{}`", conditions.path));
        }
        let machine = self.machine.clone();
        let trajectory = plan_tour(&machine, Some(14.0), |_| Ok(None)).unwrap();
        let controller = designed_controller(&machine, &trajectory, None).unwrap();
        let limits = controller.gains().tension_limits();
        let start = trajectory.first().unwrap();
        let tensions = resting_tensions(&machine.robot, &start, &limits).unwrap();
        let specimen = ArmSpecimen::nominal(&machine).unwrap();
        let plant = ArmTwin::new(&specimen, &start, &tensions, 1).unwrap();
        let limits = Limits::from_machine(&machine, controller.gains()).unwrap();
        let supervisor = Supervisor::new(controller, limits).unwrap();
        Ok(SimulationParts { machine, plant, supervisor, trajectory: Arc::new(trajectory) })
    }

    fn failure(&self, text: &str) -> Result<(Failure, f64), String> {
        if text == "cable:0" {
            Ok((Failure::Cable(0), f64::INFINITY))
        } else {
            Err(format!("no fault `{text}`"))
        }
    }
}

fn stage(name: &str) -> Stage {
    let machine = sinew_lab::machine_file::load_machine(Path::new(name), None).unwrap().machine;
    let conditions = Conditions { path: "tour".to_owned(), variant: "observer".to_owned(), payload: 0.0 };
    let mut source = Box::new(Designs { machine });
    let parts = source.prepare(&conditions).unwrap();
    Stage::new(source, conditions, parts).unwrap()
}

fn server(name: &str) -> Server {
    Server::start(ServerSettings {
        address: "127.0.0.1:0".parse().unwrap(),
        source: Box::new(stage(name)),
        foxglove: None,
    })
    .unwrap()
}

/// Status and body of a request with these lines in its head.
fn request(address: SocketAddr, path: &str, head: &str) -> (u16, String) {
    let mut stream = TcpStream::connect(address).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\n{head}Connection: close\r\n\r\n").unwrap();
    let mut text = Vec::new();
    stream.read_to_end(&mut text).unwrap();
    let text = String::from_utf8_lossy(&text).into_owned();
    let status = text.split(' ').nth(1).unwrap().parse().unwrap();
    (status, text.split_once("\r\n\r\n").unwrap().1.to_owned())
}

fn own(address: SocketAddr) -> String {
    format!("Host: {address}\r\n")
}

fn scene(address: SocketAddr) -> Value {
    let (status, body) = request(address, "/scene", &own(address));
    assert_eq!(status, 200);
    serde_json::from_str(&body).unwrap()
}

/// One viewer.
struct Viewer {
    socket: WebSocket<TcpStream>,
    layout: Value,
}

impl Viewer {
    fn new(address: SocketAddr) -> Self {
        let stream = TcpStream::connect(address).unwrap();
        let mut request = format!("ws://{address}/stream").into_client_request().unwrap();
        request.headers_mut().insert("Sec-WebSocket-Protocol", "sinew.live.1".parse().unwrap());
        let (socket, _) = tungstenite::client::client(request, stream).unwrap();
        Self { socket, layout: scene(address)["layout"].clone() }
    }

    /// Kind and body of the next message.
    fn next(&mut self) -> (u16, Vec<u8>) {
        loop {
            if let Message::Binary(bytes) = self.socket.read().unwrap() {
                assert_eq!(&bytes[..4], b"SNLV");
                assert_eq!(u16::from_le_bytes([bytes[4], bytes[5]]), 1);
                let length = u32::from_le_bytes(bytes[8..12].try_into().unwrap()) as usize;
                assert_eq!(bytes.len(), 16 + length);
                return (u16::from_le_bytes([bytes[6], bytes[7]]), bytes[16..].to_vec());
            }
        }
    }

    fn state(&mut self) -> Vec<u8> {
        loop {
            let (kind, body) = self.next();
            if kind == 1 {
                return body;
            }
        }
    }

    /// Numbers of a field of a state.
    fn field(&self, state: &[u8], name: &str) -> Vec<f64> {
        let mut at = 0;
        for field in self.layout.as_array().unwrap() {
            let bytes = match field["type"].as_str().unwrap() {
                "u8" => 1,
                "u16" => 2,
                "f32" => 4,
                _ => 8,
            };
            let count = field["count"].as_u64().unwrap() as usize;
            if field["name"] == name {
                let number = |k: usize| {
                    let part = &state[at + k * bytes..][..bytes];
                    match bytes {
                        1 => f64::from(part[0]),
                        2 => f64::from(u16::from_le_bytes(part.try_into().unwrap())),
                        4 => f64::from(f32::from_le_bytes(part.try_into().unwrap())),
                        _ => f64::from_le_bytes(part.try_into().unwrap()),
                    }
                };
                return (0..count).map(number).collect();
            }
            at += bytes * count;
        }
        panic!("no field {name}");
    }

    /// The answer to a command.
    fn ask(&mut self, command: &Value) -> Value {
        self.socket.send(Message::Text(command.to_string().into())).unwrap();
        loop {
            let (kind, body) = self.next();
            if kind == 4 {
                return serde_json::from_slice(&body).unwrap();
            }
        }
    }

    /// States until one that fits, in at most so many.
    fn until(&mut self, most: usize, fits: impl Fn(&Self, &[u8]) -> bool) -> Vec<u8> {
        for _ in 0..most {
            let state = self.state();
            if fits(self, &state) {
                return state;
            }
        }
        panic!("no such state in {most}");
    }
}

#[test]
fn the_poses_of_a_state_are_those_of_the_machine_in_it() {
    for name in ["planar_leg", "surgical_wrist"] {
        let server = server(name);
        let mut viewer = Viewer::new(server.address());
        let machine = sinew_lab::machine_file::load_machine(Path::new(name), None).unwrap().machine;
        let mut poses = Poses::new(&machine.robot);
        let state = viewer.until(600, |viewer, state| viewer.field(state, "time_s")[0] > 0.2);
        let q = machine.robot.pose_from_independent(&viewer.field(&state, "joint_true")).unwrap();
        machine.robot.forward_kinematics(&q, &mut poses).unwrap();
        let shown = viewer.field(&state, "body_pose");
        for body in 0..machine.robot.parts().bodies.len() {
            let origin = machine.robot.body_pose(&poses, body).origin;
            for (a, b) in origin.iter().zip(&shown[7 * body..]) {
                assert!((a - b).abs() < 1e-6, "{name}, body {body}: {a} {b}");
            }
        }
        let near = viewer.field(&state, "tension_in_n");
        let along = viewer.field(&state, "cable_tension");
        let points = along.len() / near.len();
        let far = viewer.field(&state, "tension_out_n");
        for (muscle, far) in far.iter().enumerate() {
            let [first, last] = [along[muscle * points], along[(muscle + 1) * points - 1]];
            assert!(first > 0.0 && (last - far).abs() < 1e-4 * far, "{name} {muscle}: {first} {last} {far}");
        }
    }
}

#[test]
fn a_stop_counts_from_the_next_cycle_on_and_wrong_commands_are_refused_in_words() {
    let server = server("planar_leg");
    let mut viewer = Viewer::new(server.address());
    let mode = |viewer: &Viewer, state: &[u8]| viewer.field(state, "mode")[0] as u8;
    viewer.until(600, |viewer, state| mode(viewer, state) == Mode::Run as u8);
    // Time stands: what follows is on the machine's clock.
    assert_eq!(viewer.ask(&json!({"id": 1, "command": "speed", "factor": 1, "paused": true}))["ok"], true);
    let paused = viewer.until(60, |viewer, state| viewer.field(state, "flags")[0] as u16 & 1 == 1);
    let before = viewer.field(&paused, "time_s")[0];
    let answer = viewer.ask(&json!({"id": 2, "command": "mode", "request": "safe_stop"}));
    assert_eq!(answer, json!({"id": 2, "ok": true, "error": null}));
    viewer.ask(&json!({"id": 3, "command": "step", "cycles": 2}));
    let stopped = viewer.until(60, |viewer, state| mode(viewer, state) == Mode::SafeStop as u8);
    assert!(viewer.field(&stopped, "time_s")[0] - before < 0.0201);
    for (command, words) in [
        (json!({"id": 4, "command": "mode", "request": "fly"}), "expected one of"),
        (json!({"id": 5, "command": "path", "name": "moon"}), "no path `moon`"),
        (json!({"id": 6, "command": "fault", "fault": "cable:9"}), "no fault"),
        (
            json!({"id": 7, "command": "push", "body": 99, "point": [0, 0, 0], "force_n": [1, 0, 0], "duration_s": 0.1}),
            "body is 99",
        ),
        (json!({"id": 8}), "command is null"),
    ] {
        let answer = viewer.ask(&command);
        assert_eq!((&answer["id"], &answer["ok"]), (&command["id"], &json!(false)), "{answer}");
        assert!(answer["error"].as_str().unwrap().contains(words), "{answer}");
    }
    for text in ["", "[1,2", "nul", "\u{0}", "{\"id\":1e99}"] {
        viewer.socket.send(Message::Text(text.into())).unwrap();
    }
    viewer.socket.send(Message::Binary(vec![1, 2, 3].into())).unwrap();
    assert!(viewer.state().len() > 100);
}

#[test]
fn a_dragged_end_point_moves_there_and_the_path_is_taken_up_again() {
    let mut stage = stage("planar_leg");
    let run = |stage: &mut Stage, cycles: u32| stage.command(&Command::Step(cycles)).unwrap();
    run(&mut stage, 400);
    assert_eq!(stage.simulation().mode(), Mode::Run);
    let end = |stage: &Stage| {
        let machine = stage.simulation().machine();
        let mut poses = Poses::new(&machine.robot);
        machine.robot.forward_kinematics(stage.simulation().plant().truth().q, &mut poses).unwrap();
        machine.robot.site_pose(&poses, machine.task.site().unwrap()).origin
    };
    let mut target = end(&stage);
    target[2] += 0.03;
    stage.command(&Command::Drag(target)).unwrap();
    for _ in 0..4 {
        run(&mut stage, 1000);
    }
    let reached = end(&stage);
    let distance = reached.iter().zip(&target).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    assert!(distance < 5e-3, "{distance}: {reached:?} {target:?}");
    stage.command(&Command::DragEnd).unwrap();
    stage.command(&Command::Mode(sinew::control::supervisor::Request::Run)).unwrap();
    for _ in 0..6 {
        run(&mut stage, 1000);
    }
    assert_eq!(stage.simulation().mode(), Mode::Run);
}

#[test]
fn a_drag_does_not_undo_a_stop() {
    use sinew::control::supervisor::Request;
    let mut stage = stage("planar_leg");
    stage.command(&Command::Step(400)).unwrap();
    stage.command(&Command::Mode(Request::SafeStop)).unwrap();
    stage.command(&Command::Drag([0.1, 0.0, 0.0])).unwrap();
    for _ in 0..10 {
        stage.command(&Command::Step(500)).unwrap();
        assert!(
            matches!(stage.simulation().mode(), Mode::SafeStop | Mode::Ready),
            "{:?}",
            stage.simulation().mode()
        );
    }
}

#[test]
fn a_broken_cable_stops_the_machine() {
    let mut stage = stage("planar_leg");
    stage.command(&Command::Step(300)).unwrap();
    stage.command(&Command::Fault("cable:0".to_owned())).unwrap();
    stage.command(&Command::Step(1500)).unwrap();
    assert!(
        matches!(stage.simulation().mode(), Mode::SafeStop | Mode::Fault),
        "{:?}",
        stage.simulation().mode()
    );
}

#[test]
fn time_that_is_paused_without_a_factor_goes_on_as_fast_as_before() {
    let mut stage = stage("bench_joint");
    let speed = |factor, paused| Command::Speed { factor, paused };
    for command in [speed(Some(0.1), None), speed(None, Some(true)), speed(None, Some(false))] {
        stage.command(&command).unwrap();
    }
    stage.advance(1.0, &mut || false).unwrap();
    assert!((stage.simulation().time() - 0.1).abs() < 2e-3, "{}", stage.simulation().time());
}

#[test]
fn a_failure_for_good_is_held_once_and_a_refused_push_changes_nothing() {
    let mut stage = stage("planar_leg");
    stage.command(&Command::Step(100)).unwrap();
    for _ in 0..300 {
        stage.command(&Command::Fault("cable:0".to_owned())).unwrap();
    }
    assert_eq!(stage.simulation().faults().len(), 1);
    let push =
        |body, duration| Command::Push { body, point: [0.0, 0.0, -0.1], force: [30.0, 20.0, 10.0], duration };
    let fixed = stage.command(&push(1, 0.02)).unwrap_err();
    assert!(fixed.contains("moves no joint"), "{fixed}");
    let machine = stage.simulation().machine();
    let moved = machine.robot.parts().sites[machine.task.site().unwrap()].body;
    assert!(stage.command(&push(moved, f64::NAN)).is_err());
    assert_eq!(stage.simulation().faults().len(), 1);
    stage.command(&push(moved, 0.02)).unwrap();
    assert!(stage.simulation().faults().len() > 1);
    // What is over needs no place.
    stage.command(&Command::Step(100)).unwrap();
    stage.command(&Command::Fault("cable:0".to_owned())).unwrap();
    assert_eq!(stage.simulation().faults().len(), 1);
}

#[test]
fn eight_viewers_see_the_same_states() {
    let server = server("bench_joint");
    let mut viewers: Vec<Viewer> = (0..8).map(|_| Viewer::new(server.address())).collect();
    let mut seen: BTreeMap<u64, (Vec<u8>, usize)> = BTreeMap::new();
    for _ in 0..30 {
        for viewer in &mut viewers {
            let state = viewer.state();
            let sequence = viewer.field(&state, "sequence")[0] as u64;
            let (first, times) = seen.entry(sequence).or_insert_with(|| (state.clone(), 0));
            assert_eq!(*first, state, "state {sequence}");
            *times += 1;
        }
    }
    assert!(seen.values().filter(|(_, times)| *times == viewers.len()).count() >= 10, "{}", seen.len());
}

#[test]
fn requests_by_other_names_and_from_other_pages_are_refused() {
    let server = server("bench_joint");
    let address = server.address();
    let status = |path: &str, head: &str| request(address, path, head).0;
    assert_eq!(status("/", &own(address)), 200);
    assert_eq!(status("/assets/live/main.js", &own(address)), 200);
    assert_eq!(status("/assets/../Cargo.toml", &own(address)), 404);
    assert_eq!(status("/nothing", &own(address)), 404);
    let foreign = format!("Host: evil.example:{}\r\n", address.port());
    let origin = format!("{}Origin: http://evil.example\r\n", own(address));
    for path in ["/", "/scene", "/stream", "/assets/live/main.js"] {
        assert_eq!(status(path, &foreign), 403, "{path}");
        assert_eq!(status(path, &origin), 403, "{path}");
    }
}

#[test]
fn off_loopback_scene_history_and_stream_need_the_token() {
    let source = Box::new(stage("bench_joint"));
    let server =
        Server::start(ServerSettings { address: "0.0.0.0:0".parse().unwrap(), source, foxglove: None })
            .unwrap();
    let (url, port) = (server.url(), server.address().port());
    let address: SocketAddr = format!("127.0.0.1:{port}").parse().unwrap();
    let token = url.strip_prefix(&format!("http://{address}/#token=")).unwrap().to_owned();
    assert_eq!(token.len(), 32, "{url}");
    let status = |path: &str, more: &str| request(address, path, &format!("{}{more}", own(address))).0;
    assert_eq!(status("/", ""), 200, "the page itself holds no secret");
    let wrong = format!("Authorization: Bearer {}\r\n", "0".repeat(32));
    let right = format!("Authorization: Bearer {token}\r\n");
    for path in ["/scene", "/history"] {
        assert_eq!((status(path, ""), status(path, &wrong)), (401, 401), "{path}");
    }
    assert_eq!((status("/scene", &right), status("/history", &right)), (200, 204));
    let open = |protocol: &str| {
        let stream = TcpStream::connect(address).unwrap();
        let mut request = format!("ws://{address}/stream").into_client_request().unwrap();
        request.headers_mut().insert("Sec-WebSocket-Protocol", protocol.parse().unwrap());
        tungstenite::client::client(request, stream).is_ok()
    };
    assert!(!open("sinew.live.1") && !open(&format!("sinew.live.1, token.{}", "0".repeat(32))));
    assert!(open(&format!("sinew.live.1, token.{token}")));
}

#[test]
fn no_more_pages_are_served_than_there_are_places() {
    let server = server("bench_joint");
    let open = || {
        let stream = TcpStream::connect(server.address()).unwrap();
        let mut request = format!("ws://{}/stream", server.address()).into_client_request().unwrap();
        request.headers_mut().insert("Sec-WebSocket-Protocol", "sinew.live.1".parse().unwrap());
        tungstenite::client::client(request, stream).map(|(socket, _)| socket).ok()
    };
    let mut viewers: Vec<_> = (0..40).filter_map(|_| open()).collect();
    assert_eq!(viewers.len(), 32);
    // Places are given back.
    viewers.truncate(30);
    let again = (0..200).any(|_| {
        std::thread::sleep(std::time::Duration::from_millis(20));
        open().is_some()
    });
    assert!(again);
}

#[test]
fn a_port_in_use_is_said() {
    let server = server("bench_joint");
    let second = Server::start(ServerSettings {
        address: server.address(),
        source: Box::new(stage("bench_joint")),
        foxglove: None,
    });
    let Err(error) = second else { panic!("both listen on one port") };
    assert!(error.to_string().contains(&server.address().to_string()), "{error}");
}

/// Numbers that repeat for a seed.
struct Draws(u64);

impl Draws {
    fn next(&mut self, below: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % below
    }

    fn number(&mut self, most: f64) -> f64 {
        most * (self.next(2001) as f64 / 1000.0 - 1.0)
    }
}

#[test]
fn whatever_is_commanded_in_whatever_order_a_machine_can_be_drawn() {
    use sinew::control::supervisor::Request;
    for (seed, name) in
        ["planar_leg", "finger", "surgical_wrist", "exosuit_elbow", "bench_joint"].iter().enumerate()
    {
        let (mut stage, mut draws) = (stage(name), Draws(seed as u64 + 1));
        let parts = stage.simulation().machine().robot.parts().clone();
        for _ in 0..80 {
            let muscle = &parts.tendons[draws.next(parts.tendons.len())].name;
            let command = match draws.next(10) {
                0..=2 => Command::Mode(Request::ALL[1 + draws.next(Request::ALL.len() - 1)]),
                3 => Command::Drag([0; 3].map(|_| draws.number(2.0))),
                4 => Command::DragEnd,
                5 => Command::Push {
                    body: draws.next(parts.bodies.len() + 2),
                    point: [0; 3].map(|_| draws.number(0.5)),
                    force: [0; 3].map(|_| draws.number(100.0)),
                    duration: 0.1,
                },
                6 => Command::Fault(if draws.next(2) == 0 { "cable:0".to_owned() } else { muscle.clone() }),
                7 => Command::Path(if draws.next(2) == 0 { "tour".to_owned() } else { "nowhere".to_owned() }),
                8 => Command::Seek(draws.number(1.0).abs()),
                _ => Command::Speed { factor: Some(0.5), paused: Some(draws.next(2) == 0) },
            };
            if let Err(reason) = stage.command(&command) {
                assert!(!reason.is_empty(), "{name}: {command:?}");
            }
            stage.command(&Command::Step(1 + draws.next(60) as u32)).unwrap();
            let scene = stage.scene().unwrap();
            let bytes = stage.state().unwrap();
            let before: usize = scene["layout"]
                .as_array()
                .unwrap()
                .iter()
                .take_while(|field| field["name"] != "body_pose")
                .map(|field| match field["type"].as_str().unwrap() {
                    "u8" => 1,
                    "u16" => 2,
                    _ => 8,
                } * field["count"].as_u64().unwrap() as usize)
                .sum();
            let poses = &bytes[16 + before..][..28 * parts.bodies.len()];
            let finite = poses.chunks_exact(4).all(|x| f32::from_le_bytes(x.try_into().unwrap()).is_finite());
            assert!(finite, "{name} after {command:?}");
        }
    }
}
