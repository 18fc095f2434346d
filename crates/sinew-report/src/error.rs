//! Errors of writing a report.

/// Why no report could be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The page template could not be filled.
    #[error("the report's page could not be written: {0}")]
    Page(#[from] askama::Error),
    /// The traces could not be packed for the page.
    #[error("the report's traces could not be packed: {0}")]
    Data(#[from] serde_json::Error),
    /// The machine could not be drawn.
    #[error("the machine could not be drawn: {0}")]
    Drawing(#[from] sinew::Error),
}
