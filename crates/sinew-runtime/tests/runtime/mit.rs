//! Motors in MIT mode and their watchdog, in virtual time.

use crate::can_common::{Act, Guard, MIDDLE, Watched, bus, setup_on, stopped};
use crate::common::{Setup, tracked};
use proptest::prelude::*;
use sinew_runtime::can::{
    CanBus, CanDevice, CanFault, CanNode, FoundNode, Frame, Link, MitFamily, MitMotor, Protocol, scan_mit,
    words,
};
use sinew_segment::{CanDrive, MitCommand, MitRanges, MitReadings};
use sinew_session::BusFault;

/// The same motors of another model.
fn of_model(nodes: &[CanDevice], model: &str) -> Vec<CanDevice> {
    let (_, ranges) = MitMotor::models().find(|(name, _)| *name == model).unwrap();
    let of = |node: &CanDevice| {
        let motor = MitMotor { model: model.to_owned(), ranges, ..node.mit.clone().unwrap() };
        CanDevice { mit: Some(motor), ..node.clone() }
    };
    nodes.iter().map(of).collect()
}

/// Angle of the motor of a muscle at the start, rad.
fn centre(setup: &Setup, muscle: usize) -> f64 {
    let drive = setup.machine.muscles[muscle].drive;
    drive.winch.angle(setup.plant.reading().motor[muscle]) * drive.reducer.ratio
}

/// Octets of commands by somebody else: PyPI's mini-cheetah-motor-driver-socketcan 0.4.3 and damiao-motor
/// 1.0.6; those with numbers in the middle of a step would be another one, since they round down.
#[test]
fn commands_and_answers_in_mit_mode_have_the_octets_of_other_peoples_programs() {
    let ranges = |model: &str| MitMotor::models().find(|(name, _)| *name == model).unwrap().1;
    let commands = [
        ("AK10-9", [10.18, -42.4, 423.0, 0.9, 28.4], 0xe83d_137d_882e_1b7e_u64),
        ("AK10-9", [-8.71, 13.5, 265.0, 2.6, 15.9], 0x26cf_a288_7a85_19f4),
        ("AK10-9", [11.49, -38.0, 12.0, 0.9, -23.5], 0xf5a7_1eb0_622e_151b),
        ("DM-J8009", [4.98, -10.4, 38.0, 3.9, -30.2], 0xb2fe_6261_37c7_a386),
        ("DM-J8009", [-10.61, 44.1, 91.0, 2.9, -18.6], 0x135a_fd62_e994_753e),
        ("DM-J8009", [-10.29, 21.2, 302.0, 3.8, 50.0], 0x16a1_bc49_a9c2_8f67),
    ];
    for (model, [position, velocity, stiffness, damping, torque], octets) in commands {
        let command = MitCommand { position, velocity, stiffness, damping, torque };
        assert_eq!(ranges(model).command(&command), octets.to_be_bytes(), "{model} {command:?}");
    }
    let answers = [
        (
            [0xa1, 0xb2, 0x7f, 0xf8, 0x40],
            [3.290_798_809_796_293, -0.010_989_010_989_014_503, 1.701_098_901_098_902],
        ),
        ([0x00, 0x0f, 0xff, 0xff, 0xff], [-12.494_277_866_788_739, 45.0, 54.0]),
        ([0xff, 0xff, 0x00, 0x00, 0x0a], [12.5, -45.0, -53.736_263_736_263_74]),
    ];
    for (octets, expected) in answers {
        let MitReadings { position, velocity, torque } = ranges("DM-J8009").readings(octets);
        for (got, expected) in [position, velocity, torque].into_iter().zip(expected) {
            assert!((got - expected).abs() < 1e-12, "{octets:x?}: {got} {expected}");
        }
    }
}

