use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// A file whose text cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum TextFileError {
    /// It cannot be opened or read.
    #[error("{}: cannot be read: {source}", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It is larger than any real one.
    #[error("{}: expected at most {limit_mb} MB, got more", file.display())]
    TooLarge {
        /// The file.
        file: PathBuf,
        /// Largest size that is read.
        limit_mb: u64,
    },
    /// It is no text.
    #[error("{}: expected text (UTF-8), got {source}", file.display())]
    NotText {
        /// The file.
        file: PathBuf,
        /// Where.
        source: std::str::Utf8Error,
    },
}

/// Largest file that is read, MB; real ones have some ten kilobytes, logs of hours some ten megabytes.
const MAX_FILE_MB: u64 = 64;

/// Text of a file of bounded size, without a byte order mark.
///
/// # Errors
/// [`TextFileError`] names the file.
pub fn read_text(path: &Path) -> Result<String, TextFileError> {
    let unreadable = |source| TextFileError::Unreadable { file: path.to_owned(), source };
    let limit = MAX_FILE_MB << 20;
    let mut bytes = Vec::new();
    // Bounded while it is read: a device or a pipe has no size beforehand.
    let file = std::fs::File::open(path).map_err(unreadable)?;
    file.take(limit + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > limit {
        return Err(TextFileError::TooLarge { file: path.to_owned(), limit_mb: MAX_FILE_MB });
    }
    let text = String::from_utf8(bytes)
        .map_err(|e| TextFileError::NotText { file: path.to_owned(), source: e.utf8_error() })?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}
