"""What specimens cost in worlds of a machine: time of an action with those of the design and with drawn ones, and memory.

    python python/benches/machine_worlds.py [MACHINE [WORLDS [ROUNDS]]]

Both are timed in turn, by the processor's time where the worlds are on it; the ratio is the median over pairs.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np
import warp as wp

from sinew.gym import Randomisation
from sinew.warp.gym import MachineVectorEnv


def bytes_of(value: Any, seen: set[int], depth: int = 4) -> int:
    """Memory of all arrays within a value, each counted once."""
    if isinstance(value, wp.array):
        known = value.ptr is None or value.ptr in seen
        seen.add(value.ptr)
        return 0 if known else int(value.capacity)
    if hasattr(value, "_ctype"):  # a structure of kernels
        return sum(bytes_of(getattr(value, name), seen, depth) for name in value._cls.vars)
    parts = getattr(value, "__dict__", {}) if depth else {}
    return sum(bytes_of(one, seen, depth - 1) for one in parts.values())


def main(machine: str = "lm_arm", worlds: int = 64, rounds: int = 25) -> None:
    """Prints times and memory."""
    kinds = {"design": Randomisation.none(), "specimens": Randomisation()}
    known: dict[str, Any] = {"machine": machine, "autoreset_mode": "Disabled", "steps": 10**6}
    envs = {name: MachineVectorEnv(worlds, randomisation=kind, **known) for name, kind in kinds.items()}
    clock = time.perf_counter if wp.get_device().is_cuda else time.process_time
    random = np.random.default_rng(0)
    times: dict[str, list[float]] = {name: [] for name in envs}
    for name, env in envs.items():
        began = clock()
        env.reset(seed=1)
        print(f"{machine}, {worlds} worlds, {name}: reset {clock() - began:.2f} s", flush=True)
    for turn in range(rounds + 2):
        actions = random.uniform(-0.3, 0.3, (worlds, envs["design"].environments.actions))
        for name, env in envs.items():
            began = clock()
            env.step(actions)
            wp.synchronize()
            if turn > 1:  # kernels are loaded in the first, captured in the second
                times[name].append(clock() - began)
    ratio = np.median(np.array(times["specimens"]) / np.array(times["design"]))
    milliseconds = {name: 1e3 * np.median(seen) for name, seen in times.items()}
    print(f"an action: {milliseconds['design']:.2f} ms by the design, {milliseconds['specimens']:.2f} ms with specimens, ratio {ratio:.3f}")
    for name, env in envs.items():
        many: Any = env.environments
        seen: set[int] = set()
        parts = {"MuJoCo Warp's data": many.d, "model": many.m, "cables, drives, sensors, specimen": many._part}
        sizes = {part: bytes_of(value, seen) / worlds / 1e3 for part, value in parts.items()}
        print(f"{name}, kB a world: " + ", ".join(f"{part} {size:.1f}" for part, size in sizes.items()))


if __name__ == "__main__":
    wp.config.log_level = getattr(wp, "LOG_WARNING", 30)
    main(*sys.argv[1:2], *map(int, sys.argv[2:4]))
