//! How a run is stopped from elsewhere: the first Ctrl-C and the page ask for the same safe stop, whose
//! states are said; the second Ctrl-C ends the run at once.

use crate::interrupt;
use crate::verbs::page::RunPage;
use sinew::control::supervisor::Mode;
use sinew_runtime::cycle::Cycle;
use sinew_session::{CycleRecord, Plant};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

/// The ways in which a run is stopped, and what has come of them.
pub(super) struct Stopping {
    safely: Arc<AtomicBool>,
    at_once: &'static AtomicBool,
    shown: Arc<Shown>,
    teller: Option<JoinHandle<()>>,
    /// When the stop was asked for, s of the run.
    stopped: Option<f64>,
}

/// What is said of a run.
struct Shown {
    /// Mode of a machine that is being stopped; [`NOT_STOPPING`] before.
    mode: AtomicU8,
    ended: AtomicBool,
}

const NOT_STOPPING: u8 = 0xff;
/// Between two looks at the mode.
const LOOK: Duration = Duration::from_millis(20);

impl Stopping {
    /// From here on Ctrl-C is answered. Before the cycle's thread has its priority, which a thread that is
    /// started later would inherit.
    pub(super) fn begin() -> Self {
        let (safely, at_once) = interrupt::answer_twice();
        let shown = Arc::new(Shown { mode: AtomicU8::new(NOT_STOPPING), ended: AtomicBool::new(false) });
        let seen = Arc::clone(&shown);
        // Without the thread the stop is the same, and nothing is said of it.
        let teller = std::thread::Builder::new().name("stopping".into()).spawn(move || tell(&seen)).ok();
        Self { safely, at_once, shown, teller, stopped: None }
    }

    /// A cycle that follows the terminal's stop, and the page's.
    pub(super) fn of<'a, P: Plant>(&self, cycle: Cycle<'a, P>, page: Option<&RunPage>) -> Cycle<'a, P> {
        let cycle = cycle.with_stop(Arc::clone(&self.safely));
        match page {
            Some(page) => cycle.with_stop(page.stop()),
            None => cycle,
        }
    }

    /// Whoever sets it ends the run at once.
    pub(super) fn at_once(&self) -> &'static AtomicBool {
        self.at_once
    }

    /// Looks at a cycle.
    pub(super) fn see<B>(&mut self, record: &CycleRecord<'_, B>) {
        if record.stopping {
            self.stopped.get_or_insert(record.moment.time);
            self.shown.mode.store(record.command.mode as u8, Ordering::Relaxed);
        }
    }

    /// Whether a stop has been asked for.
    pub(super) fn is_stopping(&self) -> bool {
        self.stopped.is_some()
    }

    /// Who stopped the run and when, s of the run.
    pub(super) fn stopped(&self, page: Option<&RunPage>) -> Option<Stopped> {
        let from_page = page.is_some_and(|page| page.stop().load(Ordering::Relaxed));
        let by = if from_page && !interrupt::is_requested() { By::Page } else { By::Terminal };
        self.stopped.map(|time| Stopped { by, time })
    }
}

impl Drop for Stopping {
    fn drop(&mut self) {
        self.shown.ended.store(true, Ordering::Release);
        if let Some(teller) = self.teller.take() {
            let _ = teller.join();
        }
    }
}

/// A stop from elsewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stopped {
    pub(super) by: By,
    /// s of the run.
    pub(super) time: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum By {
    Page,
    Terminal,
}

impl Stopped {
    /// Key of its time in JSON.
    pub(super) fn key(self) -> &'static str {
        match self.by {
            By::Page => "stopped_from_page_s",
            By::Terminal => "interrupted_s",
        }
    }

    pub(super) fn by(self) -> &'static str {
        match self.by {
            By::Page => "from the page",
            By::Terminal => "by Ctrl-C",
        }
    }

    pub(super) fn text(self) -> String {
        let by = self.by();
        format!("Stopped {by} at {:.3} s; the errors above are those until then\n", self.time)
    }
}

/// Says what a machine that is being stopped does, until the run has ended.
fn tell(shown: &Shown) {
    let mut last = NOT_STOPPING;
    loop {
        // Read first, so that the last mode is said, too.
        let ended = shown.ended.load(Ordering::Acquire);
        let now = shown.mode.load(Ordering::Relaxed);
        if now != last {
            if last == NOT_STOPPING {
                tell!("\nstopping; Ctrl-C again ends at once, with the brakes on");
            }
            last = now;
            tell!("{}", Mode::from_number(now).map_or("", words));
        }
        if ended {
            if interrupt::is_requested_at_once() {
                tell!("ended at once, by a second Ctrl-C; the brakes are on");
            }
            return;
        }
        std::thread::sleep(LOOK);
    }
}

fn words(mode: Mode) -> &'static str {
    match mode {
        Mode::SafeStop => "safe stop: the winches brake, stand, and release the tension",
        Mode::Ready => "released",
        Mode::Fault => "released, with a fault",
        Mode::Off => "off",
        Mode::Pretension | Mode::Hold | Mode::Run => "",
    }
}
