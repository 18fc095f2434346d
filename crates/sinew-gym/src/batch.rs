use crate::design::EnvironmentDesign;
use crate::environment::{Environment, advance_together, check_actions};
use crate::groups::Groups;
use crate::threads::{Threads, check_worlds};
use sinew::Error;
use sinew::twin::arm::ArmTwins;
use std::sync::Arc;

/// When an environment whose episode has ended begins another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResetMode {
    /// In the next step, whose action it ignores and whose reward is 0.
    NextStep,
    /// At the end of the same step; its last observation is told apart.
    SameStep,
    /// When it is told to; it takes no step before.
    Disabled,
}

/// Many environments of one design, stepped together: in groups of up to eight ([`ArmTwins`]), with the bits
/// of one by one.
#[derive(Debug)]
pub struct EnvironmentBatch {
    environments: Vec<Environment>,
    groups: Groups,
    mode: ResetMode,
}

/// Where a step writes: one row for every environment.
#[derive(Debug)]
pub struct Outcomes<'a> {
    /// `[environments x observations]`.
    pub observations: &'a mut [f32],
    /// `[environments]`.
    pub rewards: &'a mut [f64],
    /// `[environments]`.
    pub terminated: &'a mut [bool],
    /// `[environments]`.
    pub truncated: &'a mut [bool],
    /// `[environments]`; see [`Outcome::error`](crate::Outcome::error).
    pub errors: &'a mut [f64],
    /// Last observations of episodes that ended in this step and were reset in it:
    /// `[environments x observations]`, other rows unchanged.
    pub last_observations: &'a mut [f32],
    /// Errors at the ends of those episodes: `[environments]`, other entries unchanged.
    pub last_errors: &'a mut [f64],
}

/// One environment with its rows.
type Rows<'a> = (
    &'a mut Environment,
    &'a [f32],
    (&'a mut [f32], &'a mut [f32]),
    (&'a mut f64, (&'a mut f64, &'a mut f64)),
    (&'a mut bool, &'a mut bool),
);

impl EnvironmentBatch {
    /// One environment for each seed, stepped by `threads` threads, the calling one among them.
    ///
    /// # Errors
    /// As [`Environment::new`]; [`Error::OutOfDomain`] for the number of seeds or threads, or where the
    /// operating system gives no threads.
    pub fn new(
        design: &Arc<EnvironmentDesign>,
        seeds: &[u64],
        mode: ResetMode,
        threads: usize,
    ) -> Result<Self, Error> {
        check_worlds("number of environments", seeds.len())?;
        let threads = Threads::new(threads, seeds.len())?;
        let environments = threads.map(0..seeds.len(), |k| Environment::new(design.clone(), seeds[k]))?;
        let groups = Groups::new(environments[0].twin(), seeds.len(), threads);
        Ok(Self { environments, groups, mode })
    }

    /// The environments.
    #[must_use]
    pub fn environments(&self) -> &[Environment] {
        &self.environments
    }

    /// Begins another episode in the environments that `mask` names, all without one; with seeds, the first
    /// of each seed. Writes the observations and errors of all.
    ///
    /// # Shapes
    /// `seeds`, `mask` and `errors: [environments]`, `observations: [environments x observations]`.
    ///
    /// # Errors
    /// As [`Environment::reset`]; [`Error::WrongLength`].
    pub fn reset(
        &mut self,
        seeds: Option<&[u64]>,
        mask: Option<&[bool]>,
        observations: &mut [f32],
        errors: &mut [f64],
    ) -> Result<(), Error> {
        let (count, width) = (self.environments.len(), self.width());
        check("seeds", seeds.map_or(count, <[u64]>::len), count)?;
        check("reset mask", mask.map_or(count, <[bool]>::len), count)?;
        check("observations", observations.len(), count * width)?;
        check("errors", errors.len(), count)?;
        let one = |(k, ((environment, row), error)): (usize, ((&mut Environment, &mut [f32]), &mut f64))| {
            if mask.is_none_or(|mask| mask[k]) {
                environment.reset(seeds.map(|seeds| seeds[k]))?;
            }
            environment.observe(row);
            *error = environment.error();
            Ok(())
        };
        let rows = self.environments.iter_mut().zip(observations.chunks_exact_mut(width));
        self.groups.threads().share(rows.zip(errors).enumerate(), one)
    }

