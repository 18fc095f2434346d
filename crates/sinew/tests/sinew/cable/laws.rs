//! Closed forms, limits, and what must be refused.

use sinew::Error;
use sinew::transmission::cable::{
    Cable, CableBatch, CableLaw, CableParameters, CablePath, EndMotion, EndTensions, Segment, Weakening,
};
use sinew::transmission::{Elongation, Sliding};

fn without_drag() -> CableParameters {
    CableParameters { drag: 0.0, ..CableParameters::bench() }
}

fn cable(parameters: &CableParameters, cells: usize) -> Cable {
    Cable::new(CableLaw::new(&CablePath::bench(), parameters, cells).unwrap())
}

fn both(speed: f64) -> EndMotion {
    EndMotion { motor: 1e-3 * speed, anchor: 1e-3 * speed }
}

#[test]
fn sliding_is_the_capstan_law_exactly_whatever_came_before() {
    for cells in [3, 8, 12, 40] {
        for (speed, sliding) in [(0.1, Sliding::TowardMotor), (-0.1, Sliding::AwayFromMotor)] {
            let parameters = without_drag();
            let mut cable = cable(&parameters, cells);
            let opposite = if speed > 0.0 { Sliding::AwayFromMotor } else { Sliding::TowardMotor };
            cable.settle(120.0, opposite).unwrap();
            let mut ends = cable.ends();
            for _ in 0..3000 {
                ends = cable.step(1e-3, both(speed)).unwrap();
            }
            let ratio = ends.tension_in / (ends.tension_out - parameters.pretension);
            let angle = sliding.sign() * cable.law().friction_angle();
            // The series of the hyperbolic tangent is exact to 2e-9 up to a node angle of 0.3.
            let exact = if cells == 3 { 1e-4 } else { 1e-8 };
            assert!((ratio / angle.exp() - 1.0).abs() < exact, "{cells} cells: {ratio} and {}", angle.exp());
        }
    }
}

#[test]
fn the_stretch_of_sliding_converges_with_order_two_to_the_integral_of_tension() {
    let path = CablePath::new(vec![
        Segment::Free { length: 1e-6 },
        Segment::Sheath { length: 0.8, bend: 5.0, curvature: vec![] },
        Segment::Free { length: 1e-6 },
    ])
    .unwrap();
    let parameters = CableParameters { friction: 0.2, efficiency: 1.0, pretension: 0.0, ..without_drag() };
    let exact = Elongation::new(parameters.compliance, 1.0, 0.2, 5.0 / 0.8, 0.8, 0.0)
        .and_then(|law| law.stretch(100.0, Sliding::TowardMotor))
        .unwrap();
    // What is left of 100 N behind the sheath, and both ends' fraction of the stretch.
    let far = 100.0 * (-1.0_f64).exp();
    let ends = 1e-6 * parameters.compliance * (100.0 + far);
    let error = |cells: usize| {
        let mut cable = Cable::new(CableLaw::new(&path, &parameters, cells + 2).unwrap());
        cable.settle(far, Sliding::TowardMotor).unwrap();
        (cable.stretch() - ends - exact).abs()
    };
    let order = (error(8) / error(32)).ln() / 4.0_f64.ln();
    assert!((order - 2.0).abs() < 0.1, "order {order}");
}

#[test]
fn time_steps_converge_with_order_one() {
    // Drag makes the law depend on time; everything slides, so nothing but the step's length is at work.
    let far = |per_second: u32| {
        let mut cable = cable(&CableParameters::bench(), 12).with_iterations(6);
        cable.settle(100.0, Sliding::TowardMotor).unwrap();
        let mut ends = cable.ends();
        let at = |step: u32| {
            let t = f64::from(step) / f64::from(per_second);
            0.1 * t + 0.004 * (15.0 * t).sin()
        };
        for step in 0..per_second / 10 {
            let motion = EndMotion { motor: at(step + 1) - at(step), anchor: 0.1 / f64::from(per_second) };
            ends = cable.step(1.0 / f64::from(per_second), motion).unwrap();
        }
        ends.tension_out
    };
    let (a, b, c) = (far(500), far(1000), far(2000));
    let order = ((b - a) / (c - b)).abs().ln() / 2.0_f64.ln();
    assert!((order - 1.0).abs() < 0.3, "order {order}: {a} {b} {c}");
    assert!((a - b).abs() > 1e-6, "nothing happened");
}

