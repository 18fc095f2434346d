//! Arguments of runs that can be shown on a page.

use clap::Args;
use std::net::SocketAddr;

// What `sinew run` and `sinew track` take: no documentation comment here.
#[derive(Debug, Args)]
pub(crate) struct PageArguments {
    /// Show the run on a page in the browser while it lasts; the page can stop it; see `sinew live`
    #[arg(long)]
    pub(crate) page: bool,
    /// Address and port of the page; port 0 is any that is free
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8470", requires = "page")]
    pub(crate) bind: SocketAddr,
    /// Open the page in the browser
    #[arg(long, requires = "page")]
    pub(crate) open: bool,
    /// Serve Foxglove's protocol as well, on this loopback address; needs a program built with the feature
    /// foxglove
    #[arg(long, value_name = "ADDRESS:PORT", requires = "page")]
    pub(crate) foxglove: Option<SocketAddr>,
}
