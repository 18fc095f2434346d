use super::drift::Drift;

/// A change of one cable that explains what its fits and those of the others show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Explanation {
    pub(super) cable: usize,
    pub(super) change: Change,
    /// Whether it is significant.
    pub(super) found: bool,
    /// How far it has drifted, in standard errors.
    deviations: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Change {
    /// Growth.
    Friction,
    /// Loss.
    Pretension,
    /// Loss.
    Stiffness,
}

/// What the fits of one cable show.
#[derive(Debug, Clone, Copy)]
pub(super) struct Evidence {
    /// By the travel that its observer does not explain.
    pub(super) friction: Shown,
    pub(super) stiffness: Shown,
    /// By the torques, if nothing else changes.
    pub(super) friction_by_torque: Drift,
    pub(super) pretension: Drift,
    /// Mean squares of the torques that a growth of its friction explains and a loss of its pretension, Nm^2.
    pub(super) explained: [f64; 2],
}

/// A drift and its ratio to the standard error by scatter alone.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shown {
    pub(super) drift: Drift,
    pub(super) significance: f64,
}

/// Fraction of the most from which on the frictions of two cables explain the torques alike: a correlation of
/// 0.77.
const ALIKE: f64 = 0.6;
/// Significance by which the travel of a cable must show more friction than that of one whose friction
/// explains the torques better.
const CLEARLY: f64 = 2.0;
/// Standard errors by which the torques must show less friction than at the beginning to contradict a travel
/// that shows more.
const CONTRADICTED: f64 = 2.0;

/// The one change of one cable that explains most of what all `cables` show; none where nothing has changed.
///
/// A change of one cable changes the tensions, with them the errors of all models, and so what the travel of
/// its neighbours shows: the change of largest significance is the cause. A short cable shows more in the
/// torques than in its travel: they decide where they are further from their beginning.
///
/// # Source
/// Our own.
pub(super) fn best(cables: impl Iterator<Item = Evidence> + Clone) -> Option<Explanation> {
    let travel = by_travel(cables.clone()).filter(|travel| travel.found);
    let torque = by_torque(cables);
    match (travel, torque) {
        (Some(travel), Some(torque)) if torque.deviations > travel.deviations => Some(torque),
        (None, torque) => torque,
        (travel, _) => travel,
    }
}

/// The growth of friction or loss of stiffness that is most significant.
///
/// The travel of an antagonist of a cable whose friction grows shows a growth, too, but its torques show a
/// fall: a growth that the torques contradict does not count.
fn by_travel(cables: impl Iterator<Item = Evidence>) -> Option<Explanation> {
    let changes =
        cables.enumerate().flat_map(|(cable, Evidence { friction, stiffness, friction_by_torque, .. })| {
            let of = |change, Shown { drift, significance }: Shown, wear: f64| {
                let (found, deviations) = (drift.found, wear * drift.deviations());
                (wear * significance, Explanation { cable, change, found, deviations })
            };
            let contradicted = friction_by_torque.deviations() < -CONTRADICTED;
            let rougher = (!contradicted).then(|| of(Change::Friction, friction, 1.0));
            rougher.into_iter().chain([of(Change::Stiffness, stiffness, -1.0)])
        });
    let worn = changes.filter(|(significance, _)| *significance > 0.0);
    worn.max_by(|(one, _), (other, _)| one.total_cmp(other)).map(|(_, change)| change)
}

