//! Every scenario against the reference of 202 cells and 0.1 ms.

use super::reference::{Reference, SUBSTEPS};
use sinew::transmission::Sliding;
use sinew::transmission::cable::{Cable, CableLaw, CableParameters, CablePath, EndMotion};

/// Cells that the table of the documentation calls the plant's.
const CELLS: usize = 12;

/// A motion of both ends, m at s, and how it starts.
struct Scenario {
    name: &'static str,
    seconds: f64,
    start: (f64, Sliding),
    motor: fn(f64) -> f64,
    anchor: fn(f64) -> f64,
    /// Samples at its start that are not compared, s.
    skip: f64,
}

/// Root mean square and largest difference of the near and the far tension, N.
#[derive(Debug, Clone, Copy)]
struct Errors {
    near: (f64, f64),
    far: (f64, f64),
}

/// Of cables with these numbers of cells, beside one run of the reference.
fn compare(scenario: &Scenario, cells: [usize; 2]) -> [Errors; 2] {
    let mut cables = cells.map(|cells| {
        Cable::new(CableLaw::new(&CablePath::bench(), &CableParameters::bench(), cells).unwrap())
    });
    let mut reference = Reference::new(95.0);
    let (tension, sliding) = scenario.start;
    cables.iter_mut().for_each(|cable| cable.settle(tension, sliding).unwrap());
    reference.settle(tension, sliding.sign());
    let (mut errors, mut count) = ([Errors { near: (0.0, 0.0), far: (0.0, 0.0) }; 2], 0.0);
    let (mut lowest, mut highest) = (f64::INFINITY, 0.0_f64);
    for step in 0..(1e3 * scenario.seconds) as usize {
        let at = |k: usize| (step * SUBSTEPS + k) as f64 * 1e-3 / SUBSTEPS as f64;
        for k in 0..SUBSTEPS {
            let change = |of: fn(f64) -> f64| of(at(k + 1)) - of(at(k));
            reference.step(1e-3 / SUBSTEPS as f64, change(scenario.motor), change(scenario.anchor));
        }
        let change = |of: fn(f64) -> f64| of(at(SUBSTEPS)) - of(at(0));
        let motion = EndMotion { motor: change(scenario.motor), anchor: change(scenario.anchor) };
        let ends = cables.each_mut().map(|cable| cable.step(1e-3, motion).unwrap());
        lowest = lowest.min(reference.tension_out());
        highest = highest.max(reference.tension_out());
        if at(SUBSTEPS) < scenario.skip {
            continue;
        }
        let note = |to: &mut (f64, f64), error: f64| *to = (to.0 + error * error, to.1.max(error.abs()));
        for (errors, ends) in errors.iter_mut().zip(ends) {
            note(&mut errors.near, ends.tension_in - reference.tension_in());
            note(&mut errors.far, ends.tension_out - reference.tension_out());
        }
        count += 1.0;
    }
    assert_eq!(reference.failures, 0, "{}: the reference did not converge", scenario.name);
    assert!(highest < 900.0, "{}: {lowest} to {highest} N is beyond any cable", scenario.name);
    let root = |(squares, worst): (f64, f64)| ((squares / count).sqrt(), worst);
    let errors = errors.map(|errors| Errors { near: root(errors.near), far: root(errors.far) });
    eprintln!("{} M={cells:?}: {errors:.3?} N ({lowest:.0} to {highest:.0})", scenario.name);
    errors
}

fn assert_accurate(scenario: &Scenario) {
    let cells = [CELLS, 16];
    for (Errors { near, far }, cells) in compare(scenario, cells).into_iter().zip(cells) {
        let name = scenario.name;
        assert!(far.0 <= 0.1, "{name} M={cells}: T_out {} N rms", far.0);
        assert!(far.1 <= 0.5, "{name} M={cells}: T_out {} N at worst", far.1);
        assert!(near.0 <= 0.5, "{name} M={cells}: T_in {} N rms", near.0);
    }
}