#[test]
fn a_cable_that_is_held_does_not_creep() {
    let mut cable = cable(&CableParameters::bench(), 12);
    cable.settle(80.0, Sliding::AwayFromMotor).unwrap();
    for _ in 0..500 {
        cable.step(1e-3, EndMotion { motor: 4e-5, anchor: 0.0 }).unwrap();
    }
    for _ in 0..200 {
        cable.step(1e-3, EndMotion::default()).unwrap();
    }
    let before: Vec<f64> = cable.tensions().collect();
    for _ in 0..100_000 {
        cable.step(1e-3, EndMotion::default()).unwrap();
    }
    for (then, now) in before.iter().zip(cable.tensions()) {
        assert!((then - now).abs() < 1e-6, "{then} became {now}");
    }
    assert!(before[0] > 2.0 * before[11], "the hold began in a stick profile: {before:?}");
}

#[test]
fn tension_after_slack_is_that_of_sliding() {
    for (motion, sliding) in [
        (EndMotion { motor: 5e-5, anchor: 0.0 }, Sliding::TowardMotor),
        (EndMotion { motor: 0.0, anchor: -5e-5 }, Sliding::AwayFromMotor),
    ] {
        let mut cable = cable(&without_drag(), 12);
        cable.settle(50.0, Sliding::TowardMotor).unwrap();
        while cable.stretch() > -0.01 {
            cable.step(1e-3, EndMotion { motor: -1e-4, anchor: 0.0 }).unwrap();
        }
        assert!(cable.ends().tension_in == 0.0 && (cable.ends().tension_out - 15.5).abs() < 1e-12);
        while cable.stretch() < 0.02 {
            cable.step(1e-3, motion).unwrap();
        }
        let mut slid = Cable::new(cable.law().clone());
        slid.settle(cable.ends().tension_out, sliding).unwrap();
        for (t, exact) in cable.tensions().zip(slid.tensions()) {
            assert!((t / exact - 1.0).abs() < 1e-6, "{t} and {exact} N");
        }
        assert!(cable.ends().tension_out > 30.0);
    }
}

#[test]
fn without_friction_tension_is_the_same_everywhere() {
    let parameters = CableParameters { friction: 0.0, efficiency: 1.0, ..without_drag() };
    let mut cable = cable(&parameters, 12);
    let mut far = 0.0;
    for step in 0..3000 {
        let t = f64::from(step) * 1e-3;
        let motion = EndMotion { motor: 1e-4 * (3.0 * t).cos(), anchor: -1e-5 };
        far = cable.step(1e-3, motion).unwrap().tension_out;
        let first = cable.ends().tension_in;
        assert!(cable.tensions().all(|tension| (tension - first).abs() < 1e-9));
    }
    assert!(far > 20.0, "it was tight in the end: {far}");
}

#[test]
fn tension_is_never_negative_and_never_lost_in_any_motion() {
    let mut cable = cable(&CableParameters::bench(), 8);
    let mut random = Random(7);
    let mut taut = 0;
    for _ in 0..200_000 {
        let motion = EndMotion { motor: 3e-3 * random.unit(), anchor: 3e-3 * random.unit() };
        let ends = cable.step(1e-3, motion).unwrap();
        assert!(cable.tensions().all(|t| t >= 0.0 && t.is_finite()));
        assert!(ends.tension_in >= 0.0 && ends.tension_out >= 15.5);
        let sum: f64 = cable.tensions().zip(cable.law().compliance()).map(|(t, c)| t * c).sum();
        assert!((sum - cable.stretch().max(0.0)).abs() < 1e-12, "{sum} and {}", cable.stretch());
        taut += usize::from(cable.stretch() > 0.0);
    }
    assert!((1000..199_000).contains(&taut), "both slack and taut were seen: {taut}");
}

