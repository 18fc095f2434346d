//! The bench with each compensation: accuracy of the far tension, determinism, and a broken cable.
#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use sinew::control::compensation::{CapstanCompensation, Compensation, ObserverCompensation};
use sinew::predictor::CableModel;
use sinew::twin::cable::Specimen;
use sinew_lab::experiment::bench::{BenchRow, BenchRun, MuscleControl, Programme, Stop, run};

/// Root mean square error of the far tension in the windows of active and passive strokes, N.
fn errors(specimen: Specimen, speed: f64, mut compensation: Compensation) -> [f64; 2] {
    let desired = BenchRun::paper(specimen, Programme::Track, speed, 1);
    let mut sums = [[0.0; 2]; 2];
    let stop = run(&desired, MuscleControl::Compensation(&mut compensation), 30.0, |row| {
        if row.window.abs() > 0.0 && row.time > 3.0 {
            let sum = &mut sums[usize::from(row.window < 0.0)];
            sum[0] += (row.truth[1] - row.desired).powi(2);
            sum[1] += 1.0;
        }
    });
    assert_eq!(stop.unwrap(), None);
    assert!(sums.iter().all(|sum| sum[1] > 2000.0), "the windows are long enough to mean something");
    sums.map(|sum| (sum[0] / sum[1]).sqrt())
}

fn observer() -> Compensation {
    Compensation::Observer(Box::new(ObserverCompensation::new(&CableModel::bench()).unwrap()))
}

#[test]
fn the_observer_tracks_the_far_tension_better_than_capstan_and_no_compensation() {
    let bench = Specimen::bench;
    let capstan = Compensation::Capstan(CapstanCompensation::new(1.054, 15.5).unwrap());
    let none = errors(bench(), 0.06, Compensation::None);
    let capstan = errors(bench(), 0.06, capstan);
    let observer = errors(bench(), 0.06, observer());
    assert!(none.iter().all(|e| *e > 60.0), "{none:?}");
    for k in 0..2 {
        assert!(capstan[k] < 0.3 * none[k] && observer[k] < 0.5 * capstan[k], "{capstan:?} {observer:?}");
    }
    assert!(observer[0] < 1.7, "{observer:?}");
}

#[test]
fn the_same_seed_gives_the_same_run() {
    let rows = |seed| {
        let desired = BenchRun::paper(Specimen::draw(seed), Programme::Calibrate, 0.1, seed);
        let mut bits = Vec::new();
        let see =
            |row: &BenchRow| bits.push([row.far, row.sample.tension_in, row.truth[1]].map(f64::to_bits));
        assert_eq!(
            run(&desired, MuscleControl::Compensation(&mut Compensation::None), 3.0, see).unwrap(),
            None
        );
        bits
    };
    assert_eq!(rows(3), rows(3));
    assert_ne!(rows(3), rows(4));
}

#[test]
fn a_broken_cable_is_reported_with_its_time_and_ends_the_run() {
    let mut specimen = Specimen::bench();
    specimen.effects.breakage.as_mut().unwrap().tension = 250.0;
    let desired = BenchRun::paper(specimen, Programme::Track, 0.06, 1);
    let mut last = 0.0;
    let stop =
        run(&desired, MuscleControl::Compensation(&mut observer()), 30.0, |row| last = row.time).unwrap();
    assert!(matches!(stop, Some(Stop::Broken(broken)) if broken.tension > 250.0), "{stop:?}");
    assert!(last < 29.0);
}
