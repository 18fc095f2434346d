//! Set-points over jitter.

use proptest::prelude::*;
use sinew_link::{Playing, Playout, Pushed};

const MS: u64 = 1_000_000;

/// The reference every millisecond, from points that arrive at given times.
fn played(delay: u64, arrivals: &[(u64, u64, f64)], duration: u64) -> Vec<(f64, f64)> {
    let mut playout = Playout::new(1, 64, delay, 50 * MS);
    playout.reset(0, &[0.0]);
    let (mut next, mut out) = (0, Vec::new());
    for ms in 0..duration {
        let now = ms * MS;
        while next < arrivals.len() && arrivals[next].0 <= now {
            playout.push(now, arrivals[next].1, &[arrivals[next].2]);
            next += 1;
        }
        let (mut x, mut v) = ([0.0], [0.0]);
        playout.sample(now, &mut x, &mut v);
        out.push((x[0], v[0]));
    }
    out
}

#[test]
fn a_smooth_motion_is_reproduced_through_jitter_with_the_order_of_the_interpolation() {
    let motion = |t: f64| 0.5 - 0.5 * (3.0 * t).cos();
    let mut errors = Vec::new();
    for spacing in [40, 20, 10] {
        let points: Vec<_> = (0..3000 / spacing)
            .map(|k| {
                let at = k * spacing * MS;
                (at + (k * 7919 % spacing) * MS, at, motion(at as f64 * 1e-9))
            })
            .collect();
        let delay = 3 * spacing;
        let out = played(delay * MS, &points, 2500);
        let worst =
            (200..2500).map(|ms: u64| (out[ms as usize].0 - motion((ms - delay) as f64 * 1e-3)).abs());
        errors.push(worst.fold(0.0, f64::max));
    }
    // Slopes are second order, and 0 at extrema of the points: a quarter of the spacing, less than a ninth of
    // the error.
    assert!(errors[0] / errors[2] > 9.0, "{errors:?}");
    assert!(errors[2] < 1e-4, "{errors:?}");
}

#[test]
fn jitter_below_the_delay_changes_nothing_to_the_bit() {
    let point = |k: u64, jitter: u64| (k * 2 * MS + jitter, k * 2 * MS, (k as f64 * 0.1).sin());
    let steady: Vec<_> = (0..500).map(|k| point(k, 0)).collect();
    let jittery: Vec<_> = (0..500).map(|k| point(k, k * 31 % 2 * MS)).collect();
    assert_eq!(played(6 * MS, &steady, 900), played(6 * MS, &jittery, 900));
}

#[test]
fn the_motion_comes_to_rest_where_points_fail_to_come_and_goes_on_without_a_jump() {
    let ramp = |k: u64| (k * 2 * MS, k * 2 * MS, k as f64 * 0.002);
    let points: Vec<_> = (0..100).chain(150..250).map(ramp).collect();
    let out = played(4 * MS, &points, 450);
    assert!(
        out[150].1 > 0.9 && out[280].1.abs() < 1e-12,
        "moving, then at rest: {:?} {:?}",
        out[150],
        out[280]
    );
    assert!((out[280].0 - (0.198 + 0.5 * 0.05)).abs() < 1e-9, "over half of v B: {}", out[280].0);
    assert!(out[450 - 1].1 > 0.9, "it goes on");
}

#[test]
fn late_points_and_points_without_room_are_reported() {
    let mut playout = Playout::new(2, 4, 0, MS);
    playout.reset(10 * MS, &[0.0, 0.0]);
    assert_eq!(playout.push(10 * MS, 9 * MS, &[1.0, 1.0]), Pushed::Late);
    assert_eq!(playout.push(10 * MS, 20 * MS, &[1.0]), Pushed::Full, "another number of values");
    for k in 0..4 {
        assert_eq!(playout.push(10 * MS, (20 + k) * MS, &[1.0, 1.0]), Pushed::Queued);
    }
    assert_eq!(playout.push(10 * MS, 22 * MS, &[2.0, 2.0]), Pushed::Queued, "the same time: replaced");
    assert_eq!(playout.push(10 * MS, 30 * MS, &[1.0, 1.0]), Pushed::Full);
    let (mut x, mut v) = ([0.0; 2], [0.0; 2]);
    assert_eq!(playout.sample(22 * MS, &mut x, &mut v), Playing::Following);
    assert!((x[0] - 2.0).abs() < 1e-12);
}

#[test]
fn a_point_far_ahead_does_not_shut_out_the_ones_before_it() {
    let mut playout = Playout::new(1, 8, 0, MS);
    playout.reset(0, &[0.0]);
    let (mut x, mut v) = ([0.0], [0.0]);
    playout.push(0, u64::MAX, &[1.0]);
    playout.sample(MS, &mut x, &mut v);
    assert_eq!(playout.push(MS, 11 * MS, &[0.5]), Pushed::Queued);
    playout.sample(11 * MS, &mut x, &mut v);
    assert!((x[0] - 0.5).abs() < 1e-12, "{x:?}");
}

proptest! {
    #[test]
    fn neither_position_nor_velocity_jumps_whatever_arrives(
        points in prop::collection::vec((0_u64..2000, 0_u64..2000, -1.0..1.0_f64), 0..80),
        delay in 0_u64..20,
    ) {
        let mut points = points;
        points.sort_by_key(|point| point.0);
        let mut playout = Playout::new(1, 32, delay * MS, 50 * MS);
        playout.reset(0, &[0.25]);
        let (mut next, mut before) = (0, (0.25, 0.0_f64));
        for us in 0..2500 * 5_u64 {
            let now = us * 200_000;
            while next < points.len() && points[next].0 * MS <= now {
                playout.push(now, points[next].1 * MS, &[points[next].2]);
                next += 1;
            }
            let (mut x, mut v) = ([0.0], [0.0]);
            playout.sample(now, &mut x, &mut v);
            prop_assert!(x[0].is_finite() && v[0].is_finite());
            // Between two samples the position moves by the velocity: of a cubic, up to its curvature in a
            // piece of 1 ms or more.
            let speed = v[0].abs().max(before.1.abs()).max((x[0] - before.0).abs() / 2e-4);
            prop_assert!((x[0] - before.0).abs() <= 2e-4 * (2.0 * speed + 1e-9));
            let most = 12.0 * (2.0 + speed * 1e-3) / 1e-6;
            prop_assert!((v[0] - before.1).abs() <= 2e-4 * most, "{before:?} {x:?} {v:?}");
            before = (x[0], v[0]);
        }
    }
}
