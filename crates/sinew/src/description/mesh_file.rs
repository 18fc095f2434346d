//! Paths of mesh files.

use alloc::format;
use alloc::string::{String, ToString};

/// A path within a folder; an absolute path or a URI stays what it is.
pub(super) fn joined(folder: &str, path: &str) -> String {
    let folder = folder.trim_end_matches('/');
    if folder.is_empty() || path.starts_with('/') || path.contains("://") {
        return path.to_string();
    }
    format!("{folder}/{path}")
}
