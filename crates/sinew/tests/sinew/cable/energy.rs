//! No step creates energy, however violent; masses at both ends never swing up.

use super::laws::Random;
use proptest::prelude::*;
use sinew::transmission::Sliding;
use sinew::transmission::cable::{
    Cable, CableBatch, CableLaw, CableParameters, CablePath, EndMotion, EndTensions, Segment, Weakening,
    WeakeningForm,
};

fn law(parameters: &CableParameters, cells: usize) -> CableLaw {
    CableLaw::new(&CablePath::bench(), parameters, cells).unwrap()
}

/// Random motion of both ends, `rms` m per step, pulled back to a stretch of about 30 mm.
fn shake(rms: f64, steps: usize, parameters: &CableParameters) {
    let mut cables = CableBatch::new(&vec![law(parameters, 12); 8]).unwrap();
    for cable in 0..8 {
        cables.settle(cable, 80.0, Sliding::TowardMotor).unwrap();
    }
    let energy = |cables: &CableBatch, k: usize| -> f64 {
        let compliance = law(parameters, 12);
        cables.tensions(k).zip(compliance.compliance()).map(|(t, c)| 0.5 * c * t * t).sum()
    };
    let start: Vec<f64> = (0..8).map(|k| energy(&cables, k)).collect();
    let mut random = Random(11);
    let mut ends = [EndTensions::default(); 8];
    let (mut work, mut scale, mut slack) = ([0.0_f64; 8], [0.0_f64; 8], 0);
    for _ in 0..steps {
        // The sum of three uniform numbers has variance 1.
        let mut draw = |pull: f64| rms * (random.unit() + random.unit() + random.unit()) + pull;
        let mut motions = [EndMotion::default(); 8];
        for (k, motion) in motions.iter_mut().enumerate() {
            let pull = 0.02 * (0.03 - cables.stretch(k).unwrap());
            *motion = EndMotion { motor: draw(pull).clamp(-0.1, 0.1), anchor: draw(-pull).clamp(-0.1, 0.1) };
        }
        cables.step(1e-3, &motions, &mut ends).unwrap();
        for (k, (motion, end)) in motions.iter().zip(&ends).enumerate() {
            // The constant force T_0 only moves potential energy: the cable's own part is what counts.
            let done = end.tension_in * motion.motor - (end.tension_out - 15.5) * motion.anchor;
            work[k] += done;
            scale[k] += done.abs();
            assert!(end.dissipated >= -1e-12, "a step created {} J", -end.dissipated);
            slack += usize::from(end.tension_in == 0.0);
        }
    }
    let mut dissipated = 0.0;
    for k in 0..8 {
        let created = energy(&cables, k) - start[k] - work[k];
        assert!(created <= 1e-9 * scale[k], "{created} J of {} J", scale[k]);
        dissipated -= created;
    }
    assert!(dissipated > 1.0, "it was shaken: {dissipated} J");
    eprintln!("{rms} m: {dissipated:.0} J dissipated, {slack} slack lane-steps");
}

#[test]
fn a_million_random_steps_create_no_energy() {
    let bench = CableParameters::bench();
    for (rms, steps) in [(3e-5, 20_000), (3e-4, 60_000), (1e-3, 30_000), (5e-3, 20_000)] {
        shake(rms, steps, &bench);
    }
}

#[test]
fn nor_do_they_where_friction_weakens_or_drag_is_absent() {
    for form in WeakeningForm::ALL {
        let weakening = Some(Weakening { form, ..Weakening::rational(0.6, 3e-3, 0.02) });
        shake(3e-4, 20_000, &CableParameters { weakening, ..CableParameters::bench() });
    }
    shake(3e-4, 20_000, &CableParameters { drag: 0.0, ..CableParameters::bench() });
    shake(
        1e-3,
        20_000,
        &CableParameters { friction: 0.0, efficiency: 1.0, drag: 0.0, ..CableParameters::bench() },
    );
}

#[test]
fn masses_at_both_ends_never_gain_energy() {
    for (winch, load) in [(138.0, 10.0), (138.0, 1.0), (138.0, 0.3), (20.0, 0.1)] {
        let mut cable = Cable::new(law(&CableParameters::bench(), 12));
        cable.settle(100.0, Sliding::TowardMotor).unwrap();
        // Constant forces that balance the start, so that their potential joins the account.
        let (pull, hold) = (cable.ends().tension_in, cable.ends().tension_out);
        let (mut v_m, mut v_a, mut p_m, mut p_a) = (0.1, -0.3, 0.0_f64, 0.0_f64);
        let total = |cable: &Cable, v_m: f64, v_a: f64, p_m: f64, p_a: f64| {
            0.5 * (winch * v_m * v_m + load * v_a * v_a) + cable.energy() - (pull * p_m) + hold * p_a
                - 15.5 * p_a
        };
        let start = total(&cable, v_m, v_a, p_m, p_a);
        let mut ends = cable.ends();
        let (mut highest, mut travelled) = (f64::NEG_INFINITY, 0.0);
        for _ in 0..10_000 {
            v_m += 1e-3 * (pull - ends.tension_in) / winch;
            v_a += 1e-3 * (ends.tension_out - hold) / load;
            let motion = EndMotion { motor: 1e-3 * v_m, anchor: 1e-3 * v_a };
            p_m += motion.motor;
            p_a += motion.anchor;
            travelled += motion.anchor.abs();
            ends = cable.step(1e-3, motion).unwrap();
            highest = highest.max(total(&cable, v_m, v_a, p_m, p_a) - start);
        }
        let end = total(&cable, v_m, v_a, p_m, p_a) - start;
        assert!(highest < 4e-3, "{winch} | {load} kg gained {highest} J");
        assert!(end < -1e-3 && travelled > 1e-3, "{winch} | {load} kg: {end} J, {travelled} m");
    }
}

