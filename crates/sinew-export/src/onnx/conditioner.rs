//! Time stamps, missing values and spikes of a sample.

use super::graph::{Graph, Kind, Value};
use sinew::predictor::{InputLimits, MAX_HELD_SAMPLES, MAX_MAGNITUDE, Model};

/// A sample as the predictor takes it.
pub(super) struct Sample {
    /// Table of the inputs.
    pub(super) values: Value,
    pub(super) dt_s: Value,
    /// Zero, one for each sequence.
    pub(super) zero: Value,
    /// Whether the sample follows the one before; else it starts a sequence.
    pub(super) next: Value,
    /// Whether its time is that of the sample before.
    pub(super) repeated: Value,
    pub(super) any_held: Value,
    /// Whether an input is outside its range in training.
    pub(super) outside: Value,
}

/// As `Conditioner::update`.
pub(super) fn condition(g: &mut Graph, model: &Model, time: Value, inputs: Value) -> Sample {
    let column = |of: fn(&InputLimits) -> f64| model.guards.iter().map(of).collect::<Vec<f64>>();
    let [jump, low, high, typical] =
        [column(|l| l.jump), column(|l| l.low), column(|l| l.high), column(|l| l.typical)]
            .map(|row| g.doubles(&row));
    let [clock, count] = [3, 2 * model.inputs.len()].map(|width| g.remember(width));
    let (zero, one) = (g.double(0.0), g.double(1.0));

    let before = g.split(clock.before, &[1, 1, 1]);
    let (started, time_before, dt_before) = (g.op("Greater", &[before[0], zero]), before[1], before[2]);
    let (magnitude, most) = (g.op("Abs", &[time]), g.double(f64::MAX));
    let timed = g.op("LessOrEqual", &[magnitude, most]);
    let difference = g.op("Sub", &[time, time_before]);
    let interval = g.select(timed, difference, dt_before);
    let same = g.op("Equal", &[interval, zero]);
    let repeated = g.op("And", &[started, same]);
    let (backwards, gap) = (g.op("GreaterOrEqual", &[interval, zero]), g.double(model.gap_s));
    let no_gap = g.op("LessOrEqual", &[interval, gap]);
    let follows = g.op("And", &[backwards, no_gap]);
    let next = g.op("And", &[started, follows]);
    let dt_s = g.select(next, interval, zero);
    let later = g.op("Add", &[time_before, dt_s]);
    let time_s = g.select(timed, time, later);
    let nothing = g.op("Sub", &[dt_s, dt_s]);
    let always = g.op("Add", &[nothing, one]);
    let after = g.join(&[always, time_s, dt_s]);
    g.keep(clock, after);

    let n = model.inputs.len();
    let halves = g.split(count.before, &[n, n]);
    let (last, held) = (halves[0], halves[1]);
    let change = g.op("Sub", &[inputs, last]);
    let change = g.op("Abs", &[change]);
    let (jumps, patience) = (g.op("Greater", &[change, jump]), g.double(f64::from(MAX_HELD_SAMPLES)));
    let patient = g.op("Less", &[held, patience]);
    let spike = g.op("And", &[jumps, patient]);
    let spike = g.op("And", &[spike, next]);
    let (magnitude, most) = (g.op("Abs", &[inputs]), g.double(MAX_MAGNITUDE));
    let there = g.op("LessOrEqual", &[magnitude, most]);
    let spiked = g.op("Not", &[spike]);
    let accepted = g.op("And", &[there, spiked]);
    let kept = g.select(started, last, typical);
    let values = g.select(accepted, inputs, kept);
    let longer = g.cast(spike, Kind::Double);
    let longer = g.op("Add", &[held, longer]);
    let held = g.select(accepted, zero, longer);
    let after = g.join(&[values, held]);
    g.keep(count, after);

    let replaced = g.op("Not", &[accepted]);
    let (below, above) = (g.op("Less", &[values, low]), g.op("Greater", &[values, high]));
    let outside = g.op("Or", &[below, above]);
    let (any_held, outside) = (g.any(replaced), g.any(outside));
    Sample { values, dt_s, zero: nothing, next, repeated, any_held, outside }
}
