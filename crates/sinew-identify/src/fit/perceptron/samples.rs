//! Checked and standardised samples.

use crate::Error;

/// Standardised samples and their scaling.
#[derive(Debug)]
pub(super) struct Samples {
    pub(super) inputs: usize,
    /// Rows of `[inputs, target]`.
    pub(super) rows: Vec<f64>,
    pub(super) input: Vec<Scaling>,
    pub(super) target: Scaling,
}

/// `(value - mean) / scale`
#[derive(Debug, Clone, Copy)]
pub(super) struct Scaling {
    pub(super) mean: f64,
    pub(super) scale: f64,
}

impl Samples {
    pub(super) fn new(inputs: &[f64], targets: &[f64]) -> Result<Self, Error> {
        let n = targets.len();
        if n == 0 {
            return Err(Error::samples("targets", "at least one sample", &n));
        }
        if inputs.is_empty() || !inputs.len().is_multiple_of(n) {
            let expected = format!("as many numbers for each of the {n} targets, at least one");
            return Err(Error::samples("inputs", expected, &inputs.len()));
        }
        let k = inputs.len() / n;
        if k > 256 {
            return Err(Error::samples("inputs", "at most 256 columns", &k));
        }
        finite("inputs", inputs, k)?;
        finite("targets", targets, 1)?;
        let input = (0..k)
            .map(|i| Scaling::new(&format!("inputs, column {}", i + 1), inputs.iter().skip(i).step_by(k)))
            .collect::<Result<Vec<_>, _>>()?;
        let target = Scaling::new("targets", targets.iter())?;
        if targets.iter().all(|t| t.total_cmp(&targets[0]).is_eq()) {
            return Err(Error::samples("targets", "values that differ from each other", &targets[0]));
        }
        let mut rows = Vec::with_capacity(n * (k + 1));
        for (row, t) in inputs.chunks_exact(k).zip(targets) {
            rows.extend(row.iter().zip(&input).map(|(x, scaling)| scaling.apply(*x)));
            rows.push(target.apply(*t));
        }
        Ok(Self { inputs: k, rows, input, target })
    }
}

impl Scaling {
    fn new<'a>(name: &str, column: impl ExactSizeIterator<Item = &'a f64> + Clone) -> Result<Self, Error> {
        let n = column.len() as f64;
        let mean = column.clone().map(|x| x / n).sum::<f64>();
        let scale = column.clone().map(|x| (x - mean) * (x - mean) / n).sum::<f64>().sqrt();
        if !scale.is_finite() {
            let largest = column.map(|x| x.abs()).fold(0.0, f64::max);
            return Err(Error::samples(name, "a spread whose square is a finite number", &largest));
        }
        // A column that varies by rounding alone carries no information and stays at zero.
        let varies = scale > 1e-12 * mean.abs();
        Ok(Self { mean, scale: if varies { scale } else { 1.0 } })
    }

    fn apply(self, value: f64) -> f64 {
        (value - self.mean) / self.scale
    }
}

fn finite(name: &str, values: &[f64], columns: usize) -> Result<(), Error> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(at) => {
            let mut place = format!("{name}, sample {}", at / columns + 1);
            if columns > 1 {
                place += &format!(", column {}", at % columns + 1);
            }
            Err(Error::samples(place, "a finite number", &values[at]))
        }
    }
}
