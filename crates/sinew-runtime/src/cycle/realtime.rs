use rustix::mm::{MlockAllFlags, mlockall};
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy, set_thread_priority_and_policy,
    thread_native_id,
};

/// Priority of the cycle's thread among real-time ones, 1 to 99: above the kernel's interrupt threads, which
/// have 50.
const PRIORITY: u8 = 80;

/// What the operating system granted to the cycle's thread.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RealTime {
    /// What it refused, with the remedy.
    pub shortcomings: Vec<Shortcoming>,
}

/// A request that the operating system refused.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shortcoming {
    /// The request.
    pub what: &'static str,
    /// Its answer.
    pub why: String,
    /// What helps.
    pub remedy: &'static str,
}

impl std::fmt::Display for Shortcoming {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}; {}", self.what, self.why, self.remedy)
    }
}

impl RealTime {
    /// Locks the program's memory and schedules the calling thread before all others (SCHED_FIFO). Without
    /// either the cycle runs, with longer delays.
    #[must_use]
    pub fn request() -> Self {
        let mut shortcomings = Vec::new();
        if let Err(error) = mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE) {
            shortcomings.push(Shortcoming {
                what: "memory is not locked",
                why: std::io::Error::from(error).to_string(),
                remedy: "raise the limit with `ulimit -l unlimited` or grant the capability CAP_IPC_LOCK",
            });
        }
        let scheduled =
            ThreadPriority::try_from(PRIORITY).map_err(|error| error.to_owned()).and_then(|priority| {
                let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
                set_thread_priority_and_policy(thread_native_id(), priority, policy)
                    .map_err(|error| format!("{error:?}"))
            });
        if let Err(why) = scheduled {
            shortcomings.push(Shortcoming {
                what: "the cycle's thread has no real-time priority",
                why,
                remedy: "grant the capability CAP_SYS_NICE, or allow `rtprio 80` in /etc/security/limits.d",
            });
        }
        Self { shortcomings }
    }
}
