//! A recording on the page: any time of it, its events, another one over it, and files that are none.

use crate::common::Setup;
use serde_json::Value;
use sinew_live::{Command, Playback, PlaybackParts, Source};
use sinew_record::Recording;

const MACHINES: [&str; 3] = ["planar_leg", "finger", "bench_joint"];

fn parts(setup: &Setup, bytes: Vec<u8>) -> PlaybackParts {
    PlaybackParts {
        machine: setup.machine.clone(),
        trajectory: Some(setup.trajectory.clone()),
        path: "there".to_owned(),
        bytes,
        overlays: Vec::new(),
        tension_limits: vec![[1.0, 100.0]; setup.machine.muscles.len()],
    }
}

fn playback(setup: &Setup, bytes: Vec<u8>) -> Playback {
    Playback::new(parts(setup, bytes), |_| {}).unwrap()
}

/// Numbers of a field of the fields that `keep` keeps, packed.
fn field(layout: &Value, body: &[u8], name: &str, keep: impl Fn(&str) -> bool) -> Vec<f64> {
    let mut at = 0;
    for field in layout.as_array().unwrap() {
        let (bytes, count) = (
            match field["type"].as_str().unwrap() {
                "u8" => 1,
                "u16" => 2,
                "f32" => 4,
                _ => 8,
            },
            field["count"].as_u64().unwrap() as usize,
        );
        if !keep(field["name"].as_str().unwrap()) {
            continue;
        }
        if field["name"] == name {
            let number = |k: usize| {
                let part = &body[at + k * bytes..][..bytes];
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

fn shown(playback: &mut Playback, name: &str) -> Vec<f64> {
    let layout = playback.scene().unwrap()["layout"].clone();
    let state = playback.state().unwrap();
    field(&layout, &state[16..], name, |_| true)
}

#[test]
fn every_time_of_a_recording_shows_what_was_recorded_then() {
    for name in MACHINES {
        let setup = Setup::new(name, 3);
        let (bytes, _) = setup.recorded();
        let recording = Recording::read(&bytes).unwrap();
        let blocks: Vec<_> = recording.blocks().map(Result::unwrap).collect();
        let column =
            |name: &str| recording.head.fast.iter().position(|spec| spec.name.starts_with(name)).unwrap();
        let slow =
            |name: &str| recording.head.slow.iter().position(|spec| spec.name.starts_with(name)).unwrap();
        let mut playback = playback(&setup, bytes.clone());
        let scene = playback.scene().unwrap();
        assert_eq!((&scene["source"], &scene["simulated"]), (&"recording".into(), &true.into()));
        assert_eq!(scene["fault_kinds"], serde_json::json!([]), "what is recorded cannot fail any more");
        let duration = scene["recording"]["duration_s"].as_f64().unwrap();
        assert!((duration - 2.499).abs() < 1e-9, "{name}: {duration}");
        // Multiples of the stride, in no order, and cycles between them.
        for cycle in [0_usize, 2480, 1000, 1001, 480, 499, 500, 20] {
            playback.command(&Command::Seek(cycle as f64 * 1e-3)).unwrap();
            let block = blocks.iter().rfind(|block| block.first <= cycle as u64).unwrap();
            let row = cycle - block.first as usize;
            for (field, first) in
                [("tension_in_n", column("tension_in_n:")), ("position_in_m", column("position_in_m:"))]
            {
                for (k, value) in shown(&mut playback, field).iter().enumerate() {
                    let recorded: f64 = block.fast[first + k][row];
                    assert_eq!(value.to_bits(), recorded.to_bits(), "{name} {field} {k} at {cycle}");
                }
            }
            if let Some(row) = block.slow_row(row, recording.head.stride) {
                for (field, first) in
                    [("joint_true", slow("joint_true_")), ("tension_out_n", slow("tension_out_n:"))]
                {
                    for (k, value) in shown(&mut playback, field).iter().enumerate() {
                        let recorded: f64 = block.slow[first + k][row];
                        assert!((value - recorded).abs() < 1e-12, "{name} {field} {k} at {cycle}");
                    }
                }
            }
        }
    }
}

#[test]
fn time_passes_stands_and_ends_and_what_was_before_is_told() {
    let setup = Setup::new("planar_leg", 1);
    let mut playback = playback(&setup, setup.recorded().0);
    let time = |playback: &mut Playback| shown(playback, "time_s")[0];
    let pass = |playback: &mut Playback, seconds: f64| playback.advance(seconds, &mut || false).unwrap();
    pass(&mut playback, 1.0);
    assert!(time(&mut playback).abs() < 1e-12, "it waits for somebody to look");
    playback.command(&Command::Speed { factor: Some(0.5), paused: Some(false) }).unwrap();
    pass(&mut playback, 1.0);
    assert!((time(&mut playback) - 0.5).abs() < 1e-12);
    playback.command(&Command::Step(3)).unwrap();
    pass(&mut playback, 1.0);
    assert!((time(&mut playback) - 0.503).abs() < 1e-12);
    // Pause and go on without a factor: it is kept.
    playback.command(&Command::Speed { factor: None, paused: Some(false) }).unwrap();
    pass(&mut playback, 1.0);
    assert!((time(&mut playback) - 1.003).abs() < 1e-12);
    pass(&mut playback, 100.0);
    assert!((time(&mut playback) - 2.499).abs() < 1e-12);
    let layout = playback.scene().unwrap()["layout"].clone();
    let history = playback.history().unwrap().unwrap();
    let plotted =
        |name: &str| !["body_pose", "reference_pose", "cable_"].iter().any(|start| name.starts_with(start));
    let bytes: usize = layout
        .as_array()
        .unwrap()
        .iter()
        .filter(|field| plotted(field["name"].as_str().unwrap()))
        .map(|field| {
            let bytes = match field["type"].as_str().unwrap() {
                "u8" => 1,
                "u16" => 2,
                "f32" => 4,
                _ => 8,
            };
            bytes * field["count"].as_u64().unwrap() as usize
        })
        .sum();
    let rows: Vec<f64> =
        history[16..].chunks_exact(bytes).map(|row| field(&layout, row, "time_s", plotted)[0]).collect();
    assert_eq!((history.len() - 16) % bytes, 0);
    assert!(rows.len() > 50 && rows.windows(2).all(|pair| pair[0] < pair[1]), "{rows:?}");
    assert!(rows[0] < 0.05 && rows[rows.len() - 1] < 2.499);
    // Played again from the beginning.
    playback.command(&Command::Speed { factor: Some(1.0), paused: Some(false) }).unwrap();
    assert!(time(&mut playback).abs() < 1e-12);
    let refused = playback.command(&Command::DragEnd).unwrap_err();
    assert!(refused.contains("watched, not commanded"), "{refused}");
}

#[test]
fn modes_and_repeats_are_events_and_another_recording_lies_over_it() {
    let (setup, other, foreign) =
        (Setup::new("planar_leg", 1), Setup::new("planar_leg", 2), Setup::new("finger", 1));
    let with = |overlays: Vec<(String, Vec<u8>)>| {
        Playback::new(PlaybackParts { overlays, ..parts(&setup, setup.recorded().0) }, |_| {})
    };
    let mut playback = with(vec![("b.mcap".to_owned(), other.recorded().0)]).unwrap();
    let scene = playback.scene().unwrap();
    assert_eq!(scene["compare"], "b.mcap");
    let events = scene["events"].as_array().unwrap();
    assert!(
        events.iter().any(|event| event["kind"] == "repeat" && event["text"] == "repeat 1"),
        "{events:?}"
    );
    assert!(events.iter().any(|event| event["kind"] == "state"), "{events:?}");
    playback.command(&Command::Seek(1.2)).unwrap();
    let over = shown(&mut playback, "joint_2");
    let mut alone = self::playback(&other, other.recorded().0);
    alone.command(&Command::Seek(1.2)).unwrap();
    assert_eq!(over, shown(&mut alone, "joint_true"));
    let revision = playback.revision();
    playback.command(&Command::Overlay(None)).unwrap();
    assert!(playback.revision() > revision && playback.scene().unwrap()["compare"].is_null());
    let refused = playback.command(&Command::Overlay(Some("c.mcap".to_owned()))).unwrap_err();
    assert!(refused.contains("no recording `c.mcap`; expected one of b.mcap"), "{refused}");
    let refused = with(vec![("f.mcap".to_owned(), foreign.recorded().0)]).unwrap_err().to_string();
    assert!(refused.contains("f.mcap") && refused.contains("same muscles and joints"), "{refused}");
}

#[test]
fn a_recording_that_contradicts_its_machine_is_refused() {
    let (setup, other) = (Setup::new("planar_leg", 1), Setup::new("finger", 1));
    let refused = Playback::new(parts(&other, setup.recorded().0), |_| {}).unwrap_err().to_string();
    assert!(refused.contains("head.json") && refused.contains("muscles"), "{refused}");
}

#[test]
fn what_is_whole_of_a_cut_recording_is_shown_and_the_rest_is_said() {
    let setup = Setup::new("planar_leg", 1);
    let bytes = setup.recorded().0;
    let mut shown_to_the_end = 0;
    for k in 1..40 {
        let cut = bytes[..bytes.len() * k / 40].to_vec();
        match Playback::new(parts(&setup, cut), |_| {}) {
            Ok(mut playback) => {
                assert!(playback.notice().unwrap().contains("cut short"), "{:?}", playback.notice());
                playback.command(&Command::Seek(1e6)).unwrap();
                assert!(shown(&mut playback, "tension_in_n").iter().all(|tension| tension.is_finite()));
                shown_to_the_end += 1;
            }
            Err(error) => assert!(error.to_string().contains("cut short"), "{error}"),
        }
    }
    assert!(shown_to_the_end > 5, "{shown_to_the_end}");
    // Damage anywhere is refused or shown, never worse.
    for k in 0..400 {
        let mut damaged = bytes.clone();
        let place = (k * 7919) % damaged.len();
        damaged[place] ^= 1 << (k % 8);
        if let Ok(mut playback) = Playback::new(parts(&setup, damaged), |_| {}) {
            playback.command(&Command::Seek(1.0)).unwrap();
            assert!(playback.scene().is_ok() && playback.state().is_ok() && playback.history().is_ok());
        }
    }
}
