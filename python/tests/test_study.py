"""Studies: resumed after kills, refused where wrong, reported."""

from __future__ import annotations

import functools
import json
import os
import random
import re
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import sinew
from sinew.study import Range, Study, pareto_front, robustness, routing, write_report
from sinew.study._backends import Objective
from sinew.study._identity import identity
from sinew.study._routing import torque_set_size

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


def test_a_trial_that_was_cut_off_runs_again_under_its_own_number(tmp_path: Path) -> None:
    with Study(tmp_path, objective, RANGES) as study:
        whole = study.run(6)
    lines = (tmp_path / "journal.jsonl").read_bytes().splitlines(keepends=True)
    # As if killed while trial 2 ran: its proposal stands there, its end does not.
    kept = [line for line in lines if not (b'"values"' in line and json.loads(line)["trial"] == 2)]
    (tmp_path / "journal.jsonl").write_bytes(b"".join(kept))
    with Study(tmp_path, objective, RANGES) as study:
        assert study.run(6) == whole
    after = [json.loads(line) for line in (tmp_path / "journal.jsonl").read_text().splitlines()[1:]]
    assert [line["trial"] for line in after if "parameters" in line] == list(range(6))
    assert after[-1]["trial"] == 2 and set(whole[2].versions) >= {"sinew", "python", "numpy"}


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

    def no_names(_parameters: dict[str, float], _seed: int) -> float:
        return 0.5

    unnamed = r"TypeError: .*return named numbers.* but returned 0\.5"
    for k, (failing, reason) in enumerate([(wrong, "finite"), (no_names, unnamed)]):
        with Study(tmp_path / str(k), failing, RANGES) as study:  # type: ignore[arg-type]
            with pytest.warns(UserWarning, match=f"all 2 trials of the study ended with an error, the first with .*{reason}"):
                assert all(trial.error for trial in study.run(2))
            assert repr(study).endswith("2 trials ended, 2 of them with an error; 2 parameters)")


def test_a_study_warns_of_trials_of_another_objective(tmp_path: Path) -> None:
    def of(scale: float, code: str = "p['x'] * scale") -> Objective:
        space = {"scale": scale}
        exec(f"def found(p, _seed):\n    return {{'near': {code}}}", space)
        found: Objective = space["found"]  # type: ignore[assignment]
        return found

    with Study(tmp_path, of(1.0), RANGES) as study:
        study.run(3)
    # The same again, from a function of its own.
    Study(tmp_path, of(1.0), RANGES).close()
    with pytest.warns(UserWarning, match="3 trials were computed by found before its code was changed.*another folder"):
        Study(tmp_path, of(1.0, "p['x'] + 1.0"), RANGES).close()
    with pytest.warns(UserWarning, match=r"3 trials were computed by found, not by objective: they keep their numbers"):
        Study(tmp_path, objective, RANGES).close()
    closures = [(lambda scale: lambda p, _seed: {"near": p["x"] * scale})(scale) for scale in (1.0, 1.0, 2.0)]
    same = [identity(one) for one in closures]
    assert same[0] == same[1] != same[2]
    assert identity(functools.partial(slow, seed=1)) != identity(functools.partial(slow, seed=2))
    # A journal of a version that did not note it.
    journal = tmp_path / "journal.jsonl"
    journal.write_text(re.sub(r', "objective": "[^"]*"', "", journal.read_text()))
    with Study(tmp_path, objective, RANGES) as study:
        assert len(study.run(3)) == 3


def test_samplers_without_optuna_say_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ValueError, match="sampler must be None, 'tpe', 'nsga2' or a sampler of Optuna, but is 'cma'"):
        Study(tmp_path, objective, RANGES, minimize=["far"], sampler="cma")
    monkeypatch.setitem(sys.modules, "optuna", None)
    with pytest.raises(ImportError, match=r"pip install 'sinew-robotics\[study\]'"):
        Study(tmp_path, objective, RANGES, minimize=["far"], sampler="tpe")


