use crate::threads::Threads;
use sinew::Error;
use sinew::twin::arm::{ArmTwin, ArmTwins};
use std::sync::Arc;

/// Worlds of one machine in groups of up to eight, each with memory to step together, and the threads that
/// share the groups.
#[derive(Debug, Clone)]
pub(crate) struct Groups {
    memory: Vec<ArmTwins>,
    /// Worlds of a group.
    size: usize,
    threads: Arc<Threads>,
}

impl Groups {
    /// For so many worlds with machines like this one: as large as leaves a group to every thread.
    pub(crate) fn new(twin: &ArmTwin, worlds: usize, threads: Threads) -> Self {
        let size = worlds.div_ceil(threads.count()).clamp(1, ArmTwins::LANES);
        Self { memory: vec![ArmTwins::new(twin); worlds.div_ceil(size)], size, threads: Arc::new(threads) }
    }

    /// Does `work` on every group of these worlds.
    ///
    /// # Errors
    /// As [`Threads::share`].
    pub(crate) fn share<T: Send>(
        &mut self,
        mut worlds: impl Iterator<Item = T> + Send,
        work: impl Fn(&mut ArmTwins, Vec<T>) -> Result<(), Error> + Sync,
    ) -> Result<(), Error> {
        let size = self.size;
        let groups = self.memory.iter_mut().map(|memory| (memory, worlds.by_ref().take(size).collect()));
        self.threads.share(groups, |(memory, worlds)| work(memory, worlds))
    }

    /// The threads.
    pub(crate) fn threads(&self) -> &Threads {
        &self.threads
    }
}
