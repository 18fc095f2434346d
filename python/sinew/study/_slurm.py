"""Array jobs of Slurm: a folder for every job, with its script, its trials, and the results that its tasks leave there."""

from __future__ import annotations

import json
import pickle
import shlex
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict
from itertools import islice
from pathlib import Path

from ._backends import Objective, Result, evaluate
from ._journal import Trial

#: Seconds between looks for results.
INTERVAL_S = 1.0


def run_slurm(
    objective: Objective, pending: Iterator[Trial], workers: int, batch: int, folder: Path, at_once: int | None
) -> Iterator[Result]:
    """Submits jobs with `sbatch` and waits for their results; `workers` tasks run at the same time, each a batch.

    `at_once`: trials of a job; none for one job with all. Results of jobs that an earlier call submitted are taken
    over, jobs of it that still run are waited for. Raises `RuntimeError` where Slurm refuses a job, or a job ends without results.
    """
    earlier = [_Job(path.parent) for path in sorted((folder / "slurm").glob("job-*/tasks.json"))]
    while wave := list(islice(pending, at_once)):
        desired = {trial.number for trial in wave}
        for job in earlier:
            for result in job.results(desired):
                desired.discard(result[0])
                yield result
        if rest := [trial for trial in wave if trial.number in desired]:
            yield from _submit(objective, rest, workers, batch, folder).results(desired, must_end=True)


class _Job:
    """A job that was submitted."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        # Without an id the program ended before it learnt whether Slurm took the job.
        self._id = (folder / "id").read_text() if (folder / "id").is_file() else ""
        self._tasks = json.loads((folder / "tasks.json").read_text())

    def results(self, desired: set[int], *, must_end: bool = False) -> Iterator[Result]:
        """Results of the trials that are desired, as their tasks end."""
        waiting = {k for k, task in enumerate(self._tasks) if desired & {trial["number"] for trial in task}}
        while waiting:
            # Asked before the results are read: a task that ends in between has left its own.
            alive = self._is_alive()
            for k in sorted(waiting):
                file = self._folder / f"result-{k}.json"
                if file.is_file():
                    waiting.discard(k)
                    for number, values, error in json.loads(file.read_text()):
                        if number in desired:
                            yield number, values, error
            if waiting and not alive:
                if must_end:
                    raise RuntimeError(f"job {self._id} of Slurm ended without results of {len(waiting)} tasks: {self._folder}")
                return
            if waiting:
                time.sleep(INTERVAL_S)

    def _is_alive(self) -> bool:
        if not self._id:
            return False
        command = ["squeue", "--noheader", "--jobs", self._id]
        done = subprocess.run(command, capture_output=True, text=True)
        # Slurm forgets a job some minutes after its end; its id is then an error.
        return done.returncode == 0 and bool(done.stdout.strip())


def _submit(objective: Objective, trials: list[Trial], workers: int, batch: int, folder: Path) -> _Job:
    """Writes a job and hands it to Slurm."""
    place = (folder / "slurm").resolve()
    place.mkdir(parents=True, exist_ok=True)
    number = len(list(place.iterdir()))
    job = place / f"job-{number:04}"
    job.mkdir()
    try:
        (job / "objective.pickle").write_bytes(pickle.dumps(objective))
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise ValueError(f"objective must be picklable for Slurm, a function of a module for example: {error}") from error
    tasks = [[asdict(trial) for trial in trials[k : k + batch]] for k in range(0, len(trials), batch)]
    (job / "tasks.json").write_text(json.dumps(tasks))
    python, quoted = shlex.quote(sys.executable), shlex.quote(str(job))
    paths = shlex.quote(":".join(path for path in sys.path if path))
    script = (
        "#!/bin/sh\n"
        "#SBATCH --job-name=sinew-study\n"
        f"#SBATCH --array=0-{len(tasks) - 1}%{workers}\n"
        f"#SBATCH --output={job}/task-%a.log\n"
        f"export PYTHONPATH={paths}\n"
        f'exec {python} -m sinew.study._slurm {quoted} "$SLURM_ARRAY_TASK_ID"\n'
    )
    (job / "job.sh").write_text(script)
    try:
        done = subprocess.run(["sbatch", "--parsable", str(job / "job.sh")], capture_output=True, text=True)
    except FileNotFoundError as error:
        raise RuntimeError("there is no sbatch: expected the commands of Slurm on PATH") from error
    if done.returncode != 0:
        raise RuntimeError(f"sbatch refused {job / 'job.sh'}: {done.stderr.strip()}")
    # `--parsable` prints the id, and the cluster after a semicolon where there are several.
    (job / "id").write_text(done.stdout.strip().split(";")[0])
    return _Job(job)


def run_task(job: Path, task: int) -> None:
    """What a task of a job does: its trials, whose results are written whole or not at all."""
    objective = pickle.loads((job / "objective.pickle").read_bytes())
    trials = [Trial(**trial) for trial in json.loads((job / "tasks.json").read_text())[task]]
    part = job / f"result-{task}.json.part"
    part.write_text(json.dumps([evaluate(objective, trial) for trial in trials]))
    part.replace(job / f"result-{task}.json")


if __name__ == "__main__":
    run_task(Path(sys.argv[1]), int(sys.argv[2]))
