"""Tension distribution: `sinew tension` against DAQP, quadprog and a least-squares oracle on random problems.

    tension.py SINEW [PROBLEMS]

SINEW is the program. Prints, for every kind of problem, the largest difference of the answers relative to the largest
tension; then times. DAQP's times are those its C code takes of itself, set-up and solve, the least of several runs.
"""

import json
import subprocess
import sys
import tempfile

import daqp
import numpy as np
import quadprog
from scipy.optimize import lsq_linear

SIZES = [(2, 1), (3, 2), (6, 3), (8, 4), (15, 7), (20, 3), (30, 12), (63, 20), (100, 30)]
KINDS = ["plain", "grouped", "sparse", "ill", "degenerate", "beyond"]
REPEATS = 7


def problem(rng, kind, muscles, joints):
    arms = 0.04 * rng.normal(size=(muscles, joints))
    if kind == "grouped":
        group = np.arange(joints) // 3
        arms[group[None, :] != group[np.arange(muscles) % joints][:, None]] = 0.0
    if kind == "sparse":
        arms[rng.random(arms.shape).argsort(axis=1) >= 3] = 0.0
    if kind == "ill":
        for j in range(1, joints):
            arms[:, j] = 10.0 ** -(j % 3) * (arms[:, 0] + 0.05 * arms[:, j])
    if kind == "degenerate":
        twice = rng.integers(muscles, size=max(1, muscles // 4))
        arms[rng.integers(muscles, size=twice.size)] = arms[twice]
        arms[rng.integers(muscles, size=max(1, muscles // 8))] = 0.0
    low = 20.0 * rng.random(muscles)
    high = low + 50.0 + 350.0 * rng.random(muscles)
    torque = arms.T @ (low + (high - low) * rng.random(muscles))
    if kind == "beyond":
        torque += 0.04 * high.sum() * rng.random() * rng.normal(size=joints)
    return {
        "moment_arms": arms.tolist(),
        "torque_nm": torque.tolist(),
        "min_n": low.tolist(),
        "max_n": high.tolist(),
        "reference_n": (100.0 * rng.random(muscles) * rng.integers(2, size=muscles)).tolist(),
        "weight": (10.0 ** (rng.random(muscles) - 0.5)).tolist(),
    }


def matrices(p):
    """`min 1/2 F'HF + f'F` with the limits first and the torques after them, as DAQP has it."""
    weight, reference = np.array(p["weight"]), np.array(p["reference_n"])
    arms, torque = np.array(p["moment_arms"]), np.array(p["torque_nm"])
    upper, lower = np.r_[p["max_n"], torque], np.r_[p["min_n"], torque]
    sense = np.r_[np.zeros(weight.size), np.full(torque.size, 5)].astype(np.int32)
    return np.diag(weight), -weight * reference, np.ascontiguousarray(arms.T), upper, lower, sense


def by_daqp(h, f, a, upper, lower, sense):
    """Answer and least time, or none where it gives up."""
    best = np.inf
    for _ in range(REPEATS):
        x, _, flag, info = daqp.solve(h, f, a, upper, lower, sense.copy(), primal_tol=1e-11, dual_tol=1e-12)
        best = min(best, info["setup_time"] + info["solve_time"])
    return (np.array(x), best) if flag == 1 else (None, best)


def by_quadprog(h, f, a, upper, lower, joints):
    muscles = len(f)
    eye = np.eye(muscles)
    normals = np.hstack([a.T, eye, -eye])
    bounds = np.r_[upper[muscles:], lower[:muscles], -upper[:muscles]]
    try:
        return quadprog.solve_qp(h, -f, normals, bounds, joints)[0]
    except ValueError:
        return None


def full_rank(a):
    """Answers of active-set methods are compared where the torques are independent; others refuse or wander."""
    values = np.linalg.svd(a, compute_uv=False)
    return a.shape[0] <= a.shape[1] and values[-1] > 1e-10 * values[0]


def solve_all(program, problems):
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump({"problems": problems}, file)
        file.flush()
        runs = [subprocess.run([program, "tension", file.name, "--json"], capture_output=True, check=True)
                for _ in range(REPEATS)]
    runs = [json.loads(run.stdout)["solutions"] for run in runs]
    for k, solution in enumerate(runs[0]):
        solution["seconds"] = min(run[k]["seconds"] for run in runs)
    return runs[0]


def compare(p, solution, worst, count):
    tension, residual = np.array(solution["tension_n"]), np.array(solution["residual_nm"])
    h, f, a, upper, lower, sense = matrices(p)
    torque = np.array(p["torque_nm"])
    size = np.abs(tension).max()
    if solution["status"] == "infeasible":
        count["infeasible"] += 1
        # The closest torque; then the same question for a torque that can be reached.
        oracle = lsq_linear(a, torque, (lower[: len(f)], upper[: len(f)] + 1e-12), method="bvls", tol=1e-15)
        gap = (np.linalg.norm(residual) - np.linalg.norm(oracle.fun)) / np.linalg.norm(torque)
        worst["residual above least squares"] = max(worst["residual above least squares"], gap)
        return None
    x, seconds = by_daqp(h, f, a, upper, lower, sense)
    cost = lambda t: (np.array(p["weight"]) * (t - np.array(p["reference_n"])) ** 2).sum()
    for name, other in [("daqp", x), ("quadprog", by_quadprog(h, f, a, upper, lower, len(torque)))]:
        if other is None or not full_rank(a):
            count[name + " without answer"] += 1
            continue
        missed = np.abs(a @ other - torque).max() / np.abs(torque).max()
        apart = np.abs(other - tension).max() / size
        count[name + " misses the torque by more than 1e-10"] += int(missed > 1e-10)
        if missed <= 1e-10:
            worst[name] = max(worst[name], apart)
            worst[name + ", cost"] = max(worst[name + ", cost"], (cost(tension) - cost(other)) / cost(other))
    return seconds


class Zero(dict):
    def __missing__(self, key):
        return 0


def main():
    program, total = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 10_000
    rng = np.random.default_rng(20261121)
    each = -(-total // (len(SIZES) * len(KINDS)))
    times = {}
    for kind in KINDS:
        worst, count = Zero(), Zero()
        for size in SIZES:
            problems = [problem(rng, kind, *size) for _ in range(each)]
            for p, solution in zip(problems, solve_all(program, problems)):
                seconds = compare(p, solution, worst, count)
                if seconds is not None:
                    times.setdefault((kind, size), []).append((solution["seconds"], seconds))
        print(f"{kind}: {each * len(SIZES)} problems; {dict(count)}")
        for name, value in worst.items():
            print(f"    {name}: {value:.1e}")
    print("times, us: median of Sinew cold from the file's problem, of DAQP's set-up and solve, ratio")
    for (kind, size), pairs in times.items():
        ours, theirs = 1e6 * np.median(np.array(pairs), axis=0)
        print(f"    {kind} {size[0]}x{size[1]}: {ours:.2f} {theirs:.2f} {ours / theirs:.2f}")


if __name__ == "__main__":
    main()
