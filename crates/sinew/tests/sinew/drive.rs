//! The whole drive: energy, loops, limits, faults.
#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use sinew::drive::{Drive, DriveCommand, DriveFault, DriveParameters, DriveStep, Quadrant, Reducer};
use sinew::random::Random;

const H: f64 = 1e-3;

fn drive() -> Drive {
    Drive::new(DriveParameters::mc_am(), 1).unwrap()
}

/// A spring at the cable: what the drive feels when the far end is held.
struct Spring {
    stiffness: f64,
    stretch: f64,
}

impl Spring {
    fn pull(&mut self, moved: f64) -> f64 {
        self.stretch = (self.stretch + moved).max(0.0);
        self.stiffness * self.stretch
    }
}

#[test]
fn electrical_energy_equals_work_heat_losses_and_stored_energy() {
    let mut drive = drive();
    let mut random = Random::new(5);
    let (mut electrical, mut heat, mut work, mut motion) = (0.0, 0.0, 0.0, 0.0);
    let (mut friction, mut to_air, mut through) = (0.0, 0.0, 0.0);
    let mut quadrants = [0; 4];
    let (mut speed, mut tension) = (0.0, 100.0);
    for k in 0..60_000 {
        if k % 300 == 0 {
            // Back toward the middle of the drum, so that a minute finds no end.
            speed = 0.2 * (random.unit() - 0.5) + 0.5 * (0.55 - drive.wound());
            tension = 20.0 + 280.0 * random.unit();
        }
        let command = match k / 300 % 20 {
            17 => DriveCommand::Off,
            18 => DriveCommand::Current(15.0 * (random.unit() - 0.5)),
            _ => DriveCommand::Velocity(speed),
        };
        let (stored, warm) = (drive.stored(), drive.warmth());
        let pull = if k / 300 % 20 == 19 { 0.0 } else { tension };
        let step: DriveStep = drive.step(command, pull, H);
        let spent = step.heat + step.lost + pull * step.moved + drive.stored() - stored;
        let size = step.electrical.abs() + stored + step.heat + (pull * step.moved).abs() + 1e-3;
        assert!((step.electrical - spent).abs() < 1e-9 * size, "{k}: {step:?} {spent}");
        assert!((step.heat - step.to_air - (drive.warmth() - warm)).abs() < 1e-9 * (1.0 + warm), "{k}");
        assert!(step.heat >= 0.0 && step.lost >= -1e-15, "{k}: {step:?}");
        assert_eq!(step.fault, None);
        friction += step.lost;
        to_air += step.to_air;
        through += pull * step.moved.abs();
        electrical += step.electrical;
        heat += step.heat;
        work += pull * step.moved;
        motion += step.moved.abs();
        quadrants[step.quadrant as usize] += 1;
    }
    let size = heat + friction + through;
    assert!((electrical - heat - friction - work - drive.stored()).abs() < 1e-9 * size);
    assert!((heat - to_air - drive.warmth()).abs() < 1e-9 * heat && to_air > 0.0);
    assert!(motion > 2.0 && quadrants.iter().all(|n| *n > 50), "{motion} {quadrants:?}");
    assert!(heat > 0.0 && friction > 0.0, "heat {heat}, friction {friction}");
    // The losses of the reducer at its efficiency of 0.7, of the work's size: no more, no less.
    assert!(friction < 0.6 * through && friction > 0.01 * through, "{friction} {through}");
}

#[test]
fn an_unpowered_drive_is_pulled_only_by_more_than_its_friction_and_gains_nothing() {
    let mut drive = drive();
    let (mut work, mut moved) = (0.0, 0.0);
    for _ in 0..2000 {
        let step = drive.step(DriveCommand::Off, 20.0, H);
        moved += step.moved.abs();
    }
    // 20 N at 10 mm are 3.8 mNm at the motor: less than its friction.
    assert!(moved < 1e-4, "{moved}");
    for _ in 0..400 {
        work -= 200.0 * drive.step(DriveCommand::Off, 200.0, H).moved;
        assert!(drive.kinetic() <= work + 1e-6);
    }
    assert!(work > 1.0, "200 N pull it out");
}

#[test]
fn a_speed_is_reached_with_the_acceleration_allowed_and_without_overshoot() {
    for (desired, tension) in [(0.1, 50.0), (-0.1, 200.0), (0.02, 300.0)] {
        let mut drive = drive();
        let mut steps = Vec::new();
        for _ in 0..600 {
            steps.push(drive.step(DriveCommand::Velocity(desired), tension, H).speed);
        }
        let settled = &steps[300..];
        assert!(
            settled.iter().all(|v| (v - desired).abs() < 0.02 * f64::abs(desired) + 1e-3),
            "{desired}: {settled:?}"
        );
        let most = steps.iter().map(|v| v / desired).fold(0.0, f64::max);
        assert!(most < 1.15, "overshoot {most}");
        let limit = drive.parameters().acceleration;
        let mean = |k: usize| steps[k..k + 10].iter().sum::<f64>() / 10.0;
        for k in 20..100 {
            assert!((mean(k + 10) - mean(k)).abs() < 2.0 * limit * 10.0 * H, "{k}");
        }
    }
}

