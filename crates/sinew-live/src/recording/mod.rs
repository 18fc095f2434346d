//! A recording on the page.

mod cycles;
mod events;
mod playback;

pub use playback::{Playback, PlaybackParts};
