"""Tension distribution: `sinew design tension` against DAQP, quadprog and a least-squares oracle on random problems.

    tension.py SINEW CLARABEL [PROBLEMS]

SINEW is the program, CLARABEL the one in tension_clarabel. Prints, for every kind of problem, the largest difference of
the answers relative to the largest tension; where one exceeds 1e-9, who is nearer to the optimum in exact arithmetic; then
times. DAQP's times are those its C code takes of itself, set-up and solve, the smallest of several runs.
"""

import json
import subprocess
import sys
import tempfile
from fractions import Fraction

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


def solve_all(program, clarabel, problems):
    """Solutions with the least time of each over several runs, and what Clarabel's program says to them."""
    with tempfile.TemporaryDirectory() as folder:
        asked, answered = folder + "/problems.json", folder + "/solutions.json"
        with open(asked, "w") as file:
            json.dump({"problems": problems}, file)
        runs = [subprocess.run([program, "design", "tension", asked, "--json"], capture_output=True)
                for _ in range(REPEATS)]
        with open(answered, "wb") as file:
            file.write(runs[0].stdout)
        said = subprocess.run([clarabel, asked, answered], capture_output=True, check=True, text=True).stdout
    runs = [json.loads(run.stdout)["solutions"] for run in runs]
    for k, solution in enumerate(runs[0]):
        solution["seconds"] = min(run[k]["seconds"] for run in runs)
    return runs[0], said


def exact(p, tension):
    """The optimum with the same muscles at their limits, in fractions; none where these are not the optimum's."""
    low, high = p["min_n"], p["max_n"]
    free = [i for i, t in enumerate(tension) if low[i] < t < high[i]]
    arms = [[Fraction(a) for a in row] for row in p["moment_arms"]]
    weight, reference = [Fraction(w) for w in p["weight"]], [Fraction(r) for r in p["reference_n"]]
    n = len(p["torque_nm"])
    rows = []
    for j in range(n):
        right = Fraction(p["torque_nm"][j])
        right -= sum(arms[i][j] * (reference[i] if i in free else Fraction(t)) for i, t in enumerate(tension))
        rows.append([sum(arms[i][j] * arms[i][k] / weight[i] for i in free) for k in range(n)] + [right])
    for k in range(n):
        pivot = next((r for r in range(k, n) if rows[r][k] != 0), None)
        if pivot is None:
            return None
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for r in range(n):
            if r != k and rows[r][k] != 0:
                rows[r] = [x - rows[r][k] * y for x, y in zip(rows[r], rows[k])]
    best = []
    for i, t in enumerate(tension):
        desired = reference[i] + sum(a * row[n] for a, row in zip(arms[i], rows)) / weight[i]
        if (i in free) != (low[i] < desired < high[i]):
            return None
        best.append(float(desired) if i in free else t)
    return np.array(best)


def judge(p, ours, theirs, name, size):
    """Says who is right where two differ."""
    snap = lambda t: np.where(t - p["min_n"] < 1e-7 * size, p["min_n"], np.where(p["max_n"] - t < 1e-7 * size, p["max_n"], t))
    for start in (ours, snap(theirs)):
        best = exact(p, start.tolist())
        if best is not None:
            off = [np.abs(x - best).max() / size for x in (ours, theirs)]
            return f"from the exact optimum: Sinew {off[0]:.1e}, {name} {off[1]:.1e}"
    a, torque, weight, reference = (np.array(p[k], dtype=np.longdouble)
                                    for k in ("moment_arms", "torque_nm", "weight", "reference_n"))
    miss = [float(np.abs(a.T @ x - torque).max() / np.abs(torque).max()) for x in (ours, theirs)]
    cost = [float((weight * (x - reference) ** 2).sum()) for x in (ours, theirs)]
    return f"joints are linearly dependent: torque missed by {miss[0]:.1e}, {miss[1]:.1e}, cost {cost[0]:.15g}, {cost[1]:.15g}"


def compare(p, solution, worst, count):
    tension, residual = np.array(solution["tension_n"]), np.array(solution["residual_nm"])
    h, f, a, upper, lower, sense = matrices(p)
    torque = np.array(p["torque_nm"])
    size = np.abs(tension).max()
    if solution["status"] != "optimal":
        count[solution["status"]] += 1
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
        if apart > 1e-9:
            print(f"    {len(f)}x{len(torque)}: {name} {apart:.1e} apart; {judge(p, tension, other, name, size)}")
        if missed <= 1e-10:
            worst[name] = max(worst[name], apart)
            worst[name + ", cost"] = max(worst[name + ", cost"], (cost(tension) - cost(other)) / cost(other))
    return seconds


class Zero(dict):
    def __missing__(self, key):
        return 0


def main():
    program, clarabel = sys.argv[1:3]
    total = int(sys.argv[3]) if len(sys.argv) > 3 else 10_000
    rng = np.random.default_rng(20261121)
    each = -(-total // (len(SIZES) * len(KINDS)))
    times = {}
    for kind in KINDS:
        worst, count, clarabels = Zero(), Zero(), []
        for size in SIZES:
            problems = [problem(rng, kind, *size) for _ in range(each)]
            solutions, said = solve_all(program, clarabel, problems)
            clarabels.append(f"{size[0]}x{size[1]} {said}")
            for p, solution in zip(problems, solutions):
                seconds = compare(p, solution, worst, count)
                if seconds is not None:
                    times.setdefault((kind, size), []).append((solution["seconds"], seconds))
        print(f"{kind}: {each * len(SIZES)} problems; {dict(count)}")
        for name, value in worst.items():
            print(f"    {name}: {value:.1e}")
        print("    " + "    ".join(clarabels), end="")
    print("times, us: median of Sinew cold from the file's problem, of DAQP's set-up and solve, ratio")
    for (kind, size), pairs in times.items():
        ours, theirs = 1e6 * np.median(np.array(pairs), axis=0)
        print(f"    {kind} {size[0]}x{size[1]}: {ours:.2f} {theirs:.2f} {ours / theirs:.2f}")


if __name__ == "__main__":
    main()
