//! Output that is whole or not there.

use crate::error::Error;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Held while files are put in place, so that Ctrl-C waits for that moment to pass.
static WRITING: Mutex<()> = Mutex::new(());

/// From here on Ctrl-C ends the program between writes, never within one.
pub(crate) fn leave_nothing_half_written() -> Result<(), Error> {
    ctrlc::set_handler(|| {
        let _whole = lock();
        eprintln!("\ninterrupted: nothing was left half written");
        std::process::exit(130);
    })?;
    Ok(())
}

fn lock() -> MutexGuard<'static, ()> {
    WRITING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A folder that is known to be writable before the work starts; removed again if it was made for nothing.
#[derive(Debug)]
pub(crate) struct Folder {
    path: PathBuf,
    made: bool,
}

impl Folder {
    /// Makes the folder if it is missing and tries whether a file can be written into it.
    pub(crate) fn open(path: &Path) -> Result<Self, Error> {
        let unwritable = |source| Error::Unwritable { file: path.to_owned(), source };
        let made = !path.exists();
        std::fs::create_dir_all(path).map_err(unwritable)?;
        let folder = Self { path: path.to_owned(), made };
        let _whole = lock();
        tempfile::NamedTempFile::new_in(path).map_err(unwritable)?;
        Ok(folder)
    }

    /// Path of a file in it.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if self.made {
            // Fails, as it should, where the folder holds results.
            let _ = std::fs::remove_dir(&self.path);
        }
    }
}

/// Writes files so that all of them appear whole or none does.
pub(crate) fn write_all(files: &[(PathBuf, &[u8])]) -> Result<(), Error> {
    let _whole = lock();
    let mut prepared = Vec::new();
    for (path, bytes) in files {
        let unwritable = |source| Error::Unwritable { file: path.clone(), source };
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let mut temporary = tempfile::Builder::new();
        #[cfg(unix)]
        temporary.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
        let mut file = temporary.tempfile_in(folder).map_err(unwritable)?;
        file.write_all(bytes).and_then(|()| file.as_file().sync_all()).map_err(unwritable)?;
        prepared.push((file, path));
    }
    for (file, path) in prepared {
        file.persist(path).map_err(|e| Error::Unwritable { file: path.clone(), source: e.error })?;
    }
    Ok(())
}

/// Prints to standard output.
pub(crate) fn print(text: &str) -> Result<(), Error> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(Error::Stdout)
}

/// Whether a person looks at standard output.
pub(crate) fn colours() -> bool {
    std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none()
}

/// Red on a terminal.
pub(crate) fn red(text: &str) -> String {
    let colours = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    if colours { format!("\x1b[1;31m{text}\x1b[0m") } else { text.to_string() }
}

/// Bold on a terminal.
pub(crate) fn bold(text: &str) -> String {
    if colours() { format!("\x1b[1m{text}\x1b[0m") } else { text.to_string() }
}
