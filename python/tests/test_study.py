"""Studies: resumed after kills, refused where wrong, reported."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest

from sinew.study import Range, Study, pareto_front, write_report

KILLS = 10 if os.environ.get("SINEW_LONG") else 2
RANGES = {"x": Range(-1.0, 1.0), "y": Range(0.1, 10.0, log=True)}


def objective(parameters: dict[str, float], seed: int) -> dict[str, float]:
    return {"near": parameters["x"] ** 2, "far": (parameters["x"] - 1.0) ** 2 + parameters["y"], "seed": seed}


def slow(parameters: dict[str, float], seed: int) -> dict[str, float]:
    time.sleep(0.02)
    return objective(parameters, seed)


def test_no_trial_is_lost_or_recorded_twice_after_kills(tmp_path: Path) -> None:
    code = f"import test_study as t; t.Study({str(tmp_path / 'a')!r}, t.slow, t.RANGES).run(120, workers=2)"
    draw = random.Random(3)
    for _ in range(KILLS):
        child = subprocess.Popen([sys.executable, "-c", code], cwd=Path(__file__).parent)
        time.sleep(draw.uniform(0.1, 0.7))
        child.send_signal(signal.SIGKILL)
        child.wait()
    with Study(tmp_path / "a", slow, RANGES) as study:
        resumed = study.run(120, workers=2)
    lines = [json.loads(line) for line in (tmp_path / "a/journal.jsonl").read_text().splitlines()[1:]]
    for kind in ("parameters", "values"):
        assert Counter(line["trial"] for line in lines if kind in line) == Counter(range(120))
    with Study(tmp_path / "b", objective, RANGES) as study:
        assert study.run(120) == resumed


def test_a_line_cut_off_is_written_again(tmp_path: Path) -> None:
    with Study(tmp_path, objective, RANGES) as study:
        whole = study.run(5)
    journal = tmp_path / "journal.jsonl"
    journal.write_bytes(journal.read_bytes()[:-7])
    with Study(tmp_path, objective, RANGES) as study:
        assert study.run(5) == whole


def test_wrong_input_is_refused(tmp_path: Path) -> None:
    for low, high, log in ((1.0, 0.0, False), (float("nan"), 1.0, False), (0.0, 1.0, True)):
        with pytest.raises(ValueError):
            Range(low, high, log)
    with Study(tmp_path, objective, RANGES) as study:
        for trials in (0, -1, True, 1.5):
            with pytest.raises(ValueError, match="trials"):
                study.run(trials)  # type: ignore[arg-type]
        with pytest.raises(ValueError, match="another process"):
            Study(tmp_path, objective, RANGES)
    with pytest.raises(ValueError, match="line 1"):
        Study(tmp_path, objective, RANGES, seed=2)


def test_an_error_of_the_objective_is_recorded(tmp_path: Path) -> None:
    def wrong(_parameters: dict[str, float], _seed: int) -> dict[str, float]:
        return {"near": float("nan")}

    with Study(tmp_path, wrong, RANGES) as study:
        assert "finite" in str(study.run(1)[0].error)


def test_results_and_report(tmp_path: Path) -> None:
    polars = pytest.importorskip("polars", reason="polars is not installed")
    with Study(tmp_path, objective, RANGES, minimize=["near", "far"]) as study:
        trials = study.run(20)
        table = polars.read_parquet(study.save())
        write_report(study, tmp_path / "report.html")
    assert table["seed"].to_list() == [t.seed for t in trials]
    front = pareto_front(trials, ["near", "far"])
    assert 0 < len(front) < 20
    page = (tmp_path / "report.html").read_text()
    assert page.count("<polyline") == 20 and page.count("<circle") == 20


def test_a_sampler_of_optuna_continues(tmp_path: Path) -> None:
    optuna = pytest.importorskip("optuna", reason="Optuna is not installed")
    for trials in (15, 30):
        with Study(
            tmp_path, objective, RANGES, minimize=["far"], sampler=optuna.samplers.TPESampler(seed=1)
        ) as study:
            ended = study.run(trials, workers=1)
    assert len(ended) == 30 and all(t.ended and t.error is None for t in ended)
