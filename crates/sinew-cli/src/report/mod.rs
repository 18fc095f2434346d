//! The report: an [`IdentificationReport`](sinew_identify::report::IdentificationReport) as one HTML file,
//! and as one picture.
//!
//! Pictures are inline SVG without text, stretched by the page, with labels set by the page beside them: own
//! code, because `plotters` and `kuva` put text into the SVG, where it scales with the picture and becomes
//! illegible on a phone, and `plotters` writes fixed colours, which cannot follow the reader's theme. The
//! zoomable traces are uPlot (`assets/uplot`); the page is an askama template, which escapes every name.

pub(crate) mod cable;
pub(crate) mod capability;
pub(crate) mod capability_plots;
mod checks;
pub(crate) mod colours;
pub(crate) mod error;
#[cfg(test)]
mod fixture;
mod format;
mod laws;
mod loops;
pub(crate) mod machine_picture;
mod machine_scene;
mod models;
mod pack;
mod page;
pub(crate) mod payload;
mod picture;
mod plot;
mod record;
pub(crate) mod reproduction;
mod residuals;
mod scale;
mod svg_path;
#[cfg(test)]
mod tests;
mod traces;
pub(crate) mod tracking;
mod tracking_plots;
pub(crate) mod tuning;
mod variants;
mod view;

pub(crate) use page::render;
pub(crate) use picture::picture_svg;