proptest! {
    #[test]
    fn every_command_of_every_model_is_understood_within_half_a_step(model in 0_usize..19,
        parts in proptest::array::uniform5(-1.1_f64..1.1)) {
        let (_, ranges) = MitMotor::models().nth(model).unwrap();
        let [position, velocity, torque] = [ranges.position, ranges.velocity, ranges.torque];
        let [p, v, kp, kd, t] = parts;
        let told = MitCommand {
            position: position * p,
            velocity: velocity * v,
            stiffness: ranges.stiffness * kp.abs(),
            damping: ranges.damping * kd.abs(),
            torque: torque * t,
        };
        let octets = ranges.command(&told);
        let understood = ranges.commanded(octets);
        prop_assert_eq!(ranges.command(&understood), octets);
        // Beyond a range its end is told.
        let near = |told: f64, understood: f64, low: f64, high: f64, steps: f64| {
            (told.clamp(low, high) - understood).abs() <= 0.5001 * (high - low) / steps
        };
        prop_assert!(near(told.position, understood.position, -position, position, 65_535.0));
        prop_assert!(near(told.velocity, understood.velocity, -velocity, velocity, 4095.0));
        prop_assert!(near(told.torque, understood.torque, -torque, torque, 4095.0));
        prop_assert!(near(told.stiffness, understood.stiffness, 0.0, ranges.stiffness, 4095.0));
        prop_assert!(near(told.damping, understood.damping, 0.0, ranges.damping, 4095.0));
        let shown = MitReadings { position: told.position.clamp(-position, position), velocity: 0.0, torque: 0.0 };
        let seen = ranges.readings(ranges.answer(&shown));
        prop_assert!(near(shown.position, seen.position, -position, position, 65_535.0), "{:?} {:?}", shown, seen);
    }
}

#[test]
fn motors_of_every_family_in_mit_mode_track_and_end_without_power() {
    let (setup, nodes) = setup_on("bench_joint", Protocol::Mit);
    let (direct, _) = tracked(&setup, setup.twin_bus());
    for model in ["mini-cheetah", "AK10-9", "DM-J10010"] {
        let nodes = of_model(&nodes, model);
        let (found, digest) = tracked(&setup, bus(&setup, &nodes));
        println!("{model}: {found:?}, twin {direct:?}");
        let mut soft = nodes.clone();
        soft.iter_mut().for_each(|node| node.mit.as_mut().unwrap().stiffness = 500.0 / 4095.0);
        // With damping alone, or nearly so, it creeps.
        let (soft, _) = tracked(&setup, bus(&setup, &soft));
        assert!(soft.max > 1.2 * found.max, "{model}: {soft:?}");
        assert!(found.mean < 1.5 * direct.mean && found.max < 1.6 * direct.max, "{model}: {found:?}");
        assert_eq!(tracked(&setup, bus(&setup, &nodes)).1, digest, "{model}: bits of a second run");
        assert_eq!(stopped(&setup, &Watched::new(&setup, &nodes), &nodes), None, "{model}");
    }
}

