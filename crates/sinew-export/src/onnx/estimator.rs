//! Clamp cell, features, regression, networks and members of an estimator, in the library's order of sums.

use super::conditioner::Sample;
use super::graph::{Graph, Kind, Slot, Value};
use sinew::predictor::{
    Ensemble, Estimator, FADE, Feature, GATE_STRENGTH, LinearLaw, MAX_MAGNITUDE, MEMBERS, Signal,
};
use sinew::transmission::{BasisTerm, ClampCell};

/// Where the quick hyperbolic tangent of the networks becomes constant.
const QUICK_EDGE: f32 = 4.97;

/// As `sinew::predictor::Estimate`.
#[derive(Clone, Copy)]
pub(super) struct Estimate {
    pub(super) mean: Value,
    pub(super) variance: Value,
    pub(super) gate: Value,
    /// None where there is no state that could be unknown.
    pub(super) known: Option<Value>,
    /// None without networks.
    pub(super) clipped: Option<Value>,
    beyond: Value,
}

/// The cell after a sample.
struct Cell {
    state: Value,
    low: Value,
    width: Value,
    /// Whether the state is known, and the width of the interval in which it may be before; none without one.
    known: Option<(Value, Value)>,
}

pub(super) fn estimate(g: &mut Graph, estimator: &Estimator, sample: &Sample) -> Estimate {
    let law = &estimator.law;
    let inputs = law.signals.iter().flat_map(|signal| match *signal {
        Signal::Input(i) | Signal::LogTension { input: i, .. } => [i, i],
        Signal::Difference(i, j) | Signal::LogRatio { first: i, second: j, .. } => [i, j],
    });
    let count = inputs.max().map_or(0, |last| last + 1);
    let columns = columns(g, sample.values, count);
    let signals: Vec<Value> = law.signals.iter().map(|signal| value_of(g, signal, &columns)).collect();
    let previous: Vec<Slot> = signals.iter().map(|_| g.remember(1)).collect();
    for (slot, signal) in previous.iter().zip(&signals) {
        g.keep(*slot, *signal);
    }
    let cell = cell(g, law.cell.as_ref(), &signals, &previous, sample);
    let features = features(g, estimator, &signals, &previous, &cell, sample);

    let zero = g.double(0.0);
    let start = cell.known.map(|(_, unknown)| {
        let (square, twelve) = (g.op("Mul", &[unknown, unknown]), g.double(12.0));
        g.op("Div", &[square, twelve])
    });
    let sigma = g.double(estimator.sigma0 * estimator.sigma0);
    let mut variance = start.map_or(sigma, |start| g.op("Add", &[sigma, start]));
    let mut mean = cell.state;
    if let Some(linear) = &estimator.linear {
        let regression = regression(g, linear, &features);
        mean = g.op("Add", &[mean, regression]);
    }
    let (mut gate, mut clipped, mut excess) = (g.double(1.0), None, zero);
    if let Some(ensemble) = &estimator.ensemble {
        let output = networks(g, ensemble, &features, sample.zero);
        if let Some(power) = estimator.gate_power {
            let (power, strength) = (g.double(power), g.double(GATE_STRENGTH));
            let weighted = g.op("Mul", &[strength, output.variance]);
            let (sum, least) = (g.op("Add", &[power, weighted]), g.double(f64::MIN_POSITIVE));
            let sum = g.larger(sum, least);
            gate = g.op("Div", &[power, sum]);
        }
        let correction = g.op("Mul", &[gate, output.median]);
        mean = g.op("Add", &[mean, correction]);
        variance = g.op("Add", &[variance, output.variance]);
        (clipped, excess) = (output.clipped, output.beyond);
    }
    let farthest = g.remember(1);
    let before = g.select(sample.next, farthest.before, zero);
    let beyond = g.larger(before, excess);
    g.keep(farthest, beyond);
    let known = cell.known.map(|(known, _)| known);
    let own = Estimate { mean, variance, gate, known, clipped, beyond };
    with_members(g, estimator, own, sample)
}

/// The single inputs up to a number of them.
fn columns(g: &mut Graph, values: Value, count: usize) -> Vec<Value> {
    (0..count)
        .map(|i| {
            let (index, axis) = (g.wholes(&[i]), [("axis", 1)]);
            g.node("Gather", &[values, index], 1, &axis)[0]
        })
        .collect()
}

