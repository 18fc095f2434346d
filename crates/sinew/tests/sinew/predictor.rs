//! Guarantees of the predictor: finite predictions, exact resumption, resets, model files.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::common;

use common::{EASED, PULLED, SIGMA_0, capstan, complete};
use proptest::prelude::*;
use sinew::predictor::{InputLimits, MAX_MAGNITUDE, Model, Prediction, Predictor, Sample, Signal, VERSION};
use sinew::transmission::BasisTerm;

/// Number, number, number, flags: predictions are compared bit for bit.
fn bits(p: &Prediction) -> (u64, u64, u64, String) {
    (p.mean.to_bits(), p.standard_deviation.to_bits(), p.gate.to_bits(), format!("{:?}", p.flags))
}

fn run(predictor: &mut Predictor, samples: &[(f64, [f64; 3])]) -> Vec<Prediction> {
    let width = predictor.model().inputs.len();
    samples
        .iter()
        .map(|(time_s, inputs)| predictor.step(&Sample { time_s: *time_s, inputs: &inputs[..width] }))
        .collect()
}

/// A plausible log of `n` samples at 100 Hz with a gap in the middle.
fn plausible(n: u32) -> Vec<(f64, [f64; 3])> {
    (0..n)
        .map(|k| {
            let t = f64::from(k) * 0.01;
            let gap = if k > n / 2 { 3.0 } else { 0.0 };
            let swing = 40.0 * (3.0 * t).sin() + 8.0 * (11.0 * t).sin();
            (t + gap, [60.0 + swing, 60.0 - swing, 0.03 * (3.0 * t).cos()])
        })
        .collect()
}

#[track_caller]
fn sound(p: &Prediction) {
    assert!(p.mean.is_finite(), "{p:?}");
    assert!(p.standard_deviation.is_finite() && p.standard_deviation >= 0.0, "{p:?}");
    assert!((0.0..=1.0).contains(&p.gate), "{p:?}");
}

/// Any bit pattern, special values with higher probability.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<u64>().prop_map(f64::from_bits),
        -300.0..300.0,
        prop::sample::select(vec![
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::MAX,
            f64::MIN,
            f64::MIN_POSITIVE,
            5e-324,
            -5e-324,
            0.0,
            -0.0,
            1e30,
            -1e160,
            1e200,
        ]),
    ]
}

/// Times that mostly run forward, so that the state matters, and sometimes arbitrary ones.
fn any_samples() -> impl Strategy<Value = Vec<(f64, [f64; 3])>> {
    let step = prop_oneof![8 => (0.0..0.02).prop_map(Ok), 1 => any_number().prop_map(Err)];
    prop::collection::vec((step, prop::array::uniform3(any_number())), 1..80).prop_map(|list| {
        let mut now = 0.0;
        list.into_iter()
            .map(|(step, inputs)| match step {
                Ok(dt_s) => {
                    now += dt_s;
                    (now, inputs)
                }
                Err(time_s) => (time_s, inputs),
            })
            .collect()
    })
}

proptest! {
    #[test]
    fn a_finite_model_gives_finite_predictions_for_any_measurement(samples in any_samples()) {
        for model in [capstan(), complete()] {
            run(&mut Predictor::new(model).unwrap(), &samples).iter().for_each(sound);
        }
    }

    #[test]
    fn predictions_are_finite_without_input_limits(samples in any_samples()) {
        let mut model = complete();
        for guard in &mut model.guards {
            *guard = InputLimits { jump: f64::MAX, ..*guard };
        }
        run(&mut Predictor::new(model).unwrap(), &samples).iter().for_each(sound);
    }

    #[test]
    fn a_cloned_predictor_continues_to_the_bit(samples in any_samples(), place in 0.0..1.0) {
        let mut whole = Predictor::new(complete()).unwrap();
        let expected = run(&mut whole, &samples);
        let split = (place * samples.len() as f64) as usize;
        let mut first = Predictor::new(complete()).unwrap();
        let mut seen = run(&mut first, &samples[..split]);
        let mut second = first.clone();
        // Samples of the original after the split do not affect the clone.
        first.step(&Sample { time_s: 0.0, inputs: &[1.0, 2.0, 3.0] });
        seen.extend(run(&mut second, &samples[split..]));
        prop_assert!(seen.iter().map(bits).eq(expected.iter().map(bits)));
    }

    #[test]
    fn predictions_after_a_reset_do_not_depend_on_the_past(past in any_samples(), future in any_samples()) {
        let mut fresh = Predictor::new(complete()).unwrap();
        let expected = run(&mut fresh, &future);
        let mut used = Predictor::new(complete()).unwrap();
        run(&mut used, &past);
        used.reset();
        let seen = run(&mut used, &future);
        prop_assert!(seen.iter().map(bits).eq(expected.iter().map(bits)));
    }
}

