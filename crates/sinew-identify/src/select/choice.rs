//! The choice among cross-validated candidates, and the error to expect of what was chosen.

use super::candidates::{CandidateRecipe, PhysicsPrior};
use super::cross_validation::{FoldScore, ScoredCandidate};
use super::laws::ScoredLaw;

/// A candidate with less physics must have at most this fraction of the error of one with more.
const MARGIN: f64 = 0.97;

/// The same where the folds are stretches of one log: they do not show how a model extrapolates to another
/// day, which physics does better.
const MARGIN_WITHIN_LOG: f64 = 0.7;

/// The same of an axis, whose motion is often periodic: a network knows every stretch from the others.
const MARGIN_OF_AXIS: f64 = 0.625;

/// Loss, % of the range, up to which a model with fewer parameters is named.
const NAMED_LOSS: f64 = 1.0;

/// Standard errors of the mean log ratio of errors, sequence by sequence, by which it must be better.
const STANDARD_ERRORS: f64 = 1.0;

/// The choice among candidates.
///
/// ```text
/// s_k = exp( mean over folds f of ln e(k, f) )
/// chosen: least s_k among the candidates with the physics of the roles; one with less physics instead where
///         s_k < m s_chosen,  mean d + sigma(d)/sqrt(n) < 0,   d_i = ln e(k, i) - ln e(chosen, i),
///         and e(k, f) < e(chosen, f) on every fold f that extrapolates a condition
/// ```
///
/// | symbol   | meaning                                                      | unit |
/// |----------|--------------------------------------------------------------|------|
/// | e(k, f)  | RMSE of candidate k on fold f, fitted without it              | far  |
/// | e(k, i)  | RMSE on held-out sequence i of n                              | far  |
/// | m        | 0.97; where the folds are stretches of one log 0.7, of an axis 0.625 | 1    |
pub(crate) struct Choice<'a> {
    pub(crate) candidates: &'a [CandidateRecipe],
    pub(crate) scored: &'a [ScoredCandidate],
    /// Whether the folds hold out whole logs, trials or conditions.
    pub(crate) grouped: bool,
    /// `[fold]`: whether it holds out a condition beyond all others
    /// ([`Folds::extrapolates`](super::folds::Folds)).
    pub(crate) extrapolates: &'a [bool],
    /// The error, far unit, that fewer parameters may cost; none where the least error is chosen.
    pub(crate) loss: Option<f64>,
}