fn value_of(g: &mut Graph, signal: &Signal, inputs: &[Value]) -> Value {
    let taut = |g: &mut Graph, input: usize, offset: f64| {
        let (zero, offset) = (g.double(0.0), g.double(offset));
        let tension = g.larger(inputs[input], zero);
        g.op("Add", &[tension, offset])
    };
    match *signal {
        Signal::Input(i) => inputs[i],
        Signal::Difference(i, j) => g.op("Sub", &[inputs[i], inputs[j]]),
        Signal::LogTension { input, offset } => {
            let tension = taut(g, input, offset);
            g.op("Log", &[tension])
        }
        Signal::LogRatio { first, second, offset } => {
            let (first, second) = (taut(g, first, offset), taut(g, second, offset));
            let ratio = g.op("Div", &[first, second]);
            g.op("Log", &[ratio])
        }
    }
}

/// `coefficients . x`, added one after another to a start.
fn sum_of(g: &mut Graph, start: Value, terms: impl IntoIterator<Item = (f64, Value)>) -> Value {
    terms.into_iter().fold(start, |sum, (coefficient, x)| {
        let coefficient = g.double(coefficient);
        let term = g.op("Mul", &[coefficient, x]);
        g.op("Add", &[sum, term])
    })
}

fn cell(
    g: &mut Graph,
    cell: Option<&ClampCell>,
    signals: &[Value],
    previous: &[Slot],
    sample: &Sample,
) -> Cell {
    let (zero, nothing) = (g.double(0.0), sample.zero);
    let Some(cell) = cell else { return Cell { state: nothing, low: nothing, width: nothing, known: None } };
    let terms: Vec<Value> = cell
        .basis
        .iter()
        .map(|term| match *term {
            BasisTerm::One => g.double(1.0),
            BasisTerm::Signal(i) => signals[i],
            BasisTerm::Product(i, j) => g.op("Mul", &[signals[i], signals[j]]),
        })
        .collect();
    let bound =
        |g: &mut Graph, weights: &[f64]| sum_of(g, zero, weights.iter().copied().zip(terms.iter().copied()));
    let (low, high) = (bound(g, &cell.low), bound(g, &cell.high));
    let half = g.double(0.5);
    let sum = g.op("Add", &[low, high]);
    let mean = g.op("Mul", &[half, sum]);
    let crossed = g.op("Less", &[high, low]);
    let [low, high] = [low, high].map(|bound| g.select(crossed, mean, bound));
    let sum = g.op("Add", &[low, high]);
    let (middle, width) = (g.op("Mul", &[half, sum]), g.op("Sub", &[high, low]));
    let half_width = g.op("Mul", &[half, width]);
    let mut increment = zero;
    for (i, kappa) in cell.elastic.iter().zip(&cell.kappa) {
        let change = g.op("Sub", &[signals[*i], previous[*i].before]);
        increment = sum_of(g, increment, [(*kappa, change)]);
    }
    let kept = g.remember(1);
    let (mut state, mut slid) = (zero, g.select(sample.next, kept.before, zero));
    for branch in &cell.branches {
        let slot = g.remember(1);
        let (share, position, weight) =
            (g.double(branch.width), g.double(cell.start), g.double(branch.fraction));
        let reach = g.op("Mul", &[share, half_width]);
        let (lower, upper) = (g.op("Sub", &[middle, reach]), g.op("Add", &[middle, reach]));
        let band = g.op("Sub", &[upper, lower]);
        let inside = g.op("Mul", &[position, band]);
        let (begin, moved) = (g.op("Add", &[lower, inside]), g.op("Add", &[slot.before, increment]));
        let trial = g.select(sample.next, moved, begin);
        let projected = g.saturate(trial, lower, upper);
        g.keep(slot, projected);
        let part = g.op("Mul", &[weight, projected]);
        state = g.op("Add", &[state, part]);
        let (below, above) = (g.op("Less", &[trial, lower]), g.op("Greater", &[trial, upper]));
        let (active, wider) = (g.op("Or", &[below, above]), g.op("Greater", &[share, slid]));
        let first = g.op("And", &[active, wider]);
        slid = g.select(first, share, slid);
    }
    g.keep(kept, slid);
    let mut fraction = zero;
    for branch in &cell.branches {
        let (part, share) = (g.double(branch.fraction.abs() * branch.width), g.double(branch.width));
        let wider = g.op("Greater", &[share, slid]);
        let part = g.select(wider, part, zero);
        fraction = g.op("Add", &[fraction, part]);
    }
    let one = g.double(1.0);
    let partly = g.op("Less", &[slid, one]);
    let (known, unknown) = (g.op("Not", &[partly]), g.op("Mul", &[fraction, width]));
    let unknown = g.select(partly, unknown, zero);
    Cell { state, low, width, known: Some((known, unknown)) }
}