/// Back and forth with speed 1, turning near 0 and `half` within 48 ms: 5 m/s2 at 0.12 m/s.
fn triangle(t: f64, half: f64) -> f64 {
    const TURN: f64 = 0.024;
    let phase = t.rem_euclid(2.0 * half);
    let sharp = phase.min(2.0 * half - phase);
    let round = |x: f64| if x < TURN { (x * x / TURN + TURN) / 2.0 } else { x };
    if sharp < half / 2.0 { round(sharp) } else { half - round(half - sharp) }
}

/// Path of a motion that reaches speed 1 with a time constant of 40 ms: 3 m/s2 at 0.12 m/s.
fn started(t: f64) -> f64 {
    t + 0.04 * (-t / 0.04).exp_m1()
}

const SETTLED: (f64, Sliding) = (100.0, Sliding::TowardMotor);
const YIELDED: (f64, Sliding) = (100.0, Sliding::AwayFromMotor);

fn slide(name: &'static str, start: (f64, Sliding), motion: fn(f64) -> f64) -> Scenario {
    Scenario { name, seconds: 0.6, start, motor: motion, anchor: motion, skip: 0.0 }
}

#[test]
fn steady_sliding_slow_and_fast_both_ways() {
    assert_accurate(&slide("slide +0.02", SETTLED, |t| 0.02 * started(t)));
    assert_accurate(&slide("slide +0.12", SETTLED, |t| 0.12 * started(t)));
    assert_accurate(&slide("slide -0.02", YIELDED, |t| -0.02 * started(t)));
    assert_accurate(&slide("slide -0.12", YIELDED, |t| -0.12 * started(t)));
}

#[test]
fn slow_reversals_under_a_changing_load() {
    // 50 mm there and back at 0.02 m/s; the load swings the stretch by +-15 mm.
    assert_accurate(&Scenario {
        name: "reversals 0.02",
        seconds: 6.0,
        start: SETTLED,
        motor: |t| 0.02 * triangle(t, 2.5),
        anchor: |t| 0.02 * triangle(t, 2.5) - 0.015 * (1.3 * t).sin(),
        skip: 0.0,
    });
}

#[test]
fn fast_reversals_under_a_changing_load() {
    assert_accurate(&Scenario {
        name: "reversals 0.12",
        seconds: 4.0,
        start: SETTLED,
        motor: |t| 0.12 * triangle(t, 1.0),
        anchor: |t| 0.12 * triangle(t, 1.0) - 0.015 * (2.1 * t).sin(),
        skip: 0.0,
    });
}

#[test]
fn dither_inside_the_dead_band() {
    assert_accurate(&Scenario {
        name: "dither",
        seconds: 2.0,
        start: SETTLED,
        motor: |t| 0.002 * (2.0 * std::f64::consts::PI * 5.0 * t).sin() - 0.004 * t,
        anchor: |_| 0.0,
        skip: 0.0,
    });
}

#[test]
fn into_slack_and_back() {
    assert_accurate(&Scenario {
        name: "slack",
        seconds: 4.0,
        start: (60.0, Sliding::TowardMotor),
        // 60 mm out at 0.06 m/s, past slack, and back.
        motor: |t| -0.06 * triangle(t, 1.0),
        anchor: |_| 0.0,
        skip: 0.0,
    });
}

#[test]
fn the_load_pulls_while_the_motor_stands() {
    assert_accurate(&Scenario {
        name: "load moves",
        seconds: 4.0,
        start: (60.0, Sliding::TowardMotor),
        motor: |_| 0.0,
        anchor: |t| -0.04 * triangle(t, 1.0),
        skip: 0.0,
    });
}

#[test]
fn errors_fall_as_cells_grow_finer() {
    let scenario = Scenario {
        name: "order",
        seconds: 1.2,
        start: SETTLED,
        motor: |t| 0.06 * t,
        anchor: |t| 0.06 * t - 0.01 * (3.0 * t).sin(),
        skip: 0.2,
    };
    let [coarse, fine] = compare(&scenario, [6, 14]).map(|errors| errors.near.0);
    // Three times as many sheath cells: order 2 in space would be 9, time steps keep their fraction.
    assert!(fine < coarse / 3.0, "{coarse} N with 6 cells, {fine} N with 14");
}
