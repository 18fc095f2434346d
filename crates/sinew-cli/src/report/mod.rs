//! The report: an [`Account`](sinew_identify::account::Account) as one HTML file, and as one picture.
//!
//! Pictures are inline SVG without text, stretched by the page, with labels set by the page beside them:
//! own code, because `plotters` and `kuva` write fixed colours and text that shrinks with the picture, so neither
//! follows a reader's theme nor stays readable on a phone. The zoomable traces are uPlot (`assets/uplot`),
//! the page is an askama template, which escapes every name.

mod checks;
pub(crate) mod error;
#[cfg(test)]
mod fixture;
mod format;
mod laws;
mod loops;
mod models;
mod page;
mod path;
mod picture;
mod plot;
mod record;
mod residuals;
mod scale;
#[cfg(test)]
mod tests;
mod traces;

pub(crate) use page::render;
pub(crate) use picture::picture_svg;
