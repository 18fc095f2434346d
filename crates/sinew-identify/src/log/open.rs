//! From a path or bytes to a log of which the columns are known.

#[cfg(feature = "parquet")]
use super::binary::ParquetLog;
use super::binary::{ArrayLog, is_mat5};
use super::memory_limit::MEMORY_LIMIT_BYTES;
use super::table::{Requested, Table};
use super::text::TextLog;
use super::units::{is_known, unit_of};
use crate::Error;
use std::io::Read;
use std::path::{Path, PathBuf};

/// A log of which the columns are known but no row is read.
pub(super) struct OpenLog {
    /// Its unique name.
    pub(super) file: String,
    /// The name of every column, under which it is read: `[columns]`.
    pub(super) names: Vec<String>,
    /// Its unit, or an empty text: `[columns]`.
    pub(super) units: Vec<String>,
    /// What its numbers are multiplied with to have the unit of the other logs: `[columns]`.
    pub(super) factors: Vec<f64>,
    /// What was done to names and units, in words.
    pub(super) findings: Vec<String>,
    content: Content,
}

enum Content {
    Text(TextLog),
    Arrays(ArrayLog),
    #[cfg(feature = "parquet")]
    Parquet(ParquetLog),
}

/// What kind of file it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Text,
    Mat5,
    Mat73,
    Parquet,
}

/// The kind by content, whatever the extension.
fn kind(head: &[u8]) -> Kind {
    const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
    // MATLAB writes 512 bytes of its own before the HDF5 signature.
    if head.starts_with(HDF5) || head.get(512..520) == Some(HDF5) {
        Kind::Mat73
    } else if is_mat5(head) {
        Kind::Mat5
    } else if head.starts_with(b"PAR1") {
        Kind::Parquet
    } else {
        Kind::Text
    }
}

#[cfg(not(all(feature = "parquet", feature = "mat73")))]
fn not_built(file: &str, format: &'static str, feature: &'static str) -> Error {
    Error::FormatNotBuilt { file: file.to_owned(), format, feature }
}

#[cfg(feature = "mat73")]
fn mat73(file: &str, bytes: Vec<u8>) -> Result<Content, Error> {
    ArrayLog::from_mat73(file, bytes).map(Content::Arrays)
}

#[cfg(not(feature = "mat73"))]
fn mat73(file: &str, _: Vec<u8>) -> Result<Content, Error> {
    Err(not_built(file, "MATLAB v7.3", "mat73"))
}

#[cfg(not(feature = "parquet"))]
fn parquet_file(file: &str, _: &Path) -> Result<Content, Error> {
    Err(not_built(file, "Parquet", "parquet"))
}

#[cfg(feature = "parquet")]
fn parquet_file(file: &str, path: &Path) -> Result<Content, Error> {
    ParquetLog::open(file, path).map(Content::Parquet)
}

#[cfg(not(feature = "parquet"))]
fn parquet_bytes(file: &str, _: &[u8]) -> Result<Content, Error> {
    Err(not_built(file, "Parquet", "parquet"))
}

#[cfg(feature = "parquet")]
fn parquet_bytes(file: &str, bytes: &[u8]) -> Result<Content, Error> {
    ParquetLog::from_bytes(file, bytes.to_vec()).map(Content::Parquet)
}

