use super::body::{LANES, Limbs};
use super::state::ArmTwin;
use crate::Error;
use crate::drive::DriveCommand;
use crate::error::within;

/// Memory in which several arms of one machine move together, bit for bit as each of them alone.
///
/// Bodies and muscles of eight worlds are computed at once, in SIMD lanes. The arms may differ in all
/// numbers: parameters, states, commands, faults. Where joints are coupled, or an arm is of another machine,
/// resolution or period than the others, all are stepped one by one.
///
/// # Example
/// ```
/// use sinew::drive::DriveCommand;
/// use sinew::machine::Machine;
/// use sinew::twin::arm::{ArmSpecimen, ArmTwin, ArmTwins};
/// let text = sinew_models::BENCH_JOINT;
/// let read = sinew::description::machine_from_toml("bench_joint.toml", text, &mut |_| Err("none".into()))?;
/// let (machine, pull) = (read.machine, [40.0; 2]);
/// let arm = |seed| ArmTwin::new(&ArmSpecimen::draw(&machine, seed)?, &machine.start, &pull, seed);
/// let mut arms = (0..8).map(arm).collect::<Result<Vec<_>, _>>()?;
/// let mut alone = arms[3].clone();
/// let mut twins = ArmTwins::new(&arms[0]);
/// let mut group: Vec<&mut ArmTwin> = arms.iter_mut().collect();
/// let hold = [DriveCommand::Velocity(0.0); 2];
/// let mut together = twins.gather(&mut group)?;
/// for _ in 0..10 {
///     assert!(together.step(&[&hold[..]; 8], 1e-3).iter().all(Result::is_ok));
///     alone.step(&hold, 1e-3)?;
/// }
/// assert_eq!(arms[3].truth().q, alone.truth().q);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct ArmTwins {
    /// None for a machine whose joints are coupled.
    limbs: Option<Limbs>,
}

/// Arms between [`ArmTwins::gather`] and the last step together.
#[derive(Debug)]
pub struct Together<'a, 'b> {
    limbs: Option<&'a mut Limbs>,
    twins: &'a mut [&'b mut ArmTwin],
    failed: [bool; LANES],
}

impl ArmTwins {
    /// Most arms that move together.
    pub const LANES: usize = LANES;

    /// For arms of the same machine as this one.
    #[must_use]
    pub fn new(twin: &ArmTwin) -> Self {
        Self { limbs: Limbs::new(&twin.limb) }
    }

    /// Takes up to [`LANES`](Self::LANES) arms as they are.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for none, or for more.
    pub fn gather<'a, 'b>(&'a mut self, twins: &'a mut [&'b mut ArmTwin]) -> Result<Together<'a, 'b>, Error> {
        let count = twins.len();
        within("number of arms", "from 1 to 8", count as f64, (1..=LANES).contains(&count))?;
        let alike = |limbs: &Limbs| {
            let same = |one: &ArmTwin, other: &ArmTwin| {
                one.specimen.resolution == other.specimen.resolution
                    && one.step.to_bits() == other.step.to_bits()
            };
            count > 1 && twins.iter().all(|twin| same(twins[0], twin) && limbs.is_alike(&twin.limb))
        };
        let mut limbs = self.limbs.as_mut().filter(|limbs| alike(limbs));
        if let Some(limbs) = &mut limbs {
            // Idle lanes copy the last arm.
            (0..LANES).for_each(|k| limbs.take(k, &twins[k.min(count - 1)].limb));
            limbs.evaluate();
        }
        Ok(Together { limbs, twins, failed: [false; LANES] })
    }
}

impl Together<'_, '_> {
    /// One of the arms.
    #[must_use]
    pub fn twin(&self, k: usize) -> Option<&ArmTwin> {
        self.twins.get(k).map(|twin| &**twin)
    }

    /// [`ArmTwin::step`] of every arm. One that fails stays as that leaves it and takes no further steps; the
    /// others go on.
    ///
    /// # Shapes
    /// `commands: [arms][muscles]`.
    ///
    /// # Errors
    /// Of every arm as there; [`Error::WrongLength`] for one without commands, [`Error::OutOfDomain`] for one
    /// that has failed before.
    pub fn step(&mut self, commands: &[&[DriveCommand]], h: f64) -> [Result<(), Error>; LANES] {
        let mut results = [const { Ok(()) }; LANES];
        let (mut parts, mut step) = (0, h);
        for (k, twin) in self.twins.iter().enumerate() {
            let (name, expected) = ("arm", "one that has not failed in a step before");
            results[k] = within(name, expected, k as f64, !self.failed[k]).and_then(|_| {
                (parts, step) = twin.parts_of(commands.get(k).copied().unwrap_or_default(), h)?;
                Ok(())
            });
        }
        let moving = results.each_ref().map(Result::is_ok);
        let Self { limbs: Some(limbs), twins, .. } = self else {
            for (k, twin) in self.twins.iter_mut().enumerate().filter(|(k, _)| moving[*k]) {
                results[k] = twin.step(commands[k], h).map(|_| ());
                self.failed[k] = results[k].is_err();
            }
            return results;
        };
        let count = twins.len();
        for part in 0..parts {
            each(twins, &mut results, |k, twin| twin.begin(commands[k], step));
            let substeps = twins[0].specimen.resolution.substeps;
            for _ in 0..substeps {
                for k in 0..LANES {
                    let twin = &twins[k.min(count - 1)];
                    limbs.load(k, &twin.limb, &twin.anchor_tension);
                }
                let short = step / substeps as f64;
                let sound = limbs.advance(short);
                each(twins, &mut results, |k, twin| {
                    if sound.0[k] != 0 {
                        limbs.give(k, &mut twin.limb);
                    } else {
                        // Alone it says what is wrong.
                        twin.limb.advance(short, &twin.anchor_tension)?;
                        limbs.take(k, &twin.limb);
                        limbs.evaluate();
                    }
                    twin.pull(step)
                });
            }
            limbs.update_bends();
            each(twins, &mut results, |k, twin| {
                limbs.give_bends(k, &mut twin.limb);
                twin.finish(part, step)
            });
        }
        for k in (0..count).filter(|&k| moving[k]) {
            self.failed[k] = results[k].is_err();
        }
        results
    }
}

/// Does `work` on every arm that has not failed.
fn each(
    twins: &mut [&mut ArmTwin],
    results: &mut [Result<(), Error>; LANES],
    mut work: impl FnMut(usize, &mut ArmTwin) -> Result<(), Error>,
) {
    for (k, (twin, result)) in twins.iter_mut().zip(results).enumerate() {
        if result.is_ok() {
            *result = work(k, twin);
        }
    }
}
