//! Memory of the page over time.

use crate::Outcome;
use crate::browser::{Browser, rest};

/// Growth that counts as none, as a fraction, and of a short run also in bytes: the heap is swept in steps.
const GROWTH: f64 = 0.2;
const SWEEP: f64 = 3.0e6;

/// Bytes in use after a collection.
async fn used(page: &Browser) -> Outcome<f64> {
    page.value("if (window.gc) gc();").await?;
    page.number("return performance.memory.usedJSHeapSize").await
}

/// Compares the memory after the first part with that at the end; an hour with `SINEW_LONG`.
pub(crate) async fn steady(page: &Browser) -> Outcome<()> {
    let long = std::env::var_os("SINEW_LONG").is_some();
    let (first_s, then_s) = if long { (60, 3540) } else { (6, 12) };
    rest(1000 * first_s).await;
    let first = used(page).await?;
    rest(1000 * then_s).await;
    let last = used(page).await?;
    println!(
        "memory: {:.1} MB after {first_s} s, {:.1} MB after {} s",
        first / 1e6,
        last / 1e6,
        first_s + then_s
    );
    let allowed = first * (1.0 + GROWTH) + if long { 0.0 } else { SWEEP };
    if last > allowed {
        Err(format!("the page's memory grew from {:.1} to {:.1} MB", first / 1e6, last / 1e6))
    } else {
        Ok(())
    }
}
