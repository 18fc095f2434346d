//! Two thousand single faults of every kind on forty calibrated arms: what is bridged stays accurate, what is
//! not is stopped or reported, and the right part is named.
//!
//! Minutes long: it runs only where the environment variable `SINEW_LONG` is set.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]
#![allow(clippy::print_stderr, reason = "a skipped test says so, the campaign prints its table")]

mod common;

use common::faults::{Case, campaign};
use rayon::prelude::*;

/// Arms, and faults per arm.
const CAMPAIGN: (u64, usize) = (40, 50);
/// Largest end-point error of a bridged fault, m.
const BRIDGED: f64 = 0.020;

#[test]
fn long_campaign_of_single_faults() {
    if std::env::var_os("SINEW_LONG").is_none() {
        eprintln!("skipped: SINEW_LONG is not set");
        return;
    }
    let (arms, count) = CAMPAIGN;
    let cases: Vec<Case> =
        (1000..1000 + arms).into_par_iter().flat_map_iter(|seed| campaign(seed, count)).collect();
    let bridged: Vec<&Case> = cases.iter().filter(|case| !case.stopped).collect();
    let inaccurate: Vec<&&Case> = bridged.iter().filter(|case| case.error > BRIDGED).collect();
    let named = cases.iter().filter(|case| case.named().is_some()).count();
    let wrong: Vec<&Case> =
        cases.iter().filter(|case| case.named().is_some() && !case.is_named_rightly()).collect();
    let silent: Vec<&&&Case> = inaccurate.iter().filter(|case| case.is_as_planned()).collect();
    for case in inaccurate.iter().map(|case| **case).chain(wrong.iter().copied()) {
        eprintln!("{case:?}");
    }
    eprintln!(
        "{} faults, {} stopped, {} bridged, of which {} above {BRIDGED} m, {} of them neither reported nor above \
         the bound of a completed run; {named} named, {} wrongly",
        cases.len(),
        cases.len() - bridged.len(),
        bridged.len(),
        inaccurate.len(),
        silent.len(),
        wrong.len()
    );
    assert!(inaccurate.len() as f64 <= 0.01 * bridged.len() as f64);
    assert!(wrong.len() as f64 <= 0.02 * named as f64);
}
