//! Added to the instrumented crate: the number of the active mutant, and which mutants a test reaches.
extern crate std;

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
use std::io::Write;

const UNKNOWN: u32 = u32::MAX;
const COVERAGE: u32 = u32::MAX - 1;

static ACTIVE: AtomicU32 = AtomicU32::new(UNKNOWN);
static REACHED: [AtomicBool; 1 << 16] = [const { AtomicBool::new(false) }; 1 << 16];

/// The active mutant, 0 for none. `site` is the first mutant of the place that asks.
#[inline]
pub fn at(site: u32) -> u32 {
    let active = ACTIVE.load(Relaxed);
    if active < COVERAGE { active } else { uncommon(site) }
}

#[cold]
fn uncommon(site: u32) -> u32 {
    if ACTIVE.load(Relaxed) == UNKNOWN {
        let active = std::env::var("SINEW_MUTANT").ok().and_then(|text| text.parse().ok());
        let coverage = std::env::var_os("SINEW_MUTANTS_REACHED").is_some();
        ACTIVE.store(if coverage { COVERAGE } else { active.unwrap_or(0) }, Relaxed);
        return at(site);
    }
    if !REACHED[site as usize].swap(true, Relaxed) {
        let path = std::env::var_os("SINEW_MUTANTS_REACHED").unwrap_or_default();
        let file = std::fs::OpenOptions::new().append(true).create(true).open(path);
        if let Ok(mut file) = file {
            let _ = file.write_all(std::format!("{site}\n").as_bytes());
        }
    }
    0
}