fn features(
    g: &mut Graph,
    estimator: &Estimator,
    signals: &[Value],
    previous: &[Slot],
    cell: &Cell,
    sample: &Sample,
) -> Vec<Value> {
    let mut list: Vec<Value> = Vec::new();
    if estimator.ensemble.is_none() && estimator.linear.is_none() {
        return list;
    }
    let zero = g.double(0.0);
    for feature in &estimator.law.features {
        // The state of a feature before the sample, which starts at the signal.
        let begin = |g: &mut Graph, slot: Slot, start: Value| g.select(sample.next, slot.before, start);
        let value = match *feature {
            Feature::Signal(i) => signals[i],
            Feature::Clamped { signal, low, high } => {
                let (low, high) = (g.double(low), g.double(high));
                g.saturate(signals[signal], low, high)
            }
            Feature::Stop { signal, radius } => {
                let (u, r, slot) = (signals[signal], g.double(radius), g.remember(1));
                let play = begin(g, slot, u);
                let (low, high) = (g.op("Sub", &[u, r]), g.op("Add", &[u, r]));
                let play = g.saturate(play, low, high);
                g.keep(slot, play);
                let inside = g.op("Sub", &[u, play]);
                g.op("Div", &[inside, r])
            }
            Feature::LowPassDifference { signal, tau_s } => {
                let (u, tau, slot) = (signals[signal], g.double(tau_s), g.remember(1));
                let before = begin(g, slot, u);
                let (change, time) = (g.op("Sub", &[u, before]), g.op("Add", &[sample.dt_s, tau]));
                let change = g.op("Mul", &[change, sample.dt_s]);
                let change = g.op("Div", &[change, time]);
                let after = g.op("Add", &[before, change]);
                g.keep(slot, after);
                g.op("Sub", &[u, after])
            }
            Feature::CellState => cell.state,
            Feature::CellWidth => cell.width,
            Feature::CellPosition => {
                let (above, least) = (g.op("Sub", &[cell.state, cell.low]), g.double(1e-12));
                let width = g.larger(cell.width, least);
                g.op("Div", &[above, width])
            }
            // Of the cable's observer, which is not exported.
            Feature::Innovation => sample.zero,
            Feature::Rate(i) => {
                let change = g.op("Sub", &[signals[i], previous[i].before]);
                let rate = g.op("Div", &[change, sample.dt_s]);
                let (low, high) = (g.double(-MAX_MAGNITUDE), g.double(MAX_MAGNITUDE));
                let rate = g.saturate(rate, low, high);
                let later = g.op("Greater", &[sample.dt_s, zero]);
                g.select(later, rate, zero)
            }
            Feature::Previous(i) => {
                let slot = g.remember(1);
                g.keep(slot, list[i]);
                begin(g, slot, zero)
            }
            Feature::Sign { feature, scale } => {
                let (scale, one) = (g.double(scale), g.double(1.0));
                let x = g.op("Div", &[list[feature], scale]);
                let square = g.op("Mul", &[x, x]);
                let sum = g.op("Add", &[one, square]);
                let root = g.op("Sqrt", &[sum]);
                g.op("Div", &[x, root])
            }
            Feature::BelowMaximum(i) | Feature::AboveMinimum(i) => {
                let (u, slot) = (signals[i], g.remember(1));
                let before = begin(g, slot, u);
                let most = matches!(feature, Feature::BelowMaximum(_));
                let after = if most { g.larger(before, u) } else { g.smaller(before, u) };
                g.keep(slot, after);
                g.op("Sub", &[u, after])
            }
            Feature::Product { feature, signal } => g.op("Mul", &[list[feature], signals[signal]]),
        };
        list.push(value);
    }
    list
}

