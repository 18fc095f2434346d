//! No friction law returns more energy over a closed cycle than was put in, at the edges of its domain too.

use proptest::prelude::*;
use sinew::transmission::{
    BasisTerm, BoucWen, Branch, ClampCell, Dahl, LuGre, Play, Sliding, Stribeck, capstan_tension_out,
};

/// A value of a range, or one of its edges one time in four.
fn edgy(range: std::ops::Range<f64>, edges: &'static [f64]) -> impl Strategy<Value = f64> {
    prop_oneof![3 => range, 1 => proptest::sample::select(edges)]
}

/// Slides in m that sum to zero (to rounding): tiny, ordinary and huge ones mixed.
fn closed_cycle() -> impl Strategy<Value = Vec<f64>> {
    let slide = prop_oneof![
        4 => -1e-3..1e-3_f64, 2 => -1e-6..1e-6_f64, 1 => -0.5..0.5_f64, 1 => Just(0.0), 1 => Just(1e-14),
    ];
    proptest::collection::vec(slide, 3..40).prop_map(|mut slides| {
        let rest: f64 = slides.iter().sum();
        slides.push(-rest);
        slides
    })
}

/// Work done against a force over two rounds of a cycle, started without force: `(work, scale)`.
///
/// The force of a step's end is taken over the whole step: what an implicit neighbour feels.
fn work(cycle: &[f64], mut force: impl FnMut(usize, f64) -> f64) -> (f64, f64) {
    let (mut done, mut scale) = (0.0, 0.0);
    for round in 0..2 {
        for (i, &slide) in cycle.iter().enumerate() {
            let w = force(round * cycle.len() + i, slide) * slide;
            assert!(w.is_finite());
            done += w;
            scale += w.abs();
        }
    }
    (done, scale)
}

/// Passive, and with a guard: a path of many yield displacements must have cost something.
fn assert_passive(cycle: &[f64], yielded: f64, (done, scale): (f64, f64)) {
    assert!(done >= -1e-9 * scale - 1e-15, "created {} J", -done);
    let path: f64 = cycle.iter().map(|slide| slide.abs()).sum();
    if yielded > 0.0 && path > 50.0 * yielded {
        assert!(done > 1e-6 * scale, "moved {path} m and lost nothing of {scale} J");
    }
}

fn curve() -> impl Strategy<Value = Stribeck> {
    (
        edgy(0.0..0.5, &[0.0]),
        edgy(0.0..0.5, &[0.0]),
        edgy(1e-4..0.1, &[1e-9, 1e3]),
        edgy(0.0..1.0, &[0.0]),
        edgy(0.0..50.0, &[0.0]),
    )
        .prop_filter_map("valid", |(coulomb, extra, speed, viscous, drag)| {
            Stribeck::new(coulomb, coulomb + extra, speed, viscous, drag).ok()
        })
}

