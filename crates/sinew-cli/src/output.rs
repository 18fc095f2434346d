//! Output that is whole or not there.

use crate::error::Error;
use std::fs::OpenOptions;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::NamedTempFile;

/// Folders that this run made, innermost first. Locked while files are put in place, so that Ctrl-C waits for that
/// moment to pass.
static MADE: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// From here on Ctrl-C ends the program between writes, never within one.
pub(crate) fn leave_nothing_half_written() -> Result<(), Error> {
    ctrlc::set_handler(|| {
        let mut made = lock();
        remove_empty(&mut made);
        eprintln!("\ninterrupted: nothing was left half written");
        std::process::exit(130);
    })?;
    Ok(())
}

fn lock() -> MutexGuard<'static, Vec<PathBuf>> {
    MADE.lock().unwrap_or_else(PoisonError::into_inner)
}

fn remove_empty(made: &mut Vec<PathBuf>) {
    for folder in made.drain(..) {
        // Fails, as it should, where the folder holds results.
        let _ = std::fs::remove_dir(folder);
    }
}

/// A folder that is known to be writable before the work starts; removed again if it was made for nothing.
#[derive(Debug)]
pub(crate) struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Makes the folder if it is missing and tries whether a file can be written into it.
    pub(crate) fn open(path: &Path) -> Result<Self, Error> {
        // Made first, so that its end also cleans up after a failure below.
        let folder = Self { path: path.to_owned() };
        let mut made = lock();
        let missing = path.ancestors().filter(|p| !p.as_os_str().is_empty() && !p.exists());
        made.extend(missing.map(Path::to_owned));
        let tried = std::fs::create_dir_all(path).and_then(|()| NamedTempFile::new_in(path).map(drop));
        drop(made);
        tried.map_err(|source| Error::Unwritable { file: path.to_owned(), source })?;
        Ok(folder)
    }

    /// Path of a file in it.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        remove_empty(&mut lock());
    }
}

/// Refuses, before any work, to write over what is read, a log or a model of this run, and where nothing can be written.
pub(crate) fn spare<'a>(
    inputs: impl IntoIterator<Item = &'a PathBuf>,
    outputs: &[PathBuf],
) -> Result<(), Error> {
    let real = |path: &Path| path.canonicalize().ok();
    for input in inputs {
        for output in outputs {
            if real(output).is_some_and(|output| real(input) == Some(output)) {
                let source = io::Error::other("it is read by this run; choose another place");
                return Err(Error::Unwritable { file: output.clone(), source });
            }
        }
    }
    let _whole = lock();
    for (k, output) in outputs.iter().enumerate() {
        let unwritable = |source| Error::Unwritable { file: output.clone(), source };
        once(output, &outputs[..k]).and_then(|()| try_out(output)).map_err(unwritable)?;
    }
    Ok(())
}

/// Refuses a place that something else goes to.
fn once(path: &Path, others: &[PathBuf]) -> io::Result<()> {
    if others.iter().any(|other| other == path) {
        return Err(io::Error::other("two results would be written there"));
    }
    Ok(())
}

/// Tries whether a file can be put there; a device or a pipe is left alone.
fn try_out(path: &Path) -> io::Result<()> {
    match std::fs::metadata(path) {
        Ok(there) if there.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Ok(there) if !there.is_file() => Ok(()),
        _ => NamedTempFile::new_in(folder_of(path)?).map(drop),
    }
}

/// The folder that a file is to stand in.
fn folder_of(path: &Path) -> io::Result<&Path> {
    match path.parent() {
        Some(parent) if parent.as_os_str().is_empty() => Ok(Path::new(".")),
        Some(parent) if !parent.is_dir() => {
            Err(io::Error::new(io::ErrorKind::NotFound, format!("there is no folder {}", parent.display())))
        }
        Some(parent) => Ok(parent),
        None => Err(io::ErrorKind::IsADirectory.into()),
    }
}

/// What stands ready to be put in place.
enum Prepared {
    /// A whole file beside its place.
    File(NamedTempFile, PathBuf),
    /// A device or a pipe, which cannot be replaced, only written to.
    Stream(std::fs::File),
}

/// Writes files so that all of them appear whole or none does.
pub(crate) fn write_all(files: &[(PathBuf, &[u8])]) -> Result<(), Error> {
    let _whole = lock();
    let mut prepared = Vec::new();
    let places: Vec<PathBuf> = files.iter().map(|(path, _)| path.clone()).collect();
    for (k, (path, bytes)) in files.iter().enumerate() {
        let unwritable = |source| Error::Unwritable { file: path.clone(), source };
        once(path, &places[..k]).map_err(unwritable)?;
        prepared.push((prepare(path, bytes).map_err(unwritable)?, path, bytes));
    }
    for (file, path, bytes) in prepared {
        let placed = match file {
            Prepared::File(file, place) => file.persist(place).map(drop).map_err(|e| e.error),
            Prepared::Stream(mut stream) => stream.write_all(bytes).and_then(|()| stream.flush()),
        };
        placed.map_err(|source| Error::Unwritable { file: path.clone(), source })?;
    }
    Ok(())
}

fn prepare(path: &Path, bytes: &[u8]) -> io::Result<Prepared> {
    let place = match std::fs::metadata(path) {
        Ok(there) if there.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
        Ok(there) if !there.is_file() => {
            return OpenOptions::new().write(true).open(path).map(Prepared::Stream);
        }
        // A link stays a link: the file that it leads to is replaced.
        Ok(_) => path.canonicalize()?,
        Err(_) => path.to_owned(),
    };
    let mut temporary = tempfile::Builder::new();
    #[cfg(unix)]
    temporary.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
    let mut file = temporary.tempfile_in(folder_of(&place)?)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    Ok(Prepared::File(file, place))
}

/// Prints to standard output.
pub(crate) fn print(text: &str) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(Error::Stdout)
}

/// Text from a file cannot break the line or command the terminal: control characters are written as escapes.
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

/// Whether a person looks at standard output.
pub(crate) fn colours() -> bool {
    io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none()
}

/// Red on a terminal.
pub(crate) fn red(text: &str) -> String {
    let colours = io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    if colours { format!("\x1b[1;31m{text}\x1b[0m") } else { text.to_string() }
}

/// Bold on a terminal.
pub(crate) fn bold(text: &str) -> String {
    if colours() { format!("\x1b[1m{text}\x1b[0m") } else { text.to_string() }
}
