"""Tension distribution where joints, arms, weights and limits differ by up to 18 decades: `sinew design tension` against a reference
in numbers of 1500 bits.

    tension_scaling.py SINEW [PROBLEMS] [SEED]

The reference is proved by weak duality: its dual value bounds the cost, its direction the least residual, from below, whatever
its own method. A claim of `sinew design tension` is wrong where its cost or its residual is above the bound by more than 1e-6 of it,
apart from 1e-13 of the terms of the torque, which is the rounding of tensions. Needs gmpy2 and numpy.
"""

import json
import subprocess
import sys
import tempfile

import gmpy2
import numpy as np
from gmpy2 import mpfr

gmpy2.get_context().precision = 1500
SIZES = [(2, 1), (3, 2), (6, 3), (8, 4), (15, 4), (15, 6), (15, 7), (20, 5)]
EPS = mpfr("1e-160")


def problem(rng):
    muscles, joints = SIZES[rng.integers(len(SIZES))]
    scales = lambda count: 10.0 ** ((9.0 if rng.random() < 0.5 else 0.0) * (2.0 * rng.random(count) - 1.0))
    column, row, weight, tension = scales(joints), scales(muscles), scales(muscles), scales(muscles)
    arms = 0.04 * rng.normal(size=(muscles, joints)) * row[:, None] * column[None, :]
    if rng.random() < 0.5:
        arms[rng.random(arms.shape) < 0.4] = 0.0
    low = 20.0 * rng.random(muscles) * tension
    high = low + (50.0 + 350.0 * rng.random(muscles)) * tension
    kind = rng.integers(4)
    part = rng.integers(2, size=muscles) if kind == 2 else rng.random(muscles)
    torque = arms.T @ (low + (high - low) * part)
    if kind == 3:
        torque *= 3.0 * rng.normal(size=joints)
    return {
        "moment_arms": arms.tolist(),
        "torque_nm": torque.tolist(),
        "min_n": low.tolist(),
        "max_n": high.tolist(),
        "reference_n": (100.0 * rng.random(muscles) * rng.integers(2, size=muscles) * tension).tolist(),
        "weight": weight.tolist(),
    }


class Reference:
    """Dual ascent with the regularization eps, proximal steps until the residual stays."""

    def __init__(self, p):
        big = lambda list: [mpfr(x) for x in list]
        self.arms = [[(j, mpfr(a)) for j, a in enumerate(row) if a != 0.0] for row in p["moment_arms"]]
        self.torque, self.low, self.high = big(p["torque_nm"]), big(p["min_n"]), big(p["max_n"])
        self.reference, self.weight = big(p["reference_n"]), big(p["weight"])
        self.n = len(self.torque)
        most = max([mpfr(0)] + [a * a / w for row, w in zip(self.arms, self.weight) for _, a in row])
        self.eps = EPS * (most or 1)

    def tensions(self, x):
        desired = [r + sum(a * x[j] for j, a in row) / w for r, row, w in zip(self.reference, self.arms, self.weight)]
        return desired, [min(max(u, l), h) for u, l, h in zip(desired, self.low, self.high)]

    def left(self, tensions):
        left = list(self.torque)
        for row, tension in zip(self.arms, tensions):
            for j, a in row:
                left[j] -= a * tension
        return left

    def newton(self, x, center):
        n = self.n
        for _ in range(500):
            desired, tensions = self.tensions(x)
            gradient = [r - self.eps * (a - b) for r, a, b in zip(self.left(tensions), x, center)]
            h = [[self.eps if i == j else mpfr(0) for j in range(n)] + [gradient[i]] for i in range(n)]
            for i, row in enumerate(self.arms):
                if self.low[i] < desired[i] < self.high[i]:
                    for j, a in row:
                        for k, b in row:
                            h[j][k] += a * b / self.weight[i]
            for k in range(n):
                for i in range(n):
                    if i != k and h[i][k] != 0:
                        f = h[i][k] / h[k][k]
                        h[i] = [p - f * q for p, q in zip(h[i], h[k])]
            step = [h[k][n] / h[k][k] for k in range(n)]
            length = self.line_search(x, center, step)
            x = [a + length * b for a, b in zip(x, step)]
            if abs(length - 1) < mpfr("1e-100"):
                after, _ = self.tensions(x)
                side = lambda u: [(a > l) + (a >= h) for a, l, h in zip(u, self.low, self.high)]
                if side(after) == side(desired):
                    return x
        return x

    def line_search(self, x, center, step):
        """Where the slope along the step, which falls, vanishes: by its breakpoints in order."""
        desired, _ = self.tensions(x)
        rate = [sum(a * step[j] for j, a in row) / w for row, w in zip(self.arms, self.weight)]

        def slope(s):
            at = [a + s * b for a, b in zip(x, step)]
            _, tensions = self.tensions(at)
            return sum(d * (r - self.eps * (a - b)) for d, r, a, b in zip(step, self.left(tensions), at, center))

        points = sorted(s for u, r, l, h in zip(desired, rate, self.low, self.high) if r != 0
                        for s in ((l - u) / r, (h - u) / r) if s > 0)
        first, last = 0, len(points)
        while first < last:
            middle = (first + last) // 2
            first, last = (middle + 1, last) if slope(points[middle]) > 0 else (first, middle)
        near = points[first - 1] if first > 0 else mpfr(0)
        far = points[first] if first < len(points) else near + 1
        a, b = slope(near), slope(far)
        return near + a / (a - b) * (far - near) if a != b else near

    def solve(self):
        """Dual value and lower bound of the residual's length."""
        zero = [mpfr(0)] * self.n
        x = self.newton(zero, zero)
        y = self.newton(x, x)
        _, tensions = self.tensions(y)
        left = self.left(tensions)
        return y, left

    def min_residual(self, d):
        length = gmpy2.sqrt(sum(a * a for a in d))
        if length == 0:
            return mpfr(0)
        pull = [sum(a * d[j] for j, a in row) for row in self.arms]
        reach = sum(max(p * l, p * h) for p, l, h in zip(pull, self.low, self.high))
        return (sum(a * b for a, b in zip(self.torque, d)) - reach) / length

    def cost(self, tensions):
        return sum(w * (t - r) ** 2 for w, t, r in zip(self.weight, tensions, self.reference)) / 2


