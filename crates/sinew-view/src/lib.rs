//! The three-dimensional view and the page of a running machine.
//!
//! The assets are native ES modules with JSDoc types, without a bundler: `assets/view` draws a machine and is
//! shared by the page and the reports, `assets/live` is the page, `assets/style` the one design of all pages,
//! `assets/vendor` three.js and uPlot as they were published. A server asks for [`asset`] by the path of a
//! request; a report puts [`inline_view`] into its one file.

mod files;
mod inline;
mod meshes;
mod reduction;
mod shapes;

pub use files::{Asset, asset, paths};
pub use inline::{InlineView, inline_view};
pub use meshes::{EncodedMesh, ReadMesh, meshes, read_meshes, surface_of};
pub use shapes::{Shape, shapes};

/// Style sheet of the design that all pages share: colours in light and dark, type, buttons, bar and tags.
pub const DESIGN_STYLE: &str = include_str!("../assets/style/design.css");
/// Style sheet of the three-dimensional view.
pub const VIEW_STYLE: &str = include_str!("../assets/style/view.css");
/// uPlot, a script that defines `uPlot`.
pub const UPLOT: &str = include_str!("../assets/vendor/uplot/uPlot.iife.min.js");
/// Style sheet of uPlot.
pub const UPLOT_STYLE: &str = include_str!("../assets/vendor/uplot/uPlot.min.css");
/// Licence of uPlot.
pub const UPLOT_LICENCE: &str = include_str!("../assets/vendor/uplot/LICENSE");