    /// One action for every environment.
    ///
    /// # Shapes
    /// `actions: [environments x actions]`.
    ///
    /// # Errors
    /// [`Error::WrongLength`] and [`Error::EntryOutOfDomain`] for actions, and for an environment that has to
    /// be reset first: nothing has then changed. As [`Environment::reset`] where episodes begin.
    pub fn step(&mut self, actions: &[f32], out: &mut Outcomes<'_>) -> Result<(), Error> {
        let (count, width, mode) = (self.environments.len(), self.width(), self.mode);
        let acts = self.environments[0].design().actions();
        check_actions(actions, count * acts)?;
        for (name, got, expected) in [
            ("observations", out.observations.len(), count * width),
            ("last observations", out.last_observations.len(), count * width),
            ("rewards", out.rewards.len(), count),
            ("errors", out.errors.len(), count),
            ("last errors", out.last_errors.len(), count),
            ("terminated", out.terminated.len(), count),
            ("truncated", out.truncated.len(), count),
        ] {
            check(name, got, expected)?;
        }
        if mode == ResetMode::Disabled
            && let Some(index) = self.environments.iter().position(Environment::ended)
        {
            let (name, expected) = ("environment", "reset after the end of its episode, which has ended");
            return Err(Error::EntryOutOfDomain { name, index, expected, got: 1.0 });
        }
        let outputs =
            out.observations.chunks_exact_mut(width).zip(out.last_observations.chunks_exact_mut(width));
        let rewards = out.rewards.iter_mut().zip(out.errors.iter_mut().zip(out.last_errors.iter_mut()));
        let ends = out.terminated.iter_mut().zip(out.truncated.iter_mut());
        let rows = self.environments.iter_mut().zip(actions.chunks_exact(acts)).zip(outputs).zip(rewards);
        let rows = rows.zip(ends).map(|((((environment, action), observations), rewards), ends)| {
            (environment, action, observations, rewards, ends)
        });
        self.groups.share(rows, |twins, rows| step_group(mode, twins, rows))
    }

    fn width(&self) -> usize {
        self.environments[0].design().observations()
    }
}

fn step_group(mode: ResetMode, twins: &mut ArmTwins, rows: Vec<Rows<'_>>) -> Result<(), Error> {
    let (mut moving, mut outputs) = (Vec::new(), Vec::new());
    for (environment, action, observations, rewards, ends) in rows {
        if environment.ended() && mode == ResetMode::NextStep {
            environment.reset(None)?;
            let ((reward, (error, _)), (terminated, truncated)) = (rewards, ends);
            (*reward, *terminated, *truncated, *error) = (0.0, false, false, environment.error());
            environment.observe(observations.0);
        } else {
            moving.push((environment, action));
            outputs.push((observations, rewards, ends));
        }
    }
    advance_together(&mut moving, twins, |k, outcome| {
        let (_, (reward, (error, _)), (terminated, truncated)) = &mut outputs[k];
        (**reward, **error) = (outcome.reward, outcome.error);
        (**terminated, **truncated) = (outcome.terminated, outcome.truncated);
    })?;
    for ((environment, _), ((observation, last), (_, (error, last_error)), _)) in
        moving.into_iter().zip(outputs)
    {
        if environment.ended() && mode == ResetMode::SameStep {
            environment.observe(last);
            *last_error = *error;
            environment.reset(None)?;
            *error = environment.error();
        }
        environment.observe(observation);
    }
    Ok(())
}

/// Refuses another length than this one.
pub(crate) fn check(name: &'static str, got: usize, expected: usize) -> Result<(), Error> {
    if got == expected { Ok(()) } else { Err(Error::WrongLength { name, expected, got }) }
}
