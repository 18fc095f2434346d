"""A policy for a joint between two cables, trained with and without the friction of their sheaths.

Run: `python train_policy.py [GENERATIONS [PAIRS [SEED [warp]]]]`. Needs gymnasium, and mujoco-warp where the
policy is to be trained in worlds of MuJoCo Warp. A linear policy commands the tensions of two drives
from their encoders and load cells and the joint's encoder; an evolution strategy after Salimans et al. (2017) trains it on
`sinew/BenchJoint-v0`, once on cables without friction and once on cables in their sheaths. Both are then evaluated on other
episodes of both kinds by the native twin, wherever they were trained. All data are simulated.
"""

from __future__ import annotations

import sys

import numpy as np
from numpy.typing import NDArray

from sinew.gym import MachineVectorEnv, Randomisation

Floats = NDArray[np.float64]

#: Without friction; with that of the design, which differs from episode to episode.
PLANTS = {"without friction": Randomisation(friction=(0.0, 0.0)), "with friction": Randomisation()}
STEPS = 200


def environment(plant: str, count: int, warp: bool = False) -> MachineVectorEnv:
    """Environments in which tensions are commanded every 10 ms for 2 s."""
    kind = MachineVectorEnv
    if warp:
        from sinew.warp.gym import MachineVectorEnv as Worlds

        kind = Worlds
    return kind(
        count,
        machine="bench_joint",
        task="reach",
        actuation="tension",
        steps=STEPS,
        effort=0.0,
        randomisation=PLANTS[plant],
        threads=2,
        copy=False,
        autoreset_mode="Disabled",
    )


def features(env: MachineVectorEnv, observations: NDArray[np.float32]) -> Floats:
    """Observations scaled to about one, with the difference of target and joint and a constant."""
    parts = env.observation_parts
    scale = {"motor": 0.05, "motor_rate": 0.2, "tension": 200.0, "joint": 1.0, "joint_rate": 3.0, "last_action": 1.0}
    columns = [observations[:, parts[name].start : parts[name].stop] / by for name, by in scale.items()]
    joint, target = (observations[:, parts[name].start : parts[name].stop] for name in ("joint", "target"))
    return np.concatenate([*columns, target - joint, np.ones_like(joint)], axis=1, dtype=np.float64)


def run(env: MachineVectorEnv, policies: Floats, seeds: list[int]) -> tuple[Floats, Floats]:
    """Mean reward of an episode of every environment under its own policy, and its mean error in the second half."""
    observations, _ = env.reset(seed=seeds)
    rewards, errors, alive = np.zeros(env.num_envs), np.zeros(env.num_envs), np.ones(env.num_envs, dtype=bool)
    for step in range(STEPS):
        actions = np.tanh(np.einsum("naf,nf->na", policies, features(env, observations)))
        observations, reward, terminated, _, infos = env.step(actions)
        rewards += np.where(alive, reward, 0.0) / STEPS
        if 2 * step >= STEPS:
            errors += infos["error"] / (STEPS / 2)
        if terminated.any() and step + 1 < STEPS:
            # An episode that failed earns nothing more, whatever follows.
            alive &= ~terminated
            observations, _ = env.reset(options={"reset_mask": terminated.copy()})
    return rewards, errors


def train(plant: str, generations: int, pairs: int, seed: int = 0, warp: bool = False) -> Floats:
    """A policy from so many generations of pairs of opposite changes, each pair on one episode."""
    random = np.random.default_rng(seed)
    env = environment(plant, 2 * pairs, warp)
    shape = env.environments.actions, features(env, env.reset(seed=0)[0]).shape[1]
    # From low tensions on, of which the policy knows nothing else.
    mean, speed = np.zeros(shape), np.zeros(shape)
    mean[:, -1] = -0.8
    for generation in range(generations):
        changes = random.normal(size=(pairs, *shape))
        size = 0.15 * 0.99**generation
        policies = mean + size * np.concatenate([changes, -changes])
        seeds = [int(s) for s in random.integers(1 << 31, size=pairs)] * 2
        rewards, _ = run(env, policies, seeds)
        ranks = np.empty(2 * pairs)
        ranks[np.argsort(rewards)] = np.linspace(-0.5, 0.5, 2 * pairs)
        gradient = np.tensordot(ranks[:pairs] - ranks[pairs:], changes, axes=1) / pairs
        speed = 0.8 * speed + 0.4 * gradient
        mean = mean + speed
        if generation % 10 == 9:
            print(f"  {plant}, generation {generation + 1}: mean reward {rewards.mean():.3f}", flush=True)
    env.close()
    return mean


def main(
    generations: int = 60, pairs: int = 48, seed: int = 0, episodes: int = 200, *, warp: bool = False
) -> dict[tuple[str, str], float]:
    """Trains, evaluates, prints; mean errors by training and evaluation, as a fraction of the joint's range."""
    found = {}
    for trained in PLANTS:
        policy = train(trained, generations, pairs, seed, warp)
        for tested in PLANTS:
            env = environment(tested, episodes)
            policies = np.broadcast_to(policy, (episodes, *policy.shape))
            rewards, errors = run(env, policies, [10**9 + k for k in range(episodes)])
            found[trained, tested] = float(errors.mean())
            error = 100 * errors.mean()
            print(f"trained {trained}, run {tested}: mean error {error:.1f} % of the range, reward {rewards.mean():.3f}")
            env.close()
    return found


if __name__ == "__main__":
    main(*map(int, sys.argv[1:4]), warp="warp" in sys.argv)
