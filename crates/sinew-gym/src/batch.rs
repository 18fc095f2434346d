use crate::design::EnvironmentDesign;
use crate::environment::{Environment, check_actions};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use sinew::Error;
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

/// Many environments of one design, stepped together.
#[derive(Debug)]
pub struct EnvironmentBatch {
    environments: Vec<Environment>,
    mode: ResetMode,
    /// None: in the calling thread.
    pool: Option<ThreadPool>,
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
    /// Last observations of episodes that ended in this step and were reset in it: `[environments x observations]`, other
    /// rows unchanged.
    pub last_observations: &'a mut [f32],
    /// Errors at the ends of those episodes: `[environments]`, other entries unchanged.
    pub last_errors: &'a mut [f64],
}

/// Blocks of environments for each thread: those whose environments reset last longer.
const BLOCKS_PER_THREAD: usize = 4;
/// Most threads and most environments.
const MOST_THREADS: usize = 1024;
const MOST_ENVIRONMENTS: usize = 1_000_000;

/// One environment with its rows.
type Rows<'a> = (
    &'a mut Environment,
    &'a [f32],
    (&'a mut [f32], &'a mut [f32]),
    (&'a mut f64, (&'a mut f64, &'a mut f64)),
    (&'a mut bool, &'a mut bool),
);

impl EnvironmentBatch {
    /// One environment for each seed, stepped by `threads` threads; 1: by the calling thread.
    ///
    /// # Errors
    /// As [`Environment::new`]; [`Error::OutOfDomain`] for the number of seeds or threads, or where the operating system
    /// gives no threads.
    pub fn new(
        design: &Arc<EnvironmentDesign>,
        seeds: &[u64],
        mode: ResetMode,
        threads: usize,
    ) -> Result<Self, Error> {
        let domain = |name, expected, got: usize| Error::OutOfDomain { name, expected, got: got as f64 };
        if !(1..=MOST_ENVIRONMENTS).contains(&seeds.len()) {
            return Err(domain("number of environments", "from 1 to 1 000 000", seeds.len()));
        }
        if !(1..=MOST_THREADS).contains(&threads) {
            return Err(domain("number of threads", "from 1 to 1024", threads));
        }
        let pool = if threads == 1 || seeds.len() == 1 {
            None
        } else {
            let built = ThreadPoolBuilder::new().num_threads(threads.min(seeds.len())).build();
            Some(built.map_err(|_| domain("number of threads", "as many as the system gives", threads))?)
        };
        let make = |seed: &u64| Environment::new(design.clone(), *seed);
        let environments = match &pool {
            None => seeds.iter().map(make).collect::<Result<_, _>>()?,
            Some(pool) => pool.install(|| seeds.par_iter().map(make).collect::<Result<_, _>>())?,
        };
        Ok(Self { environments, mode, pool })
    }

    /// The environments.
    #[must_use]
    pub fn environments(&self) -> &[Environment] {
        &self.environments
    }

    /// Begins another episode in the environments that `mask` names, all without one; with seeds, the first of each seed.
    /// Writes the observations and errors of all.
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
        let Self { environments, pool, .. } = self;
        match pool {
            None => {
                let rows = environments.iter_mut().zip(observations.chunks_exact_mut(width));
                rows.zip(errors).enumerate().try_for_each(one)
            }
            Some(pool) => pool.install(|| {
                let rows = environments.par_iter_mut().zip(observations.par_chunks_exact_mut(width));
                rows.zip(errors).enumerate().try_for_each(one)
            }),
        }
    }

    /// One action for every environment.
    ///
    /// # Shapes
    /// `actions: [environments x actions]`.
    ///
    /// # Errors
    /// [`Error::WrongLength`] and [`Error::EntryOutOfDomain`] for actions, and for an environment that has to be reset first:
    /// nothing has then changed. As [`Environment::reset`] where episodes begin.
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
        let Self { environments, pool, .. } = self;
        let one = |rows: Rows<'_>| step_one(mode, rows);
        match pool {
            None => environments
                .iter_mut()
                .zip(actions.chunks_exact(acts))
                .zip(
                    out.observations
                        .chunks_exact_mut(width)
                        .zip(out.last_observations.chunks_exact_mut(width)),
                )
                .zip(out.rewards.iter_mut().zip(out.errors.iter_mut().zip(out.last_errors.iter_mut())))
                .zip(out.terminated.iter_mut().zip(out.truncated.iter_mut()))
                .try_for_each(|((((a, b), c), d), e)| one((a, b, c, d, e))),
            Some(pool) => {
                let block = count.div_ceil(BLOCKS_PER_THREAD * pool.current_num_threads());
                pool.install(|| {
                    environments
                        .par_iter_mut()
                        .zip(actions.par_chunks_exact(acts))
                        .zip(
                            out.observations
                                .par_chunks_exact_mut(width)
                                .zip(out.last_observations.par_chunks_exact_mut(width)),
                        )
                        .zip(
                            out.rewards
                                .par_iter_mut()
                                .zip(out.errors.par_iter_mut().zip(out.last_errors.par_iter_mut())),
                        )
                        .zip(out.terminated.par_iter_mut().zip(out.truncated.par_iter_mut()))
                        .with_min_len(block)
                        .try_for_each(|((((a, b), c), d), e)| one((a, b, c, d, e)))
                })
            }
        }
    }

    fn width(&self) -> usize {
        self.environments[0].design().observations()
    }
}

fn step_one(mode: ResetMode, rows: Rows<'_>) -> Result<(), Error> {
    let (environment, action, (observation, last), (reward, (error, last_error)), (terminated, truncated)) =
        rows;
    if environment.ended() && mode == ResetMode::NextStep {
        environment.reset(None)?;
        (*reward, *terminated, *truncated, *error) = (0.0, false, false, environment.error());
        environment.observe(observation);
        return Ok(());
    }
    let outcome = environment.advance(action);
    (*reward, *error) = (outcome.reward, outcome.error);
    (*terminated, *truncated) = (outcome.terminated, outcome.truncated);
    if environment.ended() && mode == ResetMode::SameStep {
        environment.observe(last);
        *last_error = outcome.error;
        environment.reset(None)?;
        *error = environment.error();
    }
    environment.observe(observation);
    Ok(())
}

fn check(name: &'static str, got: usize, expected: usize) -> Result<(), Error> {
    if got == expected { Ok(()) } else { Err(Error::WrongLength { name, expected, got }) }
}
