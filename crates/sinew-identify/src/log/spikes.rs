//! Single samples far off their neighbours on both sides: a sensor's slip, not a cable's motion.

use super::times::quantile;

/// Samples a centred median looks at.
const WINDOW: usize = 5;
/// A spike is this many times farther from the median of its neighbours than 99 % of the samples,
const TIMES_TYPICAL: f64 = 6.0;
/// at least this fraction of the range of the signal,
const RANGE_FRACTION: f64 = 0.1;
/// and this many times farther from it than most of its neighbours, which keeps fast motion out.
const TIMES_NEIGHBOURS: f64 = 5.0;

/// Centred median of five; at the ends of what is there. NaN stays NaN and is not counted by others.
pub(super) fn median5(signal: &[f64]) -> Vec<f64> {
    let half = WINDOW / 2;
    (0..signal.len())
        .map(|i| {
            if signal[i].is_nan() {
                return f64::NAN;
            }
            let window = &signal[i.saturating_sub(half)..(i + half + 1).min(signal.len())];
            let mut sorted = [0.0; WINDOW];
            let mut n = 0;
            for &value in window.iter().filter(|v| !v.is_nan()) {
                sorted[n] = value;
                n += 1;
            }
            sorted[..n].sort_unstable_by(f64::total_cmp);
            // The lower of two middles, so that the result is always a measured value.
            sorted[(n - 1) / 2]
        })
        .collect()
}

/// How far sample `i` is from the median of the five around it, and how far most of these are.
fn deviation(signal: &[f64], i: usize) -> Option<(f64, f64)> {
    // At an end there are neighbours on one side only: a jump there may be motion.
    if i == 0 || i + 1 == signal.len() {
        return None;
    }
    let start = i.saturating_sub(WINDOW / 2).min(signal.len().saturating_sub(WINDOW));
    let mut window: [f64; WINDOW] = signal.get(start..start + WINDOW)?.try_into().ok()?;
    if window.iter().any(|x| x.is_nan()) {
        return None;
    }
    let middle = WINDOW / 2;
    window.sort_unstable_by(f64::total_cmp);
    let median = window[middle];
    let mut distances = window.map(|x| (x - median).abs());
    distances.sort_unstable_by(f64::total_cmp);
    Some(((signal[i] - median).abs(), distances[middle]))
}

/// Indices `(sequence, sample)` of the spikes in a signal that is cut into sequences.
pub(super) fn find(sequences: &[Vec<f64>]) -> Vec<(usize, usize)> {
    let mut finite: Vec<f64> = sequences.iter().flatten().copied().filter(|x| !x.is_nan()).collect();
    if finite.len() < 4 * WINDOW {
        return Vec::new();
    }
    let range = quantile(&mut finite, 0.995) - quantile(&mut finite, 0.005);
    let at = |s: usize| {
        let sequence = &sequences[s];
        (0..sequence.len()).filter_map(move |i| deviation(sequence, i).map(|(own, most)| (s, i, own, most)))
    };
    finite.clear();
    finite.extend((0..sequences.len()).flat_map(at).map(|(_, _, own, _)| own));
    let threshold = (TIMES_TYPICAL * quantile(&mut finite, 0.99)).max(RANGE_FRACTION * range);
    let far_off = (0..sequences.len())
        .flat_map(at)
        .filter(|&(_, _, own, most)| own > threshold && own > TIMES_NEIGHBOURS * most);
    far_off.map(|(s, i, ..)| (s, i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(n: usize, per_period: f64) -> Vec<f64> {
        (0..n).map(|i| (std::f64::consts::TAU * i as f64 / per_period).sin()).collect()
    }

    #[test]
    fn a_spike_is_found_where_it_is_and_a_coarsely_sampled_sine_has_none() {
        assert!(find(&[sine(600, 9.0)]).is_empty());
        let mut signal = sine(600, 80.0);
        signal[200] += 3.0;
        signal[201] -= 2.0;
        signal[0] = 4.0;
        signal[1] = 3.0;
        assert_eq!(find(&[signal]), [(0, 1), (0, 200), (0, 201)], "the first could be motion");
    }

    #[test]
    fn a_step_and_a_burst_of_motion_are_no_spikes() {
        let mut signal = vec![0.0; 300];
        signal[100..].fill(5.0);
        assert!(find(&[signal.clone()]).is_empty());
        for (i, x) in signal[200..220].iter_mut().enumerate() {
            *x += 3.0 * (i as f64 * 1.3).sin();
        }
        assert!(find(&[signal]).is_empty());
    }

    #[test]
    fn the_median_keeps_a_ramp_and_leaves_holes_alone() {
        let ramp = [0.0, 1.0, 2.0, f64::NAN, 4.0, 5.0, 6.0];
        let got = median5(&ramp);
        assert!((got[2] - 1.0).abs() < 1e-12, "lower middle of 0, 1, 2, 4");
        assert!(got[3].is_nan());
        let full: Vec<f64> = (0..9).map(f64::from).collect();
        assert_eq!(median5(&full)[2..7], full[2..7]);
    }
}
