//! Calls that take long: without the interpreter's lock, and ended by Ctrl-C.

use crate::failure::Failure;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// Interval at which signals are looked at.
const POLL: Duration = Duration::from_millis(20);

/// Calls `work` for every index below `count`; more than one without the interpreter's lock.
pub(crate) fn for_each(
    py: Python<'_>,
    count: usize,
    mut work: impl FnMut(usize) -> Result<(), Failure> + Send,
) -> PyResult<()> {
    if count == 1 {
        return Ok(work(0)?);
    }
    let mut next = 0;
    while next < count {
        next = py.detach(|| {
            let began = Instant::now();
            while next < count {
                work(next)?;
                next += 1;
                // The clock costs as much as a small pose.
                if next.is_multiple_of(8) && began.elapsed() > POLL {
                    break;
                }
            }
            Ok::<usize, Failure>(next)
        })?;
        py.check_signals()?;
    }
    Ok(())
}

/// Prefixes the error of one of many with its index.
pub(crate) fn at(count: usize, index: usize, error: &dyn std::fmt::Display) -> Failure {
    if count == 1 {
        Failure::refused(error.to_string())
    } else {
        Failure::refused(format!("row {index}: {error}"))
    }
}

/// What the work of a long call tells while it runs.
#[derive(Clone)]
pub(crate) struct Progress {
    told: Sender<Event>,
    stop: Arc<AtomicBool>,
    desired: bool,
}

enum Event {
    Stage(String, f64),
    Ended,
}

/// Unwinds a thread whose result nobody waits for any more.
struct Abandoned;

impl Progress {
    /// Tells stage and fraction of what is done; ends the work where its caller no longer waits for it.
    pub(crate) fn tell(&self, stage: &str, done: f64) {
        if self.stop.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Abandoned));
        }
        if self.desired {
            // Nobody listens any more only where the next call unwinds.
            let _ = self.told.send(Event::Stage(stage.to_owned(), done));
        }
    }
}

/// Runs `work` on a thread of its own and waits for it without the interpreter's lock.
///
/// Ctrl-C raises `KeyboardInterrupt` at once; the thread ends when its work next tells of its progress.
/// `progress` is called as `progress(stage, fraction)`, on the thread that waits. `threads` bounds those of
/// the work, which are otherwise shared by all calls.
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    threads: Option<usize>,
    work: impl FnOnce(&Progress) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let (told, mut events) = channel();
    let stop = Arc::new(AtomicBool::new(false));
    let teller = Progress { told: told.clone(), stop: stop.clone(), desired: progress.is_some() };
    let pool = threads.map(pool).transpose()?;
    let body = move || {
        let run = AssertUnwindSafe(|| match &pool {
            Some(pool) => pool.install(|| work(&teller)),
            None => work(&teller),
        });
        let outcome = catch_unwind(run);
        let _ = told.send(Event::Ended);
        outcome
    };
    let thread = std::thread::Builder::new().name("sinew".into()).spawn(body);
    let thread = thread.map_err(|e| PyRuntimeError::new_err(format!("no thread could be started: {e}")))?;
    loop {
        let told = match py.detach(|| events_within(&mut events)) {
            Ok(Event::Ended) | Err(RecvTimeoutError::Disconnected) => break,
            Ok(Event::Stage(stage, done)) => {
                progress.map_or(Ok(()), |tell| tell.call1((stage, done)).map(drop))
            }
            Err(RecvTimeoutError::Timeout) => Ok(()),
        };
        if let Err(error) = told.and_then(|()| py.check_signals()) {
            stop.store(true, Ordering::Relaxed);
            return Err(error);
        }
    }
    match py.detach(|| thread.join().and_then(|outcome| outcome)) {
        Ok(result) => Ok(result?),
        Err(panic) => {
            Err(PyRuntimeError::new_err(format!("a mistake of this package: {}", panic_text(&*panic))))
        }
    }
}

fn events_within(events: &mut std::sync::mpsc::Receiver<Event>) -> Result<Event, RecvTimeoutError> {
    events.recv_timeout(POLL)
}

fn pool(threads: usize) -> Result<rayon::ThreadPool, Failure> {
    if !(1..=1024).contains(&threads) {
        return Err(Failure::refused(format!("threads must be 1 to 1024, but is {threads}")));
    }
    let built = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    built.map_err(|e| Failure::Internal(format!("no threads could be started: {e}")))
}

fn panic_text(panic: &(dyn std::any::Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("it ended early")
}
