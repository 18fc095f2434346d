use crate::batch::check;
use crate::groups::Groups;
use crate::threads::{Threads, check_worlds};
use sinew::Error;
use sinew::drive::DriveCommand;
use sinew::twin::arm::{ArmTwin, ArmTwins};

/// Many simulated machines of one design, stepped together in groups of up to eight, with the bits of one by
/// one: specimens, candidates, samples of a planner.
///
/// One that cannot go on stays where it is until it is reset; the others go on.
///
/// # Example
/// ```
/// use sinew::drive::DriveCommand;
/// use sinew::machine::Machine;
/// use sinew::twin::arm::{ArmSpecimen, ArmTwin};
/// use sinew_gym::TwinBatch;
/// let text = sinew_models::BENCH_JOINT;
/// let read = sinew::description::machine_from_toml("bench_joint.toml", text, &mut |_| Err("none".into()))?;
/// let machine = read.machine;
/// let arm = |seed: usize| {
///     ArmTwin::new(&ArmSpecimen::draw(&machine, seed as u64)?, &machine.start, &[40.0; 2], seed as u64)
/// };
/// let mut batch = TwinBatch::new(20, 2, arm)?;
/// batch.step(&[DriveCommand::Velocity(0.01); 40], 0.01)?;
/// let mut alone = arm(7)?;
/// alone.step(&[DriveCommand::Velocity(0.01); 2], 0.01)?;
/// assert_eq!(batch.twins()[7].truth().q, alone.truth().q);
/// assert!(batch.failures().iter().all(Option::is_none));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct TwinBatch {
    twins: Vec<ArmTwin>,
    failures: Vec<Option<Error>>,
    groups: Groups,
}

impl TwinBatch {
    /// So many machines, as `make` makes them from their indices, stepped by `threads` threads, the calling
    /// one among them.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for the number of machines, 1 to 1 000 000, or of threads; that of the first
    /// machine that cannot be made.
    pub fn new<E: From<Error> + Send>(
        worlds: usize,
        threads: usize,
        make: impl Fn(usize) -> Result<ArmTwin, E> + Sync,
    ) -> Result<Self, E> {
        check_worlds("number of worlds", worlds)?;
        let threads = Threads::new(threads, worlds)?;
        let twins = threads.map(0..worlds, make)?;
        let groups = Groups::new(&twins[0], worlds, threads);
        Ok(Self { failures: vec![None; worlds], groups, twins })
    }

    /// The machines: `[worlds]`.
    #[must_use]
    pub fn twins(&self) -> &[ArmTwin] {
        &self.twins
    }

    /// Why machines cannot go on until they are reset: `[worlds]`.
    #[must_use]
    pub fn failures(&self) -> &[Option<Error>] {
        &self.failures
    }

    /// Replaces the machines where `mask` holds by what `make` makes from their indices.
    ///
    /// # Shapes
    /// `mask: [worlds]`.
    ///
    /// # Errors
    /// [`Error::WrongLength`]; that of the first machine that cannot be made. Nothing has then changed.
    pub fn reset<E: From<Error> + Send>(
        &mut self,
        mask: &[bool],
        make: impl Fn(usize) -> Result<ArmTwin, E> + Sync,
    ) -> Result<(), E> {
        check("mask", mask.len(), self.twins.len())?;
        let chosen = || (0..mask.len()).filter(|k| mask[*k]);
        let made = self.groups.threads().map(chosen(), make)?;
        for (k, twin) in chosen().zip(made) {
            (self.twins[k], self.failures[k]) = (twin, None);
        }
        Ok(())
    }

    /// [`ArmTwin::step`] of all machines that have not failed.
    ///
    /// # Shapes
    /// `commands: [worlds x muscles]`.
    ///
    /// # Errors
    /// [`Error::WrongLength`], and [`Error::OutOfDomain`] for `h` as there; nothing has then changed. What
    /// ends a machine's own run is in [`failures`](Self::failures).
    pub fn step(&mut self, commands: &[DriveCommand], h: f64) -> Result<(), Error> {
        let (worlds, first) = (self.twins.len(), &self.twins[0]);
        let muscles = first.truth().lengths.len();
        check("commands", commands.len(), worlds * muscles)?;
        first.check_step(&commands[..muscles], h)?;
        let rows = self.twins.iter_mut().zip(&mut self.failures).zip(commands.chunks_exact(muscles));
        let moving = rows.filter(|((_, failure), _)| failure.is_none());
        self.groups.share(moving, |memory, worlds| step_group(memory, worlds, h))
    }
}

/// A machine, where its failure is kept, and its commands.
type World<'a> = ((&'a mut ArmTwin, &'a mut Option<Error>), &'a [DriveCommand]);

fn step_group(memory: &mut ArmTwins, worlds: Vec<World<'_>>, h: f64) -> Result<(), Error> {
    let (machines, commands): (Vec<_>, Vec<_>) = worlds.into_iter().unzip();
    let (mut twins, failures): (Vec<_>, Vec<_>) = machines.into_iter().unzip();
    if !twins.is_empty() {
        let results = memory.gather(&mut twins)?.step(&commands, h);
        failures.into_iter().zip(results).for_each(|(failure, result)| *failure = result.err());
    }
    Ok(())
}
