"""Identified models of transmissions."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Unpack

import numpy as np
from numpy.typing import NDArray

from . import _sinew
from ._display import html_table, number, percent
from ._logs import Logs, native_logs
from ._progress import Progress, reported
from ._refused import whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class Scores:
    """Errors of a model on samples that counted, in the unit of the far end; `None` where there is no number."""

    #: Samples that counted.
    n: int
    #: Mean squared error, unit squared.
    mse: float | None
    #: Root mean squared error.
    rmse: float | None
    #: Pearson correlation.
    pearson: float | None
    #: RMSE as % of the range of the far end in these samples.
    percent_of_range: float | None
    #: Fraction of samples inside the 95 % band.
    coverage95: float | None
    #: Fraction of samples outside the ranges of the training logs.
    out_of_range: float | None
    #: RMSE to expect of these samples; beyond the conditions of the training logs what is expected there.
    expected: float | None
    #: RMSE of the samples inside those ranges.
    rmse_in_range: float | None
    #: RMSE of the samples outside of them.
    rmse_out_of_range: float | None
    #: Trials that were `judged`, those of an `other` specimen, and the one that deviates `most`.
    specimen: dict[str, Any] | None
    #: Fraction of samples at which the hysteresis still depends on its unknown beginning.
    state_unknown: float | None


@dataclass(frozen=True, slots=True)
class Evaluation:
    """Scores of a model on logs."""

    #: All samples together.
    overall: Scores
    #: Log by log, by name.
    logs: dict[str, Scores]
    #: Those of them to which the model was fitted: their errors are none on unseen data.
    in_training: frozenset[str]
    #: The column that is predicted.
    far: str
    #: Its unit, in which the errors are; empty where its name states none.
    far_unit: str

    def _repr_html_(self) -> str:
        def row(name: str, s: Scores) -> list[str]:
            fraction = None if s.percent_of_range is None else s.percent_of_range / 100
            return [
                name,
                str(s.n),
                number(s.rmse),
                percent(fraction),
                number(s.pearson),
                percent(s.coverage95),
                percent(s.out_of_range),
            ]

        rows = [*(row(name, scores) for name, scores in self.logs.items()), row("all", self.overall)]
        head = ["log", "samples", f"RMSE, {self.far_unit or 'unit'}", "of range", "Pearson", "in 95 % band", "outside"]
        fitted = ", ".join(sorted(self.in_training))
        notes = [f"The model was fitted to {fitted}: no error on unseen data."] if fitted else []
        return html_table(f"Prediction of {self.far}", head, rows, notes)


@dataclass(frozen=True, slots=True)
class Predictions:
    """Predictions of the samples of logs, arrays of shape `(n,)`; the unit is that of the far end."""

    #: Names of log and trial of every sample.
    log: NDArray[np.str_]
    trial: NDArray[np.str_]
    #: Time, s.
    time_s: NDArray[np.float64]
    #: The far end as the logs hold it, in the model's unit; NaN where they do not.
    measured: NDArray[np.float64]
    #: The far end.
    mean: NDArray[np.float64]
    standard_deviation: NDArray[np.float64]
    #: Half width of the 95 % band.
    half_width: NDArray[np.float64]
    #: Gate on the learned correction, 0 to 1.
    gate: NDArray[np.float64]
    #: Whether the state in the dead band depends on its start.
    state_unknown: NDArray[np.bool_]
    #: Whether an input lies outside the range of the training logs.
    out_of_range: NDArray[np.bool_]
    #: Whether an input was missing or jumped.
    input_held: NDArray[np.bool_]
    #: Whether all states were reset.
    reset: NDArray[np.bool_]
    #: Whether the loops of near effort over near motion are not those of the specimen in training.
    other_specimen: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.mean)

    def columns(self) -> dict[str, NDArray[Any]]:
        """The columns by name: `pandas.DataFrame(predictions.columns())`."""
        return {name: getattr(self, name) for name in self.__slots__}


class PredictKeywords(TypedDict, total=False):
    """Keywords of `Model.predict`."""

    rename: Mapping[str, str] | None
    units: Mapping[str, str] | None
    rate_hz: float | None
    anchor_reading_s: float | None


class Model:
    """A model of one transmission: near side in, far end out.

    Made by :func:`identify`, :meth:`Model.load` and :meth:`adapt`.
    """

    __slots__ = ("_native",)

    def __init__(self, native: _sinew.Model) -> None:
        if not isinstance(native, _sinew.Model):
            raise TypeError("a Model is made by sinew.identify, Model.load or Model.from_json")
        self._native = native

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Model:
        """Reads a `model.json`.

        Raises `FileNotFoundError`, and `ValueError` for another kind of file, a newer version or a damaged file.
        """
        place = os.fspath(path)
        with open(place, encoding="utf-8") as file:
            try:
                return Model.from_json(file.read())
            except ValueError as error:
                raise ValueError(f"{place!s}: {error}") from None

    @staticmethod
    def from_json(text: str) -> Model:
        """Reads the text of a `model.json`."""
        return Model(_sinew.Model.from_json(text))

    def to_json(self) -> str:
        """The text of a `model.json`; every number survives the round trip bit for bit."""
        return self._native.to_json()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a `model.json`, complete or not at all."""
        write_whole(path, self.to_json())

    def __reduce__(self) -> tuple[Callable[[str], Model], tuple[str]]:
        return Model.from_json, (self.to_json(),)

    @property
    def far(self) -> str:
        """The column that it predicts."""
        return self._native.far

    @property
    def inputs(self) -> dict[str, str]:
        """The columns that it reads, in the order of a predictor's inputs, and their roles."""
        return dict(self._native.inputs)

    @property
    def provenance(self) -> dict[str, Any]:
        """Origin: candidate, logs, samples, seed, error on unseen data in the unit of the far end."""
        return _object(self._native.provenance_json())

    @property
    def identification(self) -> dict[str, Any] | None:
        """Report of the identification: candidates, errors, laws, warnings, grade, advice.

        `None` of a model that was read from a file.
        """
        text = self._native.report_json()
        return None if text is None else _object(text)

    @property
    def grade(self) -> Literal["use", "use_with_care", "do_not_use"] | None:
        """`"use"`, `"use_with_care"` or `"do_not_use"`, by the identification; `None` of a model that was read from a file."""
        report = self.identification
        return None if report is None else report["grade"]

    @property
    def advice(self) -> tuple[str, ...]:
        """Sentences of the identification on what the model is good for; none of a model that was read from a file."""
        report = self.identification
        return () if report is None else tuple(report["advice"])

    def report(self, path: str | os.PathLike[str]) -> None:
        """Writes the report of the identification: one HTML file that opens in any browser, complete or not at all.

        Raises `ValueError` for a model that was read from a file.
        """
        text = self._native.report_html()
        if text is None:
            raise ValueError("a report belongs to a model of sinew.identify or Model.adapt, this one was read from a file")
        write_whole(path, text)

    def plot(self, logs: Logs | None = None, **keywords: Unpack[PredictKeywords]) -> Figure:
        """Prediction of every sample of logs over time with its 95 % band; without logs, errors of the candidates.

        What was measured at the far end is drawn over it where the logs have it under its name: tables, CSV and TSV files; the title
        has the error. The axis leaves out the wide band of samples whose state depends on its start.
        `keywords`: as of :meth:`predict`. Needs matplotlib. Raises `ValueError` for a model that was read from a file where
        there are no logs.
        """
        from matplotlib.figure import Figure

        figure = Figure(figsize=(9, 4), layout="constrained")
        axes = figure.subplots()
        if logs is not None:
            found = self.predict(logs, **keywords)
            breaks = np.flatnonzero(found.reset[1:]) + 1
            low, high = found.mean - found.half_width, found.mean + found.half_width
            for number, part in enumerate(np.split(np.arange(len(found)), breaks)):
                names = ["predicted", "95 % band"] if number == 0 else [None, None]
                axes.plot(found.time_s[part], found.mean[part], label=names[0], color="tab:blue", linewidth=0.9)
                axes.fill_between(found.time_s[part], low[part], high[part], label=names[1], color="tab:blue", alpha=0.25)
            seen = [found.mean, low[~found.state_unknown], high[~found.state_unknown]]
            if np.isfinite(found.measured).any():
                axes.plot(found.time_s, found.measured, ".", label="measured", color="0.1", markersize=1.0)
                seen.append(found.measured)
            title, unit = self._error_title(logs, keywords)
            every = np.concatenate(seen)
            least, most = np.nanmin(every), np.nanmax(every)
            margin = 0.05 * (most - least) or 1.0
            axes.set(xlabel="time, s", ylabel=f"{self.far}, {unit}" if unit else self.far, title=title)
            axes.set_ylim(least - margin, most + margin)
        else:
            report = self.identification
            if report is None:
                raise ValueError("candidates belong to a model of sinew.identify, this one was read from a file: plot(logs)")
            candidates = [c for c in reversed(report["candidates"]) if c["percent_of_range"] is not None]
            for chosen, name, color in ((True, "chosen", "tab:blue"), (False, "other candidates", "0.7")):
                rows = [(k, c["percent_of_range"]) for k, c in enumerate(candidates) if c["chosen"] is chosen]
                axes.barh(*zip(*rows), label=name, color=color) if rows else None
            axes.set_yticks(range(len(candidates)), [c["name"] for c in candidates])
            axes.set_xlabel(f"error of {self.far} on unseen data, % of its range")
        axes.legend()
        return figure

    def _error_title(self, logs: Logs, keywords: PredictKeywords) -> tuple[str, str]:
        """What a plot says of the error on logs, and the unit of the far end."""
        try:
            found = self.evaluate(logs, **keywords)
        except ValueError:  # They hold no far end.
            report = self.identification
            return f"{self.provenance['member']}: nothing measured to compare", "" if report is None else report["far_unit"]
        fitted = ", was fitted to it" if found.in_training else ""
        return f"{self.provenance['member']}: RMSE {number(found.overall.rmse)} {found.far_unit}{fitted}", found.far_unit

    def evaluate(
        self,
        logs: Logs,
        *,
        skip_s: float = 0.0,
        rename: Mapping[str, str] | None = None,
        units: Mapping[str, str] | None = None,
        rate_hz: float | None = None,
        anchor_reading_s: float | None = None,
    ) -> Evaluation:
        """Scores on logs that hold the far end; `skip_s` seconds at the start of every trial are not scored.

        `rename`, `units`, `rate_hz`: as of :func:`identify`. `anchor_reading_s`: as of :meth:`predict`.
        """
        columns = column_keywords(rename, units, rate_hz)
        found = _object(self._native.evaluate(native_logs(logs), columns, skip_s, anchor_reading_s))
        seen = frozenset(log["log"] for log in found["logs"] if log.pop("in_training"))
        scores = {log.pop("log"): Scores(**log) for log in found["logs"]}
        return Evaluation(Scores(**found["overall"]), scores, seen, found["far"], found["far_unit"])

    def predict(
        self,
        logs: Logs,
        *,
        rename: Mapping[str, str] | None = None,
        units: Mapping[str, str] | None = None,
        rate_hz: float | None = None,
        anchor_reading_s: float | None = None,
    ) -> Predictions:
        """Predicts every sample of logs, causally, as a predictor in real time does; the far end need not be there.

        `rename`, `units`, `rate_hz`: as of :func:`identify`. `anchor_reading_s`: seconds after the start of every trial at which
        the far end is read once, as a homing or a stop gives it; later predictions are moved by its shrunken error.
        """
        columns = column_keywords(rename, units, rate_hz)
        found: dict[str, Any] = self._native.predict(native_logs(logs), columns, anchor_reading_s)
        names = {name: np.asarray(found.pop(f"{name}_names"), dtype=np.str_) for name in ("log", "trial")}
        labels = {name: names[name][found.pop(f"{name}_index")] for name in names}
        return Predictions(**labels, **found)

    def predictor(self) -> _sinew.Predictor:
        """A predictor before its first sample: `predictor.step(time_s, inputs)`."""
        return self._native.predictor()

    def compensator(
        self,
        *,
        near: str | None = None,
        min: float | None = None,
        max: float | None = None,
        rate: float | None = None,
        tolerance: float | None = None,
    ) -> _sinew.Compensator:
        """The inverse of the model: `compensator.step(time_s, inputs, desired)` is the near-side command for a desired far end.

        `near`: the column that is commanded. `min`, `max`: limits of the command. `rate`: its largest rate, per second: what the
        drive can follow, also across the dead band. `tolerance`: error of the far end that is no reason to move.
        """
        return self._native.compensator(near, min, max, rate, tolerance)

    def adapt(
        self,
        logs: Logs,
        *,
        skip_s: float = 0.0,
        rename: Mapping[str, str] | None = None,
        units: Mapping[str, str] | None = None,
        rate_hz: float | None = None,
        seed: int = 1,
        threads: int | None = None,
        progress: Progress | None = None,
    ) -> Model:
        """Refits the model to a short calibration of another specimen, with this model as prior.

        `rename`, `units`, `rate_hz`: as of :func:`identify`.
        """
        columns = column_keywords(rename, units, rate_hz)
        first = whole("seed", seed)
        with reported(progress) as said:
            return Model(self._native.adapt(native_logs(logs), columns, skip_s, first, threads, said))

    def __repr__(self) -> str:
        origin = self.provenance
        reads = ", ".join(self.inputs)
        grade = "" if self.grade in (None, "use") else f"; {str(self.grade).replace('_', ' ').upper()}"
        error = f"RMSE {number(origin['rmse_unseen'])} on unseen data"
        return f"Model({self.far} from {reads}; {origin['member']}, {error}{grade})"

    def _repr_html_(self) -> str:
        report = self.identification
        if report is None:
            rows = [[name, value] for name, value in self.provenance.items() if name != "logs"]
            return html_table(f"Model of {self.far}", ["", ""], rows)
        head = ["", "model", "mean of folds", "RMSE", "of range", "Pearson", "in 95 % band"]
        rows = [
            [
                "→" if c["chosen"] else "",
                c["name"],
                number(c["score"]),
                number(c["rmse"]),
                percent(None if c["percent_of_range"] is None else c["percent_of_range"] / 100),
                number(c["pearson"]),
                percent(c["coverage95"]),
            ]
            for c in report["candidates"]
        ]
        notes = [report["chosen"]["reason"], *report["warnings"], " ".join(report["advice"])]
        return html_table(f"Cross-validated prediction of {self.far}", head, rows, notes)


