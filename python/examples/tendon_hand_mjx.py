"""A finger on two tendons in 64 worlds of MJX, each with a friction of its own: an environment as MuJoCo Playground writes them.

Run: `python python/examples/tendon_hand_mjx.py`. Needs MJX (`pip install mujoco-mjx`). Prints how far a policy without feedback
closes the finger where friction differs, and the reward that it gets.
"""

from __future__ import annotations

from pathlib import Path
from runpy import run_path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import mujoco
import mujoco.mjx as mjx
import numpy as np

import sinew.batch
import sinew.mjx

FINGER: str = run_path(str(Path(__file__).with_name("tendon_hand.py")))["FINGER"]


class State(NamedTuple):
    """Of an episode; one of Playground has the same fields and more."""

    data: Any
    obs: Any
    reward: Any


class Reach:
    """The knuckle is to reach an angle; the action is the difference of the tensions, N."""

    substeps, goal, rest = 20, 0.6, 4.0

    def __init__(self, sheath: sinew.batch.Sheath) -> None:
        model = sinew.batch.prepare(mujoco.MjModel.from_xml_string(FINGER), {"*": sheath})
        #: What a randomisation replaces and maps over: the model of MJX and its sheaths.
        self.model = sinew.mjx.put_model(model)

    def reset(self) -> State:
        """Begins at rest."""
        data = mjx.make_data(self.model[0])
        return State(data, self._observed(data), jnp.zeros(()))

    def step(self, model: Any, state: State, action: Any) -> State:
        """One action; `model` is `self.model`, or one of many that are randomised."""
        tensions = self.rest + jnp.array([0.5, -0.5]) * action
        data = sinew.mjx.env_step(model, state.data, tensions, self.substeps)
        return State(data, self._observed(data), -jnp.abs(data.qpos[0] - self.goal))

    def _observed(self, data: Any) -> Any:
        return jnp.concatenate([data.qpos, data.qvel])


def main(worlds: int = 64, actions: int = 50) -> None:
    """Prints the knuckle's angle over friction."""
    environment = Reach(sinew.batch.Sheath(mu=0.08, bend=4.0))
    mx, sheaths = environment.model
    random = np.random.default_rng(1)
    # Domain randomisation: friction of every world and tendon.
    sheaths = sheaths.set(mu=np.sort(random.uniform(0.0, 0.2, (worlds, 1)), 0).repeat(len(sheaths.names), 1))
    pulls = jnp.concatenate([jnp.linspace(0.0, 5.0, actions // 2), jnp.full(actions - actions // 2, 3.0)])

    def episode(sheaths: Any) -> Any:
        def one(state: State, action: Any) -> tuple[State, Any]:
            state = environment.step((mx, sheaths), state, action)
            return state, state.reward

        last, rewards = jax.lax.scan(one, environment.reset(), pulls)
        return last.data.qpos[0], rewards.mean()

    angle, reward = jax.jit(jax.vmap(episode, in_axes=(sheaths.axes,)))(sheaths)
    print("mu        knuckle, rad   mean reward")
    for k in range(0, worlds, max(worlds // 8, 1)):
        print(f"{float(sheaths.mu[k, 0]):.3f}   {float(angle[k]):12.3f}   {float(reward[k]):12.3f}")
    print(f"the same tensions close the finger by {float(angle.min()):.3f} to {float(angle.max()):.3f} rad")


if __name__ == "__main__":
    main()
