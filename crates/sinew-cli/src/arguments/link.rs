//! Arguments of `sinew link`, and those of `sinew run` that concern a link.

use super::values::number;
use clap::{Args, Subcommand};
use std::net::SocketAddr;
use std::path::PathBuf;

/// Commands from elsewhere to a machine under `sinew run`.
#[derive(Debug, Args)]
pub(crate) struct LinkArguments {
    #[command(subcommand)]
    pub(crate) verb: LinkVerb,
}

#[derive(Debug, Subcommand)]
pub(crate) enum LinkVerb {
    Key(LinkKeyArguments),
    Watch(LinkWatchArguments),
}

/// Write a new random key for links to a new file that its owner alone may read.
///
/// Example: sinew link key robot.key
#[derive(Debug, Args)]
pub(crate) struct LinkKeyArguments {
    /// File to write; it must not exist
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
}

/// Show the state of a machine that runs with a link, without commanding it.
///
/// Up to eight watch beside the client that commands. With --json one line per state.
///
/// Example: sinew link watch 127.0.0.1:7500
#[derive(Debug, Args)]
pub(crate) struct LinkWatchArguments {
    /// Where the machine's link listens
    #[arg(value_name = "ADDR:PORT")]
    pub(crate) address: SocketAddr,
    /// Key file of the link
    #[arg(long, value_name = "FILE")]
    pub(crate) key: Option<PathBuf>,
    /// Seconds after which it ends, 0.1 to 86400 [default: never]
    #[arg(long, value_name = "SECONDS",
        value_parser = number("0.1 to 86400 s", |s| (0.1..=86_400.0).contains(&s)))]
    pub(crate) duration: Option<f64>,
}

// What `sinew run` takes: no documentation comment here.
#[derive(Debug, Args)]
pub(crate) struct RunLinkArguments {
    /// Take requests and set-points from a client at this address and port (0: a free one) in place of a
    /// motion; the motion's speeds and accelerations [default: those of a tour] are the limits. In virtual
    /// time the machine's time goes on as the client asks
    #[arg(long, value_name = "ADDR:PORT")]
    pub(crate) link: Option<SocketAddr>,
    /// Key file of the link; needed unless the address is a loopback one
    #[arg(long, value_name = "FILE", requires = "link")]
    pub(crate) key: Option<PathBuf>,
    /// Seconds of the machine's time after which a run with --link or --ros-commands ends, 0.1 to 1e6
    /// [default: when it is turned off from there]
    #[arg(long, value_name = "SECONDS",
        value_parser = number("0.1 to 1e6 s", |s| (0.1..=1e6).contains(&s)))]
    pub(crate) until: Option<f64>,
}