/// A file that has to be in memory as a whole.
fn whole(file: &str, path: &Path) -> Result<Vec<u8>, Error> {
    let unreadable = |source| Error::Unreadable { file: file.to_owned(), source };
    let handle = std::fs::File::open(path).map_err(unreadable)?;
    let size = handle.metadata().map_err(unreadable)?.len();
    let mut bytes = Vec::new();
    // Bounded while it is read, because a file may grow.
    if size <= MEMORY_LIMIT_BYTES {
        handle.take(MEMORY_LIMIT_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    }
    let size = size.max(bytes.len() as u64);
    if size > MEMORY_LIMIT_BYTES {
        return Err(too_large(file, size));
    }
    Ok(bytes)
}

fn too_large(file: &str, bytes: u64) -> Error {
    Error::TooLarge { file: file.to_owned(), needed_mb: bytes >> 20, limit_mb: MEMORY_LIMIT_BYTES >> 20 }
}

impl OpenLog {
    fn from_path(file: String, path: &Path) -> Result<Self, Error> {
        let given = || path.display().to_string();
        let unreadable = |source| Error::Unreadable { file: given(), source };
        let mut head = Vec::new();
        // Before it is opened: a pipe waits for its writer.
        let kind_of_file = std::fs::metadata(path).map_err(unreadable)?.file_type();
        if !kind_of_file.is_file() && !kind_of_file.is_dir() {
            // A log is read twice, first to find its columns.
            let got = "a device or a pipe".to_owned();
            return Err(Error::Malformed {
                file: given(),
                line: None,
                expected: "a file on disk".into(),
                got,
            });
        }
        let handle = std::fs::File::open(path).map_err(unreadable)?;
        handle.take(1024).read_to_end(&mut head).map_err(unreadable)?;
        let content = match kind(&head) {
            Kind::Text => Content::Text(TextLog::open(&file, path.to_owned())?),
            Kind::Mat5 => Content::Arrays(ArrayLog::from_mat5(&file, &whole(&file, path)?)?),
            Kind::Mat73 => mat73(&file, whole(&file, path)?)?,
            Kind::Parquet => parquet_file(&file, path)?,
        };
        Ok(Self::new(file, content))
    }

    fn from_bytes(file: String, bytes: &[u8]) -> Result<Self, Error> {
        let content = match kind(bytes) {
            Kind::Text => Content::Text(TextLog::from_bytes(&file, bytes.to_vec())?),
            Kind::Mat5 => Content::Arrays(ArrayLog::from_mat5(&file, bytes)?),
            Kind::Mat73 => mat73(&file, bytes.to_vec())?,
            Kind::Parquet => parquet_bytes(&file, bytes)?,
        };
        Ok(Self::new(file, content))
    }

    fn new(file: String, content: Content) -> Self {
        let names = match &content {
            Content::Text(log) => log.columns(),
            Content::Arrays(log) => log.columns(),
            #[cfg(feature = "parquet")]
            Content::Parquet(log) => log.columns(),
        };
        let names = names.to_vec();
        let row = |column: usize| match &content {
            Content::Text(log) => log.unit(column).trim_matches(['[', ']', '(', ')', ' ']),
            _ => "",
        };
        let unit = |(column, name): (usize, &String)| match (row(column), unit_of(name)) {
            (row, by_name) if row.is_empty() || !is_known(row) && !by_name.is_empty() => by_name,
            (row, _) => row.to_owned(),
        };
        let units = names.iter().enumerate().map(unit).collect();
        let factors = vec![1.0; names.len()];
        Self { file, names, units, factors, findings: Vec::new(), content }
    }

    /// Whether the cells of a column state time by themselves.
    pub(super) fn is_stamped(&self, column: usize) -> bool {
        match &self.content {
            Content::Text(log) => log.is_stamped(column),
            Content::Arrays(_) => false,
            #[cfg(feature = "parquet")]
            Content::Parquet(log) => log.is_stamped(column),
        }
    }

    /// Number of rows, for text an estimate.
    pub(super) fn rows(&self) -> u64 {
        match &self.content {
            Content::Text(log) => log.rows(),
            Content::Arrays(log) => log.rows(),
            #[cfg(feature = "parquet")]
            Content::Parquet(log) => log.rows(),
        }
    }

    /// Reads what is `requested`.
    pub(super) fn read(self, requested: &Requested) -> Result<Table, Error> {
        match self.content {
            Content::Text(log) => log.read(requested),
            Content::Arrays(log) => log.read(requested),
            #[cfg(feature = "parquet")]
            Content::Parquet(log) => log.read(requested),
        }
    }
}

/// Opens files; sorted by name, so that the order in which they were given changes nothing.
pub(super) fn open_paths(paths: &[PathBuf]) -> Result<Vec<OpenLog>, Error> {
    let mut named: Vec<(String, &PathBuf)> = unique_names(paths).into_iter().zip(paths).collect();
    named.sort();
    named.into_iter().map(|(name, path)| OpenLog::from_path(name, path)).collect()
}

/// Opens logs in memory; sorted by name and content.
pub(super) fn open_bytes(logs: &[(&str, &[u8])]) -> Result<Vec<OpenLog>, Error> {
    let mut logs = logs.to_vec();
    logs.sort();
    let paths: Vec<PathBuf> = logs.iter().map(|(name, _)| PathBuf::from(name)).collect();
    let named = unique_names(&paths).into_iter().zip(&logs);
    named.map(|(name, (_, bytes))| OpenLog::from_bytes(name, bytes)).collect()
}

/// File names without folders, with as many folders as make them unique.
fn unique_names(paths: &[PathBuf]) -> Vec<String> {
    let parts: Vec<Vec<String>> = paths
        .iter()
        .map(|p| p.components().map(|c| c.as_os_str().to_string_lossy().into_owned()).collect())
        .collect();
    let tail = |i: usize, n: usize| parts[i][parts[i].len().saturating_sub(n)..].join("/");
    let name_of = |i: usize| {
        let deepest = parts[i].len().max(1);
        let alone = |n: &usize| (0..paths.len()).all(|j| j == i || tail(j, *n) != tail(i, *n));
        let depth = (1..=deepest).find(alone);
        // The same path given twice: numbered, and noticed later as a duplicate.
        depth.map_or_else(
            || {
                let before = (0..i).filter(|&j| parts[j] == parts[i]).count();
                let suffix = if before == 0 { String::new() } else { format!(" ({})", before + 1) };
                format!("{}{suffix}", tail(i, 1))
            },
            |n| tail(i, n),
        )
    };
    (0..paths.len()).map(name_of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_as_short_as_they_can_be_and_unique() {
        let paths: Vec<PathBuf> =
            ["a/run.csv", "b/run.csv", "c/other.csv", "c/other.csv"].iter().map(Into::into).collect();
        assert_eq!(unique_names(&paths), ["a/run.csv", "b/run.csv", "other.csv", "other.csv (2)"]);
    }
}
