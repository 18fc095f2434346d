"""The journal of a study: one JSON object a line, flushed to the disk before the study goes on."""

from __future__ import annotations

import json
import os
import weakref
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO, Self

try:
    import fcntl
except ImportError:  # Windows has no such locks: there, nothing refuses a second writer.
    fcntl = None  # type: ignore[assignment]


@dataclass(slots=True)
class Trial:
    """One evaluation of the study's function."""

    number: int
    parameters: dict[str, float]
    #: Seed that the function is given.
    seed: int
    #: Versions of what computed it, by package.
    versions: dict[str, str] = field(default_factory=dict)
    #: What the function returned; empty before its end and after an error.
    values: dict[str, float] = field(default_factory=dict)
    #: Error of the function, if it raised one.
    error: str | None = None
    ended: bool = False
    #: Which objective computed it: its name and a digest of its code.
    objective: str | None = field(default=None, compare=False)


class Journal:
    """A file that only this process appends to."""

    def __init__(self, path: Path, head: dict[str, Any]) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self.trials: dict[int, Trial] = {}
        self._file: BinaryIO = open(path, "a+b")  # noqa: SIM115
        # A study that nobody closes is closed with its last reference.
        weakref.finalize(self, self._file.close)
        try:
            if fcntl is not None:
                try:
                    fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except OSError as error:
                    raise ValueError(f"{path}: another process runs this study") from error
            self._read(path, head)
        except BaseException:
            self._file.close()
            raise

    def _read(self, path: Path, head: dict[str, Any]) -> None:
        self._file.seek(0)
        whole = 0
        for number, line in enumerate(self._file.readlines()):
            if not line.endswith(b"\n"):
                break  # Cut off in mid-write: what it says was not acted on.
            try:
                entry = json.loads(line)
                if number == 0:
                    if entry != head:
                        raise ValueError(f"expected the study {json.dumps(head)}, but is {json.dumps(entry)}")
                elif "parameters" in entry:
                    trial = Trial(entry["trial"], entry["parameters"], entry["seed"], entry["versions"])
                    self.trials[trial.number] = trial
                else:
                    trial = self.trials[entry["trial"]]
                    trial.values, trial.error, trial.ended = entry["values"], entry["error"], True
                    # Journals of earlier versions lack it.
                    trial.objective = entry.get("objective")
            except (ValueError, KeyError, TypeError) as error:
                raise ValueError(f"{path}, line {number + 1}: {error}") from error
            whole += len(line)
        self._file.truncate(whole)
        if whole == 0:
            self._append(head)

    def _append(self, entry: dict[str, Any]) -> None:
        self._file.write(json.dumps(entry).encode() + b"\n")
        self._file.flush()
        os.fsync(self._file.fileno())

    def propose(self, trial: Trial) -> None:
        """Writes a trial before it runs."""
        self._append(
            {"trial": trial.number, "parameters": trial.parameters, "seed": trial.seed, "versions": trial.versions}
        )
        self.trials[trial.number] = trial

    def end(self, number: int, values: dict[str, float], error: str | None, objective: str) -> None:
        """Writes the result of a trial."""
        trial = self.trials[number]
        if trial.ended:
            raise RuntimeError(f"trial {number} ended twice")
        self._append({"trial": number, "values": values, "error": error, "objective": objective})
        trial.values, trial.error, trial.ended, trial.objective = values, error, True, objective

    def close(self) -> None:
        """Lets another process continue."""
        self._file.close()
