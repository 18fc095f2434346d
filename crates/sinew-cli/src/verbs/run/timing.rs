//! Times of the control cycle: a table, a plot in text, JSON.

use crate::table::{number, table};
use sinew_runtime::cycle::Timing;

/// Bins of the plot, us; the last one is open.
const EDGES: [f64; 9] = [0.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0];
/// Characters of a full bar.
const WIDTH: f64 = 40.0;

/// Quantiles of every quantity, us.
pub(super) fn json(timing: &Timing) -> serde_json::Value {
    let rows = timing.rows().map(|row| {
        let key = row.quantity.replace([' ', '-'], "_");
        let quantiles =
            serde_json::json!({"median": row.median, "p99": row.p99, "p999": row.p999, "max": row.max});
        (key, quantiles)
    });
    let mut all: serde_json::Map<_, _> = rows.into_iter().collect();
    all.insert("cycles".to_owned(), timing.cycles().into());
    all.insert("skipped".to_owned(), timing.skipped().into());
    all.into()
}

/// The same as a table, and the distribution of the wake-ups and of the control.
pub(super) fn text(timing: &Timing) -> String {
    let rows: Vec<Vec<String>> = timing
        .rows()
        .iter()
        .map(|row| {
            let times = [row.median, row.p99, row.p999, row.max].map(|time| number(Some(time)));
            [row.quantity.to_owned()].into_iter().chain(times).collect()
        })
        .collect();
    let mut text = table(&["control cycle, us", "median", "p99", "p99.9", "max"], &rows, 1);
    text += &format!("{} cycles, {} deadlines skipped\n", timing.cycles(), timing.skipped());
    let drawn = ["wake-up", "control"];
    for (quantity, fractions) in timing.fractions(&EDGES).iter().filter(|(name, _)| drawn.contains(name)) {
        text += &format!("\n{quantity}\n");
        for (k, fraction) in fractions.iter().enumerate().filter(|(_, fraction)| **fraction > 0.0) {
            let from = EDGES[k];
            let bin = EDGES
                .get(k + 1)
                .map_or(format!("{from:>5} us and more"), |to| format!("{from:>5} to {to:>4} us"));
            let bar = "#".repeat((WIDTH * fraction).ceil() as usize);
            text += &format!("{bin:>17}  {bar:<40} {:.3} %\n", 100.0 * fraction);
        }
    }
    text
}
