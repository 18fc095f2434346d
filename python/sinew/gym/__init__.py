"""Environments for reinforcement learning on simulated machines whose motors pull cables through sheaths.

Importing this module registers `sinew/Reach-v0`, `sinew/Track-v0`, `sinew/Hold-v0` and `sinew/BenchJoint-v0` with Gymnasium, each as
one environment and as a vector environment. Needs `pip install gymnasium`, version 1.1 or newer. See docs/gym.md. Everything is
simulated.
"""

import gymnasium

from ._conditions import Conditions, ObservationPart, Randomisation
from ._one import MachineEnv
from ._vector import MachineVectorEnv

__all__ = ["Conditions", "MachineEnv", "MachineVectorEnv", "ObservationPart", "Randomisation"]


def _register() -> None:
    for name, machine, task in [
        ("Reach", "lm_arm", "reach"),
        ("Track", "lm_arm", "track"),
        ("Hold", "lm_arm", "hold"),
        ("BenchJoint", "bench_joint", "reach"),
    ]:
        gymnasium.register(
            f"sinew/{name}-v0",
            entry_point="sinew.gym:MachineEnv",
            vector_entry_point="sinew.gym:MachineVectorEnv",
            kwargs={"machine": machine, "task": task},
        )


_register()
