//! Colours of drawings: fixed in a standalone file, those of the theme within a page.

/// Colours of a drawing.
pub struct Colours {
    /// Background of the drawing.
    pub(super) card: &'static str,
    /// What hides that which lies below.
    pub(super) paper: &'static str,
    pub(super) line: &'static str,
    pub(super) ink: &'static str,
    pub(super) soft: &'static str,
    pub(super) near: &'static str,
    pub(super) far: &'static str,
    pub(super) toward: &'static str,
    pub(super) away: &'static str,
}

/// For a standalone file, on a white card that is legible on light and dark pages.
pub const STANDALONE: Colours = Colours {
    card: "#ffffff",
    paper: "#ffffff",
    line: "#aeb6bf",
    ink: "#14181d",
    soft: "#4d5763",
    near: "#8d949c",
    far: "#0a66c9",
    toward: "#c2570a",
    away: "#1b7f5c",
};

/// For the report, whose style sheet defines these names.
pub const PAGE: Colours = Colours {
    card: "none",
    paper: "var(--card)",
    line: "var(--rule)",
    ink: "var(--ink)",
    soft: "var(--soft)",
    near: "var(--measured)",
    far: "var(--accent)",
    toward: "var(--warm)",
    away: "var(--near)",
};
