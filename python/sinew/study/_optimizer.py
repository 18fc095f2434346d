"""Ask and tell of Optuna. The journal says what was found; Optuna's storage is a copy for its samplers and its dashboard."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ._journal import Trial


#: Samplers that have a name of their own.
SAMPLERS = ("tpe", "nsga2")


def import_optuna() -> Any:
    """Optuna; raises `ImportError` that says what to install."""
    try:
        import optuna
    except ModuleNotFoundError as error:
        raise ImportError("a sampler needs Optuna: pip install 'sinew-robotics[study]'", name=error.name) from error
    return optuna


class Optimizer:
    """A study of Optuna that knows the trials of a journal.

    `distributions`: low, high and whether logarithmic, by parameter. `storage`: `None` for memory, a URL or a storage of Optuna, which
    keeps the study under `name`.

    Raises `ValueError` where the storage holds another study of that name.
    """

    def __init__(
        self,
        name: str,
        head: Mapping[str, Any],
        trials: Iterable[Trial],
        *,
        distributions: Mapping[str, tuple[float, float, bool]],
        minimize: Sequence[str],
        maximize: Sequence[str],
        sampler: Any,
        storage: Any,
    ) -> None:
        optuna = import_optuna()
        if isinstance(sampler, str):
            made = {"tpe": optuna.samplers.TPESampler, "nsga2": optuna.samplers.NSGAIISampler}[sampler]
            sampler = made(seed=head["seed"])
        self._failed = optuna.trial.TrialState.FAIL
        self._complete = optuna.trial.TrialState.COMPLETE
        self._values = (*minimize, *maximize)
        self._space: dict[str, Any] = {
            parameter: optuna.distributions.FloatDistribution(low, high, log=log)
            for parameter, (low, high, log) in distributions.items()
        }
        directions: list[Any] = ["minimize"] * len(minimize) + ["maximize"] * len(maximize)
        self._study = optuna.create_study(
            directions=directions,
            sampler=sampler,
            storage=storage,
            study_name=name,
            load_if_exists=True,
        )
        self._asked: dict[int, Any] = {}
        told = self._told(name, head, {trial.number: trial for trial in trials if trial.ended})
        for trial in trials:
            if trial.ended and trial.error is None and trial.number not in told:
                made = optuna.trial.create_trial(
                    params=trial.parameters,
                    distributions=self._space,
                    values=[trial.values[value] for value in self._values],
                    user_attrs={"trial": trial.number},
                )
                self._study.add_trial(made)

    def _told(self, name: str, head: Mapping[str, Any], ended: Mapping[int, Trial]) -> set[int]:
        """Numbers of the trials that the storage holds with their values."""
        stored = self._study.get_trials(deepcopy=False)
        known = self._study.user_attrs.get("sinew")
        if known is None and not stored:
            self._study.set_user_attr("sinew", dict(head))
        elif known != dict(head):
            raise ValueError(f"the storage holds another study {name!r}: {known or 'not of sinew.study'}")
        told: set[int] = set()
        for trial in stored:
            number: int = trial.user_attrs.get("trial", -1)
            if trial.state == self._complete:
                if number not in ended or ended[number].parameters != trial.params:
                    raise ValueError(f"the storage holds another study {name!r}: trial {number} is not in the journal")
                told.add(number)
            elif not trial.state.is_finished():
                # Of a process that was killed: the journal runs it again.
                self._study.tell(trial.number, state=self._failed)
        return told

    def ask(self, number: int) -> dict[str, float]:
        """Parameters of a new trial."""
        asked = self._study.ask(self._space)
        asked.set_user_attr("trial", number)
        self._asked[number] = asked
        return dict(asked.params)

    def again(self, trial: Trial) -> None:
        """Announces a trial that was proposed earlier and has not ended."""
        self._study.enqueue_trial(trial.parameters)
        self.ask(trial.number)

    def tell(self, trial: Trial) -> None:
        """Takes the result of a trial."""
        asked = self._asked.pop(trial.number)
        if trial.error is not None:
            self._study.tell(asked, state=self._failed)
        else:
            self._study.tell(asked, [trial.values[value] for value in self._values])
