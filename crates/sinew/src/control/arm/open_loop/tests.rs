use super::*;

const H: f64 = 1e-3;

/// A corrected observer and the copies beside it; its load cell reads `offset` N more than the cable has from
/// the third second on.
fn run(seconds: f64, offset: f64, renewing: impl Fn(f64) -> bool) -> Vec<[f64; 2]> {
    let models = [CableModel::bench()];
    let mut observers = CableObservers::new(&models).unwrap();
    let mut truth = CableObservers::new(&models).unwrap();
    let mut cables = OpenLoopCables::new(&models, 1).unwrap();
    let (mut estimates, mut actual) = ([CableEstimate::default()], [CableEstimate::default()]);
    let mut rows = Vec::new();
    let mut time = 0.0;
    while time < seconds {
        let travel = 2e-3 * (1.0 - libm::cos(3.0 * time));
        let moved = CableSample { motor: travel, tension_in: f64::NAN, ..CableSample::default() };
        truth.step(H, &[moved], &mut actual).unwrap();
        let wrong = if time > 3.0 { offset } else { 0.0 };
        let read = CableSample { tension_in: actual[0].tension_in + wrong, ..moved };
        observers.step(H, &[read], &mut estimates).unwrap();
        let corrected = Corrected {
            observers: &observers,
            unexplained: &[0.0],
            pose: &[0.0],
            disturbance_torque: &[0.0],
        };
        cables.step(H, &[read], &corrected, renewing(time)).unwrap();
        if let Some(copy) = cables.used() {
            rows.push([
                copy.tension_in[0] - actual[0].tension_in,
                estimates[0].tension_in - actual[0].tension_in,
            ]);
        }
        time += H;
    }
    rows
}

#[test]
fn a_copy_estimates_what_the_corrected_observer_does_where_the_load_cell_is_right() {
    let rows = run(6.0, 0.0, |_| true);
    // The first copy that is compared is a second old; it steps every 16 ms.
    assert!((3990..4010).contains(&rows.len()), "{}", rows.len());
    assert!(
        rows.iter().flatten().all(|error| error.abs() < 1.5),
        "{:?}",
        rows.iter().flatten().fold(0.0_f64, |a, b| a.max(b.abs()))
    );
}

#[test]
fn copies_step_every_sixteen_milliseconds_one_at_a_time_or_in_every_cycle_that_takes_longer() {
    for (h, interval) in
        [(1e-3, 0.016), (2e-3, 0.016), (5e-3, 0.015), (0.008, 0.016), (0.0105, 0.0105), (0.018, 0.018)]
    {
        let models = [CableModel::bench()];
        let observers = CableObservers::new(&models).unwrap();
        let mut cables = OpenLoopCables::new(&models, 1).unwrap();
        let corrected = Corrected {
            observers: &observers,
            unexplained: &[0.0],
            pose: &[0.0],
            disturbance_torque: &[0.0],
        };
        let cycles = (8.0 / h) as u32;
        let mut stepped = 0;
        for _ in 0..cycles {
            let before = cables.copies[cables.used].unstepped;
            if cables.step(h, &[CableSample::default()], &corrected, true).unwrap() {
                stepped += 1;
                assert!(before + h < 0.02 + 1e-9, "{h}: {before}");
            }
        }
        let mean = 8.0 / f64::from(stepped);
        assert!((mean - interval).abs() < 0.1 * interval, "{h}: {mean}");
    }
}

#[test]
fn a_copy_does_not_follow_a_load_cell_that_has_become_false_since_it_was_made() {
    let rows = run(6.0, 20.0, |time| time < 3.0);
    let [copy, corrected] = rows[rows.len() - 1];
    assert!(copy.abs() < 1.5 && corrected > 15.0, "{copy} {corrected}");
}

#[test]
fn the_copy_that_is_compared_is_at_least_one_and_at_most_two_seconds_old() {
    // A false cell is in no compared copy for a second, and in all of them after two.
    let rows = run(6.0, 20.0, |_| true);
    let at = |time: f64| rows[rows.len() - 1 - ((6.0 - time) / H) as usize][0];
    assert!(at(3.9).abs() < 1.5, "{}", at(3.9));
    assert!(at(5.2) > 10.0, "{}", at(5.2));
}