def identify(
    logs: Logs,
    far: str | None = None,
    *,
    effort: Iterable[str] = (),
    motion: Iterable[str] = (),
    anchor: str | None = None,
    given: Iterable[str] = (),
    time: str | None = None,
    trial: str | None = None,
    group: str | None = None,
    ignore: Iterable[str] = (),
    rename: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    rate_hz: float | None = None,
    skip_s: float = 0.0,
    models: Iterable[str] = (),
    keep: Iterable[str] | None = (),
    loss_percent: float | None = None,
    seed: int = 1,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Model:
    """Identifies the transmission that made logs.

    Candidates are compared by cross-validation, the best is fitted to all data and its 95 % band calibrated.

    `logs`: paths (CSV, TSV, MATLAB, Parquet), data frames of pandas or polars, mappings of column names to arrays of shape
    `(n,)`, or a list of these. `far`: the column to predict. `effort`, `motion`, `anchor`, `given`: near-side tensions or
    torques, positions or strokes, displacement of the far end, slow quantities. Roles that are not given are found by
    names with units such as `tension_in_n`, `position_in_m`, `tension_out_n`, `time_s`. `time`: seconds. `trial`: label at
    whose changes states are reset. `group`: condition by whose values folds are formed. `ignore`: columns to exclude,
    whatever role their names imply. `rename`: names in the logs and the names to read them under. `units`: units of columns,
    whatever their names say; names that differ in their unit alone are one column, whose numbers are converted. `rate_hz`:
    samples per second of logs without a column of time, which are refused otherwise; the time of a data frame may be its
    index, and may be numbers, `datetime64`, `timedelta64` or text such as `2026-03-01 12:00:00.005`. `skip_s`: seconds
    at the start of every trial that are neither fitted nor scored.
    `models`: names of candidates, all by default. `keep`: names of logs that are kept although they do harm to the
    prediction of the others, `None` for all. `loss_percent`: error, in % of the far end's range, that a model with fewer
    numbers may cost; the one with the fewest is then chosen in place of the most accurate. The same `seed` gives the same bits whatever the `threads`, by default all
    that are there, shared by all calls. `progress(stage, fraction)` is called while it runs;
    without it a terminal or notebook shows a line after two seconds.

    Warns where the model is not to be used, see :attr:`Model.grade` and :attr:`Model.advice`. Raises `FileNotFoundError`, and
    `ValueError` that names log, line and column.
    """
    roles = {
        "far": far,
        "effort": names(effort, "effort"),
        "motion": names(motion, "motion"),
        "anchor": anchor,
        "given": names(given, "given"),
        "time": time,
        "trial": trial,
        "group": group,
        "ignore": names(ignore, "ignore"),
    }
    kept = None if keep is None else names(keep, "keep")
    columns = column_keywords(rename, units, rate_hz)
    desired = names(models, "models")
    first = whole("seed", seed)
    with reported(progress) as said:
        fitted = _sinew.identify(native_logs(logs), roles, columns, skip_s, desired, kept, loss_percent, first, threads, said)
    found = Model(fitted)
    if found.grade == "do_not_use":
        warnings.warn(next(iter(found.advice), "do not use the model"), UserWarning, stacklevel=2)
    return found


def column_keywords(
    rename: Mapping[str, str] | None, units: Mapping[str, str] | None, rate_hz: float | None
) -> dict[str, Any]:
    """What logs do not say of their columns, as the native part takes it."""
    return {"rename": list((rename or {}).items()), "units": list((units or {}).items()), "rate_hz": rate_hz}


def demo_logs(seed: int = 1) -> dict[str, str]:
    """SIMULATED logs of a bench, names and texts of CSV files: four days for training, the last one for testing."""
    return dict(_sinew.demo_logs(whole("seed", seed)))


def names(given: Iterable[str], argument: str) -> list[str]:
    """Names as a list; a text alone, whose letters would be names, is refused."""
    if isinstance(given, str):
        raise TypeError(f"{argument} must be a list of names, but is the text {given!r}")
    return list(given)


def write_whole(path: str | os.PathLike[str], text: str) -> None:
    """Writes a file that appears complete or not at all."""
    import tempfile  # slow, and rarely needed

    target = os.path.realpath(path)
    if os.path.isdir(target):
        raise IsADirectoryError(f"{os.fspath(path)}: is a folder, expected a file")
    handle, temporary = tempfile.mkstemp(dir=os.path.dirname(target), prefix=".sinew-")
    try:
        with open(handle, "w", encoding="utf-8", newline="") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o644)
        os.replace(temporary, target)
    except BaseException:
        os.unlink(temporary)
        raise


def _object(text: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(text)
    return found