#[test]
fn a_lane_and_a_lone_cable_agree_to_the_bit() {
    let weakening = Some(Weakening::rational(0.4, 4e-3, 0.04));
    for weakening in [None, weakening] {
        let laws: Vec<CableLaw> = (0..19)
            .map(|k| {
                let friction = 0.1 + 0.005 * f64::from(k);
                let parameters = CableParameters { friction, weakening, ..CableParameters::bench() };
                CableLaw::new(&CablePath::bench(), &parameters, 10).unwrap()
            })
            .collect();
        let mut lanes = CableBatch::new(&laws).unwrap();
        let mut alone: Vec<Cable> = laws.into_iter().map(Cable::new).collect();
        let mut random = Random(3);
        let mut ends = [EndTensions::default(); 19];
        for _ in 0..3000 {
            let motions: [EndMotion; 19] = core::array::from_fn(|_| EndMotion {
                motor: 2e-4 * random.unit() + 2e-5,
                anchor: 2e-4 * random.unit(),
            });
            lanes.step(1e-3, &motions, &mut ends).unwrap();
            for (cable, (motion, end)) in alone.iter_mut().zip(motions.iter().zip(&ends)) {
                let expected = cable.step(1e-3, *motion).unwrap();
                assert_eq!(expected.tension_in.to_bits(), end.tension_in.to_bits());
                assert_eq!(expected.tension_out.to_bits(), end.tension_out.to_bits());
                assert_eq!(expected.dissipated.to_bits(), end.dissipated.to_bits());
            }
        }
        assert!(lanes.tensions(18).zip(alone[18].tensions()).all(|(a, b)| a.to_bits() == b.to_bits()));
    }
}

#[test]
fn a_wrap_that_shrinks_lets_the_stuck_cable_slip() {
    let mut cable = cable(&without_drag(), 12);
    cable.settle(100.0, Sliding::TowardMotor).unwrap();
    let before = cable.ends().tension_out;
    let full = std::f64::consts::FRAC_PI_2;
    for step in 1..=500 {
        cable.set_wrap(0, full * (1.0 - f64::from(step) / 500.0)).unwrap();
        cable.step(1e-3, EndMotion::default()).unwrap();
    }
    // Less friction between the ends: what was held back at the near side reaches the anchor.
    assert!(cable.ends().tension_out > before + 3.0, "{} to {}", before, cable.ends().tension_out);
    assert!((cable.law().friction_angle() - (1.054 - 0.156 * full)).abs() < 2e-3);
}

#[test]
fn a_sheath_that_bends_further_is_the_cable_built_with_that_bend() {
    let bent = |bend: f64, curvature: &[f64]| {
        let mut segments = CablePath::bench().segments().to_vec();
        segments[1] = Segment::Sheath { length: 0.806, bend, curvature: curvature.to_vec() };
        CableLaw::new(&CablePath::new(segments).unwrap(), &CableParameters::bench(), 12).unwrap()
    };
    for curvature in [&[][..], &[1.0, 3.0, 0.5]] {
        for (from, to) in [(1.0, 2.5), (2.5, 0.4), (3.0, 0.0)] {
            let (changed, built) = (bent(from, curvature).with_sheath_bend(to).unwrap(), bent(to, curvature));
            assert!((changed.friction_angle() - built.friction_angle()).abs() < 1e-12);
            for velocity in [0.08, -0.03] {
                let [a, b] = [&changed, &built].map(|law| law.steady(90.0, velocity, 1.0).unwrap());
                assert!((a.tension_in - b.tension_in).abs() < 1e-9 && (a.stretch - b.stretch).abs() < 1e-12);
            }
        }
    }
    // A straight sheath bends evenly.
    let straight = bent(0.0, &[]).with_sheath_bend(2.0).unwrap();
    assert!(
        (straight.steady(90.0, 0.1, 1.0).unwrap().tension_in
            - bent(2.0, &[]).steady(90.0, 0.1, 1.0).unwrap().tension_in)
            .abs()
            < 1e-9
    );
    // One cable and a lane of several are bit-identical, refusals leave them as they were.
    let law = bent(1.0, &[]);
    let (mut one, mut many) = (Cable::new(law.clone()), CableBatch::new(&vec![law; 9]).unwrap());
    one.settle(80.0, Sliding::TowardMotor).unwrap();
    many.settle(8, 80.0, Sliding::TowardMotor).unwrap();
    let mut ends = [EndTensions::default(); 9];
    for k in 0..400 {
        let bend = 1.0 + (f64::from(k) * 0.02).sin();
        one.set_sheath_bend(bend).unwrap();
        many.set_sheath_bend(8, bend).unwrap();
        let motion = EndMotion { motor: 1e-4 * (f64::from(k) * 0.05).cos(), anchor: 0.0 };
        let alone = one.step(1e-3, motion).unwrap();
        many.step(1e-3, &[motion; 9], &mut ends).unwrap();
        assert_eq!(alone.tension_out.to_bits(), ends[8].tension_out.to_bits());
        for wrong in [-0.1, f64::NAN, f64::INFINITY, 500.0] {
            assert!(one.set_sheath_bend(wrong).is_err() && many.set_sheath_bend(8, wrong).is_err());
        }
    }
    let segments =
        vec![Segment::Free { length: 1.0 }, Segment::Pulley { wrap: 1.0 }, Segment::Free { length: 1.0 }];
    let pulley = CableLaw::new(&CablePath::new(segments).unwrap(), &CableParameters::bench(), 2).unwrap();
    assert!(pulley.clone().with_sheath_bend(0.0).is_ok() && pulley.with_sheath_bend(0.1).is_err());
}

