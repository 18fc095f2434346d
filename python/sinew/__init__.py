"""Robots whose muscles are motors pulling cables through sheaths: identify, simulate, control.

Units are SI and radians. Arrays of float64 in C order are read without a copy, other numbers with one.
"""

import warnings
from pathlib import Path as _Path

# Another project's package has the import name, too, and files of one replace files of the other.
for _other in _Path(__file__).parents[1].glob("sinew-*.dist-info"):
    warnings.warn(
        f"{_other.stem} of another project is installed beside sinew-robotics, under the same import name: "
        "`pip uninstall sinew sinew-robotics`, then `pip install sinew-robotics`",
        stacklevel=2,
    )

from ._cable import Cable, Free, Pulley, Sheath
from ._experiment import Reproduction, Run, reproduce, track, verify
from ._machine import Distribution, Machine, Routing, _load_machine, distribute
from ._model import Evaluation, Model, Predictions, Scores, demo_logs, identify
from ._sinew import (
    CableEnds,
    Command,
    Compensator,
    Controller,
    NearCommand,
    Prediction,
    Predictor,
    Trajectory,
    Twin,
    TwinBatch,
    __version__,
)

__all__ = [
    "Cable",
    "CableEnds",
    "Command",
    "Compensator",
    "Controller",
    "Distribution",
    "Evaluation",
    "Free",
    "Machine",
    "Model",
    "NearCommand",
    "Prediction",
    "Predictions",
    "Predictor",
    "Pulley",
    "Reproduction",
    "Routing",
    "Run",
    "Scores",
    "Sheath",
    "Trajectory",
    "Twin",
    "TwinBatch",
    "__version__",
    "demo_logs",
    "distribute",
    "identify",
    "reproduce",
    "track",
    "verify",
]
