//! The assets by their paths.

/// A file of the page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Asset {
    /// Its content.
    pub bytes: &'static [u8],
    /// For the header `Content-Type`.
    pub content_type: &'static str,
}

macro_rules! files {
    ($($path:literal),* $(,)?) => {
        /// Paths and contents.
        const FILES: &[(&str, &[u8])] = &[$(($path, include_bytes!(concat!("../assets/", $path)))),*];
    };
}

files![
    "icon.svg",
    "index.html",
    "live/commands.js",
    "live/connection.js",
    "live/grasp.js",
    "live/history.js",
    "live/keyboard.js",
    "live/layout.js",
    "live/loop.js",
    "live/main.js",
    "live/panes.js",
    "live/protocol.js",
    "live/replay.js",
    "live/session.js",
    "live/story.js",
    "live/toolbar.js",
    "live/traces.js",
    "style/design.css",
    "style/live.css",
    "style/view.css",
    "vendor/three/LICENSE",
    "vendor/three/three.core.min.js",
    "vendor/three/three.module.min.js",
    "vendor/uplot/LICENSE",
    "vendor/uplot/uPlot.iife.min.js",
    "vendor/uplot/uPlot.min.css",
    "view/bodies.js",
    "view/cables.js",
    "view/camera.js",
    "view/mesh.js",
    "view/palette.js",
    "view/pick.js",
    "view/report.js",
    "view/ribbon.js",
    "view/stage.js",
    "view/surroundings.js",
    "view/trail.js",
    "view/types.js",
    "view/view.js",
];

/// A file by its path below `assets`, such as `view/view.js`; `index.html` is the page.
#[must_use]
pub fn asset(path: &str) -> Option<Asset> {
    let (name, bytes) = FILES.iter().find(|(name, _)| *name == path)?;
    Some(Asset { bytes, content_type: content_type(name) })
}

/// Paths of all files.
pub fn paths() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|(path, _)| *path)
}

/// By the end of the name.
fn content_type(path: &str) -> &'static str {
    match path.rsplit('.').next() {
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("html") => "text/html; charset=utf-8",
        Some("svg") => "image/svg+xml",
        _ => "text/plain; charset=utf-8",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sha2::{Digest, Sha256};
    use std::path::{Path, PathBuf};

    /// All files below a folder, by their paths from it.
    fn below(folder: &Path, prefix: &str, found: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let entry = entry.unwrap();
            let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
            if entry.path().is_dir() {
                below(&entry.path(), &format!("{name}/"), found);
            } else {
                found.push(name);
            }
        }
    }

    fn folder() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("assets")
    }

    #[test]
    fn every_file_is_embedded_under_its_path() {
        let mut found = Vec::new();
        below(&folder(), "", &mut found);
        found.retain(|name| !NOT_SERVED.iter().any(|end| name.ends_with(end)));
        found.sort();
        let mut listed: Vec<&str> = paths().collect();
        listed.sort_unstable();
        assert_eq!(listed, found);
        assert!(asset("index.html").is_some_and(|page| page.content_type.starts_with("text/html")));
        assert!(asset("../Cargo.toml").is_none());
    }

    /// What is for readers of the repository.
    const NOT_SERVED: [&str; 3] = [".d.ts", "README.md", "sums.txt"];

    #[test]
    fn vendored_files_are_as_they_were_published() {
        let sums = include_str!("../assets/vendor/sums.txt");
        let mut listed = 0;
        for line in sums.lines() {
            let (expected, name) = line.split_once("  ").unwrap();
            let path = format!("vendor/{name}");
            let digest = Sha256::digest(asset(&path).unwrap_or_else(|| panic!("{path}")).bytes);
            let found: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
            assert_eq!(found, expected, "{path}");
            listed += 1;
        }
        let vendored = paths().filter(|path| path.starts_with("vendor/")).count();
        assert_eq!(listed, vendored, "files of others without a sum");
    }

    #[test]
    fn own_scripts_are_short_and_import_what_exists() {
        for path in paths().filter(|path| path.ends_with(".js") && !path.starts_with("vendor/")) {
            let text = std::str::from_utf8(asset(path).unwrap().bytes).unwrap();
            assert!(text.lines().count() < 300, "{path} has {} lines", text.lines().count());
            let folder = path.rsplit_once('/').unwrap().0;
            for import in crate::inline::imports(text) {
                let target = crate::inline::resolve(folder, import);
                assert!(asset(&target).is_some(), "{path} imports {import}");
            }
        }
    }
}
