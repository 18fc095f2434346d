//! Pages and pictures of results: identifications, machines, tracking runs, the reproduction of one paper.
//!
//! Every page is one self-contained HTML file of one design: a bar with the theme, contents, print style.
//! Plots are inline SVG without text, stretched by the page, with labels set by the page beside them: own
//! code, because `plotters` and `kuva` put text into the SVG, where it scales with the picture and becomes
//! illegible on a phone, and `plotters` writes fixed colours, which cannot follow the reader's theme.
//! `assets/plots.js` reads their paths to show values under the cursor, to zoom and to save them;
//! three-dimensional views and the design are those of the live page (`sinew-view`); the time series of an
//! identification are uPlot. Without scripts the pages are complete but for these. The pages are askama
//! templates, which escape every name.

pub mod cable;
pub mod capability;
pub mod capability_plots;
mod checks;
pub mod colours;
mod envelope;
pub mod error;
mod format;
mod glossary;
mod laws;
mod loops;
pub mod machine_picture;
mod machine_scene;
mod models;
mod pack;
mod page;
pub mod payload;
mod picture;
mod plot;
mod record;
pub mod reproduction;
mod residuals;
pub mod robot;
mod scale;
pub mod scene;
pub mod shapes;
mod shell;
pub mod signals;
mod svg_path;
#[cfg(test)]
mod tests;
mod text;
mod traces;
pub mod tracking;
pub mod tuning;
mod variants;
mod view;

pub use page::render;
pub use picture::picture_svg;
pub use shell::page_style;
