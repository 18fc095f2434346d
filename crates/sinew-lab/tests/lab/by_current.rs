//! Calibration of muscles without load cells: cables and gears against those that were drawn.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]
#![allow(clippy::print_stderr, reason = "what was found is printed")]

use crate::common::machines;
use sinew::twin::arm::ArmSpecimen;
use sinew_lab::arm::{calibrate_arm, calibration_programmes};

/// Of all muscles of a machine without load cells, over some seeds: relative errors of friction angle,
/// compliance and efficiency, error of the gear's friction over it, and how many intervals hold the truth.
struct Found {
    errors: Vec<[f64; 4]>,
    held: [usize; 2],
}

fn found(name: &str, seeds: std::ops::Range<u64>) -> Found {
    let mut machine = machines::machine(name);
    machine.muscles.iter_mut().for_each(|muscle| muscle.drive.has_load_cell = false);
    let design = ArmSpecimen::nominal(&machine).unwrap();
    let programmes = calibration_programmes(&machine, &design).unwrap();
    let (mut errors, mut held) = (Vec::new(), [0; 2]);
    for seed in seeds {
        let specimen = ArmSpecimen::sampled_around(&design, &machine, seed).unwrap();
        let muscles = calibrate_arm(&specimen, &machine, &design, &programmes, seed).unwrap();
        for ((muscle, cable), drive) in muscles.iter().zip(&specimen.cables).zip(&specimen.drives) {
            let (gear, reducer) = (muscle.gear.unwrap(), &drive.reducer);
            let [law, truth] = [muscle.cable.law().unwrap(), cable.law(8).unwrap()];
            let whole = |law: &sinew::transmission::cable::CableLaw| law.compliance().iter().sum::<f64>();
            errors.push([
                law.friction_angle() / truth.friction_angle() - 1.0,
                whole(&law) / whole(&truth) - 1.0,
                gear.efficiency.value / reducer.efficiency - 1.0,
                gear.friction.value / reducer.friction - 1.0,
            ]);
            let inside = [(gear.efficiency, reducer.efficiency), (gear.friction, reducer.friction)];
            for (held, (interval, truth)) in held.iter_mut().zip(inside) {
                *held += usize::from((interval.low..=interval.high).contains(&truth));
            }
        }
    }
    Found { errors, held }
}

fn print(name: &str, found: &Found) {
    let n = found.errors.len();
    let rms = |i: usize| 100.0 * (found.errors.iter().map(|e| e[i] * e[i]).sum::<f64>() / n as f64).sqrt();
    let [angle, compliance, efficiency, friction] = [0, 1, 2, 3].map(rms);
    let [first, second] = found.held;
    eprintln!(
        "{name}: friction angle {angle:.1} %, compliance {compliance:.1} %, efficiency {efficiency:.1} % \
         ({first} of {n} inside), friction of the gear {friction:.1} % ({second} of {n})"
    );
}

/// A gear is known much better than its tolerance after its calibration, and the intervals hold it.
#[test]
fn currents_in_both_directions_tell_the_losses_of_a_gear() {
    let of = found("bench_joint", 1..7);
    print("bench_joint", &of);
    // Drawn within 9 and 20 % of the design; sheath and creep add to the compliance of the design.
    for [_, compliance, efficiency, friction] in &of.errors {
        assert!(compliance.abs() < 0.04 && efficiency.abs() < 0.09 && friction.abs() < 0.18);
    }
    assert!(of.held.iter().all(|held| 10 * held >= 9 * of.errors.len()), "{:?}", of.held);
}

/// `SINEW_LONG=1 cargo nextest run -p sinew-lab long_calibration_by_current --no-capture`
#[test]
fn long_calibration_by_current() {
    if std::env::var_os("SINEW_LONG").is_none() {
        eprintln!("skipped: needs SINEW_LONG=1");
        return;
    }
    let names = ["bench_joint", "planar_leg", "exosuit_elbow", "finger", "surgical_wrist", "shoulder"];
    for name in names.into_iter().chain(["two_finger_hand", "lm_arm"]) {
        print(name, &found(name, 1..5));
    }
}
