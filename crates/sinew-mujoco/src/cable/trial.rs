//! The trial step that belongs to the beginning of a time step.

use crate::view::{Data, Model, RUNGE_KUTTA};

/// When and for whom a trial is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moment {
    identity: usize,
    pub(crate) time: f64,
    timestep: f64,
    runge_kutta: bool,
}

impl Moment {
    pub(crate) fn new(model: &Model<'_>, data: &Data<'_>) -> Self {
        Self {
            identity: data.identity,
            time: data.time,
            timestep: model.timestep,
            runge_kutta: model.integrator == RUNGE_KUTTA,
        }
    }
}

/// State after a trial, until `advance` keeps it.
pub(crate) struct Trial {
    state: Vec<f64>,
    moment: Option<Moment>,
    /// Trials of the same Runge-Kutta step after the first.
    stages: usize,
}

impl Trial {
    pub(crate) fn new(count: usize) -> Self {
        Self { state: vec![0.0; count], moment: None, stages: 0 }
    }

    /// Whether a trial belongs to the beginning of a step; later stages of Runge-Kutta, two in its middle and
    /// one at its end, do not.
    pub(crate) fn begins(&mut self, moment: &Moment) -> bool {
        let first = self.moment.filter(|first| first.identity == moment.identity && moment.runge_kutta);
        let later = first.is_some_and(|first| {
            let end = if self.stages < 2 { 0.5 * first.timestep } else { first.timestep };
            self.stages < 3 && moment.time.to_bits() == (first.time + end).to_bits()
        });
        self.stages = if later { self.stages + 1 } else { 0 };
        !later
    }

    /// Whether a trial of this `mjData` waits.
    pub(crate) fn is_of(&self, identity: usize) -> bool {
        self.moment.is_some_and(|moment| moment.identity == identity)
    }

    /// The place for the state of a trial.
    pub(crate) fn fill(&mut self, moment: Moment) -> &mut [f64] {
        self.moment = Some(moment);
        &mut self.state
    }

    /// The state to keep; another trial has to come first before it is asked again.
    pub(crate) fn take(&mut self) -> &[f64] {
        self.moment = None;
        self.stages = 0;
        &self.state
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn later_stages_of_runge_kutta_are_told_from_new_steps() {
        let at = |time: f64| Moment { identity: 7, time, timestep: 1e-3, runge_kutta: true };
        let mut trial = Trial::new(1);
        for start in [0.3, 0.301] {
            assert!(trial.begins(&at(start)));
            trial.fill(at(start));
            // A second forward pass at the same time replaces the first.
            assert!(trial.begins(&at(start)));
            for (stage, end) in [0.5e-3, 0.5e-3, 1e-3].into_iter().enumerate() {
                assert!(!trial.begins(&at(start + end)), "{stage}");
            }
            assert!(trial.is_of(7) && !trial.is_of(8));
            trial.take();
            assert!(!trial.is_of(7));
        }
        let mut euler = at(0.3);
        euler.runge_kutta = false;
        assert!(trial.begins(&euler));
        trial.fill(euler);
        euler.time += 1e-3;
        assert!(trial.begins(&euler));
    }
}