#[test]
fn a_plausible_log_excites_every_part_of_the_complete_model() {
    // Validates the tests above: a model with inactive parts would pass them all.
    let seen = run(&mut Predictor::new(complete()).unwrap(), &plausible(400));
    let range = |value: fn(&Prediction) -> f64| {
        let values = seen.iter().map(value);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    };
    assert!(range(|p| p.mean) > 30.0);
    assert!(range(|p| p.gate) > 0.05);
    assert!(seen.iter().any(|p| p.flags.state_unknown) && seen.iter().any(|p| !p.flags.state_unknown));
    assert_eq!(seen.iter().filter(|p| p.flags.reset).count(), 2, "the start and the gap");
}

#[test]
fn the_far_end_is_constant_inside_the_dead_band_and_follows_the_law_outside_it() {
    let mut predictor = Predictor::new(capstan()).unwrap();
    let mut time_s = 0.0;
    let mut pull_to = |tension: f64| {
        time_s += 0.01;
        predictor.step(&Sample { time_s, inputs: &[tension] })
    };
    // The start is unknown: the middle of the band, with the variance of a uniform distribution over it.
    let start = pull_to(100.0);
    assert!(start.flags.state_unknown);
    assert!((start.mean - 0.5 * (PULLED + EASED) * 100.0).abs() < 1e-12);
    let width = (EASED - PULLED) * 100.0;
    assert!((start.standard_deviation - (SIGMA_0 * SIGMA_0 + width * width / 12.0).sqrt()).abs() < 1e-9);
    // Pulled until it slides, and further.
    for tension in [200.0, 220.0, 240.0] {
        let sliding = pull_to(tension);
        assert!(!sliding.flags.state_unknown);
        assert!((sliding.mean - PULLED * tension).abs() < 1e-12, "{sliding:?}");
        assert!((sliding.standard_deviation - SIGMA_0).abs() < 1e-12);
    }
    // Released: the far end is constant until the near tension has fallen by the ratio of the two losses.
    let plateau = PULLED * 240.0;
    let leaves_at = plateau / EASED;
    for step in 0..100 {
        let tension = 240.0 - f64::from(step) * (240.0 - leaves_at) / 100.0;
        assert_eq!(pull_to(tension).mean.to_bits(), plateau.to_bits());
    }
    for tension in [leaves_at - 1.0, 100.0, 50.0] {
        assert!((pull_to(tension).mean - EASED * tension).abs() < 1e-12);
    }
}

#[test]
fn flags_report_resets_repetitions_and_replaced_inputs() {
    let mut predictor = Predictor::new(capstan()).unwrap();
    let mut at = |time_s: f64, tension: f64| predictor.step(&Sample { time_s, inputs: &[tension] }).flags;
    assert!(at(0.0, 100.0).reset);
    let plain = at(0.1, 110.0);
    assert!(!plain.reset && !plain.input_held && !plain.out_of_range && !plain.repeated);
    assert!(at(0.2, f64::NAN).input_held);
    assert!(at(0.2, 120.0).repeated);
    assert!(at(0.3, 600.0).out_of_range);
    assert!(at(0.8001, 100.0).reset, "after a gap");
    assert!(at(0.7, 100.0).reset, "time ran backwards");
    assert!(at(0.75, 1e7).input_held, "a spike");
    assert!(at(0.76, f64::MAX).input_held, "no tension is that large");
}

#[test]
fn a_model_round_trips_through_its_file_to_the_bit() {
    for mut model in [capstan(), complete()] {
        model.estimator.sigma0 = 0.1 + 0.2;
        model.gap_s = f64::MIN_POSITIVE * 1.000_000_1;
        model.guards[0].typical = -0.0;
        model.guards[0].jump = f64::MAX;
        let text = model.to_json().unwrap();
        let again = Model::from_json(&text).unwrap();
        assert_eq!(again, model);
        assert_eq!(again.guards[0].typical.to_bits(), (-0.0_f64).to_bits());
        assert_eq!(again.to_json().unwrap(), text);
        let samples = plausible(200);
        let one = run(&mut Predictor::new(model).unwrap(), &samples);
        let other = run(&mut Predictor::new(again).unwrap(), &samples);
        assert!(one.iter().map(bits).eq(other.iter().map(bits)));
    }
}