impl Choice<'_> {
    /// The margin of a candidate with less physics than `more`.
    fn margin(&self, more: usize) -> f64 {
        match (self.grouped, self.candidates[more].is_axis()) {
            (true, _) => MARGIN,
            (false, true) => MARGIN_OF_AXIS,
            (false, false) => MARGIN_WITHIN_LOG,
        }
    }

    /// The best candidate of each kind of physics by all folds but `without`, most physics first.
    fn best_of_each(&self, without: Option<usize>) -> Vec<usize> {
        let score = |k: usize| self.scored[k].score(without);
        let best = |prior: &PhysicsPrior| {
            (0..self.candidates.len())
                .filter(|&k| self.candidates[k].prior == *prior && score(k).is_finite())
                .min_by(|&a, &b| score(a).total_cmp(&score(b)))
        };
        PhysicsPrior::CHOICES.iter().filter_map(best).collect()
    }

    /// Index of the candidate chosen by all folds but `without`; `None` where none could be fitted.
    pub(crate) fn choose(&self, without: Option<usize>) -> Option<usize> {
        let best = self.most_accurate(without)?;
        let Some(loss) = self.loss else { return Some(best) };
        let error = |k: usize| self.scored[k].root_mean_square(without);
        let allowed = |k: &usize| {
            self.candidates[*k].prior != PhysicsPrior::Reference && error(*k) <= error(best) + loss
        };
        let size = |k: &usize| (self.scored[*k].validation().map_or(usize::MAX, |v| v.size), *k != best);
        (0..self.candidates.len()).filter(allowed).min_by_key(size)
    }

    /// The best with the least physics, whatever its size.
    fn most_accurate(&self, without: Option<usize>) -> Option<usize> {
        self.best_of_each(without)
            .into_iter()
            .reduce(|old, new| if self.objection(new, old, without).is_some() { old } else { new })
    }

    /// What the fewest parameters would cost, in a sentence; nothing where none with fewer comes near.
    pub(crate) fn least(&self, chosen: usize, laws: &[ScoredLaw], range: f64) -> String {
        let compared = self.candidates.iter().zip(self.scored);
        let models = compared.filter(|(c, _)| c.prior != PhysicsPrior::Reference).map(|(_, scored)| scored);
        let all = models.chain(laws.iter().map(|law| &law.scored));
        let size = |scored: &ScoredCandidate| scored.validation().map_or(usize::MAX, |v| v.size);
        let chosen = &self.scored[chosen];
        let cost = |scored: &ScoredCandidate| {
            100.0 * (scored.root_mean_square(None) - chosen.root_mean_square(None)) / range
        };
        let small = all.filter(|scored| size(scored) < size(chosen) && cost(scored) <= NAMED_LOSS);
        let least = small.min_by(|a, b| size(a).cmp(&size(b)).then(cost(a).total_cmp(&cost(b))));
        least.map_or_else(String::new, |least| {
            let (few, of, cost) = (size(least), size(chosen), cost(least));
            let cost =
                if cost > 0.0 { format!("costs {cost:.1} % of the range") } else { "costs nothing".into() };
            format!(" {}, with {few} parameters in place of {of}, {cost}.", least.name)
        })
    }

    /// Why a candidate with less physics is not preferred to one with more, by all folds but `without`;
    /// completes "but". `None` where it is.
    fn objection(&self, less: usize, more: usize, without: Option<usize>) -> Option<String> {
        let margin = self.margin(more);
        let (less, more) = (&self.scored[less], &self.scored[more]);
        if less.score(without) >= margin * more.score(without) {
            let percent = 100.0 * (1.0 - margin);
            return Some(format!("a model with less physics must be better by {percent:.0} %"));
        }
        if !clearly_better(less, more, without) {
            return Some("by no more than one standard error of the differences between the logs".to_owned());
        }
        self.loses_beyond(less, more, without)
            .then(|| "it is worse on a condition beyond those of the other logs".to_owned())
    }

    /// Whether a fold that extrapolates a condition is predicted no better than by the other candidate.
    fn loses_beyond(&self, one: &ScoredCandidate, other: &ScoredCandidate, without: Option<usize>) -> bool {
        let folds = |scored: &ScoredCandidate| -> Vec<(usize, f64)> {
            let all = scored.validation().map_or(&[][..], |v| v.folds.as_slice()).iter().enumerate();
            let kept = all.filter(|(place, _)| Some(*place) != without);
            kept.map(|(_, fold)| (fold.fold, fold.rmse)).collect()
        };
        let beyond = |fold: usize| self.extrapolates.get(fold).copied().unwrap_or(false);
        folds(one).into_iter().zip(folds(other)).any(|((fold, a), (_, b))| beyond(fold) && a >= b)
    }

    /// The reason for the choice, in one sentence.
    pub(crate) fn reason(&self, chosen: usize) -> String {
        let score = |k: usize| self.scored[k].score(None);
        let name = |k: usize| self.scored[k].name.as_str();
        let prior = self.candidates[chosen].prior;
        if let (Some(_), Some(best)) = (self.loss, self.most_accurate(None).filter(|best| *best != chosen)) {
            let numbers = |k: usize| self.scored[k].validation().map_or(0, |v| v.size);
            return format!(
                "{} was chosen because it has the fewest parameters, {}, at no more than the loss that was allowed; {}, \
                    with {}, has the least error.",
                name(chosen),
                numbers(chosen),
                name(best),
                numbers(best)
            );
        }
        let mut reason = format!(
            "{} was chosen because it has the least mean error over the folds of the models {}",
            name(chosen),
            prior.describe()
        );
        for other in self.best_of_each(None).into_iter().filter(|&k| k != chosen) {
            let (ratio, less) = (score(other) / score(chosen), self.candidates[other].prior > prior);
            let percent = 100.0 * (ratio - 1.0).abs();
            let objection = if less { self.objection(other, chosen, None) } else { None };
            let verdict = match (objection, ratio < 1.0) {
                (Some(objection), true) => format!("is {percent:.0} % better, but {objection}"),
                (_, true) => format!("is {percent:.0} % better"),
                (_, false) => format!("is {percent:.0} % worse"),
            };
            let described = self.candidates[other].prior.describe();
            reason += &format!("; {}, the best of those {described}, {verdict}", name(other));
        }
        reason + "."
    }
}

