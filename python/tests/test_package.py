"""The package as a package: types, documentation, display, time of import."""

from __future__ import annotations

import dataclasses
import doctest
import inspect
import re
import subprocess
import sys
import time
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import columns_of

import sinew
from sinew import _cable, _machine

ROOT = Path(__file__).parents[2]

TRAINING = "crates/sinew-cli/examples/training"
STUBTEST = ["mypy.stubtest", "sinew", "--mypy-config-file", "pyproject.toml"]
STUBTEST += ["--allowlist", "python/tests/stubtest_allowlist.txt", "--ignore-unused-allowlist"]


@pytest.mark.parametrize("arguments", [["mypy"], ["mypy", "python/examples", TRAINING], STUBTEST])
def test_types_hold_and_the_stubs_are_those_of_the_native_module(arguments: list[str]) -> None:
    done = subprocess.run([sys.executable, "-m", *arguments], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("module", [_cable, _machine])
def test_examples_of_the_documentation_hold(module: Any) -> None:
    found = doctest.testmod(module)
    assert found.attempted > 0 and found.failed == 0


def public() -> list[tuple[str, Any]]:
    objects = [(name, getattr(sinew, name)) for name in sinew.__all__ if name != "__version__"]
    members = [
        (f"{name}.{member}", inspect.getattr_static(value, member))
        for name, value in objects
        if inspect.isclass(value)
        for member in dir(value)
        if not member.startswith("_")
        # Fields of data classes are documented where they stand.
        and type(inspect.getattr_static(value, member)).__name__ != "member_descriptor"
    ]
    return objects + members


@pytest.mark.parametrize(("name", "value"), public(), ids=[name for name, _ in public()])
def test_everything_public_is_documented(name: str, value: Any) -> None:
    text = inspect.getdoc(value) or ""
    assert len(text) > 8, f"{name} has no documentation"
    quantities = r"\b(q|v|a|tension|torque|lengths|moment_arms|poses|time_s|inputs|command|motor|joint)`"
    if re.search(quantities, text) and callable(value) and not inspect.isclass(value):
        assert "shape" in text, f"{name} has arrays without a shape"


class Balanced(HTMLParser):
    """Fails on a tag that is not closed."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_what_notebooks_show_is_balanced_and_escaped(model: sinew.Model, log_files: list[Path]) -> None:
    run = sinew.track(sinew.Machine("bench_joint"), "tour", repeats=1)
    shown = [
        model,
        sinew.Model.from_json(model.to_json()),
        model.evaluate({"<b>": np.ones(9000)} | columns_of(log_files[0])),
        sinew.Machine("finger"),
        run,
        sinew.Reproduction({"tracking": {"<none>": run.numbers}}),
    ]
    for one in shown:
        text = one._repr_html_()
        parser = Balanced()
        parser.feed(text)
        assert not parser.open and "<table>" in text and "<b><" not in text and "<none>" not in text
        assert len(repr(one)) > 5


def test_a_motion_that_was_verified_is_not_verified_again_and_gives_the_same_bits() -> None:
    machine = sinew.Machine("bench_joint")
    motion = machine.plan("tour")
    rules = sinew.verify(machine, motion, repeats=1)
    assert rules.keys() >= {"bandwidth_rad_per_s", "backlash_gain"} and all(value >= 0.0 for value in rules.values())
    once = sinew.track(machine, motion, repeats=1, seed=5)
    again = sinew.track(machine, motion, repeats=1, seed=5, rules=rules)
    assert once.numbers == again.numbers
    other = sinew.track(machine, motion, repeats=1, seed=5, rules=rules | {"bandwidth_rad_per_s": 2.0})
    assert other.numbers["joint_error_rad"] != once.numbers["joint_error_rad"]


def test_injected_faults_are_found_and_named_in_the_numbers() -> None:
    machine = sinew.Machine("bench_joint")
    muscle = machine.muscle_names[0]
    rules = sinew.verify(machine, "tour", repeats=1)
    bridged = sinew.track(machine, "tour", repeats=1, rules=rules, faults=f"load-cell:{muscle}:lost@5")
    assert bridged.completed and muscle in bridged.numbers["incidents"][0]["what"]
    assert 5.0 <= bridged.numbers["incidents"][0]["from_s"] < 5.1
    both = [f"load-cell:{muscle}:lost@4+1", f"cable:{muscle}@6"]
    stopped = sinew.track(machine, "tour", repeats=1, rules=rules, faults=both)
    assert not stopped.completed and muscle in stopped.numbers["reason"]


def test_a_run_takes_the_name_of_a_machine_and_names_what_is_wrong() -> None:
    with pytest.raises(TypeError, match="seed must be a whole number of at least 0, but is None"):
        sinew.track("bench_joint", "tour", seed=None)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="hold_s is 'long', which is of the wrong kind: must be real number"):
        sinew.track("bench_joint", "tour", hold_s="long")  # type: ignore[arg-type]
    for call in (sinew.demo_logs, lambda seed: sinew.identify([], seed=seed), lambda seed: sinew.reproduce(seed=seed)):
        with pytest.raises(TypeError, match="seed must be a whole number of at least 0, but is None"):
            call(None)  # type: ignore[arg-type, no-untyped-call]
    rules = sinew.verify("bench_joint", "tour", repeats=1)
    assert sinew.track("bench_joint", "tour", rules=rules).machine == "bench_joint"


def test_a_run_can_be_plotted() -> None:
    pytest.importorskip("matplotlib")
    run = sinew.track(sinew.Machine("planar_leg"), "tour", repeats=1)
    figure = run.plot()
    assert len(figure.axes) == 2 and len(figure.axes[1].lines) == len(run.muscle_names)
    named = [[text.get_text() for text in axes.get_legend().get_texts()] for axes in figure.axes]
    assert named[1] == list(run.muscle_names) and named[0]
    assert figure.axes[0].get_title() == "planar_leg, simulated: as planned" and "planar_leg: as_planned" in repr(run)
    bench = sinew.track(sinew.Machine("bench_joint"), "tour", repeats=1)
    # The file's own joints; as if it had been stopped.
    end = {"ended": "stopped", "reason": "a cable is slack", "stopped_s": 3.0}
    stopped = dataclasses.replace(bench, numbers=bench.numbers | end)
    above, below = stopped.plot().axes
    assert above.get_title() == "bench_joint, simulated: stopped: a cable is slack"
    assert [text.get_text() for text in above.get_legend().get_texts()] == ["lever", "stopped at 3.00 s"]
    assert above.get_ylabel().startswith("joint error, mrad") and below.lines[-1].get_xdata()[0] == 3.0


def test_a_model_is_plotted_with_its_candidates_or_its_prediction(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    logs = []
    for name, text in list(sinew.demo_logs().items())[:2]:
        logs.append(tmp_path / name)
        logs[-1].write_text(text, encoding="utf-8")
    model = sinew.identify(logs, far="tension_out_n", models=["linear", "cell"])
    compared = model.plot().axes[0]
    assert {text.get_text() for text in compared.get_yticklabels()} >= {"linear", "cell"}
    assert [text.get_text() for text in compared.get_legend().get_texts()] == ["chosen", "other candidates"]
    read = sinew.Model.from_json(model.to_json())
    predicted = read.plot(logs[0]).axes[0]
    assert np.array_equal(predicted.lines[0].get_ydata(), read.predict(logs[0]).mean)
    table = columns_of(logs[0])
    # Numbers alone are no log by which training is known.
    for log, note in ((logs[0], ", was fitted to it"), (table, "")):
        axes = read.plot(log).axes[0]
        assert np.array_equal(axes.lines[-1].get_ydata(), table["tension_out_n"])
        assert axes.get_ylabel() == "tension_out_n, N" and re.fullmatch(f"cell: RMSE [0-9.]+ N{note}", axes.get_title())
        low, high = axes.get_ylim()
        assert low < table["tension_out_n"].min() and high < table["tension_out_n"].max() + 60.0
    del table["tension_out_n"]
    blind = read.plot(table).axes[0]
    assert blind.get_title() == "cell: nothing measured to compare" and "measured" not in blind.get_legend_handles_labels()[1]
    with pytest.raises(ValueError, match="read from a file"):
        read.plot()


def test_a_model_that_is_not_to_be_used_says_so() -> None:
    draw, time = np.random.default_rng(1), 0.01 * np.arange(2000)
    logs = [
        {"time_s": time, "tension_in_n": 50.0 + 20.0 * np.sin(time), "tension_out_n": draw.normal(50.0, 20.0, 2000)}
        for _ in range(2)
    ]
    with pytest.warns(UserWarning, match="Do not use the model, because its error on unseen data is"):
        model = sinew.identify(logs, models=["linear"])
    assert model.grade == "do_not_use" and model.advice[0].startswith("Do not use")
    assert repr(model).endswith("DO NOT USE)")
    read = sinew.Model.from_json(model.to_json())
    assert read.grade is None and read.advice == () and "USE" not in repr(read)


def test_another_package_of_the_same_name_is_noticed(tmp_path: Path) -> None:
    (tmp_path / "sinew").symlink_to(Path(sinew.__file__).parent)
    command = [sys.executable, "-c", "import sinew; print(sinew.__file__)"]

    def said() -> subprocess.CompletedProcess[str]:
        return subprocess.run(command, env={"PYTHONPATH": str(tmp_path)}, capture_output=True, text=True, check=True)

    alone = said()
    assert alone.stdout.startswith(str(tmp_path)) and not alone.stderr
    (tmp_path / "sinew-0.0.1.dist-info").mkdir()
    assert "UserWarning: sinew-0.0.1 of another project" in said().stderr


def test_import_is_quick_and_brings_numpy_alone() -> None:
    code = "import sys, sinew; print(*{name.split('.')[0] for name in sys.modules})"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not {"pandas", "polars", "matplotlib", "hypothesis"} & set(loaded)

    def least(code: str) -> float:
        def once() -> float:
            began = time.perf_counter()
            subprocess.run([sys.executable, "-c", code], check=True)
            return time.perf_counter() - began

        return min(once() for _ in range(5))

    # NumPy alone takes most of it; the rest has to stay small on a busy machine as well.
    assert least("import sinew") - least("import numpy") < 0.1
