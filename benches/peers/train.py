"""The training of `train_paper`, by NumPy or by scikit-learn, on the same files.

Prints: seconds, steps, rejected steps, final mean squared error, peak memory in MB.
"""

import argparse
import resource
import sys
import time
import warnings
from pathlib import Path

import numpy as np

INPUTS, HIDDEN = 4, 30


def levenberg_marquardt(inputs, targets, theta, steps, block):
    """Full-batch Levenberg-Marquardt as train() of sinew-identify does it: same damping rule, same start."""
    n = len(targets)
    mean, scale = inputs.mean(0), inputs.std(0)
    target_mean, target_scale = targets.mean(), targets.std()
    x = (inputs - mean) / scale
    t = (targets - target_mean) / target_scale
    k, h = INPUTS, HIDDEN
    blocks = [slice(at, min(at + block, n)) for at in range(0, n, block)]

    def parts(theta):
        return theta[: h * k].reshape(h, k), theta[h * k : h * k + h], theta[h * k + h : -1], theta[-1]

    def loss_at(theta):
        weights, bias, output, offset = parts(theta)
        total = 0.0
        for rows in blocks:
            nodes = x[rows] @ weights.T
            nodes += bias
            np.tanh(nodes, out=nodes)
            residual = nodes @ output + offset - t[rows]
            total += residual @ residual
        return total / n

    jacobian = np.empty((block, len(theta)))

    def normal_equations(theta):
        weights, bias, output, offset = parts(theta)
        matrix, gradient = np.zeros((len(theta), len(theta))), np.zeros(len(theta))
        for rows in blocks:
            xb = x[rows]
            nodes = xb @ weights.T
            nodes += bias
            np.tanh(nodes, out=nodes)
            residual = nodes @ output + offset - t[rows]
            slope = (1.0 - nodes * nodes) * output
            j = jacobian[: len(xb)]
            np.multiply(slope[:, :, None], xb[:, None, :], out=j[:, : h * k].reshape(len(xb), h, k))
            j[:, h * k : h * k + h] = slope
            j[:, h * k + h : -1] = nodes
            j[:, -1] = 1.0
            matrix += j.T @ j  # NumPy sees the transpose of itself and calls syrk
            gradient += j.T @ residual
        return matrix / n, gradient / n

    damping, loss, rejected = 1e-3, loss_at(theta), 0
    for _ in range(steps):
        matrix, gradient = normal_equations(theta)
        refused = 0
        while True:
            trial = theta - np.linalg.solve(matrix + damping * np.eye(len(theta)), gradient)
            trial_loss = loss_at(trial)
            if trial_loss < loss:
                break
            refused += 1
            damping *= 10.0
            if damping > 1e10:
                return loss * target_scale**2, rejected + refused
        theta, loss, rejected = trial, trial_loss, rejected + refused
        if refused == 0:
            damping *= 0.1
    return loss * target_scale**2, rejected


def scikit_learn(inputs, targets, steps):
    """What scikit-learn offers for it: L-BFGS on the same network."""
    from sklearn.neural_network import MLPRegressor

    warnings.filterwarnings("ignore")
    x = (inputs - inputs.mean(0)) / inputs.std(0)
    t = (targets - targets.mean()) / targets.std()
    network = MLPRegressor(hidden_layer_sizes=(HIDDEN,), activation="tanh", solver="lbfgs", alpha=0.0, max_iter=steps, tol=0.0, random_state=0)
    network.fit(x, t)
    return np.mean((network.predict(x) - t) ** 2) * targets.std() ** 2, network.n_iter_


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("peer", choices=["numpy", "scikit-learn"])
    parser.add_argument("directory", type=Path)
    parser.add_argument("steps", type=int)
    parser.add_argument("--block", type=int, default=2000, help="rows of the Jacobian at a time; 2000 was fastest")
    arguments = parser.parse_args()
    inputs, targets, start = (np.fromfile(arguments.directory / f"{name}.f64") for name in ("inputs", "targets", "start"))
    inputs = inputs.reshape(-1, INPUTS)
    begin = time.perf_counter()
    if arguments.peer == "numpy":
        loss, rejected = levenberg_marquardt(inputs, targets, start, arguments.steps, arguments.block)
        steps = arguments.steps
    else:
        loss, steps = scikit_learn(inputs, targets, arguments.steps)
        rejected = 0
    seconds = time.perf_counter() - begin
    unit = 1024.0**2 if sys.platform == "darwin" else 1024.0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit
    print(f"{seconds:.3f} {steps} {rejected} {loss:.9e} {peak:.1f}")


if __name__ == "__main__":
    main()