#[test]
fn what_is_wrong_with_a_motor_in_mit_mode_is_refused_before_anything_moves() {
    let (setup, nodes) = setup_on("finger", Protocol::Mit);
    let name = nodes[2].name.as_str();
    let with = |nodes: &[CanDevice], change: &dyn Fn(&mut CanDevice)| {
        let mut changed = nodes.to_vec();
        change(&mut changed[2]);
        changed
    };
    let on_wire = |nodes: &[CanDevice], change: &dyn Fn(&mut CanNode)| {
        let watched = Watched::new(&setup, nodes);
        change(watched.0.borrow_mut().link.machine_mut().nodes_mut().nth(2).unwrap());
        watched
    };
    let fine = || Watched::new(&setup, &nodes);
    let configured = |nodes: &[CanDevice], leaves, mode, change: &dyn Fn(&mut MitRanges)| {
        let mut ranges = nodes[2].mit.as_ref().unwrap().ranges;
        change(&mut ranges);
        on_wire(nodes, &move |node| {
            let CanDrive::Mit(motor) = node.drive_mut() else { unreachable!() };
            motor.configure(leaves, mode, ranges);
        })
    };
    let guarded = |guard| {
        let watched = fine();
        watched.0.borrow_mut().guard = guard;
        watched
    };
    let damaged = |damage| {
        let watched = fine();
        watched.0.borrow_mut().damage = Some(damage);
        watched
    };
    let short = |frame: &Frame| Frame::new(frame.id(), &frame.octets()[..frame.octets().len().min(3)]);
    let gain = |change: &dyn Fn(&mut MitMotor)| with(&nodes, &|node| change(node.mit.as_mut().unwrap()));
    let far =
        with(&nodes, &|node| node.drive.offset = centre(&setup, 2) + 12.2 / node.drive.counts_per_turn.abs());
    let twice = Watched::new(&setup, &with(&nodes, &|node| node.node = 1));
    let slow: Vec<_> = nodes.iter().map(|node| CanDevice { bitrate: 250_000, ..node.clone() }).collect();
    // The first one answers as 0x11.
    let confused =
        with(&nodes, &|node| (node.node, node.mit) = (0x11, of_model(&nodes, "AK10-9")[2].mit.clone()));
    let (ak, cheetah) = (of_model(&nodes, "AK10-9"), of_model(&nodes, "mini-cheetah"));
    let none = |_: &mut MitRanges| {};
    let cases: [(Watched, Vec<CanDevice>, &[&str]); 18] = [
        (Watched::new(&setup, &confused), confused, &[&nodes[0].name, "under id 17"]),
        (fine(), with(&nodes, &|node| node.node = 9), &[name, "id 9", "no node answers"]),
        (fine(), with(&nodes, &|node| node.node = 1), &[name, "a node of its own"]),
        (fine(), with(&nodes, &|node| node.protocol = Protocol::Canopen), &[name, "the same protocol"]),
        (twice, nodes.clone(), &["id 1", "two nodes answer"]),
        (damaged(short), nodes.clone(), &["no node answers"]),
        (fine(), slow, &["250000 bit/s", "4.000 ms"]),
        // Another family answers in another form.
        (fine(), ak.clone(), &["no node answers"]),
        (fine(), cheetah.clone(), &["no node answers"]),
        (configured(&nodes, true, 3, &none), nodes.clone(), &[name, "control mode 3", "expected 1, MIT"]),
        (
            configured(&nodes, true, 1, &|of| of.velocity = 20.0),
            nodes.clone(),
            &[name, "VMAX 20", "DM-J4310"],
        ),
        (configured(&nodes, false, 1, &none), nodes.clone(), &[name, "keeps its power for 0.030 s"]),
        (guarded(Guard::Missing), nodes.clone(), &["the watchdog beside this program", "not found"]),
        (guarded(Guard::Idle), nodes.clone(), &["the watchdog", "not told it to leave 0.030 s after"]),
        (fine(), gain(&|motor| motor.damping = 5.1), &[name, "damping of 5.1", "4095"]),
        (fine(), gain(&|motor| motor.stiffness = 0.05), &[name, "stiffness of 0.050", "1 to 4095"]),
        (Watched::new(&setup, &far), far, &[name, "its position is", "12.00 rad"]),
        (
            on_wire(&nodes, &|node| node.set_fault(Some(CanFault::Silent))),
            nodes.clone(),
            &[name, "no node answers"],
        ),
    ];
    for (watched, nodes, parts) in cases {
        let before = watched.0.borrow_mut().link.machine_mut().arm().reading().motor.clone();
        let refused = CanBus::start(watched.clone(), &setup.machine, &nodes);
        let message = refused.err().map(|error| error.to_string()).unwrap_or_default();
        println!("{message}");
        assert!(parts.iter().all(|part| message.contains(part)), "{message}: {parts:?}");
        assert!((0..nodes.len()).all(|k| !watched.moves(k)), "{message}");
        let after = watched.0.borrow_mut().link.machine_mut().arm().reading().motor.clone();
        assert!(before.iter().zip(&after).all(|(before, after)| (before - after).abs() < 3e-4), "{message}");
    }
    for nodes in [nodes, ak, cheetah] {
        assert!(CanBus::start(Watched::new(&setup, &nodes), &setup.machine, &nodes).is_ok());
    }
}