#[test]
fn the_travel_that_a_tension_asks_for_brings_it() {
    for (start, desired, sliding) in [
        (60.0, 110.0, Sliding::TowardMotor),
        (60.0, 60.4, Sliding::TowardMotor),
        (140.0, 70.0, Sliding::AwayFromMotor),
        (140.0, 16.0, Sliding::AwayFromMotor),
    ] {
        for before in [Sliding::TowardMotor, Sliding::AwayFromMotor] {
            let mut cable = cable(&without_drag(), 12);
            cable.settle(start, before).unwrap();
            let travel = cable.travel_to(desired, sliding).unwrap();
            assert!(travel * sliding.sign() > 0.0);
            for _ in 0..4000 {
                cable.step(1e-3, EndMotion { motor: travel / 4000.0, anchor: 0.0 }).unwrap();
            }
            let got = cable.ends().tension_out;
            assert!((got - desired).abs() < 0.02, "{desired} desired, {got} after {travel} m");
        }
    }
}

#[test]
fn a_reversal_is_prepared_without_moving_the_far_end() {
    let mut cable = cable(&without_drag(), 12);
    cable.settle(90.0, Sliding::AwayFromMotor).unwrap();
    let travel = cable.travel_to(90.0, Sliding::TowardMotor).unwrap();
    assert!(travel > 0.01, "the dead band is centimetres wide: {travel}");
    for _ in 0..2000 {
        cable.step(1e-3, EndMotion { motor: travel / 2000.0, anchor: 0.0 }).unwrap();
    }
    assert!((cable.ends().tension_out - 90.0).abs() < 0.02);
    cable.step(1e-3, EndMotion { motor: 1e-3, anchor: 0.0 }).unwrap();
    assert!(cable.ends().tension_out > 90.0 + 1.0, "and the next pull reaches it at once");
}

#[test]
fn friction_that_weakens_with_speed_is_highest_after_rest() {
    let weakening = Weakening::rational(0.5, 3e-3, 0.05);
    let parameters = CableParameters { weakening: Some(weakening), ..without_drag() };
    // Smallest and largest friction angle between the ends while the whole cable slides at a speed.
    let angles = |speed: f64| {
        let mut cable = cable(&parameters, 12);
        cable.settle(100.0, Sliding::TowardMotor).unwrap();
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for step in 0..20_000 {
            let ends = cable.step(1e-3, both(speed)).unwrap();
            let angle = (ends.tension_in / (ends.tension_out - parameters.pretension)).ln();
            if step > 4000 {
                (least, most) = (least.min(angle), most.max(angle));
            }
        }
        (least, most)
    };
    let plain = cable(&without_drag(), 12).law().friction_angle();
    let sliding = plain + parameters.efficiency.ln();
    let (least, most) = angles(0.3);
    let expected = plain + sliding * (weakening.factor(0.3) - 1.0);
    assert!(
        (least - expected).abs() < 1e-6 && (most - expected).abs() < 1e-6,
        "{least} to {most}, {expected}"
    );
    // Slowly it sticks and slips: beyond sliding friction, never beyond that of rest.
    let (_, most) = angles(0.001);
    assert!(most > plain + 0.15 && most < plain + 0.5 * sliding + 1e-6, "{most}");
}

