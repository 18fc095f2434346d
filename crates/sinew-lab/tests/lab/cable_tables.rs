//! The calibrated cable on the bench of `yuan2023`: what its Tables II and III report, from the dynamic law.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use sinew::transmission::Sliding;
use sinew::transmission::cable::{Cable, CableLaw, CableParameters, CablePath, EndMotion};
use sinew_lab::paper::{EFFICIENCY, ELONGATION, SPEEDS};

/// Means over one pass of 0.4 m while the load swings the far tension twice between 40 and 200 N.
fn pass(speed: f64, sliding: Sliding) -> (f64, f64) {
    let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 16).unwrap();
    let mut cable = Cable::new(law);
    cable.settle(120.0, sliding).unwrap();
    let v = sliding.sign() * speed;
    let steps = (0.4 / speed * 1e3) as u32;
    let (mut efficiency, mut elongation, mut count) = (0.0, 0.0, 0.0);
    let mut far = cable.ends().tension_out;
    // The first swing is for the loop to settle in.
    for step in 0..steps + steps / 2 {
        let phase = 2.0 * std::f64::consts::TAU * f64::from(step) / f64::from(steps);
        let follow = v + 0.02 * (far - 120.0 - 80.0 * phase.sin());
        let ends = cable.step(1e-3, EndMotion { motor: 1e-3 * v, anchor: 1e-3 * follow }).unwrap();
        far = ends.tension_out;
        if step >= steps / 2 {
            efficiency += ends.tension_out / ends.tension_in;
            elongation += 1e3 * cable.stretch() / (ends.tension_in * CablePath::bench().length());
            count += 1.0;
        }
    }
    (efficiency / count, elongation / count)
}

#[test]
fn the_calibrated_cable_reproduces_the_means_of_tables_two_and_three() {
    let mut squares = 0.0;
    for (row, sliding) in [Sliding::TowardMotor, Sliding::AwayFromMotor].into_iter().enumerate() {
        for (column, speed) in SPEEDS.into_iter().enumerate() {
            let (efficiency, elongation) = pass(speed, sliding);
            for (name, got, paper) in [
                ("efficiency", efficiency, EFFICIENCY[row][column]),
                ("elongation", elongation, ELONGATION[row][column]),
            ] {
                let error = got / paper - 1.0;
                eprintln!("{speed} {sliding:?} {name}: {got:.3}, paper {paper}, {:+.1} %", 100.0 * error);
                assert!(error.abs() < 0.16, "{name} {speed} m/s {sliding:?}: {got}, paper {paper}");
                squares += error * error / 24.0;
            }
        }
    }
    eprintln!("{:.1} % rms", 100.0 * squares.sqrt());
    assert!(squares.sqrt() < 0.09, "{:.1} % rms over the 24 cells", 100.0 * squares.sqrt());
}
