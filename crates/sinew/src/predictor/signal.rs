//! The signals of a model, computed from the columns of a log.

use super::conditioner::MAX_MAGNITUDE;
use serde::{Deserialize, Serialize};

/// One signal, a function of the present sample alone.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Signal {
    /// An input.
    Input(usize),
    /// First input minus second: the tension difference of two antagonists, proportional to the torque of
    /// their joint.
    Difference(usize, usize),
    /// `ln(max(T, 0) + offset)`: capstan friction is a ratio of tensions, hence a band of constant width in
    /// the logarithm.
    LogTension {
        /// Which input.
        input: usize,
        /// Keeps the logarithm finite when the cable is slack, in the input's unit.
        offset: f64,
    },
    /// `ln((max(T_a, 0) + offset) / (max(T_b, 0) + offset))`: the same for an antagonistic pair.
    LogRatio {
        /// Numerator.
        first: usize,
        /// Denominator.
        second: usize,
        /// Keeps the ratio finite when a cable is slack, in the inputs' unit.
        offset: f64,
    },
}

impl Signal {
    /// Its value for one sample; `inputs: [inputs of the model]`.
    #[inline]
    #[must_use]
    pub fn value(&self, inputs: &[f64]) -> f64 {
        match *self {
            Self::Input(i) => inputs[i],
            Self::Difference(i, j) => inputs[i] - inputs[j],
            Self::LogTension { input, offset } => libm::log(inputs[input].max(0.0) + offset),
            Self::LogRatio { first, second, offset } => {
                libm::log((inputs[first].max(0.0) + offset) / (inputs[second].max(0.0) + offset))
            }
        }
    }

    /// The largest input index it reads.
    pub(super) fn last_input(&self) -> usize {
        match *self {
            Self::Input(i) | Self::LogTension { input: i, .. } => i,
            Self::Difference(i, j) | Self::LogRatio { first: i, second: j, .. } => i.max(j),
        }
    }

    /// Whether its constants are in their domain.
    pub(super) fn is_valid(&self) -> bool {
        match *self {
            Self::LogTension { offset, .. } | Self::LogRatio { offset, .. } => {
                (1.0 / MAX_MAGNITUDE..=MAX_MAGNITUDE).contains(&offset)
            }
            Self::Input(_) | Self::Difference(..) => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Signal;

    #[test]
    fn logarithms_are_those_of_tensions_above_zero_plus_the_offset() {
        let (tension, ratio) = (
            Signal::LogTension { input: 1, offset: 2.0 },
            Signal::LogRatio { first: 0, second: 1, offset: 2.0 },
        );
        for (inputs, sums) in
            [([6.0, 14.0], [8.0, 16.0]), ([-5.0, 3.0], [2.0, 5.0]), ([7.0, -0.1], [9.0, 2.0])]
        {
            let [first, second] = sums.map(|sum: f64| sum.ln());
            assert!((tension.value(&inputs) - second).abs() < 1e-15, "{inputs:?}");
            assert!((ratio.value(&inputs) - (first - second)).abs() < 5e-16, "{inputs:?}");
        }
    }
}