#[test]
fn a_changed_byte_is_refused_or_changes_nothing() {
    let model = complete();
    let text = model.to_json().unwrap();
    let (mut refused, mut accepted) = (0, 0);
    for position in (0..text.len()).step_by(7).chain(0..120).chain(text.len() - 20..text.len()) {
        for change in [0x01, 0x02, 0x10, 0x20, 0x40, 0x80] {
            let mut bytes = text.clone().into_bytes();
            bytes[position] ^= change;
            // Invalid UTF-8 cannot be passed to the reader.
            let Ok(changed) = String::from_utf8(bytes) else { continue };
            match Model::from_json(&changed) {
                Ok(read) => {
                    assert_eq!(read, model, "byte {position}: {:?}", &changed[position..=position]);
                    accepted += 1;
                }
                Err(error) => {
                    assert!(error.to_string().starts_with("model file: "), "{error}");
                    refused += 1;
                }
            }
        }
    }
    assert!(refused > 1000 && accepted < 10, "{refused} refused, {accepted} accepted");
}

#[test]
fn a_file_that_ends_early_is_refused_wherever_it_ends() {
    let text = complete().to_json().unwrap();
    for end in (0..text.len() - 1).step_by(11) {
        assert!(Model::from_json(&text[..end]).is_err(), "{end} of {} bytes", text.len());
    }
}

/// The error for the file of the capstan after `from` was replaced by `to` in it.
#[track_caller]
fn refusal(from: &str, to: &str) -> String {
    let text = capstan().to_json().unwrap();
    assert!(text.contains(from), "{from} is not in {text}");
    Model::from_json(&text.replace(from, to)).unwrap_err().to_string()
}

#[test]
fn an_error_names_field_expectation_and_value() {
    let version = format!("\"version\":{VERSION}");
    let newer = refusal(&version, "\"version\":7");
    assert!(newer.contains("version") && newer.contains("got 7") && newer.contains("update"), "{newer}");
    let far_newer = refusal(&version, "\"version\":70000000000");
    assert!(far_newer.contains("version") && far_newer.contains("70000000000"), "{far_newer}");
    let format = refusal("sinew transmission model", "sinew arm");
    assert!(format.contains("format") && format.contains("sinew arm"), "{format}");
    let edited = refusal("0.7", "0.8");
    assert!(edited.contains("checksum") && edited.contains("damaged or edited"), "{edited}");
    for (text, word) in
        [("", "no JSON"), ("[1, 2]", "no JSON"), ("{}", "another kind"), ("{\"a\": 1}", "another kind")]
    {
        let error = Model::from_json(text).unwrap_err().to_string();
        assert!(error.contains(word), "{text}: {error}");
    }
}

/// The error for a modified model.
#[track_caller]
fn invalid(change: impl FnOnce(&mut Model)) -> String {
    let mut model = complete();
    model.validate().unwrap();
    change(&mut model);
    let error = model.validate().unwrap_err().to_string();
    assert_eq!(Predictor::new(model.clone()).unwrap_err().to_string(), error);
    assert_eq!(model.to_json().unwrap_err().to_string(), error, "what could not be read back is not written");
    error
}

#[test]
fn an_invalid_model_is_refused_before_the_first_prediction() {
    let cell = |m: &mut Model, change: fn(&mut sinew::transmission::ClampCell)| {
        change(m.estimator.law.cell.as_mut().unwrap());
    };
    assert!(invalid(|m| m.inputs.clear()).contains("inputs"));
    assert!(invalid(|m| m.guards.truncate(1)).contains("guards"));
    assert!(invalid(|m| m.guards[1].jump = f64::INFINITY).contains("guards.jump"));
    assert!(invalid(|m| m.guards[1].typical = f64::NAN).contains("guards"));
    assert!(invalid(|m| m.gap_s = 0.0).contains("gap_s"));
    assert!(invalid(|m| m.band_factor = -1.0).contains("band_factor"));
    assert!(invalid(|m| m.provenance.rmse_unseen = f64::NAN).contains("provenance.rmse_unseen"));
    assert!(invalid(|m| m.provenance.far_range = f64::INFINITY).contains("provenance.far_range"));
    assert!(invalid(|m| m.estimator.law.signals[0] = Signal::Input(3)).contains("law.signals"));
    assert!(invalid(|m| cell(m, |c| c.basis[1] = BasisTerm::Product(0, 5))).contains("cell.basis"));
    assert!(invalid(|m| cell(m, |c| c.low[1] = f64::NAN)).contains("cell.low"));
    assert!(invalid(|m| cell(m, |c| c.high.truncate(1))).contains("cell.high"));
    assert!(invalid(|m| cell(m, |c| c.branches.clear())).contains("cell.branches"));
    assert!(invalid(|m| cell(m, |c| c.start = f64::NAN)).contains("cell.start"));
    assert!(
        invalid(|m| m.estimator.ensemble.as_mut().unwrap().inverse_scale[0] = 0.0)
            .contains("ensemble.inverse_scale")
    );
    assert!(invalid(|m| m.estimator.ensemble.as_mut().unwrap().bias[7] = f32::NAN).contains("ensemble.bias"));
    let mut empty = capstan();
    empty.estimator.law.signals.clear();
    assert!(
        empty.validate().unwrap_err().to_string().contains("cell.basis"),
        "no signal, so not the first either"
    );
}