/// A value of a range, or one of its edges one time in four.
fn edgy(range: std::ops::Range<f64>, edges: &'static [f64]) -> impl Strategy<Value = f64> {
    prop_oneof![3 => range, 1 => proptest::sample::select(edges)]
}

fn parameters() -> impl Strategy<Value = CableParameters> {
    let friction = (edgy(0.0..0.3, &[0.0]), edgy(0.0..2.0, &[0.0, 100.0]), edgy(0.5..1.0, &[1.0]));
    let drag = (edgy(0.0..300.0, &[0.0, 1e5]), edgy(0.1..20.0, &[1e-6, 1e6]));
    let rest = (edgy(0.0..30.0, &[0.0]), edgy(1e-5..1e-3, &[1e-8, 0.1]), edgy(0.0..1e-3, &[0.0]));
    let weakening = prop_oneof![
        Just(None),
        (
            edgy(0.0..0.6, &[0.0]),
            edgy(1e-4..0.1, &[1e-9, 1e3]),
            edgy(0.005..0.2, &[0.005]),
            proptest::sample::select(&WeakeningForm::ALL)
        )
            .prop_map(|(rise, speed, lag, form)| Some(Weakening { form, rise, speed, lag })),
    ];
    (friction, drag, rest, weakening).prop_map(|(friction, drag, rest, weakening)| CableParameters {
        friction: friction.0,
        viscous: friction.1,
        efficiency: friction.2,
        drag: drag.0,
        drag_fade: drag.1,
        pretension: rest.0,
        compliance: rest.1,
        sheath_compliance: rest.2,
        weakening,
    })
}

fn path() -> impl Strategy<Value = CablePath> {
    let free = || edgy(0.05..1.0, &[1e-3]).prop_map(|length| Segment::Free { length });
    let sheath =
        (edgy(0.1..2.0, &[1e-3]), edgy(0.0..5.0, &[0.0]), proptest::collection::vec(0.1..1.0_f64, 0..4))
            .prop_map(|(length, bend, curvature)| Segment::Sheath { length, bend, curvature });
    let pulley = edgy(0.0..2.0, &[0.0]).prop_map(|wrap| Segment::Pulley { wrap });
    let middle = prop_oneof![2 => sheath, 1 => pulley, 1 => free()];
    (free(), proptest::collection::vec(middle, 1..6), free()).prop_filter_map(
        "a path",
        |(first, middle, last)| {
            CablePath::new(std::iter::once(first).chain(middle).chain(std::iter::once(last)).collect()).ok()
        },
    )
}

/// Motions from none to absurd, both ends.
fn motions() -> impl Strategy<Value = Vec<(f64, f64)>> {
    let slide = || {
        prop_oneof![
            4 => -3e-4..3e-4_f64, 2 => Just(0.0), 2 => -1e-2..1e-2_f64, 1 => Just(1e-13), 1 => Just(0.1), 1 => Just(-0.1),
        ]
    };
    proptest::collection::vec((slide(), slide()), 10..120)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(800) })]

    #[test]
    fn no_cable_on_any_path_creates_energy_at_any_edge_of_its_domain(
        path in path(), parameters in parameters(), motions in motions(), extra in 0_usize..14,
        interval in edgy(1e-4..5e-3, &[1e-7, 0.02]), wraps in proptest::collection::vec(0.0..2.0_f64, 8),
        iterations in 1_usize..4,
    ) {
        let law = CableLaw::new(&path, &parameters, path.fewest_cells() + extra);
        // Too strong a pulley for one node, or no sheath to take more cells: refused, and that is fine.
        let Ok(law) = law else { return Ok(()) };
        let mut cable = Cable::new(law).with_iterations(iterations);
        cable.settle(parameters.pretension + 50.0, Sliding::TowardMotor).unwrap();
        let (mut work, mut scale) = (0.0, 0.0);
        let start = cable.energy();
        for (k, (motor, anchor)) in motions.into_iter().enumerate() {
            if k % 7 == 3 && path.pulleys() > 0 {
                // Refused where it would be too strong for its node; never half done.
                let _ = cable.set_wrap(k % path.pulleys(), wraps[k % 8]);
            }
            if k % 5 == 2 {
                let _ = cable.set_sheath_bend(2.0 * wraps[(k + 3) % 8]);
            }
            let ends = cable.step(interval, EndMotion { motor, anchor }).unwrap();
            let done = ends.tension_in * motor - (ends.tension_out - parameters.pretension) * anchor;
            work += done;
            scale += done.abs() + cable.energy();
            prop_assert!(ends.tension_in >= 0.0 && ends.tension_out >= parameters.pretension);
            prop_assert!(cable.tensions().all(|t| t >= 0.0 && t.is_finite()), "{:?}", cable.tensions().collect::<Vec<_>>());
            prop_assert!(ends.dissipated >= -1e-12 - 1e-12 * (done.abs() + cable.energy()), "{} J of {done}", ends.dissipated);
            let sum: f64 = cable.tensions().zip(cable.law().compliance()).map(|(t, c)| t * c).sum();
            prop_assert!((sum - cable.stretch().max(0.0)).abs() <= 1e-12 + 1e-9 * sum, "{sum} and {}", cable.stretch());
        }
        prop_assert!(cable.energy() - start - work <= 1e-9 * scale + 1e-11, "{} J", cable.energy() - start - work);
    }
}