/// Whether the error is smaller, sequence by sequence, by more than [`STANDARD_ERRORS`].
pub(crate) fn clearly_better(one: &ScoredCandidate, other: &ScoredCandidate, without: Option<usize>) -> bool {
    let (Some(one), Some(other)) = (one.validation(), other.validation()) else { return false };
    let errors = |folds: &[FoldScore]| -> Vec<f64> {
        let kept = folds.iter().enumerate().filter(|(place, _)| Some(*place) != without);
        kept.flat_map(|(_, fold)| fold.sequence_rmse.iter().copied()).collect()
    };
    let pairs = errors(&one.folds).into_iter().zip(errors(&other.folds));
    let ratios: Vec<f64> = pairs.map(|(a, b)| (a.max(1e-300) / b.max(1e-300)).ln()).collect();
    let n = ratios.len() as f64;
    if n < 3.0 {
        return false;
    }
    let mean = ratios.iter().sum::<f64>() / n;
    let variance = ratios.iter().map(|r| (r - mean) * (r - mean)).sum::<f64>() / (n - 1.0);
    mean + STANDARD_ERRORS * (variance / n).sqrt() < 0.0
}

/// Root mean square error of the selection as a whole, by leave-one-fold-out selection.
///
/// ```text
/// k_f = the candidate chosen on all folds but f
/// E^2 = sum_f n_f e(k_f, f)^2 / sum_f n_f
/// ```
///
/// The errors of the final choice on the folds that chose it are the smallest of many, hence too small; here
/// no fold takes part in the choice that it scores, and no model is fitted again. With fewer than two folds:
/// the plain error.
pub(crate) fn selection_rmse(
    scored: &[ScoredCandidate],
    chosen: usize,
    choose: &dyn Fn(Option<usize>) -> Option<usize>,
) -> f64 {
    let folds = |k: usize| scored[k].validation().map_or(&[][..], |v| v.folds.as_slice());
    let count = folds(chosen).len();
    let (mut sum, mut samples) = (0.0, 0.0);
    for fold in 0..count {
        let choice = if count > 1 { choose(Some(fold)) } else { None };
        let score = choice.and_then(|k| folds(k).get(fold)).unwrap_or(&folds(chosen)[fold]);
        sum += score.samples * score.rmse * score.rmse;
        samples += score.samples;
    }
    (sum / samples).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::recipe::{Learner, Recipe};
    use crate::select::cross_validation::CrossValidation;

    /// A candidate with one sequence of one sample in every fold.
    fn scored(fold_rmse: &[f64]) -> ScoredCandidate {
        let fold = |(fold, rmse): (usize, &f64)| FoldScore {
            fold,
            samples: 1.0,
            rmse: *rmse,
            sequence_rmse: vec![*rmse],
            ratios: vec![1.0],
        };
        let validation = CrossValidation {
            folds: fold_rmse.iter().enumerate().map(fold).collect(),
            ..CrossValidation::default()
        };
        ScoredCandidate { name: String::new(), description: String::new(), outcome: Ok(validation) }
    }

    #[test]
    fn one_sequence_with_a_small_error_is_not_significant() {
        let physics = scored(&[3.4, 1.4, 1.4, 2.7]);
        let better = |one: &ScoredCandidate, other: &ScoredCandidate| clearly_better(one, other, None);
        assert!(!better(&scored(&[1.8, 1.5, 1.45, 2.8]), &physics));
        assert!(better(&scored(&[2.0, 1.1, 1.0, 1.9]), &physics));
        assert!(!better(&scored(&[1.0, 1.0]), &scored(&[2.0, 2.0])), "two are too few");
        assert!(!better(&physics, &physics));
    }

    /// A candidate of a kind of physics; only the kind matters to the choice.
    fn candidate(prior: PhysicsPrior) -> CandidateRecipe {
        let recipe = Recipe {
            name: String::new(),
            signals: vec![],
            cell: None,
            cable: None,
            axis: None,
            features: None,
            hidden: 0,
            rows: 0,
            steps: 0,
            networks: 0,
            learner: Learner::Linear,
        };
        CandidateRecipe { recipe, description: String::new(), prior, mean_of: vec![] }
    }

    #[test]
    fn a_mean_is_left_for_a_single_law_that_is_clearly_better_alone() {
        use PhysicsPrior::{Matched, Mean};
        let candidates = [candidate(Matched), candidate(Mean)];
        let chosen = |single: [f64; 5]| {
            let scored = [scored(&single), scored(&[4.0, 4.2, 4.1, 4.0, 4.3])];
            Choice { candidates: &candidates, scored: &scored, grouped: true, extrapolates: &[], loss: None }
                .choose(None)
        };
        assert_eq!(chosen([3.95, 4.1, 4.05, 3.9, 4.2]), Some(1), "better by two per cent");
        assert_eq!(chosen([1.0, 6.0, 4.0, 4.5, 4.2]), Some(1), "better on one fold");
        assert_eq!(chosen([3.0, 3.1, 3.0, 3.2, 3.1]), Some(0));
    }

    #[test]
    fn less_physics_is_chosen_where_it_is_clearly_better_also_within_one_log() {
        use PhysicsPrior::{Learned, Matched, Reference};
        let candidates = [candidate(Matched), candidate(Matched), candidate(Learned), candidate(Reference)];
        let chosen = |learned: f64, grouped: bool| {
            let scored = [
                scored(&[4.0, 4.2, 4.1, 4.0, 4.3]),
                scored(&[5.0, 5.2, 5.1, 5.0, 5.3]),
                scored(&[4.1, 4.0, 4.2, 4.1, 4.1].map(|e: f64| e * learned)),
                scored(&[0.1; 5]),
            ];
            let choice =
                Choice { candidates: &candidates, scored: &scored, grouped, extrapolates: &[], loss: None };
            let chosen = choice.choose(None).unwrap();
            assert!(choice.reason(chosen).contains("was chosen"));
            chosen
        };
        assert_eq!((chosen(0.5, true), chosen(0.5, false)), (2, 2), "better by a factor of two");
        assert_eq!((chosen(0.9, true), chosen(0.9, false)), (2, 0), "better by a tenth");
        assert_eq!((chosen(0.99, true), chosen(0.99, false)), (0, 0), "as good");
    }

    #[test]
    fn a_model_with_less_physics_must_also_be_better_where_a_condition_is_extrapolated() {
        use PhysicsPrior::{Learned, Matched};
        let candidates = [candidate(Matched), candidate(Learned)];
        // Better by a third everywhere but on the first fold.
        let scored = [scored(&[4.0, 4.2, 4.1, 4.0, 4.3]), scored(&[4.1, 2.8, 2.7, 2.7, 2.9])];
        let choice = |extrapolates| Choice {
            candidates: &candidates,
            scored: &scored,
            grouped: true,
            extrapolates,
            loss: None,
        };
        assert_eq!(choice(&[false; 5]).choose(None), Some(1));
        let beyond = choice(&[true, false, false, false, false]);
        assert_eq!(beyond.choose(None), Some(0));
        assert!(beyond.reason(0).contains("worse on a condition beyond"), "{}", beyond.reason(0));
        assert_eq!(choice(&[false, true, false, false, true]).choose(None), Some(1));
    }

    #[test]
    fn fewer_parameters_are_chosen_where_they_cost_no_more_than_the_loss() {
        use PhysicsPrior::{Learned, Matched, Reference};
        let candidates = [candidate(Matched), candidate(Matched), candidate(Learned), candidate(Reference)];
        let mut scored = [scored(&[4.0; 5]), scored(&[4.2; 5]), scored(&[5.0; 5]), scored(&[4.0; 5])];
        for (candidate, size) in scored.iter_mut().zip([900, 9, 2, 1]) {
            candidate.name = format!("with {size}");
            candidate.outcome.as_mut().unwrap().size = size;
        }
        let choice = |loss| Choice {
            candidates: &candidates,
            scored: &scored,
            grouped: true,
            extrapolates: &[],
            loss,
        };
        let chosen = |loss| choice(loss).choose(None);
        assert_eq!([None, Some(0.1), Some(0.3), Some(1.1)].map(chosen), [0, 0, 1, 2].map(Some));
        assert_eq!(
            choice(None).least(0, &[], 100.0),
            " with 2, with 2 parameters in place of 900, costs 1.0 % of the range."
        );
        assert!(choice(Some(0.3)).reason(1).contains("fewest parameters, 9"));
    }

    #[test]
    fn the_error_of_a_selection_is_scored_on_folds_that_took_no_part_in_it() {
        // Each candidate has a small error on one fold by chance.
        let all = [scored(&[0.1, 1.0, 1.0]), scored(&[1.0, 0.2, 1.0]), scored(&[1.0, 1.0, 0.3])];
        let choose =
            |without| (0..3).min_by(|&a, &b| all[a].score(without).total_cmp(&all[b].score(without)));
        let chosen = choose(None).unwrap();
        assert_eq!(chosen, 0);
        // Without fold 0 candidate 1 is best, without another one candidate 0: each has error 1 on its fold.
        assert!((selection_rmse(&all, chosen, &choose) - 1.0).abs() < 1e-12);
        // A candidate that is best everywhere keeps its plain error.
        let all = [scored(&[0.5, 0.5, 0.5]), scored(&[1.0, 1.0, 1.0])];
        let choose =
            |without| (0..2).min_by(|&a, &b| all[a].score(without).total_cmp(&all[b].score(without)));
        assert!((selection_rmse(&all, 0, &choose) - 0.5).abs() < 1e-12);
    }
}
