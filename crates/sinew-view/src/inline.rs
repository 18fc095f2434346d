//! The view without a server: modules, style and licence to be put into one file.

use crate::files::{asset, paths};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write;

/// Parts of a page that carries the view.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InlineView {
    /// Elements `script` for the end of the page's body. Each `figure.scene` then shows the data in its own
    /// `script[type="application/json"]`. A content security policy must allow
    /// `script-src 'unsafe-inline' data:`.
    pub scripts: String,
    /// Licence of three.js.
    pub licence: &'static str,
}

/// Module that starts the view of a report.
const ENTRY: &str = "view/report.js";

/// The view of reports, offline. The same in every call.
///
/// Modules become `data:` addresses, which an import map names: such an address has no folder that a relative
/// import could start from.
#[must_use]
pub fn inline_view() -> InlineView {
    let mut map = String::new();
    for path in paths().filter(|path| is_module(path)) {
        let Some(text) = asset(path).and_then(|found| std::str::from_utf8(found.bytes).ok()) else {
            continue;
        };
        let folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
        let mut named = text.to_owned();
        for import in imports(text) {
            let name = format!("\"sinew/{}\"", resolve(folder, import));
            named = named.replace(&format!("\"{import}\""), &name);
        }
        let comma = if map.is_empty() { "" } else { "," };
        // Nothing can go wrong when writing into a string.
        let _ = write!(
            map,
            "{comma}\n\"sinew/{path}\":\"data:text/javascript;base64,{}\"",
            STANDARD.encode(named)
        );
    }
    InlineView {
        scripts: format!(
            "<script type=\"importmap\">{{\"imports\":{{{map}\n}}}}</script>\n<script \
                type=\"module\">import \"sinew/{ENTRY}\";</script>"
        ),
        licence: include_str!("../assets/vendor/three/LICENSE"),
    }
}

/// Whether a file belongs to the view.
fn is_module(path: &str) -> bool {
    path.ends_with(".js") && (path.starts_with("view/") || path.starts_with("vendor/three/"))
}

/// Relative addresses that a module imports from.
pub(crate) fn imports(text: &str) -> impl Iterator<Item = &str> {
    let quoted = text.split('"').enumerate().filter(|(k, _)| k % 2 == 1).map(|(_, part)| part);
    quoted
        .filter(|part| part.starts_with("./") || part.starts_with("../"))
        .filter(|part| part.ends_with(".js"))
}

/// The path that a relative address means in a folder.
pub(crate) fn resolve(folder: &str, import: &str) -> String {
    let mut parts: Vec<&str> = folder.split('/').filter(|part| !part.is_empty()).collect();
    for part in import.split('/') {
        match part {
            "." => {}
            ".." => {
                parts.pop();
            }
            name => parts.push(name),
        }
    }
    parts.join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_relative_address_is_resolved_in_its_folder() {
        assert_eq!(resolve("view", "./stage.js"), "view/stage.js");
        assert_eq!(resolve("live", "../vendor/three/a.js"), "vendor/three/a.js");
    }

    #[test]
    fn the_view_in_one_file_imports_only_what_it_carries() {
        let view = inline_view();
        assert_eq!(view, inline_view());
        let mut modules = 0;
        for line in view.scripts.lines().filter(|line| line.starts_with("\"sinew/")) {
            let (_, coded) = line.split_once("base64,").unwrap();
            let bytes = STANDARD.decode(coded.trim_end_matches(',').trim_end_matches('"')).unwrap();
            let text = String::from_utf8(bytes).unwrap();
            assert_eq!(imports(&text).count(), 0, "a relative import is left in {}", &line[..40]);
            for name in text.split('"').filter(|part| part.starts_with("sinew/")) {
                assert!(view.scripts.contains(&format!("\"{name}\":")), "{name} is not carried");
            }
            modules += 1;
        }
        assert!(modules > 8, "{modules}");
        // A report stays below three megabytes with its data.
        assert!(view.scripts.len() < 1_300_000, "{} bytes", view.scripts.len());
    }
}
