//! The outcome of a classical fit, as plain data.

use serde::Serialize;

/// One classical law fitted to the data.
#[derive(Debug, Clone, Serialize)]
pub struct ClassicalFit {
    /// Short name of the law, for example `capstan play`.
    pub law: String,
    /// The law in one line of mathematics (plain text).
    pub equation: String,
    /// RMSE on the data it was fitted to.
    pub rmse: f64,
    /// The same as % of range.
    pub percent_of_range: f64,
    /// Parameters with intervals.
    pub parameters: Vec<Parameter>,
    /// Condition number of the scaled normal matrix.
    pub condition: f64,
    /// What these data do not determine, in words.
    pub remark: String,
}

/// One parameter with its 95 % interval.
#[derive(Debug, Clone, Serialize)]
pub struct Parameter {
    /// Name, for example `friction angle (mu phi - ln eta)`.
    pub name: String,
    /// Unit, `1` for none.
    pub unit: String,
    /// Best value.
    pub value: f64,
    /// Lower end of the 95 % interval; NaN where it is undefined.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// False where the data do not determine it.
    pub identified: bool,
    /// Why not, or empty.
    pub remark: String,
}