def test_results_and_report(tmp_path: Path) -> None:
    polars = pytest.importorskip("polars", reason="polars is not installed")
    with Study(tmp_path, objective, RANGES, minimize=["near", "far"]) as study:
        trials = study.run(20)
        table = polars.read_parquet(study.save())
        write_report(study, tmp_path / "report.html")
    assert table["seed"].to_list() == [t.seed for t in trials]
    front = pareto_front(trials, ["near", "far"])
    points = np.array([[t.values["near"], t.values["far"]] for t in trials])
    dominated = [(np.all(points <= p, axis=1) & np.any(points < p, axis=1)).any() for p in points]
    assert [t.number for t in front] == [t.number for t, d in zip(trials, dominated, strict=True) if not d]
    assert pareto_front(trials, ["near"], ["near"]) == trials
    page = (tmp_path / "report.html").read_text()
    assert page.count("<polyline") == 20 and page.count("<circle") == 20


def test_a_sampler_of_optuna_continues(tmp_path: Path) -> None:
    optuna = pytest.importorskip("optuna", reason="Optuna is not installed")
    for trials in (15, 30):
        with Study(
            tmp_path, objective, RANGES, minimize=["far"], sampler=optuna.samplers.TPESampler(seed=1)
        ) as study:
            ended = study.run(trials, workers=1)
    with Study(tmp_path / "named", objective, RANGES, minimize=["far"], sampler="tpe") as study:
        assert study.run(15, workers=1) == ended[:15]
    assert len(ended) == 30 and all(t.ended and t.error is None for t in ended)


def test_a_storage_of_optuna_holds_what_the_journal_holds(tmp_path: Path) -> None:
    optuna = pytest.importorskip("optuna", reason="Optuna is not installed")
    url = f"sqlite:///{tmp_path / 'optuna.db'}"
    optuna.logging.set_verbosity(optuna.logging.ERROR)

    def study(folder: str, seed: int = 1, storage: str | None = url) -> Study:
        sampler = optuna.samplers.TPESampler(seed=1)
        return Study(tmp_path / folder, objective, RANGES, minimize=["far"], seed=seed, sampler=sampler, storage=storage)

    with study("a", storage=None) as begun:
        begun.run(5, workers=1)
    with study("a") as continued:
        continued.run(9, workers=1)
    # As if killed while a trial ran: its proposal and Optuna's question stand there.
    lines = (tmp_path / "a/journal.jsonl").read_text().splitlines(keepends=True)
    (tmp_path / "a/journal.jsonl").write_text("".join(lines) + lines[-2].replace('"trial": 8', '"trial": 9'))
    optuna.load_study(study_name="a", storage=url).ask()
    with study("a") as continued:
        trials = continued.run(14, workers=2)
    stored = optuna.load_study(study_name="a", storage=url).trials
    ended = [trial for trial in stored if trial.state == optuna.trial.TrialState.COMPLETE]
    assert {t.user_attrs["trial"]: (t.params, t.value) for t in ended} == {
        t.number: (t.parameters, t.values["far"]) for t in trials
    }
    assert len(ended) == 14 and all(trial.state.is_finished() for trial in stored)
    for folder, seed in (("b/a", 2), ("c/a", 1)):
        with study(folder, seed) as other, pytest.raises(ValueError, match="another study 'a'"):
            other.run(1)
    optuna.create_study(study_name="d", storage=url).ask()
    with study("d") as other, pytest.raises(ValueError, match=r"not of sinew\.study"):
        other.run(1)
    with pytest.raises(ValueError, match="storage needs a sampler"):
        Study(tmp_path / "e", objective, RANGES, storage=url)


def counted(parameters: dict[str, float], seed: int) -> dict[str, float]:
    with open(os.environ["SINEW_TEST_COUNT"], "a") as file:
        file.write(f"{seed}\n")
    time.sleep(0.1)
    return objective(parameters, seed)