#[test]
fn what_is_not_physical_is_refused_by_name() {
    let refused = |change: fn(&mut CableParameters), name: &str| {
        let mut parameters = CableParameters::bench();
        change(&mut parameters);
        let error = CableLaw::new(&CablePath::bench(), &parameters, 12).unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
    };
    refused(|p| p.friction = -0.1, "friction");
    refused(|p| p.friction = f64::NAN, "friction");
    refused(|p| p.friction = 5.0, "friction angle of a node");
    refused(|p| p.viscous = f64::INFINITY, "viscous");
    refused(|p| p.efficiency = 1.01, "efficiency");
    refused(|p| p.efficiency = 0.0, "efficiency");
    refused(|p| p.drag = -1.0, "drag");
    refused(|p| p.drag_fade = 0.0, "drag_fade");
    refused(|p| p.pretension = -1.0, "pretension");
    refused(|p| p.compliance = 0.0, "compliance");
    refused(|p| p.sheath_compliance = f64::NAN, "sheath_compliance");
    refused(|p| p.weakening = Some(Weakening::rational(-1.0, 1.0, 0.1)), "weakening.rise");
    refused(|p| p.weakening = Some(Weakening::rational(1.0, 0.0, 0.1)), "weakening.speed");
    refused(|p| p.weakening = Some(Weakening::rational(1.0, 1.0, 0.0)), "weakening.lag");
}

#[test]
fn a_step_that_cannot_be_taken_leaves_everything_as_it_was() {
    let mut one = cable(&CableParameters::bench(), 8);
    one.settle(70.0, Sliding::TowardMotor).unwrap();
    let mut many = CableBatch::new(&[one.law().clone(), one.law().clone()]).unwrap();
    many.settle(1, 70.0, Sliding::TowardMotor).unwrap();
    let before: Vec<f64> = one.tensions().collect();
    let still = EndMotion::default();
    let mut ends = [EndTensions::default(); 2];
    for bad in [f64::NAN, f64::INFINITY, 0.2, -0.2] {
        for motion in [EndMotion { motor: bad, anchor: 0.0 }, EndMotion { motor: 0.0, anchor: bad }] {
            assert!(matches!(one.step(1e-3, motion), Err(Error::OutOfDomain { .. })), "{bad}");
            assert!(matches!(many.step(1e-3, &[still, motion], &mut ends), Err(Error::OutOfDomain { .. })));
        }
    }
    for interval in [0.0, -1e-3, f64::NAN, 0.1, f64::INFINITY] {
        assert!(one.step(interval, still).is_err() && many.step(interval, &[still; 2], &mut ends).is_err());
    }
    assert!(many.step(1e-3, &[still], &mut ends).is_err());
    assert!(many.step(1e-3, &[still; 2], &mut ends[..1]).is_err());
    assert!(
        one.settle(10.0, Sliding::TowardMotor).is_err()
            && one.settle(f64::NAN, Sliding::TowardMotor).is_err()
    );
    assert!(
        one.set_wrap(1, 0.5).is_err() && one.set_wrap(0, -0.1).is_err() && one.set_wrap(0, 20.0).is_err()
    );
    assert!(one.travel_to(f64::NAN, Sliding::TowardMotor).is_err() && one.scale_drag(-1.0).is_err());
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(one.scale_compliance(bad).is_err() && many.scale_compliance(1, bad).is_err(), "{bad}");
    }
    assert!(many.scale_compliance(2, 1.2).is_err() && many.energy(2).is_err());
    assert!(many.settle(2, 70.0, Sliding::TowardMotor).is_err());
    assert!(one.tensions().eq(before.iter().copied()) && many.tensions(1).eq(before.iter().copied()));
    assert!(CableBatch::new(&[]).is_err());
    let other = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 9).unwrap();
    assert!(CableBatch::new(&[other, one.law().clone()]).is_err());
}