/// The growth of friction or loss of pretension that explains most of the torques. Of cables whose frictions
/// explain them alike, as those of antagonists, it is the one whose travel shows most friction.
fn by_torque(cables: impl Iterator<Item = Evidence> + Clone) -> Option<Explanation> {
    let explained = |cable: &Evidence| cable.explained.into_iter().fold(0.0, f64::max);
    let most = cables.clone().map(|cable| explained(&cable)).fold(0.0, f64::max);
    let (best, cable) =
        cables.clone().enumerate().find(|(_, cable)| most > 0.0 && explained(cable) >= most)?;
    let [friction, pretension] = cable.explained;
    if pretension > friction {
        let Drift { found, .. } = cable.pretension;
        let deviations = cable.pretension.deviations().abs();
        return Some(Explanation { cable: best, change: Change::Pretension, found, deviations });
    }
    let alike = cables.enumerate().filter(|(_, cable)| cable.explained[0] > ALIKE * most);
    let shown =
        |(k, cable): &(usize, Evidence)| cable.friction.significance + if *k == best { CLEARLY } else { 0.0 };
    let (named, _) = alike.clone().max_by(|one, other| shown(one).total_cmp(&shown(other)))?;
    let mut drifts = alike.map(|(_, cable)| cable.friction_by_torque);
    let deviations = drifts.clone().map(|drift| drift.deviations()).fold(0.0, f64::max);
    let found = drifts.any(|drift| drift.found);
    Some(Explanation { cable: named, change: Change::Friction, found, deviations })
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    /// A drift of so many standard errors, found from eight on.
    fn drift(deviations: f64) -> Drift {
        Drift {
            fraction: 0.01 * deviations,
            error: 0.01,
            found: deviations.abs() > 8.0,
            remaining: f64::INFINITY,
        }
    }

    /// By travel: deviations of friction and stiffness, and their significances; by torque: deviations of
    /// friction and pretension, and what they explain.
    fn cable(travel: [f64; 2], significance: [f64; 2], torque: [f64; 2], explained: [f64; 2]) -> Evidence {
        let shown = |k: usize| Shown { drift: drift(travel[k]), significance: significance[k] };
        Evidence {
            friction: shown(0),
            stiffness: shown(1),
            friction_by_torque: drift(torque[0]),
            pretension: drift(torque[1]),
            explained,
        }
    }

    fn named(cables: &[Evidence]) -> Option<(usize, Change, bool)> {
        best(cables.iter().copied()).map(|it| (it.cable, it.change, it.found))
    }

    /// By torque alone, with so much significance of friction by travel.
    fn by_torque_alone(cables: &[([f64; 2], f64)]) -> Option<(usize, Change, bool)> {
        let of = |(explained, significance): &([f64; 2], f64)| {
            let torque = [10.0 * explained[0], -10.0 * explained[1]];
            cable([0.0; 2], [*significance, 0.0], torque, *explained)
        };
        named(&cables.iter().map(of).collect::<Vec<_>>())
    }

    #[test]
    fn the_change_that_explains_the_torques_best_is_named_and_of_alike_ones_that_which_the_travel_shows() {
        assert_eq!(by_torque_alone(&[([0.0, 0.0], 9.0), ([0.0, 0.0], 0.0)]), None);
        assert_eq!(
            by_torque_alone(&[([1.0, 0.3], 0.0), ([0.2, 0.6], 9.0)]),
            Some((0, Change::Friction, true))
        );
        assert_eq!(
            by_torque_alone(&[([1.0, 0.3], 1.0), ([0.9, 0.2], 4.0)]),
            Some((1, Change::Friction, true))
        );
        assert_eq!(
            by_torque_alone(&[([1.0, 0.3], 1.0), ([0.9, 0.2], 2.0)]),
            Some((0, Change::Friction, true))
        );
        assert_eq!(
            by_torque_alone(&[([1.0, 0.3], 0.0), ([0.9, 1.2], 9.0)]),
            Some((1, Change::Pretension, true))
        );
        // What has not drifted by itself is not reported.
        assert_eq!(
            by_torque_alone(&[([0.3, 0.1], 0.0), ([0.0, 0.0], 9.0)]),
            Some((0, Change::Friction, false))
        );
    }

    #[test]
    fn of_changes_that_the_travel_shows_the_most_significant_one_is_the_cause() {
        let (none, quiet) = ([0.0; 2], [1.0, -1.0]);
        // Friction of one cable changes the fitted compliance of another.
        let rough = cable([12.0, 5.0], [40.0, 30.0], none, none);
        let softer = cable([1.0, -20.0], [3.0, -25.0], none, none);
        assert_eq!(named(&[softer, rough]), Some((1, Change::Friction, true)));
        // It is known before it is reported.
        let beginning = cable([6.0, 5.0], [40.0, 30.0], none, none);
        assert_eq!(named(&[softer, beginning]), None);
        assert_eq!(named(&[softer, cable(none, quiet, none, none)]), Some((0, Change::Stiffness, true)));
        // Neither friction that falls nor a cable that stiffens is wear.
        assert_eq!(named(&[cable([-20.0, 20.0], [-90.0, 90.0], none, none)]), None);
    }

    #[test]
    fn a_growth_of_friction_that_the_torques_contradict_is_that_of_an_antagonist() {
        let antagonist = |torque: f64| cable([9.0, 0.0], [9.0, 0.0], [torque, 0.0], [0.0; 2]);
        let rough = cable([8.5, 0.0], [8.5, 0.0], [5.0, 0.0], [1.0, 0.0]);
        assert_eq!(named(&[rough, antagonist(-5.0)]), Some((0, Change::Friction, true)));
        assert_eq!(named(&[rough, antagonist(-1.0)]), Some((1, Change::Friction, true)));
    }

    #[test]
    fn torques_decide_where_they_are_further_from_their_beginning() {
        let softer = |torque: f64| cable([0.0, -12.0], [0.0, -30.0], [torque, 0.0], [1.0, 0.0]);
        assert_eq!(named(&[softer(10.0)]), Some((0, Change::Stiffness, true)));
        assert_eq!(named(&[softer(14.0)]), Some((0, Change::Friction, true)));
    }
}
