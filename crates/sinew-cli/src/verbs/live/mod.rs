//! `sinew live`.

mod recorded;
mod simulated;

use super::page::{open, tell_foxglove};
use super::recording::is_recording;
use crate::answer::{Answer, Content, Outcome};
use crate::arguments::{General, LiveArguments};
use crate::error::Error;
use crate::interrupt;
use crate::progress::Progress;
use sinew_live::{Server, ServerSettings, Source};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

pub(crate) fn run(arguments: &LiveArguments, general: &General) -> Result<Answer, Error> {
    let (source, simulated): (Box<dyn Source>, bool) = if is_recording(&arguments.model) {
        let (playback, simulated) = recorded::playback(arguments)?;
        (Box::new(playback), simulated)
    } else {
        if let Some(file) = arguments.overlay.first() {
            let value = file.display().to_string();
            return Err(Error::Argument { flag: "--overlay", value, expected: "it beside a recording" });
        }
        let progress = Progress::new();
        progress.show("planning and verifying the motion, calibrating the machine's cables", 0.0);
        (simulated::source(arguments)?, true)
    };
    let server =
        Server::start(ServerSettings { address: arguments.bind, source, foxglove: arguments.foxglove })?;
    let url = server.url();
    let shown = match (is_recording(&arguments.model), simulated) {
        (false, _) => "SIMULATED machine",
        (true, true) => "recording of a SIMULATED machine",
        (true, false) => "recording",
    };
    tell!("{shown} on {url} (Ctrl-C ends it)");
    tell_foxglove(&server);
    if arguments.open {
        open(&url);
    }
    let (begun, stop) = (Instant::now(), interrupt::answer());
    let until = arguments.until.map(Duration::from_secs_f64);
    while !stop.load(Ordering::Relaxed)
        && !server.has_failed()
        && until.is_none_or(|until| begun.elapsed() < until)
    {
        std::thread::sleep(Duration::from_millis(20));
    }
    let failed = server.has_failed();
    drop(server);
    let ended = if failed { "failed" } else { "as_planned" };
    let content = if general.json {
        Content::json(
            &serde_json::json!({"simulated": simulated, "address": url.split('#').next(), "ended": ended}),
        )?
    } else {
        Content::Text(if failed { "What was shown has failed.\n".to_owned() } else { String::new() })
    };
    Ok(Answer { outcome: Outcome::new(!failed), content, written: Vec::new() })
}
