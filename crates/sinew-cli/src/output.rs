//! Output files that appear complete or not at all.

use crate::error::Error;
use crate::interrupt;
use std::fs::OpenOptions;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::NamedTempFile;

/// Folders created by this run, innermost first. The lock is held while files are put in place, so that
/// Ctrl-C is handled before or after it.
static CREATED_FOLDERS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// From here on Ctrl-C, a request to terminate and a closed terminal end the program between writes, never
/// during one.
pub(crate) fn install_interrupt_handler() -> Result<(), Error> {
    ctrlc::set_handler(|| {
        if interrupt::is_answered() {
            return;
        }
        let mut created = lock();
        remove_empty_folders(&mut created);
        tell!("\ninterrupted: no output was left incomplete");
        std::process::exit(130);
    })?;
    Ok(())
}

fn lock() -> MutexGuard<'static, Vec<PathBuf>> {
    CREATED_FOLDERS.lock().unwrap_or_else(PoisonError::into_inner)
}

fn remove_empty_folders(created: &mut Vec<PathBuf>) {
    for folder in created.drain(..) {
        // Fails, as intended, where the folder is not empty.
        let _ = std::fs::remove_dir(folder);
    }
}

/// A folder that was writable before the work started; removed on drop if this run created it and it is
/// empty.
#[derive(Debug)]
pub(crate) struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Creates the folder if it is missing and checks that a file can be written into it.
    pub(crate) fn open(path: &Path) -> Result<Self, Error> {
        if let Some(file) = path.ancestors().find(|p| p.exists()).filter(|p| !p.is_dir()) {
            let source = io::Error::other(format!("expected a folder, and {} is a file", file.display()));
            return Err(Error::Unwritable { file: path.to_owned(), source });
        }
        // Constructed first, so that dropping it also cleans up after a failure below.
        let folder = Self { path: path.to_owned() };
        let mut created = lock();
        let missing = path.ancestors().filter(|p| !p.as_os_str().is_empty() && !p.exists());
        // What is created later may lie inside what was created before.
        created.splice(0..0, missing.map(Path::to_owned).collect::<Vec<_>>());
        let result = std::fs::create_dir_all(path).and_then(|()| NamedTempFile::new_in(path).map(drop));
        drop(created);
        result.map_err(|source| Error::Unwritable { file: path.to_owned(), source })?;
        Ok(folder)
    }

    /// Path of a file in it.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        remove_empty_folders(&mut lock());
    }
}

/// Refuses, before any work, outputs that would replace an input or one another, places that cannot be
/// written, and with `no_clobber` those of files that exist.
pub(crate) fn refuse_overwrite<'a>(
    inputs: impl IntoIterator<Item = &'a PathBuf>,
    outputs: &[PathBuf],
    no_clobber: bool,
) -> Result<(), Error> {
    let real = |path: &Path| path.canonicalize().ok();
    for input in inputs {
        for output in outputs {
            if real(output).is_some_and(|output| real(input) == Some(output)) {
                return Err(Error::OutputIsInput { file: output.clone() });
            }
        }
    }
    let _guard = lock();
    for (k, output) in outputs.iter().enumerate() {
        refuse_duplicate(output, &outputs[..k])?;
        check_writable(output).map_err(|source| Error::Unwritable { file: output.clone(), source })?;
        if no_clobber && output.is_file() {
            return Err(Error::Exists { file: output.clone(), remedy: "no --no-clobber" });
        }
    }
    Ok(())
}

/// Refuses a place that another output has, by whatever name.
fn refuse_duplicate(path: &Path, others: &[PathBuf]) -> Result<(), Error> {
    let place = resolved(path);
    if others.iter().any(|other| resolved(other) == place) {
        return Err(Error::OutputTwice { file: path.to_owned() });
    }
    Ok(())
}

/// The place that a path leads to, whether the file exists or not.
fn resolved(path: &Path) -> PathBuf {
    let in_folder = || {
        let folder = parent_folder(path).ok()?.canonicalize().ok()?;
        Some(folder.join(path.file_name()?))
    };
    path.canonicalize().ok().or_else(in_folder).unwrap_or_else(|| path.to_owned())
}

/// Checks that a file can be written; a device or a pipe is not touched.
fn check_writable(path: &Path) -> io::Result<()> {
    match std::fs::metadata(path) {
        Ok(metadata) if metadata.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Ok(metadata) if !metadata.is_file() => Ok(()),
        _ => NamedTempFile::new_in(parent_folder(path)?).map(drop),
    }
}