#[test]
fn a_program_that_stands_for_longer_than_its_watchdog_waits_gives_nothing_power_again() {
    let (setup, nodes) = setup_on("planar_leg", Protocol::Mit);
    for (model, periods, acts) in [("DM-J8009", 4, false), ("DM-J8009", 7, true), ("AK10-9", 7, true)] {
        let nodes = of_model(&nodes, model);
        let watched = Watched::new(&setup, &nodes).with(MIDDLE, Act::Stall(periods));
        let found = stopped(&setup, &watched, &nodes);
        println!("{model} {periods}: {found:?}");
        assert_eq!(found.is_some(), acts, "{model} {periods}");
        if let Some((cycle, exchange, fault)) = found {
            assert!((MIDDLE..MIDDLE + 5).contains(&cycle) && fault.starts_with("Drive"), "{cycle} {fault}");
            let fault = exchange.fault.unwrap();
            let BusFault::NotReady { code, .. } = fault else { panic!("{fault:?}") };
            assert!(code == 3 && words(fault).contains("watchdog"), "{fault:?}");
        }
    }
}

/// What has no state in its answers is found by what it does not do.
#[test]
fn a_motor_that_does_not_follow_or_is_at_the_end_of_its_range_is_named() {
    let (setup, nodes) = setup_on("planar_leg", Protocol::Mit);
    let cheetah = of_model(&nodes, "mini-cheetah");
    let watched = Watched::new(&setup, &cheetah).with(MIDDLE, Act::Restart(1));
    let (cycle, exchange, fault) = stopped(&setup, &watched, &cheetah).unwrap();
    println!("after {} cycles, {fault}, {exchange:?}", cycle - MIDDLE);
    let mut narrow = nodes.clone();
    let ranges = &mut narrow[1].mit.as_mut().unwrap().ranges;
    // It begins in the middle of a range that ends soon.
    ranges.position = 0.3;
    narrow[1].drive.offset = centre(&setup, 1);
    let (_, exchange, fault) = stopped(&setup, &Watched::new(&setup, &narrow), &narrow).unwrap();
    println!("{exchange:?} {fault}");
    let expected = BusFault::Drive { muscle: 1, code: 0x220 };
    assert_eq!(exchange.fault, Some(expected));
    assert_eq!(words(expected), "reports a position at the end of its range");
}

#[test]
fn motors_in_mit_mode_are_listed_and_lose_their_power() {
    let (setup, mut nodes) = setup_on("planar_leg", Protocol::Mit);
    let motor = |model: &str| of_model(&nodes[..1], model)[0].mit.clone();
    let models = ["mini-cheetah", "AK80-9", "DM-J4310", "AK10-9"].map(motor);
    nodes.iter_mut().zip([9, 16, 15, 126]).for_each(|(node, id)| node.node = id);
    nodes.iter_mut().zip(models).for_each(|(node, motor)| node.mit = motor);
    let mut watched = Watched::new(&setup, &nodes);
    let enter =
        nodes.iter().map(|node| Frame::new(u16::from(node.node), &[255, 255, 255, 255, 255, 255, 255, 252]));
    watched.send(&enter.collect::<Vec<_>>()).unwrap();
    assert_eq!(watched.nodes(CanNode::has_power), [true; 4]);
    assert_eq!(std::iter::from_fn(|| watched.receive(u64::MAX).unwrap()).take(4).count(), 4);
    let found = scan_mit(&mut watched).unwrap();
    let of = |node, family, answers_as| FoundNode::Mit { node, family, answers_as };
    let expected = [
        of(9, MitFamily::MiniCheetah, 0),
        of(15, MitFamily::Damiao, 0x1f),
        of(16, MitFamily::Cubemars, 16),
        of(126, MitFamily::Cubemars, 126),
    ];
    assert_eq!(found, expected);
    assert_eq!(watched.nodes(CanNode::has_power), [false; 4]);
}
