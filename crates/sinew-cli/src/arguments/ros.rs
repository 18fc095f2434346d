//! Arguments of runs that are a node of ROS 2.

use super::values::number;
use clap::Args;
use std::net::IpAddr;

// What `sinew run` and `sinew track` take: no documentation comment here.
#[derive(Debug, Args)]
pub(crate) struct RosArguments {
    /// Publish the run as a node of ROS 2, on loopback; needs a program built with the feature ros
    #[arg(long)]
    pub(crate) ros: bool,
    /// Take trajectories, set-points and modes from other nodes in place of a motion, within the limits of
    /// --link; whoever reaches the node may command the machine
    #[arg(long, requires = "ros", conflicts_with = "link")]
    pub(crate) ros_commands: bool,
    /// Number of the domain, 0 to 232 [default: ROS_DOMAIN_ID, or 0]
    #[arg(long, value_name = "N", requires = "ros", value_parser = clap::value_parser!(u16).range(0..=232))]
    pub(crate) ros_domain: Option<u16>,
    /// Address of the network interface that is used
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1", requires = "ros")]
    pub(crate) ros_address: IpAddr,
    /// Seconds to wait for a reader of joint_states before the first cycle, 0.1 to 3600
    #[arg(long, value_name = "SECONDS", requires = "ros",
        value_parser = number("0.1 to 3600 s", |s| (0.1..=3600.0).contains(&s)))]
    pub(crate) ros_wait: Option<f64>,
}