fn loads() -> impl Strategy<Value = Vec<f64>> {
    proptest::collection::vec(edgy(0.0..200.0, &[0.0, 1e-9, 1e4]), 1..9)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(512) })]

    #[test]
    fn dahl_never_creates_energy(
        cycle in closed_cycle(), stiffness in edgy(1.0..1e6, &[1e-3, 1e9]), coulomb in edgy(0.0..50.0, &[0.0, 1e-9]),
    ) {
        let law = Dahl::new(stiffness, coulomb).unwrap();
        let mut force = 0.0;
        let result = work(&cycle, |_, slide| { force = law.step(force, slide); force });
        assert_passive(&cycle, coulomb / stiffness, result);
    }

    #[test]
    fn bouc_wen_never_creates_energy(
        cycle in closed_cycle(), limit in edgy(0.1..50.0, &[1e-9]), distance in edgy(1e-6..1e-2, &[1e-9, 10.0]),
        sharpness in edgy(1.0..6.0, &[1.0, 2.0, 1000.0]), shape in edgy(0.5..1.0, &[0.5, 1.0]),
    ) {
        let law = BoucWen::new(limit, distance, sharpness, shape).unwrap();
        let mut z = 0.0;
        let result = work(&cycle, |_, slide| { z = law.step(z, slide); law.force(z) });
        assert_passive(&cycle, distance, result);
    }

    #[test]
    fn lugre_never_creates_energy_under_any_load(
        cycle in closed_cycle(), stiffness in edgy(1e2..1e6, &[1e-3, 1e9]), damping in edgy(0.0..1e4, &[0.0, 1e8]),
        curve in curve(), loads in loads(), interval in edgy(1e-4..0.1, &[1e-9, 10.0]),
    ) {
        let law = LuGre::new(stiffness, damping, curve).unwrap();
        let mut z = 0.0;
        let result = work(&cycle, |i, slide| {
            let step = law.step(z, slide, loads[i % loads.len()], interval);
            z = step.deflection;
            step.force
        });
        assert_passive(&cycle, 0.0, result);
    }

    /// Stronger than a cycle: every single step costs at least what its springs have gained.
    #[test]
    fn no_step_stores_more_than_it_took(
        cycle in closed_cycle(), stiffness in edgy(1e2..1e6, &[1e-3, 1e9]), damping in edgy(0.0..1e4, &[0.0, 1e8]),
        curve in curve(), loads in loads(), interval in edgy(1e-4..0.1, &[1e-9, 10.0]),
        sharpness in edgy(1.0..6.0, &[1.0, 1000.0]), shape in edgy(0.5..1.0, &[0.5, 1.0]),
    ) {
        let dahl = Dahl::new(stiffness, 3.0).unwrap();
        let bouc_wen = BoucWen::new(3.0, 3.0 / stiffness, sharpness, shape).unwrap();
        let lugre = LuGre::new(stiffness, damping, curve).unwrap();
        let (mut force, mut z, mut bend) = (0.0_f64, 0.0_f64, 0.0_f64);
        for (i, &slide) in cycle.iter().chain(&cycle).enumerate() {
            let load = loads[i % loads.len()];
            let before = [
                force * force / (2.0 * stiffness),
                9.0 * z * z / (2.0 * stiffness),
                stiffness * bend * bend / 2.0,
            ];
            force = dahl.step(force, slide);
            z = bouc_wen.step(z, slide);
            let step = lugre.step(bend, slide, load, interval);
            bend = step.deflection;
            let taken = [force, bouc_wen.force(z), step.force].map(|f| f * slide);
            let after = [
                force * force / (2.0 * stiffness),
                9.0 * z * z / (2.0 * stiffness),
                stiffness * bend * bend / 2.0,
            ];
            for law in 0..3 {
                let lost = taken[law] - (after[law] - before[law]);
                let scale = taken[law].abs() + after[law] + before[law];
                prop_assert!(lost >= -1e-9 * scale - 1e-18, "law {law}, step {i}: {lost} of {scale}");
            }
        }
    }

    #[test]
    fn a_stop_as_a_force_never_creates_energy(cycle in closed_cycle(), radius in edgy(1e-6..1e-2, &[0.0, 1e-12, 10.0])) {
        let law = Play::new(radius).unwrap();
        let (mut x, mut play) = (0.0, 0.0);
        let result = work(&cycle, |_, slide| {
            x += slide;
            play = law.step(play, x);
            1e4 * law.stop(play, x)
        });
        assert_passive(&cycle, if radius > 1e-9 { radius } else { 0.0 }, result);
    }

    #[test]
    fn a_clamp_cell_with_constant_bounds_never_creates_energy(
        cycle in closed_cycle(), force in edgy(0.0..20.0, &[0.0]), stiffness in edgy(0.0..1e6, &[0.0, 1e9]),
        narrow in edgy(0.01..1.0, &[1.0]), fraction in edgy(0.0..1.0, &[0.0, 1.0]),
    ) {
        let cell = ClampCell {
            basis: vec![BasisTerm::One],
            low: vec![-force],
            high: vec![force],
            elastic: vec![0],
            kappa: vec![stiffness],
            branches: vec![Branch { width: 1.0, fraction: 1.0 - fraction }, Branch { width: narrow, fraction }],
            start: 0.5,
        };
        let mut states = [0.0; 2];
        cell.start(&mut states, &[0.0], None);
        // The bounds are constant, so only the change of the displacement matters.
        let result = work(&cycle, |_, slide| cell.step(&mut states, &[slide], &[0.0]).state);
        assert_passive(&cycle, if stiffness > 0.0 { force / stiffness } else { 0.0 }, result);
    }

    #[test]
    fn a_capstan_pulled_there_and_back_never_pays(
        tensions in proptest::collection::vec(edgy(0.0..300.0, &[0.0]), 40), cycle in closed_cycle(),
        friction in edgy(0.0..0.5, &[0.0]), wrap in edgy(0.0..9.0, &[0.0]),
    ) {
        // The loss per metre is T_in - T_out, signed by the direction of sliding.
        let result = work(&cycle, |i, slide| {
            let Some(sliding) = Sliding::from_velocity(slide) else { return 0.0 };
            let near = tensions[i % tensions.len()];
            near - capstan_tension_out(near, friction, wrap, sliding).unwrap()
        });
        assert_passive(&cycle, 0.0, result);
    }

    #[test]
    fn stribeck_friction_and_drag_never_pay(
        tensions in proptest::collection::vec(edgy(0.0..300.0, &[0.0]), 40), cycle in closed_cycle(),
        curve in curve(), wrap in edgy(0.0..4.0, &[0.0]), efficiency in edgy(0.1..1.0, &[1.0]),
    ) {
        let result = work(&cycle, |i, slide| {
            let near = tensions[i % tensions.len()];
            // The constant T_0 does no work over a closed cycle and is left out.
            curve.tension_out(near, slide, wrap, efficiency, 0.0).map_or(0.0, |out| near - out)
        });
        assert_passive(&cycle, 0.0, result);
    }
}

#[test]
fn a_slow_large_cycle_costs_four_times_force_times_amplitude() {
    // The guard of guards: the dissipated work is not merely positive but right.
    let steps = 4000;
    let amplitude = 0.01;
    let cycle: Vec<f64> = (0..steps)
        .map(|i| {
            let at = |i: i32| amplitude * (f64::from(i) / f64::from(steps) * std::f64::consts::TAU).sin();
            at(i + 1) - at(i)
        })
        .collect();
    let dahl = Dahl::new(1e6, 2.0).unwrap();
    let bouc_wen = BoucWen::new(2.0, 2e-6, 2.0, 0.5).unwrap();
    let curve = Stribeck::coulomb(0.02).unwrap();
    let lugre = LuGre::new(1e6, 10.0, curve).unwrap();
    let (mut force, mut z, mut deflection) = (0.0, 0.0, 0.0);
    let losses = [
        work(&cycle, |_, dx| {
            force = dahl.step(force, dx);
            force
        })
        .0,
        work(&cycle, |_, dx| {
            z = bouc_wen.step(z, dx);
            bouc_wen.force(z)
        })
        .0,
        work(&cycle, |_, dx| {
            let step = lugre.step(deflection, dx, 100.0, 1e-3);
            deflection = step.deflection;
            step.force
        })
        .0,
    ];
    for loss in losses {
        assert!((loss / (2.0 * 4.0 * 2.0 * amplitude) - 1.0).abs() < 0.01, "{losses:?}");
    }
}