SBATCH = """#!/bin/sh
last=$(sed -n 's/^#SBATCH --array=0-\\([0-9]*\\)%.*/\\1/p' "$2")
id=$$
touch "$SINEW_TEST_JOBS/$id"
(for k in $(seq 0 "$last"); do SLURM_ARRAY_TASK_ID=$k sh "$2"; done; rm "$SINEW_TEST_JOBS/$id") >"$2.log" 2>&1 &
echo "$id"
"""
SQUEUE = """#!/bin/sh
if [ -f "$SINEW_TEST_JOBS/$3" ]; then echo "$3"; fi
"""


@pytest.fixture
def slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Stand-ins for Slurm's commands; returns a folder for a study."""
    if os.name == "nt":
        pytest.skip("the stand-ins for Slurm are shell scripts")
    for name, text in (("sbatch", SBATCH), ("squeue", SQUEUE)):
        (tmp_path / "bin").mkdir(exist_ok=True)
        (tmp_path / "bin" / name).write_text(text)
        (tmp_path / "bin" / name).chmod(0o755)
    (tmp_path / "jobs").mkdir()
    monkeypatch.setenv("PATH", f"{tmp_path / 'bin'}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("SINEW_TEST_JOBS", str(tmp_path / "jobs"))
    monkeypatch.setenv("SINEW_TEST_COUNT", str(tmp_path / "count"))
    monkeypatch.setattr("sinew.study._slurm.INTERVAL_S", 0.05)
    return tmp_path / "study"


def test_slurm_finds_what_threads_find(slurm: Path, tmp_path: Path) -> None:
    with Study(slurm, counted, RANGES) as study:
        trials = study.run(7, backend="slurm", workers=2, batch=3)
    script = (slurm / "slurm/job-0000/job.sh").read_text()
    assert "#SBATCH --array=0-2%2\n" in script
    with Study(tmp_path / "local", objective, RANGES) as study:
        assert study.run(7) == trials


def test_jobs_of_a_study_that_was_killed_are_taken_over(slurm: Path, tmp_path: Path) -> None:
    code = f"import test_study as t; t.Study({str(slurm)!r}, t.counted, t.RANGES).run(8, backend='slurm', batch=2)"
    child = subprocess.Popen([sys.executable, "-c", code], cwd=Path(__file__).parent)
    deadline = time.monotonic() + 60.0
    while not (slurm / "slurm/job-0000/result-0.json").is_file() and time.monotonic() < deadline:
        time.sleep(0.02)
    child.send_signal(signal.SIGKILL)
    child.wait()
    with Study(slurm, counted, RANGES) as study:
        trials = study.run(8, backend="slurm", batch=2)
    assert all(t.ended and t.error is None for t in trials)
    assert Counter((tmp_path / "count").read_text().split()) == Counter(str(t.seed) for t in trials)
    assert len(list((slurm / "slurm").iterdir())) == 1


def test_a_job_without_results_is_an_error(slurm: Path, tmp_path: Path) -> None:
    (tmp_path / "bin/sbatch").write_text("#!/bin/sh\necho 77\n")
    with Study(slurm, counted, RANGES) as study, pytest.raises(RuntimeError, match="job 77 .*without results"):
        study.run(2, backend="slurm")
    (tmp_path / "bin/sbatch").write_text("#!/bin/sh\necho no such partition >&2; exit 1\n")
    with Study(slurm, counted, RANGES) as study:
        with pytest.raises(RuntimeError, match="no such partition"):
            study.run(2, backend="slurm")
        study.objective = lambda _parameters, _seed: {}
        with pytest.raises(ValueError, match="picklable"):
            study.run(2, backend="slurm")


def test_ray_finds_what_threads_find(tmp_path: Path) -> None:
    code = (
        f"import test_study as t\nfor backend in ('ray', 'local'):\n    with t.Study({str(tmp_path)!r} + '/' + backend, t.objective,"
        " t.RANGES) as study:\n        study.run(20, backend=backend, workers=2, batch=4)\n"
    )
    pytest.importorskip("ray", reason="Ray is not installed")
    # A process of its own: Ray leaves threads and warnings behind.
    subprocess.run([sys.executable, "-c", code], cwd=Path(__file__).parent, check=True, timeout=180)
    with Study(tmp_path / "ray", objective, RANGES) as ray, Study(tmp_path / "local", objective, RANGES) as local:
        assert ray.trials == local.trials and len(ray.trials) == 20


def test_the_size_of_a_set_of_torques_is_that_of_a_parallelepiped() -> None:
    edges = np.random.default_rng(3).normal(size=(1, 3, 3))
    assert torque_set_size(edges)[0] == pytest.approx(abs(np.linalg.det(edges[0])) ** (1 / 3))
    # Split edges span the same set.
    assert torque_set_size(np.concatenate([0.3 * edges, 0.7 * edges], axis=1)) == pytest.approx(torque_set_size(edges))
    # Of one muscle over three joints, an edge.
    assert torque_set_size(edges[:, :1])[0] == pytest.approx(np.linalg.norm(edges[0, 0]))


@pytest.mark.parametrize("name", sinew.Machine.built_in())
def test_the_route_of_the_design_is_the_design(name: str) -> None:
    machine = sinew.Machine(name)
    muscle = machine.muscle_names[-1]
    values = routing(name, muscle)({}, 1)
    assert 0.0 < values["friction_loss"] < 1.0 and values["torque_nm"] < values["frictionless_torque_nm"]
    bent = routing(name, muscle)({"bend_rad": 6.0}, 1)
    assert bent["friction_loss"] > values["friction_loss"] and bent["torque_nm"] < values["torque_nm"]
    assert bent["frictionless_torque_nm"] == pytest.approx(values["frictionless_torque_nm"], rel=1e-12)


def test_wrong_routes_are_refused() -> None:
    with pytest.raises(ValueError, match="expected one of front, back"):
        routing("bench_joint", "middle")
    with pytest.raises(ValueError, match="bending"):
        routing("bench_joint", "front")({"bending": 1.0}, 1)
    with pytest.raises(ValueError, match="at most 0.63"):
        routing("bench_joint", "front")({"origin_x_m": 0.7}, 1)


def test_specimens_are_drawn_by_their_seeds() -> None:
    specimen = robustness("bench_joint", "tour")
    first = specimen({}, 1)
    assert first == specimen({}, 1) != specimen({}, 2) and first["completed"] == 1.0


def on_node(_parameters: dict[str, float], _seed: int) -> dict[str, float]:
    import ray

    time.sleep(0.2)
    return {"node": float(int(ray.get_runtime_context().get_node_id()[:12], 16))}


TWO_NODES = """
import ray, sys, test_study as t
from ray.cluster_utils import Cluster
cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
cluster.add_node(num_cpus=1)
ray.init(address=cluster.address, log_to_driver=False)
with t.Study(sys.argv[1], t.on_node, {}) as study:
    study.run(20, backend="ray", workers=2)
ray.shutdown()
cluster.shutdown()
"""


@pytest.mark.skipif(not os.environ.get("SINEW_LONG"), reason="starts two nodes of Ray; runs where SINEW_LONG is set")
def test_two_nodes_of_ray_share_a_study(tmp_path: Path) -> None:
    pytest.importorskip("ray", reason="Ray is not installed")
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parent)}
    command = [sys.executable, "-c", TWO_NODES, str(tmp_path)]
    subprocess.run(command, cwd=Path(__file__).parent, env=environment, check=True, timeout=300)
    with Study(tmp_path, on_node, {}) as study:
        assert len({t.values["node"] for t in study.trials}) == 2 and len(study.trials) == 20
