//! What a compensator gives.

/// Conditions under which a command was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CommandFlags {
    /// With this command the model's far end is not the desired one, within the tolerance.
    pub not_attainable: bool,
    /// The command moves as fast as it may: by the rate, or by the largest change that the model accepts from
    /// one sample to the next. The desired far end may be attained later.
    pub rate_limited: bool,
    /// The command or another input lies outside the range of the training logs, or a network input outside
    /// its box.
    pub out_of_range: bool,
    /// The networks disagree: less than half of their correction counts.
    pub correction_withdrawn: bool,
    /// The state in the dead band depends on its start: no bound was active since the last reset.
    pub state_unknown: bool,
    /// An input, or the desired far end, was missing or jumped and was replaced by its last value.
    pub input_held: bool,
    /// All states were reset at this sample: the first one, after a gap, or where time runs backwards.
    pub reset: bool,
    /// The time stamp equals that of the sample before: the command is repeated.
    pub repeated: bool,
}

impl CommandFlags {
    /// Every flag with its name in files.
    #[must_use]
    pub fn named(&self) -> [(&'static str, bool); 8] {
        [
            ("not_attainable", self.not_attainable),
            ("rate_limited", self.rate_limited),
            ("out_of_range", self.out_of_range),
            ("correction_withdrawn", self.correction_withdrawn),
            ("state_unknown", self.state_unknown),
            ("input_held", self.input_held),
            ("reset", self.reset),
            ("repeated", self.repeated),
        ]
    }
}

/// Command for the near side at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Command {
    /// The near side for which the far end is as desired, in the unit of the near column.
    pub value: f64,
    /// The commands at the ends of the model's 95 % band: for the desired far end less and plus its half
    /// width, in ascending order, as far as they can be reached in this sample.
    pub low: f64,
    /// See [`low`](Self::low).
    pub high: f64,
    /// The far end that the model predicts at this command, far unit.
    pub mean: f64,
    /// Its standard deviation: `mean +- 1.96 standard_deviation` is the calibrated 95 % band.
    pub standard_deviation: f64,
    /// Gate on the learned correction, 0 to 1.
    pub gate: f64,
    /// How often the model was evaluated, at most [`MAX_EVALUATIONS`](super::MAX_EVALUATIONS).
    pub evaluations: u32,
    /// Conditions under which it was made.
    pub flags: CommandFlags,
}
