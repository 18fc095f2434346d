//! The files that a machine file names.

use alloc::format;
use alloc::string::{String, ToString};

/// A file that another one names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FileReference<'a> {
    /// Path as the machine file has it.
    pub path: &'a str,
    /// The file that the path is relative to: none for the machine file, else the body's, as the machine file
    /// names it.
    pub included_by: Option<&'a str>,
}

/// Gives the text of a file, or the reason why there is none.
pub type ReadFile<'a> = dyn FnMut(FileReference<'_>) -> Result<String, String> + 'a;

/// Reader of the files that a machine file names.
pub(super) struct Files<'a> {
    read: &'a mut ReadFile<'a>,
    /// Name of the machine file.
    machine: &'a str,
}

impl<'a> Files<'a> {
    pub(super) fn new(machine: &'a str, read: &'a mut ReadFile<'a>) -> Self {
        Self { read, machine }
    }

    pub(super) fn read(&mut self, path: &str) -> Result<String, String> {
        (self.read)(FileReference { path, included_by: None })
    }

    pub(super) fn include(&mut self, path: &str, by: &str) -> Result<String, String> {
        (self.read)(FileReference { path, included_by: Some(by) })
    }

    /// A path relative to the machine file as errors name it: with the folder of that file.
    pub(super) fn display(&self, path: &str) -> String {
        let folder = self.machine.rfind('/').filter(|_| !path.starts_with('/'));
        folder.map_or_else(|| path.to_string(), |end| format!("{}{path}", &self.machine[..=end]))
    }
}
