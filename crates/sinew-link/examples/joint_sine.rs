//! Moves the first joint of a machine a little, once around a sine, and prints what came back:
//! `cargo run -p sinew-link --example joint_sine -- 127.0.0.1:7500 2.0 [KEY FILE]`.
#![allow(clippy::print_stdout, reason = "an example prints")]

use sinew_link::client::Client;
use sinew_link::{Command, Key, Request, SetpointKind, Setpoints};
use std::path::Path;
use std::time::{Duration, Instant};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [address, seconds, rest @ ..] = &arguments[..] else {
        return Err("usage: joint_sine ADDRESS:PORT SECONDS [KEY FILE]".into());
    };
    let key = rest.first().map(|file| Key::read(Path::new(file))).transpose()?;
    let seconds: f64 = seconds.parse()?;
    let second = Duration::from_secs(1);
    let mut client = Client::connect(address.parse()?, key.as_ref(), 5 * second)?;
    client.send(&Command::from_request(Request::Hold))?;
    let start: Vec<f64> =
        client.receive(second)?.joints().iter().map(|joint| joint.joint_reference).collect();
    let begin = Instant::now();
    while begin.elapsed().as_secs_f64() < seconds {
        let phase = std::f64::consts::TAU * begin.elapsed().as_secs_f64() / seconds;
        let mut desired = start.clone();
        desired[0] += 0.05 * phase.sin();
        let mut setpoints = Setpoints::new(SetpointKind::Joint, desired.len());
        setpoints.push(0, &desired);
        client.send(&Command { request: Request::Run, advance_to_ns: 0, setpoints })?;
        client.receive(second)?; // states come 500 times a second
    }
    let (session, state) = (client.session(), client.session().state());
    println!("{:?}: {:.4} rad or m", state.mode, state.joints()[0].joint_estimated);
    println!("{} of ours lost, {} of theirs", session.counts().lost, session.peer().lost());
    println!("{:?}", session.peer().round_trip());
    client.close()?;
    Ok(())
}
