//! From a path or bytes to a log of which the columns are known.

use super::table::{Table, Wanted};
use super::text::TextLog;
use crate::Error;
use std::path::{Path, PathBuf};

/// Memory the columns of all logs together may take; more is refused with its size.
///
/// Estimated as rows x (columns asked for + 2) x 8 bytes before a row is kept.
pub const MEMORY_LIMIT_BYTES: u64 = 2 << 30;

/// A log that was looked at but not read.
pub(super) struct OpenLog {
    /// Its unique name.
    pub(super) file: String,
    content: Content,
}

enum Content {
    Text(TextLog),
}

impl OpenLog {
    fn from_path(file: String, path: &Path) -> Result<Self, Error> {
        let content = Content::Text(TextLog::open(&file, path.to_owned())?);
        Ok(Self { file, content })
    }

    fn from_bytes(file: String, bytes: &[u8]) -> Result<Self, Error> {
        let content = Content::Text(TextLog::from_bytes(&file, bytes.to_vec())?);
        Ok(Self { file, content })
    }

    /// Column names.
    pub(super) fn columns(&self) -> &[String] {
        match &self.content {
            Content::Text(log) => log.columns(),
        }
    }

    /// Unit of a column from a units row, or an empty string.
    pub(super) fn unit(&self, column: usize) -> &str {
        match &self.content {
            Content::Text(log) => log.unit(column),
        }
    }

    /// Estimated number of rows.
    pub(super) fn rows(&self) -> u64 {
        match &self.content {
            Content::Text(log) => log.rows(),
        }
    }

    /// Reads what is `wanted`.
    pub(super) fn read(self, wanted: &Wanted) -> Result<Table, Error> {
        match self.content {
            Content::Text(log) => log.read(wanted),
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

/// File names without folders, with as many folders as tell them apart.
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
