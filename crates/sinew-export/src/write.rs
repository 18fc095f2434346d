//! Files on disk: all of them or none.

use crate::{ExportError, ExportedFile};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// What was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrittenFile {
    /// Where it stands.
    pub path: PathBuf,
    /// Whether a file stood there before.
    pub replaced: bool,
}

/// Writes files into a folder, which is created where it is missing: first under temporary names, then each in
/// its place. Where anything fails, temporary files and created folders are removed.
///
/// # Errors
/// [`ExportError::Unwritable`] names the file or folder.
pub fn write(folder: &Path, files: &[ExportedFile]) -> Result<Vec<WrittenFile>, ExportError> {
    let mut created = CreatedFolders(Vec::new());
    let mut staged = Vec::new();
    for file in files {
        let place = folder.join(&file.path);
        let parent = place.parent().unwrap_or(folder);
        created.create(parent)?;
        if place.is_dir() {
            return Err(unwritable(&place, io::ErrorKind::IsADirectory.into()));
        }
        let temporary = stage(parent, &file.bytes).map_err(|source| unwritable(&place, source))?;
        staged.push((temporary, place));
    }
    let mut written = Vec::new();
    for (temporary, path) in staged {
        let replaced = path.is_file();
        temporary.persist(&path).map_err(|e| unwritable(&path, e.error))?;
        written.push(WrittenFile { path, replaced });
    }
    created.0.clear();
    Ok(written)
}

fn stage(folder: &Path, bytes: &[u8]) -> io::Result<tempfile::NamedTempFile> {
    let mut temporary = tempfile::Builder::new();
    #[cfg(unix)]
    temporary.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
    let mut file = temporary.tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    Ok(file)
}

fn unwritable(file: &Path, source: io::Error) -> ExportError {
    ExportError::Unwritable { file: file.to_owned(), source }
}

/// Folders that this run has made, outermost first; removed, where still empty, unless they are forgotten.
struct CreatedFolders(Vec<PathBuf>);

impl CreatedFolders {
    fn create(&mut self, folder: &Path) -> Result<(), ExportError> {
        let missing: Vec<_> =
            folder.ancestors().filter(|p| !p.as_os_str().is_empty() && !p.exists()).collect();
        for path in missing.into_iter().rev() {
            fs::create_dir(path).map_err(|source| unwritable(path, source))?;
            self.0.push(path.to_owned());
        }
        if folder.as_os_str().is_empty() || folder.is_dir() {
            return Ok(());
        }
        Err(unwritable(folder, io::ErrorKind::NotADirectory.into()))
    }
}

impl Drop for CreatedFolders {
    fn drop(&mut self) {
        for folder in self.0.iter().rev() {
            // One that holds something is not ours alone.
            let _ = fs::remove_dir(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a failing test may panic")]
    use super::*;

    fn files() -> [ExportedFile; 2] {
        ["a.c", "sub/b.c"].map(|path| ExportedFile::text(path, path.to_owned()))
    }

    #[test]
    fn files_and_their_folders_appear_and_are_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("deep/er");
        for replaced in [false, true] {
            let written = write(&out, &files()).unwrap();
            assert!(written.iter().all(|w| w.replaced == replaced));
            assert_eq!(fs::read_to_string(out.join("sub/b.c")).unwrap(), "sub/b.c");
        }
    }

    #[test]
    fn where_one_file_cannot_stand_none_does_and_no_folder_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        fs::write(folder.path().join("file"), "").unwrap();
        assert!(write(&folder.path().join("file"), &files()).is_err());
        assert!(write(&folder.path().join("file/below"), &files()).is_err());
        let [a, _] = files();
        let clash = ExportedFile::text("sub/c.c", String::new());
        // A file in the place of the folder of another.
        assert!(write(&out, &[a.clone(), ExportedFile::text("a.c/x", String::new()), clash]).is_ok());
        fs::remove_dir_all(&out).unwrap();
        fs::create_dir_all(out.join("sub/b.c")).unwrap();
        assert!(write(&out, &files()).is_err());
        assert!(!out.join("a.c").exists() && fs::read_dir(&out).unwrap().count() == 1);
    }
}
