"""Where trials run: threads, actors of Ray, array jobs of Slurm. Every backend takes trials and yields results as they end."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import Any, TypeAlias

from ._journal import Trial

#: Function of parameters and a seed that returns named numbers.
Objective: TypeAlias = Callable[[dict[str, float], int], Mapping[str, float]]
#: Number of a trial, its values, its error.
Result: TypeAlias = tuple[int, dict[str, float], str | None]


def evaluate(objective: Objective, trial: Trial) -> Result:
    """Runs one trial; what the objective raises becomes the trial's error."""
    try:
        found = objective(dict(trial.parameters), trial.seed)
        if not isinstance(found, Mapping):
            raise TypeError(f'the objective must return named numbers, such as {{"loss": 0.1}}, but returned {found!r:.60}')
        values = {str(name): float(value) for name, value in found.items()}
        if wrong := [name for name, value in values.items() if not math.isfinite(value)]:
            raise ValueError(f"{wrong[0]} must be finite, but is {values[wrong[0]]}")
    except Exception as error:
        return trial.number, {}, f"{type(error).__name__}: {error}"
    return trial.number, values, None


def run_local(objective: Objective, pending: Iterator[Trial], workers: int) -> Iterator[Result]:
    """Threads of this process; what computes in Rust runs without the interpreter's lock."""
    running: set[Future[Result]] = set()
    with ThreadPoolExecutor(workers) as pool:
        for trial in pending:
            running.add(pool.submit(evaluate, objective, trial))
            if len(running) >= workers:
                done, running = wait(running, return_when=FIRST_COMPLETED)
                yield from (future.result() for future in done)
        while running:
            done, running = wait(running, return_when=FIRST_COMPLETED)
            yield from (future.result() for future in done)


class _Worker:
    """What an actor of Ray runs."""

    def __init__(self, objective: Objective) -> None:
        self._objective = objective

    def run(self, trials: list[Trial]) -> list[Result]:
        return [evaluate(self._objective, trial) for trial in trials]


def run_ray(
    objective: Objective, pending: Iterator[Trial], workers: int, batch: int, wheel: str | None
) -> Iterator[Result]:
    """A pool of actors, each with a batch of trials at a time; `wheel`: of this package, for nodes that lack it."""
    import ray
    from ray.util import ActorPool

    if not ray.is_initialized():
        ray.init(include_dashboard=False, log_to_driver=False)
    options: dict[str, Any] = {"num_cpus": 1}
    if wheel is not None:
        options["runtime_env"] = {"py_modules": [wheel]}
    remote: Any = ray.remote(**options)(_Worker)
    pool: Any = ActorPool([remote.remote(objective) for _ in range(workers)])
    trials: list[Trial] = []

    def submit() -> None:
        pool.submit(lambda actor, value: actor.run.remote(value), list(trials))
        trials.clear()

    for trial in pending:
        trials.append(trial)
        if len(trials) == batch:
            if not pool.has_free():
                yield from pool.get_next_unordered()
            submit()
    if trials:
        submit()
    while pool.has_next():
        yield from pool.get_next_unordered()
