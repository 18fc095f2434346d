//! A recording for the page.

use crate::arguments::LiveArguments;
use crate::error::Error;
use crate::progress::Progress;
use crate::verbs::meshes::read_meshes;
use crate::verbs::page::tension_limits;
use crate::verbs::recording::{RunSetup, read_bytes, recording};
use sinew_live::{LiveError, Playback, PlaybackParts};

/// The recording of the arguments with those over it, and whether its machine was simulated.
pub(super) fn playback(arguments: &LiveArguments) -> Result<(Playback, bool), Error> {
    let file = &arguments.model;
    let bytes = read_bytes(file)?;
    let read = recording(file, &bytes)?;
    let setup = RunSetup::from_recording(file, &read)?;
    let mut machine = setup.machine(file, &read)?;
    read_meshes(&mut machine.robot, setup.machine_path(), arguments.root.dir.as_deref());
    let simulated = read.head.simulated;
    // A motion that cannot be planned again is not drawn; what was recorded is.
    let trajectory = if setup.link.is_some() { None } else { setup.trajectory(file, &read, &machine).ok() };
    drop(read);
    let overlays = arguments.overlay.iter().map(|path| {
        let name = path
            .file_name()
            .map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned());
        Ok((name, read_bytes(path)?))
    });
    let parts = PlaybackParts {
        tension_limits: tension_limits(&machine),
        path: setup.path.clone(),
        overlays: overlays.collect::<Result<_, Error>>()?,
        machine,
        trajectory,
        bytes,
    };
    let progress = Progress::new();
    let playback = Playback::new(parts, |done| progress.show("looking through the recording", done));
    drop(progress);
    let playback = playback.map_err(|error| match error {
        LiveError::Recording(error) => Error::recording(file)(error),
        LiveError::Overlay { name, reason } => Error::Shown(format!("--overlay {name}: {reason}")),
        other => other.into(),
    })?;
    if let Some(notice) = playback.notice() {
        tell!("warning: {}: {notice}", file.display());
    }
    Ok((playback, simulated))
}
