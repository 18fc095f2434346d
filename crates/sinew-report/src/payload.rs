//! Payload by the time for which it is held, and what would raise it: as data, and as rows of a page.

use super::format::physical;
use serde::Serialize;

/// Payload that is the rounding of none, kg.
const NOTHING_KG: f64 = 1e-9;

/// Payload that a machine holds for a time, over all poses.
#[derive(Debug, Serialize)]
pub struct HeldFor {
    /// `10 s`.
    #[serde(rename = "time")]
    pub words: &'static str,
    /// None: continuously.
    pub seconds: Option<f64>,
    /// Poses in which the machine itself is held.
    pub poses: usize,
    /// Worst, median and best pose, kg; zero where the machine itself is not held.
    #[serde(flatten)]
    pub spread: Spread,
    /// What limits it in most poses.
    pub limited_by: Option<Limit>,
    /// Of every pose, kg; none where the machine itself is not held.
    #[serde(rename = "of_poses_kg")]
    pub each: Vec<Option<f64>>,
}

/// Payloads over the poses.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Spread {
    /// Of the worst pose, kg.
    pub min_kg: f64,
    /// Of the median pose, kg.
    pub median_kg: f64,
    /// Of the best pose, kg.
    pub max_kg: f64,
}

/// What limits a payload in most poses.
#[derive(Debug, Serialize)]
pub struct Limit {
    /// The muscle at its limit.
    pub muscle: String,
    /// The limit in words.
    pub limit: &'static str,
    /// Poses in which it is this one.
    pub poses: usize,
}

/// Median payloads after a change of the design, for the shortest time and continuously.
#[derive(Debug, Serialize)]
pub struct Raised {
    /// The change in words.
    pub change: &'static str,
    /// By how much, in words.
    pub amount: &'static str,
    /// For the shortest time, kg.
    pub short_kg: f64,
    /// Continuously, kg.
    pub continuous_kg: f64,
}

/// Everything about payload; empty for a machine that carries none.
#[derive(Debug, Default, Serialize)]
pub struct Payload {
    /// Shortest time first, the last continuous.
    pub held: Vec<HeldFor>,
    /// As designed, then after every change.
    pub raised: Vec<Raised>,
}

impl Spread {
    /// Of the poses; none counts as zero.
    pub fn new(each: &[Option<f64>]) -> Self {
        let mut sorted: Vec<f64> = each.iter().map(|mass| mass.unwrap_or(0.0)).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |k: usize| sorted.get(k).copied().unwrap_or(f64::NAN);
        Self { min_kg: at(0), median_kg: at(sorted.len() / 2), max_kg: at(sorted.len().saturating_sub(1)) }
    }
}

impl Payload {
    /// Cells of the table of times: time, poses, least, median, most, limit.
    pub(super) fn held_rows(&self) -> Vec<[String; 6]> {
        let row = |held: &HeldFor| {
            let Spread { min_kg, median_kg, max_kg } = held.spread;
            let limit = held.limited_by.as_ref();
            let [least, median, most] = [min_kg, median_kg, max_kg].map(|mass| physical(mass, 3));
            let limit = limit
                .map_or_else(String::new, |one| format!("{}: {} ({})", one.muscle, one.limit, one.poses));
            [held.words.to_owned(), held.poses.to_string(), least, median, most, limit]
        };
        self.held.iter().map(row).collect()
    }

    /// Whether a change of the design gives any payload; none where a single cable would have to load joints
    /// independently.
    pub(super) fn is_raised(&self) -> bool {
        self.raised.iter().any(|one| one.short_kg.max(one.continuous_kg) > NOTHING_KG)
    }

    /// Cells of the table of changes: change, amount, for the shortest time, continuous.
    pub(super) fn raised_rows(&self) -> Vec<[String; 4]> {
        let row = |one: &Raised| {
            let [short, ever] = [one.short_kg, one.continuous_kg].map(|mass| physical(mass, 3));
            [one.change.to_owned(), one.amount.to_owned(), short, ever]
        };
        self.raised.iter().map(row).collect()
    }
}
