//! What every page shares: style sheet and scripts.

use super::glossary::GLOSSARY;

/// Style sheet and scripts of a page.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shell {
    /// Of the program.
    pub(super) version: &'static str,
    pub(super) style: [&'static str; 4],
    /// Theme, contents, tables and glossary.
    pub(super) page: &'static str,
    /// Terms and what they mean.
    pub(super) glossary: &'static [(&'static str, &'static str)],
    /// Saved figures.
    pub(super) figures: &'static str,
    /// Values under the cursor and zoom of plots.
    pub(super) plots: &'static str,
}

/// Style sheet of a page with figures and tables, for pages that are written elsewhere.
#[must_use]
pub fn page_style() -> String {
    [sinew_view::DESIGN_STYLE, include_str!("../assets/report.css")].concat()
}

/// The one design of all pages.
pub(super) const SHELL: Shell = Shell {
    version: env!("CARGO_PKG_VERSION"),
    style: [
        sinew_view::DESIGN_STYLE,
        sinew_view::VIEW_STYLE,
        include_str!("../assets/report.css"),
        include_str!("../assets/plots.css"),
    ],
    page: include_str!("../assets/page.js"),
    glossary: GLOSSARY,
    figures: include_str!("../assets/figures.js"),
    plots: include_str!("../assets/plots.js"),
};