fn regression(g: &mut Graph, linear: &LinearLaw, features: &[Value]) -> Value {
    let offset = g.double(linear.offset);
    sum_of(g, offset, linear.weights.iter().copied().zip(features.iter().copied()))
}

/// As `sinew::predictor::EnsembleOutput`.
struct Networks {
    median: Value,
    variance: Value,
    clipped: Option<Value>,
    beyond: Value,
}

fn networks(g: &mut Graph, ensemble: &Ensemble, features: &[Value], zero: Value) -> Networks {
    let (mut clipped, mut beyond) = (None, g.double(0.0));
    let mut z = Vec::new();
    if !features.is_empty() {
        let x = g.join(features);
        let [low, high, mean, scale] =
            [&ensemble.clip_low, &ensemble.clip_high, &ensemble.mean, &ensemble.inverse_scale]
                .map(|row| g.doubles(row));
        let above = g.larger(x, low);
        let inside = g.smaller(above, high);
        let outside = g.op("Sub", &[x, inside]);
        let outside = g.op("Abs", &[outside]);
        let excess = g.op("Mul", &[outside, scale]);
        let out = g.op("Greater", &[outside, zero]);
        (clipped, beyond) = (Some(g.any(out)), g.largest(excess));
        let centred = g.op("Sub", &[inside, mean]);
        let standard = g.op("Mul", &[centred, scale]);
        let standard = g.cast(standard, Kind::Single);
        z = g.split(standard, &vec![1; features.len()]);
    }
    // One column for each network; of the nodes one block of these for each.
    let weighted = |g: &mut Graph, sum: Value, weights: &[f32], x: Value| {
        let weights = g.singles(weights);
        let term = g.op("Mul", &[weights, x]);
        g.op("Add", &[sum, term])
    };
    // A constant has no row for each sequence; zero has.
    let (bias, nothing) = (g.singles(&ensemble.bias), g.cast(zero, Kind::Single));
    let mut outputs = g.op("Add", &[bias, nothing]);
    for (weights, z) in ensemble.skip.iter().zip(&z) {
        outputs = weighted(g, outputs, weights, *z);
    }
    let nodes = ensemble.hidden_bias.len();
    if nodes > 0 {
        let mut sums = g.singles(ensemble.hidden_bias.as_flattened());
        for (f, z) in z.iter().enumerate() {
            let of_feature: Vec<f32> =
                ensemble.hidden_weights.iter().skip(f).step_by(features.len()).flatten().copied().collect();
            sums = weighted(g, sums, &of_feature, *z);
        }
        let bent = quick_tanh(g, sums);
        let blocks = g.split(bent, &vec![MEMBERS; nodes]);
        for (weights, block) in ensemble.output_weights.iter().zip(blocks) {
            outputs = weighted(g, outputs, weights, block);
        }
    }
    let (members, rest) = (g.singles(&[MEMBERS as f32]), g.singles(&[(MEMBERS - 1) as f32]));
    let total = pairwise(g, outputs);
    let average = g.op("Div", &[total, members]);
    let deviation = g.op("Sub", &[outputs, average]);
    let squares = g.op("Mul", &[deviation, deviation]);
    let total = pairwise(g, squares);
    let variance = g.op("Div", &[total, rest]);
    let count = g.wholes(&[MEMBERS]);
    let sorted = g.node("TopK", &[outputs, count], 2, &[("axis", 1), ("largest", 0), ("sorted", 1)])[0];
    let ordered = g.split(sorted, &[3, 1, 1, 3]);
    let (half, sum) = (g.singles(&[0.5]), g.op("Add", &[ordered[1], ordered[2]]));
    let median = g.op("Mul", &[half, sum]);
    let [median, variance] = [median, variance].map(|x| g.cast(x, Kind::Double));
    Networks { median, variance, clipped, beyond }
}