#[test]
fn a_softer_cable_keeps_its_length_and_loses_tension_and_energy_in_proportion() {
    for factor in [1.0, 7.0 / 6.0, 3.0] {
        let mut one = cable(&CableParameters::bench(), 12);
        one.settle(90.0, Sliding::TowardMotor).unwrap();
        let mut many = CableBatch::new(&vec![one.law().clone(); 9]).unwrap();
        (0..9).for_each(|k| many.settle(k, 90.0, Sliding::TowardMotor).unwrap());
        let (stretch, energy, tensions) = (one.stretch(), one.energy(), one.tensions().collect::<Vec<f64>>());
        one.scale_compliance(factor).unwrap();
        many.scale_compliance(8, factor).unwrap();
        assert_eq!(one.stretch().to_bits(), stretch.to_bits());
        assert!((factor * one.energy() - energy).abs() < 1e-12 * energy, "{factor}");
        assert!(one.tensions().zip(&tensions).all(|(now, before)| (factor * now - before).abs() < 1e-9));
        // The factor is of the law: the same again changes nothing, and one takes it back.
        let softer: Vec<f64> = one.tensions().collect();
        one.scale_compliance(factor).unwrap();
        assert!(one.tensions().eq(softer.iter().copied()));
        assert!(
            many.tensions(8).eq(one.tensions())
                && many.energy(8).unwrap().to_bits() == one.energy().to_bits()
        );
        assert!(many.tensions(7).eq(tensions.iter().copied()), "another lane");
        // What the winch takes up gives a tension that is smaller by the factor.
        let stiff = {
            let mut stiff = cable(&CableParameters::bench(), 12);
            stiff.settle(90.0, Sliding::TowardMotor).unwrap();
            (0..400)
                .map(|_| stiff.step(1e-3, EndMotion { motor: 2e-5, anchor: 0.0 }).unwrap())
                .last()
                .unwrap()
        };
        let soft = (0..400).map(|_| one.step(1e-3, EndMotion { motor: 2e-5, anchor: 0.0 }).unwrap()).last();
        assert!((factor * soft.unwrap().tension_in - stiff.tension_in).abs() < 0.05 * stiff.tension_in);
        one.scale_compliance(1.0).unwrap();
        assert!((one.stretch() - stretch - 8e-3).abs() < 1e-9);
    }
    let mut slack = cable(&CableParameters::bench(), 12);
    slack.step(1e-3, EndMotion { motor: -1e-3, anchor: 0.0 }).unwrap();
    slack.scale_compliance(1.5).unwrap();
    assert!((slack.stretch() + 1e-3).abs() < 1e-12 && slack.tensions().all(|tension| tension == 0.0));
}

#[test]
fn a_cable_continues_from_its_saved_state_to_the_bit() {
    let weakening = Some(Weakening::rational(0.3, 0.01, 0.01));
    let laws: Vec<CableLaw> = (0..19)
        .map(|k| {
            let weakening = weakening.filter(|_| k < 8);
            let parameters = CableParameters {
                friction: 0.1 + 0.01 * f64::from(k),
                weakening,
                ..CableParameters::bench()
            };
            CableLaw::new(&CablePath::bench(), &parameters, 9).unwrap()
        })
        .collect();
    let mut cables = CableBatch::new(&laws).unwrap();
    let (mut other, mut random) = (cables.clone(), Random(5));
    assert_eq!(cables.state_len(), 3 * 9);
    let mut ends = vec![EndTensions::default(); 19];
    let mut other_ends = ends.clone();
    let mut state = vec![0.0; cables.state_len()];
    for round in 0..300 {
        let motions: Vec<_> = (0..19)
            .map(|_| EndMotion { motor: 2e-3 * random.unit(), anchor: 1e-3 * random.unit() })
            .collect();
        if round % 3 == 0 {
            for k in 0..19 {
                cables.save(k, &mut state).unwrap();
                other.restore(k, &state).unwrap();
            }
        }
        cables.step(1e-3, &motions, &mut ends).unwrap();
        other.step(1e-3, &motions, &mut other_ends).unwrap();
        assert_eq!(ends, other_ends);
    }
    assert!(cables.save(19, &mut state).is_err() && cables.save(0, &mut state[1..]).is_err());
    for (index, wrong) in [(0, f64::NAN), (1, f64::INFINITY), (4, -1.0)] {
        let mut damaged = state.clone();
        damaged[index] = wrong;
        assert!(matches!(other.restore(0, &damaged), Err(Error::OutOfDomain { name: "state", .. })));
    }
}

/// Numbers in [-1, 1) that are the same everywhere (splitmix64).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}