#[test]
fn a_tension_is_reached_against_a_spring_and_held() {
    for desired in [30.0, 150.0, 300.0] {
        let mut drive = drive();
        let mut spring = Spring { stiffness: 24e3, stretch: 1e-3 };
        let mut tension = 24.0;
        let mut late = Vec::new();
        for k in 0..3000 {
            let step = drive.step(DriveCommand::Tension { tension: desired, feed: 0.0 }, tension, H);
            tension = spring.pull(step.moved);
            assert!(tension < 1.25 * desired + 20.0, "{desired}: {tension}");
            if k > 1500 {
                late.push((tension - desired) * (tension - desired));
            }
        }
        let rms = (late.iter().sum::<f64>() / late.len() as f64).sqrt();
        assert!(rms < 1.0, "{desired}: {rms}");
    }
}

#[test]
fn changing_the_mode_is_bumpless() {
    let mut drive = drive();
    let mut spring = Spring { stiffness: 24e3, stretch: 5e-3 };
    let mut tension = 120.0;
    for _ in 0..2000 {
        tension =
            spring.pull(drive.step(DriveCommand::Tension { tension: 120.0, feed: 0.0 }, tension, H).moved);
    }
    for _ in 0..200 {
        tension = spring.pull(drive.step(DriveCommand::Velocity(0.0), tension, H).moved);
        assert!((tension - 120.0).abs() < 10.0, "{tension}");
    }
}

#[test]
fn a_settled_drive_under_tension_does_not_move_within_its_backlash() {
    let play = DriveParameters::mc_am();
    let play = DriveParameters { reducer: Reducer { backlash: 0.02, ..play.reducer }, ..play };
    let mut drive = Drive::new(play, 1).unwrap();
    drive.settle(40.0);
    let position = drive.reading().position;
    for _ in 0..20 {
        // Half of the backlash is 0.2 mm of cable.
        let step = drive.step(DriveCommand::Velocity(0.0), 40.0, H);
        assert!(step.moved.abs() < 1e-5, "{step:?}");
        assert!((drive.reading().position - position).abs() < 5e-5, "{:?}", drive.reading());
    }
}

#[test]
fn a_drive_neither_pulls_above_its_limit_nor_pays_out_a_slack_cable() {
    let mut drive = drive();
    let above = drive.parameters().max_tension + 10.0;
    for _ in 0..500 {
        drive.step(DriveCommand::Velocity(0.1), above, H);
    }
    assert!(drive.step(DriveCommand::Velocity(0.1), above, H).speed <= 1e-3);
    let mut drive = self::drive();
    let mut out = 0.0;
    for _ in 0..500 {
        out += drive.step(DriveCommand::Velocity(-0.1), 0.0, H).moved;
    }
    assert!(out > -2e-3, "{out}");
}

#[test]
fn the_end_of_the_drum_and_overheating_are_reported_and_stop_the_motor() {
    let mut drive = drive();
    let mut fault = None;
    for _ in 0..20_000 {
        fault = fault.or(drive.step(DriveCommand::Velocity(0.12), 30.0, H).fault);
    }
    assert_eq!(fault, Some(DriveFault::DrumFull));
    let mut drive = self::drive();
    let mut hot = None;
    for _ in 0..400_000 {
        hot = hot.or(drive.step(DriveCommand::Current(10.0), 1500.0, H).fault);
        if hot.is_some() {
            break;
        }
    }
    assert!(matches!(hot, Some(DriveFault::Hot { winding }) if winding > 155.0), "{hot:?}");
    // The field energy returns to the supply; afterwards no power flows.
    assert!(drive.step(DriveCommand::Current(10.0), 30.0, H).electrical <= 0.0);
    assert!(drive.step(DriveCommand::Current(10.0), 30.0, H).electrical.abs() < 1e-12);
}

#[test]
fn the_same_seed_gives_the_same_bits_and_nothing_passes_that_is_not_finite() {
    let run = |seed| {
        let mut drive = Drive::new(DriveParameters::mc_am(), seed).unwrap();
        let commands = [
            DriveCommand::Velocity(f64::NAN),
            DriveCommand::Tension { tension: f64::INFINITY, feed: 0.0 },
            DriveCommand::Current(f64::NAN),
            DriveCommand::Velocity(0.05),
            DriveCommand::Tension { tension: 90.0, feed: 0.01 },
        ];
        let mut bits = Vec::new();
        for k in 0..1000 {
            let tension = if k % 97 == 0 { f64::NAN } else { 80.0 };
            let step = drive.step(commands[k / 50 % 5], tension, H);
            let reading = drive.reading();
            let all = [step.moved, step.speed, step.electrical, step.heat, reading.position, reading.tension];
            assert!(all.iter().all(|value| value.is_finite()), "{k}: {all:?}");
            bits.push(all.map(f64::to_bits));
        }
        bits
    };
    assert_eq!(run(4), run(4));
    assert_ne!(run(4), run(5));
}

#[test]
fn pulling_is_the_first_quadrant_and_being_pulled_the_fourth() {
    let mut drive = drive();
    let mut last = None;
    for _ in 0..400 {
        last = Some(drive.step(DriveCommand::Velocity(0.05), 150.0, H).quadrant);
    }
    assert_eq!(last, Some(Quadrant::First));
    for _ in 0..400 {
        last = Some(drive.step(DriveCommand::Velocity(-0.05), 400.0, H).quadrant);
    }
    assert_eq!(last, Some(Quadrant::Fourth));
}