/// Pairwise sum over the networks.
fn pairwise(g: &mut Graph, row: Value) -> Value {
    let axis = [("axis", 1)];
    let take = |g: &mut Graph, k: usize| {
        let index = g.wholes(&[k]);
        g.node("Gather", &[row, index], 1, &axis)[0]
    };
    let v: Vec<Value> = (0..MEMBERS).map(|k| take(g, k)).collect();
    let mut add = |a: Value, b: Value| g.op("Add", &[a, b]);
    let pairs = [add(v[0], v[4]), add(v[1], v[5]), add(v[2], v[6]), add(v[3], v[7])];
    let halves = [add(pairs[0], pairs[1]), add(pairs[2], pairs[3])];
    add(halves[0], halves[1])
}

/// The rational hyperbolic tangent of the networks.
fn quick_tanh(g: &mut Graph, x: Value) -> Value {
    let (low, high) = (g.singles(&[-QUICK_EDGE]), g.singles(&[QUICK_EDGE]));
    let x = g.saturate(x, low, high);
    let square = g.op("Mul", &[x, x]);
    let horner = |g: &mut Graph, start: Value, coefficients: &[f32]| {
        coefficients.iter().fold(start, |sum, c| {
            let (c, product) = (g.singles(&[*c]), g.op("Mul", &[square, sum]));
            g.op("Add", &[c, product])
        })
    };
    let (first, last) = (g.singles(&[378.0]), g.singles(&[28.0]));
    let first = g.op("Add", &[first, square]);
    let p = horner(g, first, &[17_325.0, 135_135.0]);
    let q = horner(g, last, &[3150.0, 62_370.0, 135_135.0]);
    let top = g.op("Mul", &[x, p]);
    g.op("Div", &[top, q])
}

fn with_members(g: &mut Graph, estimator: &Estimator, mut own: Estimate, sample: &Sample) -> Estimate {
    if estimator.members.is_empty() {
        return own;
    }
    let members: Vec<Estimate> =
        estimator.members.iter().map(|m| estimate(g, &m.estimator, sample)).collect();
    let pairs = || estimator.members.iter().zip(&members);
    for (member, estimate) in pairs() {
        let mut both = |operator, a: Option<Value>, b: Option<Value>| match (a, b) {
            (Some(a), Some(b)) => Some(g.op(operator, &[a, b])),
            (a, b) => a.or(b),
        };
        own.known = both("And", own.known, estimate.known);
        own.clipped = both("Or", own.clipped, estimate.clipped);
        if !member.inside {
            own.beyond = g.larger(estimate.beyond, own.beyond);
        }
    }
    let (zero, one, fade) = (g.double(0.0), g.double(1.0), g.double(FADE));
    let far = g.op("Div", &[own.beyond, fade]);
    let inside = g.op("Sub", &[one, far]);
    let outside = g.larger(inside, zero);
    let all: f64 = estimator.members.iter().map(|member| member.weight).sum();
    let (mut sum, mut total, mut gate, mut weights) = (zero, zero, zero, Vec::new());
    for (member, estimate) in pairs() {
        let weight = g.double(member.weight);
        let w = if member.inside { g.op("Mul", &[weight, outside]) } else { weight };
        weights.push(w);
        total = g.op("Add", &[total, w]);
        let [mean, gated] = [estimate.mean, estimate.gate].map(|x| g.op("Mul", &[w, x]));
        (sum, gate) = (g.op("Add", &[sum, mean]), g.op("Add", &[gate, gated]));
    }
    let least = g.double(f64::MIN_POSITIVE);
    let total = g.larger(total, least);
    let mean = g.op("Div", &[sum, total]);
    let mut spread = zero;
    for ((member, estimate), w) in pairs().zip(weights) {
        let difference = g.op("Sub", &[estimate.mean, mean]);
        let square = g.op("Mul", &[difference, difference]);
        let (both, own) = (g.op("Add", &[square, estimate.variance]), member.estimator.sigma0);
        let own = g.double(own * own);
        let rest = g.op("Sub", &[both, own]);
        let part = g.op("Mul", &[w, rest]);
        spread = g.op("Add", &[spread, part]);
    }
    let spread = g.op("Div", &[spread, total]);
    let spread = g.larger(spread, zero);
    let all = g.double(all);
    let mean = g.op("Mul", &[all, mean]);
    own.mean = g.op("Add", &[own.mean, mean]);
    own.variance = g.op("Add", &[own.variance, spread]);
    own.gate = g.op("Div", &[gate, total]);
    own
}
