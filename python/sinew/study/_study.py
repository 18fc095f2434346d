"""Trials of a study: proposed, run, recorded."""

from __future__ import annotations

import math
import os
import platform
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from .. import __version__
from ._backends import Objective, Result, run_local, run_ray
from ._identity import identity, is_another
from ._journal import Journal, Trial
from ._optimizer import SAMPLERS, Optimizer, import_optuna
from ._slurm import run_slurm


@dataclass(frozen=True, slots=True)
class Range:
    """A parameter from `low` to `high`, uniform or, with `log`, uniform in its logarithm."""

    low: float
    high: float
    log: bool = False

    def __post_init__(self) -> None:
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low <= self.high):
            raise ValueError(f"a range must be finite and from low to high, but is {self.low} to {self.high}")
        if self.log and self.low <= 0.0:
            raise ValueError(f"low must be above 0 in a logarithmic range, but is {self.low}")

    def at(self, fraction: float) -> float:
        """The value at a fraction of the range, 0 to 1."""
        if self.log:
            return float(math.exp(math.log(self.low) + fraction * (math.log(self.high) - math.log(self.low))))
        return float(self.low + fraction * (self.high - self.low))


class Study:
    """A study in a folder, new or continued.

    `objective(parameters, seed)` returns named finite numbers. `parameters`: ranges by name. `minimize`, `maximize`: names of
    the values to make small and large, for Optuna, Pareto front and report. `sampler`: `None` for uniform draws that depend on `seed` and the
    trial's number alone, `"tpe"`, `"nsga2"` or a sampler of Optuna. `storage`: URL of one of Optuna's (`"sqlite:///study.db"`) or
    such an object, in which the sampler's trials are kept as well, under the folder's name, for Optuna's dashboard.

    Warns where the folder holds trials of another objective, or of one whose code was changed: their numbers stay as they are. Raises
    `ValueError` where it holds a study of other parameters or seed, or another process runs it.
    """

    def __init__(
        self,
        folder: str | os.PathLike[str],
        objective: Objective,
        parameters: Mapping[str, Range],
        *,
        minimize: Sequence[str] = (),
        maximize: Sequence[str] = (),
        seed: int = 1,
        sampler: Any = None,
        storage: Any = None,
    ) -> None:
        if not callable(objective):
            raise TypeError("objective must be a function of parameters and a seed")
        if wrong := [name for name, value in parameters.items() if not isinstance(value, Range)]:
            raise TypeError(f"parameters[{wrong[0]!r}] must be a Range")
        if sampler is not None and not (minimize or maximize):
            raise ValueError("minimize or maximize must name a value for a sampler of Optuna")
        if isinstance(sampler, str) and sampler not in SAMPLERS:
            known = ", ".join(map(repr, SAMPLERS))
            raise ValueError(f"sampler must be None, {known} or a sampler of Optuna, but is {sampler!r}")
        if sampler is not None:
            import_optuna()
        if storage is not None and sampler is None:
            raise ValueError("storage needs a sampler of Optuna")
        if both := set(minimize) & set(maximize):
            raise ValueError(f"{min(both)!r} is in minimize and in maximize")
        if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
            raise ValueError(f"seed must be an integer of at least 0, but is {seed!r}")
        self.folder, self.objective = Path(folder), objective
        self.parameters, self.seed = dict(parameters), seed
        self.minimize, self.maximize = tuple(minimize), tuple(maximize)
        self._sampler, self._storage = sampler, storage
        self._head = {
            "study": 1,
            "seed": seed,
            "minimize": list(minimize),
            "maximize": list(maximize),
            "parameters": {name: asdict(value) for name, value in self.parameters.items()},
        }
        place, own = self.folder / "journal.jsonl", identity(objective)
        self._journal = Journal(place, self._head)
        others = [t.objective for t in self.trials if t.objective is not None and is_another(t.objective, own)]
        if others:
            earlier, now = (text.rsplit(" ", 2)[0] for text in (others[0], own))
            changed = f"{now} before its code was changed" if earlier == now else f"{earlier}, not by {now}"
            warnings.warn(
                f"{place}: {len(others)} trials were computed by {changed}: they keep their numbers and are not run again, "
                "take another folder for a study of the objective as it is",
                UserWarning,
                stacklevel=2,
            )

    @property
    def trials(self) -> list[Trial]:
        """All trials by number."""
        return [trial for _, trial in sorted(self._journal.trials.items())]

    def run(
        self,
        trials: int,
        *,
        backend: Literal["local", "ray", "slurm"] = "local",
        workers: int | None = None,
        batch: int = 1,
        wheel: str | os.PathLike[str] | None = None,
    ) -> list[Trial]:
        """Runs until the study has `trials` trials that ended, those of earlier runs included.

        `workers`: threads, actors of Ray or tasks of Slurm at the same time; by default one a core. `batch`: trials that an actor
        or a task runs one after the other: a second and more of work. `wheel`: of this package, for nodes of Ray
        that do not have it.

        Warns where the objective failed in every trial; see `Trial.error`.
        """
        if backend not in ("local", "ray", "slurm"):
            raise ValueError(f"backend must be 'local', 'ray' or 'slurm', but is {backend!r}")
        for name, value in (("trials", trials), ("batch", batch), ("workers", 1 if workers is None else workers)):
            if isinstance(value, bool) or not isinstance(value, int) or value < 1:
                raise ValueError(f"{name} must be an integer of at least 1, but is {value!r}")
        count = workers or os.cpu_count() or 1
        optimizer = None if self._sampler is None else self._optimizer()
        pending = self._pending(trials, optimizer)
        own = identity(self.objective)
        results: Iterator[Result]
        if backend == "local":
            results = run_local(self.objective, pending, count)
        elif backend == "ray":
            results = run_ray(self.objective, pending, count, batch, None if wheel is None else os.fspath(wheel))
        else:
            # A sampler learns between jobs; uniform draws are one job.
            at_once = None if optimizer is None else count * batch
            results = run_slurm(self.objective, pending, count, batch, self.folder, at_once)
        for number, values, error in results:
            missing = [name for name in (*self.minimize, *self.maximize) if error is None and name not in values]
            if missing:
                values, error = {}, f"the objective returned no {missing[0]!r}"
            self._journal.end(number, values, error, own)
            if optimizer is not None:
                optimizer.tell(self._journal.trials[number])
        found = self.trials
        if all(trial.error is not None for trial in found):
            reason = f"all {len(found)} trials of the study ended with an error, the first with {found[0].error}"
            warnings.warn(reason, UserWarning, stacklevel=2)
        return found

    def _pending(self, trials: int, optimizer: Optimizer | None) -> Iterator[Trial]:
        for number in range(trials):
            trial = self._journal.trials.get(number)
            if trial is None:
                draw = np.random.default_rng([self.seed, number])
                if optimizer is None:
                    parameters = {name: value.at(draw.random()) for name, value in self.parameters.items()}
                else:
                    parameters = optimizer.ask(number)
                versions = {"sinew": __version__, "python": platform.python_version(), "numpy": np.__version__}
                trial = Trial(number, parameters, int(draw.integers(2**32)), versions)
                self._journal.propose(trial)
            elif not trial.ended and optimizer is not None:
                optimizer.again(trial)
            if not trial.ended:
                yield trial

    def _optimizer(self) -> Optimizer:
        return Optimizer(
            self.folder.resolve().name,
            self._head,
            self.trials,
            distributions={name: (value.low, value.high, value.log) for name, value in self.parameters.items()},
            minimize=self.minimize,
            maximize=self.maximize,
            sampler=self._sampler,
            storage=self._storage,
        )

    def save(self) -> Path:
        """Writes `results.parquet`, one row a trial that ended; needs polars."""
        try:
            import polars
        except ModuleNotFoundError as error:
            raise ImportError("a table of results needs polars: pip install 'sinew-robotics[study]'", name="polars") from error

        rows = [
            {"trial": t.number, "seed": t.seed, "error": t.error}
            | {f"version_{name}": version for name, version in t.versions.items()}
            | {f"parameter_{name}": value for name, value in t.parameters.items()}
            | {f"value_{name}": value for name, value in t.values.items()}
            for t in self.trials
            if t.ended
        ]
        path, part = self.folder / "results.parquet", self.folder / "results.parquet.part"
        polars.DataFrame(rows, infer_schema_length=None).write_parquet(part)
        part.replace(path)
        return path

    def close(self) -> None:
        """Lets another process continue the study."""
        self._journal.close()

    def __repr__(self) -> str:
        found = self.trials
        ended, failed = sum(trial.ended for trial in found), sum(trial.error is not None for trial in found)
        trials = f"{ended} trials ended, {failed} of them with an error"
        return f"Study({str(self.folder)!r}: {trials}; {len(self.parameters)} parameters)"

    def __enter__(self) -> Study:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
