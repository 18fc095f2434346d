//! Pages and pictures of results: identifications, machines, tracking runs, the reproduction of one paper.
//!
//! Every page is one self-contained HTML file. Pictures are inline SVG without text, stretched by the page, with labels set by
//! the page beside them: own code, because `plotters` and `kuva` put text into the SVG, where it scales with the picture and
//! becomes illegible on a phone, and `plotters` writes fixed colours, which cannot follow the reader's theme. The zoomable
//! traces are uPlot (`assets/uplot`); the pages are askama templates, which escape every name.

pub mod cable;
pub mod capability;
pub mod capability_plots;
mod checks;
pub mod colours;
pub mod error;
#[cfg(test)]
mod fixture;
mod format;
mod laws;
mod loops;
pub mod machine_picture;
mod machine_scene;
mod models;
mod pack;
mod page;
#[cfg(test)]
mod page_tests;
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
mod traces;
pub mod tracking;
pub mod tuning;
mod variants;
mod view;

pub use page::render;
pub use picture::picture_svg;
