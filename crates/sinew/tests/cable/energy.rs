//! No step creates energy, however violent; masses at both ends never swing up.

use crate::laws::Random;
use sinew::transmission::Sliding;
use sinew::transmission::cable::{
    Cable, CableLaw, CableParameters, Cables, EndMotion, EndTensions, Path, Weakening,
};

fn law(parameters: &CableParameters, cells: usize) -> CableLaw {
    CableLaw::new(&Path::bench(), parameters, cells).unwrap()
}

/// Random motion of both ends, `rms` m per step, pulled back to a stretch of about 30 mm.
fn shake(rms: f64, steps: usize, parameters: &CableParameters) {
    let mut cables = Cables::new(&vec![law(parameters, 12); 8]).unwrap();
    for cable in 0..8 {
        cables.settle(cable, 80.0, Sliding::TowardMotor).unwrap();
    }
    let energy = |cables: &Cables, k: usize| -> f64 {
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
    let weakening = Some(Weakening { rise: 0.6, speed: 3e-3, lag: 0.02 });
    shake(3e-4, 20_000, &CableParameters { weakening, ..CableParameters::bench() });
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
