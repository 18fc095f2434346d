//! Progress of runs of more than two seconds: a bar on terminals, a line now and then elsewhere.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, Write, stderr};
use std::sync::OnceLock;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

/// Time since the first bar after which one appears: what takes long in parts is seen as well.
const DELAY: Duration = Duration::from_secs(2);
/// Time after which a later bar appears: one that is gone sooner would flicker.
const LATER: Duration = Duration::from_millis(300);
/// When the first bar was made.
static BEGUN: OnceLock<Instant> = OnceLock::new();
/// Interval at which its clock is drawn, also while a stage reports nothing.
const TICK: Duration = Duration::from_millis(250);

/// Interval between two lines where no bar can be drawn: in a file or a pipe.
const LINES: Duration = Duration::from_secs(10);

/// A bar, and what is shown where it is unknown how far a run is.
const MEASURED: &str = "{bar:30} {percent:>3} % {elapsed:>4} {msg}";
const UNMEASURED: &str = "{spinner} {elapsed:>4} {msg}";

/// A bar that appears after two seconds of a verb and says what is being done.
pub(crate) struct Progress {
    bar: ProgressBar,
    /// Dropped with the bar, which ends the thread that shows it.
    _ended: Sender<()>,
}

impl Progress {
    pub(crate) fn new() -> Self {
        let bar = ProgressBar::hidden();
        bar.set_length(100);
        let (ended, waiting) = channel();
        let shown = bar.clone();
        let left = DELAY.saturating_sub(BEGUN.get_or_init(Instant::now).elapsed()).max(LATER);
        std::thread::spawn(move || {
            if waiting.recv_timeout(left) != Err(RecvTimeoutError::Timeout) {
                return;
            }
            if stderr().is_terminal() {
                shown.set_draw_target(ProgressDrawTarget::stderr());
                shown.enable_steady_tick(TICK);
            } else {
                write_lines(&shown, &waiting);
            }
        });
        Self { bar, _ended: ended }
    }

    /// Shows a stage and the progress of the whole run, 0 to 1; with 0 its time alone.
    pub(crate) fn show(&self, stage: &str, done: f64) {
        let template = if done > 0.0 { MEASURED } else { UNMEASURED };
        if let Ok(style) = ProgressStyle::with_template(template) {
            self.bar.set_style(style);
        }
        self.bar.set_message(stage.to_owned());
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to 0..100")]
        self.bar.set_position((100.0 * done.clamp(0.0, 1.0)) as u64);
    }

    /// Shows one stage for as long as something runs: for a verb that knows no more of where it is.
    pub(crate) fn during<T>(stage: &str, run: impl FnOnce() -> T) -> T {
        let progress = Self::new();
        progress.show(stage, 0.0);
        run()
    }

    /// Nothing more is shown.
    pub(crate) fn end(&self) {
        self.bar.finish_and_clear();
    }
}

/// Writes lines of progress, until its run has ended or nobody reads any more.
fn write_lines(bar: &ProgressBar, ended: &Receiver<()>) {
    while ended.recv_timeout(LINES) == Err(RecvTimeoutError::Timeout) {
        if bar.is_finished() || stderr().write_all(line(bar).as_bytes()).is_err() {
            return;
        }
    }
}

/// What a bar would show, as a line.
fn line(bar: &ProgressBar) -> String {
    let (elapsed, stage, percent) = (bar.elapsed().as_secs(), bar.message(), bar.position());
    let done = if percent > 0 { format!(": {percent} %") } else { String::new() };
    format!("[{elapsed:>4} s] {stage}{done}\n")
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.end();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_the_stage_and_what_is_known_of_its_end() {
        let progress = Progress::new();
        progress.show("fitting the cable", 0.0);
        assert_eq!(line(&progress.bar), "[   0 s] fitting the cable\n");
        progress.show("planning the motion", 0.347);
        assert_eq!(line(&progress.bar), "[   0 s] planning the motion: 34 %\n");
    }
}
