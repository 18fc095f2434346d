//! The numbers of a time column to seconds.

use super::open::OpenLog;
use super::times::quantile;
use super::types::{Defect, DefectKind};
use super::units;
use crate::Error;

/// Steps from sample to sample that are usual for seconds; others are as likely milliseconds, or days.
const USUAL_S: std::ops::RangeInclusive<f64> = 5e-6..=0.75;

/// Seconds since 1970 stay below this until the year 5138; a larger number counts parts of a second.
const LATEST_S: f64 = 1e11;

/// Where the seconds of a time column come from.
pub(super) struct Clock {
    column: String,
    /// Seconds per unit; `None` where no unit is stated.
    scale: Option<f64>,
    is_stamped: bool,
}

impl Clock {
    /// The clock of column `c`.
    pub(super) fn from_column(log: &OpenLog, c: usize) -> Self {
        let is_stamped = log.is_stamped(c);
        let scale = if is_stamped { Some(1.0) } else { units::seconds(&log.units[c]) };
        Self { column: log.names[c].clone(), scale, is_stamped }
    }

    /// Scales `time` to seconds.
    ///
    /// # Errors
    /// [`Error::UnitOfTime`] where none is stated and the steps are unusual for seconds.
    #[expect(clippy::float_cmp, reason = "1.0 is the literal of a table of units, not a result")]
    pub(super) fn to_seconds(
        &self,
        file: &str,
        time: &mut [f64],
        findings: &mut Vec<String>,
        defects: &mut Vec<Defect>,
    ) -> Result<(), Error> {
        if self.is_stamped {
            return Ok(());
        }
        let scale = match (since_1970(time), self.scale) {
            // Nothing else has numbers of this size, whatever the name says.
            (Some(scale), stated) if stated.is_none_or(|stated| stated != scale) => scale,
            (_, Some(stated)) => stated,
            (_, None) => 1.0,
        };
        let interval = median_step(time);
        if scale != 1.0 {
            time.iter_mut().for_each(|t| *t *= scale);
            findings.push(format!("time was multiplied by {scale} to have seconds"));
        } else if interval > 0.0 && !USUAL_S.contains(&interval) {
            if self.scale.is_none() {
                let (file, column) = (file.to_owned(), self.column.clone());
                return Err(Error::UnitOfTime { file, column, interval });
            }
            defects.push(Defect::of_log(
                DefectKind::Clock,
                &self.column,
                format!(
                    "`{0}` advances by {interval} s from sample to sample, in the median: if these are no \
                        seconds, every speed and time constant of the model is wrong; state its unit with \
                        --units {0}=ms",
                    self.column
                ),
            ));
        }
        Ok(())
    }
}

/// Seconds per unit where the numbers count parts of a second since 1970.
fn since_1970(time: &[f64]) -> Option<f64> {
    let first = time.iter().copied().find(|t| t.is_finite())?;
    [(1e-3, 1e14), (1e-6, 1e17), (1e-9, 1e20)]
        .into_iter()
        .find(|(_, end)| (LATEST_S..*end).contains(&first))
        .map(|(scale, _)| scale)
}

/// Median of the steps forward; 0 of none.
fn median_step(time: &[f64]) -> f64 {
    let steps = time.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0);
    quantile(&mut steps.collect::<Vec<_>>(), 0.5)
}