def check(p, solution):
    """Class of the answer and what is wrong with it, if anything."""
    reference = Reference(p)
    tensions = [mpfr(t) for t in solution["tension_n"]]
    if solution["status"] == "not_converged":
        return "not converged", None
    if any(not l <= t <= h for l, t, h in zip(reference.low, tensions, reference.high)):
        return solution["status"], "limits"
    left = reference.left(tensions)
    scale = [abs(t) for t in reference.torque]
    for row, tension in zip(reference.arms, tensions):
        for j, a in row:
            scale[j] += abs(a * tension)
    norm = lambda x: gmpy2.sqrt(sum(a * a for a in x))
    if solution["status"] == "infeasible":
        _, d = reference.solve()
        least = max(reference.min_residual(d), mpfr(0))
        if least <= 0:
            return "infeasible", "is not proved to be out of reach"
        over = norm(left) - least
        if over > mpfr("1e-6") * least + mpfr("1e-13") * norm(scale):
            return "infeasible", f"residual {float(norm(left)):.6e}, least {float(least):.6e}, terms {float(norm(scale)):.1e}"
        return "infeasible", None
    missed = max([float(abs(r) / s) for r, s in zip(left, scale) if s > 0] or [0.0])
    if missed > 1e-12:
        return "optimal", f"misses the torque by {missed:.1e}"
    # The dual for the torque that is given: what rounding leaves of it is not held against the cost.
    reference.torque = [t - r for t, r in zip(reference.torque, left)]
    y, _ = reference.solve()
    desired, best = reference.tensions(y)
    dual = reference.cost(best) + sum(a * b for a, b in zip(y, reference.left(best)))
    cost = reference.cost(tensions)
    if cost - dual > mpfr("1e-6") * cost:
        return "optimal", f"cost {float(cost):.6e}, bound {float(dual):.6e}"
    return "optimal", None


def main():
    program = sys.argv[1]
    total = int(sys.argv[2]) if len(sys.argv) > 2 else 5000
    rng = np.random.default_rng(int(sys.argv[3]) if len(sys.argv) > 3 else 1)
    problems = [problem(rng) for _ in range(total)]
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump({"problems": problems}, file)
        file.flush()
        run = subprocess.run([program, "design", "tension", file.name, "--json"], capture_output=True)
    solutions = json.loads(run.stdout)["solutions"]
    counts, wrong = {}, 0
    for k, (p, solution) in enumerate(zip(problems, solutions)):
        kind, fault = check(p, solution)
        counts[kind] = counts.get(kind, 0) + 1
        if fault is not None:
            wrong += 1
            print(f"problem {k}, {len(p['min_n'])} x {len(p['torque_nm'])}, {kind}: {fault}", flush=True)
    seconds = np.array([solution["seconds"] for solution in solutions])
    print(f"{total} problems: {counts}, wrong {wrong}; ms: median {1e3 * np.median(seconds):.3f}, most {1e3 * seconds.max():.1f}")


if __name__ == "__main__":
    main()
