//! Foxglove's protocol: what is offered, and that the signals in it are those of the machine.

use crate::common::Setup;
use serde_json::{Value, json};
use sinew_live::{Playback, PlaybackParts, Server, ServerSettings};
use std::collections::BTreeMap;
use std::net::TcpStream;
use std::time::Duration;
use tungstenite::Message;
use tungstenite::client::IntoClientRequest;

#[test]
fn a_recording_is_offered_and_its_signals_are_those_of_the_first_cycle() {
    let setup = Setup::new("planar_leg", 1);
    let parts = PlaybackParts {
        machine: setup.machine.clone(),
        trajectory: None,
        path: "there".to_owned(),
        bytes: setup.recorded().0,
        overlays: Vec::new(),
        tension_limits: vec![[1.0, 100.0]; setup.machine.muscles.len()],
    };
    let source = Box::new(Playback::new(parts, |_| {}).unwrap());
    let any = "127.0.0.1:0".parse().unwrap();
    let server = Server::start(ServerSettings { address: any, source, foxglove: Some(any) }).unwrap();
    let address = server.foxglove().unwrap();
    let mut request = format!("ws://{address}/").into_client_request().unwrap();
    request.headers_mut().insert("Sec-WebSocket-Protocol", "foxglove.sdk.v1".parse().unwrap());
    let stream = TcpStream::connect(address).unwrap();
    // A message that never comes fails the test.
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    let (mut socket, _) = tungstenite::client::client(request, stream).unwrap();
    let mut channels = BTreeMap::new();
    while channels.len() < 4 {
        let Message::Text(text) = socket.read().unwrap() else { continue };
        let message: Value = serde_json::from_str(text.as_str()).unwrap();
        for channel in message["channels"].as_array().into_iter().flatten() {
            channels.insert(channel["topic"].as_str().unwrap().to_owned(), channel["id"].clone());
        }
    }
    assert!(channels.keys().eq(["/sinew/bodies", "/sinew/cables", "/sinew/signals", "/tf"]), "{channels:?}");
    let subscriptions: Vec<Value> =
        channels.values().zip(1..).map(|(channel, id)| json!({"id": id, "channelId": channel})).collect();
    let subscribe = json!({"op": "subscribe", "subscriptions": subscriptions}).to_string();
    socket.send(Message::Text(subscribe.into())).unwrap();
    let mut seen: BTreeMap<u32, Vec<u8>> = BTreeMap::new();
    while seen.len() < 4 {
        let Message::Binary(bytes) = socket.read().unwrap() else { continue };
        // Message data: opcode, subscription, time, payload.
        if bytes[0] == 1 {
            let id = u32::from_le_bytes(bytes[1..5].try_into().unwrap());
            seen.insert(id, bytes[13..].to_vec());
        }
    }
    let signals: Value = serde_json::from_slice(&seen[&3]).unwrap();
    assert_eq!((&signals["simulated"], &signals["time_s"]), (&json!(true), &json!(0.0)));
    for (joint, start) in ["hip", "knee"].iter().zip(&setup.machine.start) {
        let shown = signals["joint_true"][joint].as_f64().unwrap();
        assert!((shown - start).abs() < 1e-3, "{joint}: {shown}, {start}");
    }
    assert!(signals["tension_in_n"].as_object().unwrap().len() == setup.machine.muscles.len());
}

#[test]
fn other_computers_are_not_served() {
    let setup = Setup::new("planar_leg", 1);
    let parts = PlaybackParts {
        machine: setup.machine.clone(),
        trajectory: None,
        path: String::new(),
        bytes: setup.recorded().0,
        overlays: Vec::new(),
        tension_limits: Vec::new(),
    };
    let source = Box::new(Playback::new(parts, |_| {}).unwrap());
    let foxglove = Some("0.0.0.0:0".parse().unwrap());
    let server = Server::start(ServerSettings { address: "127.0.0.1:0".parse().unwrap(), source, foxglove });
    let Err(error) = server else { panic!("it is served to everybody") };
    assert!(error.to_string().contains("expected a loopback address"), "{error}");
}
