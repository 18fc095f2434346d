/// Why there is no node.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The program was built without DDS.
    #[error("ROS 2: expected a program that was built with the feature ros, got one without it")]
    NotBuilt,
    /// DDS refuses.
    #[error("ROS 2: {what}: {reason}")]
    Dds {
        /// What was attempted.
        what: &'static str,
        /// Why it failed.
        reason: String,
    },
    /// Nobody subscribed in time.
    #[error("ROS 2: expected a reader of joint_states within {seconds} s, got none")]
    NoReader {
        /// How long was waited, s.
        seconds: f64,
    },
    /// The node's thread did not start.
    #[error("the node's thread: {0}")]
    Thread(std::io::Error),
    /// The machine is more than a link takes.
    #[error(transparent)]
    Link(#[from] sinew_link::Error),
    /// The machine's kinematics cannot be evaluated.
    #[error(transparent)]
    Messages(#[from] sinew_record::Error),
}
