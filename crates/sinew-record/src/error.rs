/// Why a recording cannot be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The file cannot be written.
    #[error("the recording cannot be written: {0}")]
    Write(#[from] std::io::Error),
    /// The MCAP writer refuses.
    #[error("the recording cannot be written: {0}")]
    Mcap(#[from] mcap::McapError),
    /// The thread that writes does not start or has ended early.
    #[error("the recording cannot be written: {0}")]
    Thread(String),
    /// The bytes are no recording, or damaged.
    #[error("byte {at}: expected {expected}, got {got}")]
    Damaged {
        /// Place in the file.
        at: u64,
        /// What belongs there.
        expected: &'static str,
        /// What is there.
        got: String,
    },
    /// A recording without an attachment that it needs.
    #[error("expected a recording of `sinew run` with the attachment {name}, got a file without it")]
    Missing {
        /// Name of the attachment.
        name: &'static str,
    },
    /// A bag without positions.
    #[error(
        "expected topics of tf2_msgs/TFMessage or geometry_msgs/PoseStamped, got {}",
        if topics.is_empty() { "none" } else { topics.as_str() }
    )]
    NoPoses {
        /// Its topics with their types.
        topics: String,
    },
    /// A file that ends before its attachments do.
    #[error(
        "byte {at}: expected the rest of a recording, got the end of the file: it was cut short before \
            {name}, without which nothing can be shown"
    )]
    CutShort {
        /// Place of the record that is not whole.
        at: u64,
        /// Name of the attachment that is missing.
        name: &'static str,
    },
    /// An attachment that cannot be read.
    #[error("attachment {name}: {reason}")]
    Attachment {
        /// Its name.
        name: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A recording of a newer program.
    #[error("expected a recording of format {expected}, got format {got}: a newer program wrote it")]
    Version {
        /// Newest that is read.
        expected: u32,
        /// The number that was found.
        got: u32,
    },
    /// A value outside the domain of the physics, or a machine of other dimensions.
    #[error(transparent)]
    Physics(#[from] sinew::Error),
}

impl Error {
    /// Whether the system, not the recording, is the cause.
    #[must_use]
    pub fn is_of_the_system(&self) -> bool {
        matches!(self, Self::Write(_) | Self::Mcap(_) | Self::Thread(_))
    }
}
