"""A finger on two tendons in MuJoCo Playground, 64 worlds of MJX, each with a friction of its own.

Run: `python python/examples/tendon_hand_mjx.py`. Needs Playground (`pip install playground`). The environment is one of
Playground's, and its wrapper randomises friction and begins episodes again. Prints how far a policy without feedback closes the
finger where friction differs, and the reward that it gets.
"""

from __future__ import annotations

from pathlib import Path
from runpy import run_path
from typing import Any

import jax
import jax.numpy as jnp
import mujoco
import mujoco.mjx as mjx
import numpy as np
from ml_collections import config_dict  # type: ignore[import-not-found, import-untyped, unused-ignore]
from mujoco_playground import MjxEnv, State, wrapper  # type: ignore[import-not-found, import-untyped, unused-ignore]

import sinew.batch
import sinew.mjx

HAND = Path(__file__).parents[2] / "crates/sinew-cli/examples/training/tendon_hand.py"
FINGER: str = run_path(str(HAND))["FINGER"]


class Reach(MjxEnv):  # type: ignore[misc, unused-ignore]
    """The knuckle is to reach an angle; the action is the difference of the tensions, N."""

    goal, rest = 0.6, 4.0

    def __init__(self, sheath: sinew.batch.Sheath) -> None:
        super().__init__(config_dict.create(ctrl_dt=0.02, sim_dt=0.001))
        self._mj_model = sinew.batch.prepare(mujoco.MjModel.from_xml_string(FINGER), {"*": sheath})
        # The model of MJX and its sheaths: what Playground's wrapper hands to a randomisation, and maps over.
        self._mjx_model = sinew.mjx.put_model(self._mj_model)

    def reset(self, rng: Any) -> State:
        """Begins at rest."""
        data = mjx.make_data(self._mjx_model[0])
        return State(data, self._observed(data), jnp.zeros(()), jnp.zeros(()), {}, {})

    def step(self, state: State, action: Any) -> State:
        """One action."""
        tensions = self.rest + jnp.array([0.5, -0.5]) * action[0]
        data = sinew.mjx.env_step(self._mjx_model, state.data, tensions, self.n_substeps)
        done = jnp.isnan(data.qpos).any().astype(jnp.float32)
        return state.replace(data=data, obs=self._observed(data), reward=-jnp.abs(data.qpos[0] - self.goal), done=done)

    def _observed(self, data: Any) -> Any:
        return jnp.concatenate([data.qpos, data.qvel])

    @property
    def xml_path(self) -> str:
        return str(HAND)

    @property
    def action_size(self) -> int:
        return 1

    @property
    def mj_model(self) -> mujoco.MjModel:
        return self._mj_model

    @property
    def mjx_model(self) -> Any:
        return self._mjx_model


def main(worlds: int = 64, actions: int = 50, episode: int = 50) -> np.ndarray:
    """Prints the knuckle's angle over friction; returns the angles after every action, rad, shape `(actions, worlds)`."""
    mu = np.sort(np.random.default_rng(1).uniform(0.0, 0.2, worlds))

    def randomised(model: Any) -> tuple[Any, Any]:
        mx, sheaths = model
        sheaths = sheaths.set(mu=np.tile(mu[:, None], (1, len(sheaths.names))))
        return (mx, sheaths), (None, sheaths.axes)

    env = wrapper.wrap_for_brax_training(Reach(sinew.batch.Sheath(mu=0.08, bend=4.0)), episode, randomization_fn=randomised)
    pulls = jnp.concatenate([jnp.linspace(0.0, 5.0, actions // 2), jnp.full(actions - actions // 2, 3.0)])

    def one(state: State, pull: Any) -> tuple[State, Any]:
        state = env.step(state, jnp.full((worlds, 1), pull))
        return state, (state.data.qpos[:, 0], state.reward)

    first = jax.jit(env.reset)(jax.random.split(jax.random.PRNGKey(0), worlds))
    _, (angles, rewards) = jax.jit(lambda state: jax.lax.scan(one, state, pulls))(first)
    angles, rewards = np.asarray(angles), np.asarray(rewards)
    # The wrapper begins an episode again at once: the last action of an episode shows its first pose.
    last = min(actions, episode) - 2
    print("mu        knuckle, rad   mean reward")
    for k in range(0, worlds, max(worlds // 8, 1)):
        print(f"{mu[k]:.3f}   {angles[last, k]:12.3f}   {rewards[: last + 1, k].mean():12.3f}")
    print(f"the same tensions close the finger by {angles[last].min():.3f} to {angles[last].max():.3f} rad")
    return angles


if __name__ == "__main__":
    main()
