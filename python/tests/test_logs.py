"""The same log as a file, as columns and as a data frame gives the same model bit for bit."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import polars
import pytest
from conftest import columns_of

import sinew


def frame(file: Path) -> Any:
    return pandas.DataFrame(columns_of(file))


FORMS: dict[str, Callable[[Path], Any]] = {
    "text": str,
    "path": lambda file: file,
    "pandas": frame,
    "polars": lambda file: polars.DataFrame(columns_of(file)),
    "columns": columns_of,
    "lists": lambda file: {name: column.tolist() for name, column in columns_of(file).items()},
}


@pytest.mark.parametrize("form", FORMS)
def test_every_form_of_a_log_gives_the_same_predictions(
    form: str, model: sinew.Model, log_files: list[Path]
) -> None:
    for file in log_files[:3]:
        expected, found = model.predict(file), model.predict([FORMS[form](file)])
        assert len(found) == len(expected) == 9_000
        assert (found.mean == expected.mean).all() and (found.time_s == expected.time_s).all()
        assert model.evaluate(FORMS[form](file)).overall == model.evaluate(file).overall


def test_the_fit_does_not_depend_on_the_form_of_the_logs(log_files: list[Path]) -> None:
    from_files = sinew.identify(log_files[:2], far="tension_out_n", models=["linear"])
    from_frames = sinew.identify([frame(file) for file in log_files[:2]], far="tension_out_n", models=["linear"])
    mixed = sinew.identify([log_files[0], frame(log_files[1])], far="tension_out_n", models=["linear"])
    for other in (from_frames, mixed):
        assert from_files.provenance["rmse_unseen"] == other.provenance["rmse_unseen"]
        near = np.full(len(from_files.inputs), 60.0)
        assert from_files.predictor().step(0.0, near).mean == other.predictor().step(0.0, near).mean


def test_trials_are_labels_and_missing_numbers_are_missing(model: sinew.Model, log_files: list[Path]) -> None:
    table = {name: column[:600].copy() for name, column in columns_of(log_files[0]).items()}
    trial = np.repeat(["first", "second", "third"], 200)
    table["tension_in_n"][10] = np.nan
    found = model.predict(table | {"trial": trial})
    assert found.trial.tolist() == trial.tolist()
    assert np.flatnonzero(found.reset).tolist() == [0, 200, 400]
    assert found.input_held[10] and len(set(found.log)) == 1
    columns = pandas.DataFrame(found.columns())
    assert columns.shape == (600, 13)
    np.testing.assert_array_equal(found.measured, table["tension_out_n"])
    alone = {name: column for name, column in table.items() if name != "tension_out_n"}
    assert np.isnan(model.predict(alone).measured).all()


def test_an_evaluation_tells_the_logs_of_the_fit(log_files: list[Path]) -> None:
    tables = [frame(file) for file in log_files[:3]]
    evaluation = sinew.identify(tables[:2], far="tension_out_n", models=["linear"]).evaluate(tables)
    assert len(evaluation.logs) == 3 and len(evaluation.in_training) == 2
    assert (evaluation.far, evaluation.far_unit) == ("tension_out_n", "N")


def test_adapting_starts_from_the_old_model(model: sinew.Model, log_files: list[Path]) -> None:
    adapted = model.adapt(log_files[2])
    report = adapted.identification
    assert report is not None and "transfer" in [candidate["name"] for candidate in report["candidates"]]
    assert adapted.inputs == model.inputs


def stamps(seconds: Any) -> Any:
    return np.datetime64("2026-03-01T12:00:00.000000000") + (np.round(seconds * 1e9)).astype("timedelta64[ns]")


#: The same time in every form in which data frames have it.
TIMES: dict[str, Callable[[Any], Any]] = {
    "datetime64": stamps,
    "timedelta64": lambda seconds: (np.round(seconds * 1e9)).astype("timedelta64[ns]"),
    "pandas with a zone": lambda seconds: pandas.Series(
        pandas.DatetimeIndex(stamps(seconds)).tz_localize("Europe/Berlin")
    ),
    "pandas durations": lambda seconds: pandas.to_timedelta(seconds, unit="s"),
    "polars": lambda seconds: polars.Series(stamps(seconds)),
    "Python": lambda seconds: [stamp.to_pydatetime() for stamp in pandas.DatetimeIndex(stamps(seconds))],
    "text": lambda seconds: [str(stamp).replace("T", " ") for stamp in stamps(seconds)],
    "durations as text": lambda seconds: [f"{second:.4f} sec" for second in seconds],
}


@pytest.mark.parametrize("form", TIMES)
@pytest.mark.parametrize("name", ["time_s", "Zeit", "timestamp"])
def test_every_form_of_time_is_read(form: str, name: str, model: sinew.Model, log_files: list[Path]) -> None:
    columns = {key: column[:500] for key, column in columns_of(log_files[0]).items()}
    expected = model.predict(columns)
    seconds = columns.pop("time_s")
    found = model.predict({name: TIMES[form](seconds)} | columns)
    assert np.abs(found.time_s - expected.time_s).max() < 1e-6
    assert np.abs(found.mean - expected.mean).max() < 1e-6 * np.abs(expected.mean).max()


def test_the_index_of_a_data_frame_may_be_its_time(model: sinew.Model, log_files: list[Path]) -> None:
    columns = {key: column[:500] for key, column in columns_of(log_files[0]).items()}
    expected = model.predict(columns)
    seconds = columns.pop("time_s")
    durations = pandas.to_timedelta(seconds, unit="s")
    for index in (pandas.DatetimeIndex(stamps(seconds)), durations, pandas.Index(seconds, name="t_s")):
        found = model.predict(pandas.DataFrame(columns, index=index))
        assert np.abs(found.mean - expected.mean).max() < 1e-6 * np.abs(expected.mean).max()


def test_without_a_time_the_remedy_is_named_and_a_rate_is_one(model: sinew.Model, log_files: list[Path]) -> None:
    columns = {key: column[:500] for key, column in columns_of(log_files[0]).items()}
    expected = model.predict(columns)
    del columns["time_s"]
    with pytest.raises(ValueError, match="rate_hz="):
        sinew.identify(columns, far="tension_out_n", models=["linear"])
    found = model.predict(pandas.DataFrame(columns), rate_hz=100.0)
    assert np.abs(found.mean - expected.mean).max() < 1e-6 * np.abs(expected.mean).max()


def test_columns_are_renamed_and_converted(model: sinew.Model, log_files: list[Path]) -> None:
    columns = {key: column[:500] for key, column in columns_of(log_files[0]).items()}
    expected = model.predict(columns)
    other = dict(columns)
    other["LC_prox"] = other.pop("tension_in_n") / 1e3
    other["position_in_mm"] = 1e3 * other.pop("position_in_m")
    found = model.predict(other, rename={"LC_prox": "tension_in_n"}, units={"tension_in_n": "kN"})
    assert np.abs(found.mean - expected.mean).max() < 1e-6 * np.abs(expected.mean).max()