#[test]
fn the_largest_numbers_that_are_accepted_give_finite_predictions() {
    let mut model = complete();
    for guard in &mut model.guards {
        *guard =
            InputLimits { jump: f64::MAX, low: -MAX_MAGNITUDE, high: MAX_MAGNITUDE, typical: MAX_MAGNITUDE };
    }
    let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    let law = &mut model.estimator.law;
    let cell = law.cell.as_mut().unwrap();
    cell.low.iter_mut().enumerate().for_each(|(k, c)| *c = -MAX_MAGNITUDE * sign(k));
    cell.high.iter_mut().enumerate().for_each(|(k, c)| *c = MAX_MAGNITUDE * sign(k));
    cell.kappa.fill(MAX_MAGNITUDE);
    cell.branches.iter_mut().for_each(|branch| branch.fraction = MAX_MAGNITUDE);
    law.signals[3] = Signal::LogTension { input: 0, offset: 1e-30 };
    law.signals[4] = Signal::LogRatio { first: 0, second: 1, offset: 1e-30 };
    model.estimator.sigma0 = MAX_MAGNITUDE;
    model.band_factor = MAX_MAGNITUDE;
    let ensemble = model.estimator.ensemble.as_mut().unwrap();
    ensemble.clip_low.fill(-MAX_MAGNITUDE);
    ensemble.clip_high.fill(MAX_MAGNITUDE);
    ensemble.mean.fill(0.0);
    ensemble.inverse_scale.fill(0.99e-25);
    let lanes = [&mut ensemble.hidden_weights, &mut ensemble.output_weights, &mut ensemble.skip];
    for lane in lanes.into_iter().flatten() {
        lane.iter_mut().enumerate().for_each(|(k, weight)| *weight = 1e10 * sign(k) as f32);
    }
    model.validate().unwrap();
    let extremes =
        [MAX_MAGNITUDE, -MAX_MAGNITUDE, 0.0, -MAX_MAGNITUDE, MAX_MAGNITUDE, 1.0, f64::MAX, MAX_MAGNITUDE];
    let samples: Vec<(f64, [f64; 3])> = (0_u32..400)
        .map(|k| {
            let input = |step: u32| extremes[(k * step % 8) as usize];
            (f64::from(k) * 0.01, [input(1), input(3), input(5)])
        })
        .collect();
    run(&mut Predictor::new(model).unwrap(), &samples).iter().for_each(sound);
}

#[test]
fn a_model_with_numbers_out_of_range_is_refused() {
    // Each would overflow in a prediction.
    let huge = |m: &mut Model| m.estimator.law.cell.as_mut().unwrap().high[1] = 1e300;
    assert!(invalid(huge).contains("cell.high"));
    assert!(invalid(|m| m.estimator.sigma0 = 1e200).contains("sigma0"));
    assert!(invalid(|m| m.band_factor = 1e300).contains("band_factor"));
    assert!(
        invalid(|m| m.estimator.ensemble.as_mut().unwrap().inverse_scale[0] = 1e29)
            .contains("ensemble.inverse_scale")
    );
    assert!(invalid(|m| m.estimator.ensemble.as_mut().unwrap().skip[0][3] = 1e30).contains("ensemble.skip"));
    let tiny = Signal::LogRatio { first: 0, second: 1, offset: 1e-320 };
    assert!(invalid(|m| m.estimator.law.signals[4] = tiny).contains("law.signals"));
}