/// The folder of a file.
fn parent_folder(path: &Path) -> io::Result<&Path> {
    match path.parent() {
        Some(parent) if parent.as_os_str().is_empty() => Ok(Path::new(".")),
        Some(parent) if !parent.is_dir() => {
            Err(io::Error::new(io::ErrorKind::NotFound, format!("there is no folder {}", parent.display())))
        }
        Some(parent) => Ok(parent),
        None => Err(io::ErrorKind::IsADirectory.into()),
    }
}

/// An output that is complete and not yet in place.
enum Staged {
    /// A temporary file in the target's folder, and the target.
    File(NamedTempFile, PathBuf),
    /// A device or a pipe, which is written to instead of replaced.
    Stream(std::fs::File),
}

/// A file that a run has written.
#[derive(Debug)]
pub(crate) struct Written {
    pub(crate) file: PathBuf,
    /// Whether a file stood there before.
    pub(crate) replaced: bool,
}

/// Writes files so that either all of them appear complete or none does.
pub(crate) fn write_all(files: &[(PathBuf, &[u8])]) -> Result<Vec<Written>, Error> {
    let _guard = lock();
    let mut staged = Vec::new();
    let report = |path: &PathBuf| Written { file: path.clone(), replaced: path.is_file() };
    let all = files.iter().map(|(path, _)| report(path)).collect();
    let targets: Vec<PathBuf> = files.iter().map(|(path, _)| path.clone()).collect();
    for (k, (path, bytes)) in files.iter().enumerate() {
        let unwritable = |source| Error::Unwritable { file: path.clone(), source };
        refuse_duplicate(path, &targets[..k])?;
        staged.push((stage(path, bytes).map_err(unwritable)?, path, bytes));
    }
    for (file, path, bytes) in staged {
        let written = match file {
            Staged::File(file, place) => file.persist(place).map(drop).map_err(|e| e.error),
            Staged::Stream(mut stream) => stream.write_all(bytes).and_then(|()| stream.flush()),
        };
        written.map_err(|source| Error::Unwritable { file: path.clone(), source })?;
    }
    Ok(all)
}

/// Writes a file piece by piece so that it appears complete or not at all; returns what `write` does.
pub(crate) fn write_streamed<R>(
    path: &Path,
    write: impl FnOnce(&mut std::fs::File) -> Result<R, Error>,
) -> Result<(R, Written), Error> {
    let unwritable = |source| Error::Unwritable { file: path.to_owned(), source };
    let written = Written { file: path.to_owned(), replaced: path.is_file() };
    let result = match stage(path, &[]).map_err(unwritable)? {
        Staged::File(mut file, place) => {
            let result = write(file.as_file_mut())?;
            file.as_file().sync_all().map_err(unwritable)?;
            let _guard = lock();
            file.persist(place).map_err(|e| unwritable(e.error))?;
            result
        }
        Staged::Stream(mut stream) => write(&mut stream)?,
    };
    Ok((result, written))
}

fn stage(path: &Path, bytes: &[u8]) -> io::Result<Staged> {
    let place = match std::fs::metadata(path) {
        Ok(metadata) if metadata.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
        Ok(metadata) if !metadata.is_file() => {
            return OpenOptions::new().write(true).open(path).map(Staged::Stream);
        }
        // A symbolic link stays one: its target is replaced.
        Ok(_) => path.canonicalize()?,
        Err(_) => path.to_owned(),
    };
    let mut temporary = tempfile::Builder::new();
    #[cfg(unix)]
    temporary.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
    let mut file = temporary.tempfile_in(parent_folder(&place)?)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    Ok(Staged::File(file, place))
}

/// Prints to standard output.
pub(crate) fn print(text: &str) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(Error::Stdout)
}

/// Text with control characters escaped, so that names from a file can neither break the line nor control the
/// terminal.
pub(crate) fn one_line(text: &str) -> String {
    text.chars().fold(String::new(), |mut line, c| {
        if c.is_control() {
            line.extend(c.escape_default());
        } else {
            line.push(c);
        }
        line
    })
}

/// Whether standard output is a terminal that shows colours.
pub(crate) fn stdout_is_coloured() -> bool {
    io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none()
}

/// Red on a terminal.
pub(crate) fn red(text: &str) -> String {
    let colours = io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    if colours { format!("\x1b[1;31m{text}\x1b[0m") } else { text.to_string() }
}

/// Bold on a terminal.
pub(crate) fn bold(text: &str) -> String {
    if stdout_is_coloured() { format!("\x1b[1m{text}\x1b[0m") } else { text.to_string() }
}
