//! A picture, and who gets it beside the viewers of the page: Foxglove, in programs that were built with it.

use crate::error::LiveError;
#[cfg(feature = "foxglove")]
use crate::foxglove_view::FoxgloveView;
use std::net::SocketAddr;
use std::sync::Arc;

/// The newest picture, from which every viewer takes it.
#[derive(Debug, Clone)]
pub(crate) struct Picture {
    pub(crate) revision: u32,
    pub(crate) state: Arc<Vec<u8>>,
    pub(crate) scene: Arc<String>,
}

/// Foxglove beside the page.
pub(crate) struct Beside {
    #[cfg(feature = "foxglove")]
    view: Option<FoxgloveView>,
}

impl Beside {
    #[cfg(feature = "foxglove")]
    pub(crate) fn start(address: Option<SocketAddr>) -> Result<Self, LiveError> {
        let view = address.map(FoxgloveView::start).transpose()?;
        Ok(Self { view })
    }

    #[cfg(not(feature = "foxglove"))]
    pub(crate) fn start(address: Option<SocketAddr>) -> Result<Self, LiveError> {
        match address {
            None => Ok(Self {}),
            Some(address) => {
                let reason = "this program was built without Foxglove's protocol; build it with the \
                    feature `foxglove`";
                Err(LiveError::Foxglove { address, reason: reason.to_owned() })
            }
        }
    }

    /// Where it listens, asked for an address.
    pub(crate) fn address(&self, asked: Option<SocketAddr>) -> Option<SocketAddr> {
        #[cfg(feature = "foxglove")]
        let asked = asked.map(|mut address| {
            address.set_port(self.view.as_ref().map_or(0, FoxgloveView::port));
            address
        });
        asked
    }

    #[cfg(feature = "foxglove")]
    pub(crate) fn show(&mut self, picture: &Picture) {
        if let Some(view) = &mut self.view {
            view.show(picture.revision, &picture.scene, &picture.state);
        }
    }

    #[cfg(not(feature = "foxglove"))]
    pub(crate) fn show(&mut self, _: &Picture) {}
}
