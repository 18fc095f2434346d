"""docs/model.schema.json describes every model file, and nothing that the program refuses."""

from __future__ import annotations

import json
import warnings
import zlib
from pathlib import Path
from typing import Any

import pytest

import sinew

jsonschema = pytest.importorskip("jsonschema")

ROOT = Path(__file__).parents[2]
VALIDATOR = jsonschema.Draft202012Validator(json.loads((ROOT / "docs/model.schema.json").read_text()))

def written(model: dict[str, Any]) -> str:
    """A model file with its checksum."""
    text = json.dumps(model, separators=(",", ":"))
    checksum = f"{zlib.crc32(text.encode()):08x}"
    return f'{{"format":"sinew transmission model","version":1,"checksum":"{checksum}","model":{text}}}'


def objects(value: Any) -> list[dict[str, Any]]:
    """All objects in a document."""
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else []
    found = [value] if isinstance(value, dict) else []
    return found + [one for part in inner for one in objects(part)]


@pytest.fixture(scope="module", params=["linear", "constant", "cells", "hybrid", "paper", "observer-network", "inertia"])
def document(request: pytest.FixtureRequest, log_files: list[Path]) -> dict[str, Any]:
    """A model file of one kind of candidate."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # A constant is not to be used.
        model = sinew.identify(log_files[:2], far="tension_out_n", models=[request.param])
    return json.loads(model.to_json())  # type: ignore[no-any-return]


def test_every_kind_of_model_file_is_described(document: dict[str, Any]) -> None:
    VALIDATOR.validate(document)
    again = json.loads(sinew.Model.from_json(written(document["model"])).to_json())
    assert again["model"] == document["model"]


def test_a_key_that_is_missing_or_unknown_is_refused_by_both(document: dict[str, Any]) -> None:
    for index in range(len(objects(document["model"]))):
        for change in ("missing", "unknown"):
            damaged = json.loads(json.dumps(document))
            target = objects(damaged["model"])[index]
            if change == "unknown":
                target["colour"] = 1.0
            elif target:
                del target[sorted(target)[0]]
            described = VALIDATOR.is_valid(damaged)
            try:
                sinew.Model.from_json(written(damaged["model"]))
                read = True
            except ValueError:
                read = False
            assert described or not read, f"{change} in {target}: read, but not described"
            assert not (described and change == "unknown"), f"{target}"


def test_parts_that_only_some_models_have_are_described(document: dict[str, Any]) -> None:
    check = {
        "quantity": "height",
        "terms": ["level_squared", {"given": 0}],
        "mean": [1.0, 0.0],
        "inverse_scale": [0.5, 2.0],
        "offset": 3.0,
        "weights": [0.1, 0.2],
        "covariance": [1.0, 0.0, 0.0, 1.0],
        "trials": 20,
        "deviation": 0.3,
        "scatter": 0.01,
        "limit": 5.0,
    }
    parts = {
        "specimen": {"effort": 0, "motion": 0, "reversal": 0.1, "checks": [check]},
        "outside": {"band_factor": 4.0, "sides": [{"column": "load", "outermost": 60.0, "step": -10.0, "rmse": 0.5}]},
        "offset": {"between": 0.4, "within": 0.1},
    }
    model = {**document["model"], **parts}
    VALIDATOR.validate({**document, "model": model})
    again = json.loads(sinew.Model.from_json(written(model)).to_json())["model"]
    assert {name: again[name] for name in parts} == parts
