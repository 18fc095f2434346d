//! The page beside a run.

use super::meshes::read_meshes;
use super::track::setup::Setup;
use crate::arguments::PageArguments;
use crate::error::Error;
use sinew::machine::Machine;
use sinew_live::{RunParts, Server, ServerSettings, Tap, tap};
use sinew_session::{CycleRecord, Plant};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// What moves the machine of a run.
pub(crate) struct Shown {
    /// `twin`, `segment` or `ethercat`.
    pub(crate) bus: &'static str,
    pub(crate) simulated: bool,
    /// Whether a client commands it, along no motion of its own.
    pub(crate) linked: bool,
    /// Whether the cycle keeps deadlines.
    pub(crate) timed: bool,
}

/// A page, and the side of the control cycle.
pub(crate) struct RunPage {
    tap: Tap,
    /// Serves until it is dropped.
    _server: Server,
}

impl RunPage {
    /// Serves the page of a run, before its first cycle; none where none is asked for. Before the cycle's
    /// thread has its priority, which threads that are started later would inherit.
    pub(crate) fn start(
        arguments: &PageArguments,
        setup: &Setup,
        shown: &Shown,
    ) -> Result<Option<Self>, Error> {
        if !arguments.page {
            return Ok(None);
        }
        let mut machine = setup.machine.clone();
        read_meshes(&mut machine.robot, &setup.source.path, setup.source.root.as_deref());
        let (tap, run) = tap(RunParts {
            machine,
            trajectory: (!shown.linked).then(|| setup.trajectory.clone()),
            path: setup.path.to_string(),
            bus: shown.bus,
            simulated: shown.simulated,
            timed: shown.timed,
            tension_limits: tension_limits(&setup.machine),
        })
        .map_err(sinew_lab::Error::from)?;
        let PageArguments { bind: address, foxglove, .. } = *arguments;
        let server = Server::start(ServerSettings { address, source: Box::new(run), foxglove })?;
        let url = server.url();
        let machine = if shown.simulated { "SIMULATED machine" } else { "machine" };
        tell!("{machine} on {url} while the run goes on");
        tell_foxglove(&server);
        if arguments.open {
            open(&url);
        }
        Ok(Some(Self { tap, _server: server }))
    }

    /// What the page sets to ask for a safe stop.
    pub(crate) fn stop(&self) -> Arc<AtomicBool> {
        Arc::clone(self.tap.stop())
    }

    /// Shows a cycle of a run.
    pub(crate) fn show<P: Plant>(&mut self, record: &CycleRecord<'_, P>) {
        self.tap.show(record);
    }
}

/// Smallest and largest tension at every anchor, N: `[muscles]`.
pub(crate) fn tension_limits(machine: &Machine) -> Vec<[f64; 2]> {
    let limits = machine.muscles.iter().map(|muscle| {
        let [low, high] = muscle.tension;
        [low.unwrap_or(0.0), high.unwrap_or(muscle.drive.max_tension)]
    });
    limits.collect()
}

/// Says where Foxglove finds what is shown, if its protocol is served.
pub(crate) fn tell_foxglove(server: &Server) {
    if let Some(address) = server.foxglove() {
        tell!("Foxglove: open a connection to ws://{address}");
    }
}

/// Opens an address in the browser; a warning where there is none.
pub(crate) fn open(url: &str) {
    let program = if cfg!(target_os = "macos") { "open" } else { "xdg-open" };
    let started = Command::new(program)
        .arg(url)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    let warn = move |reason: String| {
        tell!("warning: no browser was opened ({program}: {reason}); open the address above in one");
    };
    match started {
        // It ends when the browser does, or soon where it finds none.
        Ok(mut process) => drop(std::thread::spawn(move || match process.wait() {
            Ok(status) if !status.success() => warn(status.to_string()),
            _ => {}
        })),
        Err(error) => warn(error.to_string()),
    }
}
