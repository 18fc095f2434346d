"""Parameters of a cable from tensions at its ends, and what tensions change with them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from ._cable import Law, profile, scaled, simulate

#: Lengths that are tried of a step, each half of the one before.
HALVINGS = 5
#: Largest change of a parameter in a step, as the logarithm of its factor.
FARTHEST = 1.0
#: Residuals so many times the median count half.
WIDTH = 3.0


class Fit(NamedTuple):
    """What an identification found."""

    #: The law with the parameters that were found.
    law: Law
    #: Factors on the fields of the law that it began with.
    factors: dict[str, float]
    #: Root of the mean square of the residuals, N, before the first step and after every one.
    rms_n: list[float]


def sensitivity(
    law: Law, interval_s: float, motor_m: Any, anchor_m: Any, start_n: tuple[Any, Any], parameters: Sequence[str]
) -> tuple[Any, Any]:
    """Tensions at both ends over time, N, shape `(steps, 2)`, and what they change with the logarithms of parameters, N, shape
    `(steps, 2, parameters)`.

    `start_n`: tensions at both ends before the first step. `parameters`: fields of the law, scaled as a whole; a change by one
    percent changes the tensions by a hundredth of the derivative. The derivatives are those of the discrete law: where a
    node is at its bound to the last bit there is none, and one side's is returned.
    """
    names = tuple(parameters)
    scaled(law, dict.fromkeys(names, 1.0))
    found: tuple[Any, Any] = _both(law, interval_s, jnp.asarray(motor_m), jnp.asarray(anchor_m), start_n, names)
    return found


def identify(
    law: Law,
    interval_s: float,
    motor_m: Any,
    anchor_m: Any,
    tension_in_n: Any,
    tension_out_n: Any,
    *,
    start_n: tuple[Any, Any] | None = None,
    parameters: Sequence[str] = ("friction", "compliance"),
    steps: int = 6,
) -> Fit:
    """The parameters of a cable from the motions and tensions of its ends, by Gauss-Newton steps on forward derivatives.

    `motor_m`, `anchor_m`: displacements in every step, m, and `tension_in_n`, `tension_out_n`: tensions after it, N, shapes
    `(steps,)`. `start_n`: tensions at both ends before the first step, N; by default those after it. `law`: where the search
    begins. `parameters`: which fields of it are scaled.

    The log has to show what is sought: without reversals of the motion, friction and compliance are not told apart.
    """
    measured = jnp.stack([jnp.asarray(tension_in_n), jnp.asarray(tension_out_n)], axis=1)
    motor, anchor = jnp.asarray(motor_m), jnp.asarray(anchor_m)
    if motor.shape != measured.shape[:1]:
        raise ValueError(f"motor_m and the tensions must have one shape (steps,), but have {motor.shape}, {measured[:, 0].shape}")
    start = (measured[0, 0], measured[0, 1]) if start_n is None else start_n
    names = tuple(parameters)
    logs = jnp.zeros(len(names), measured.dtype)

    def residuals(at: Any) -> Any:
        return measured - _tensions(scaled(law, dict(zip(names, jnp.exp(at), strict=True))), interval_s, motor, anchor, start)

    off = residuals(logs)
    history = [_rms(off)]
    for _ in range(steps):
        here = scaled(law, dict(zip(names, jnp.exp(logs), strict=True)))
        _, slope = _both(here, interval_s, motor, anchor, start, names)
        # Single steps in which a node sticks or slips by the last bit say nothing: residuals far beyond the others count little.
        width = WIDTH * jnp.median(jnp.abs(off)) + 1e-300
        weight = 1.0 / (1.0 + (off / width) ** 2)
        scaled_slope = (slope * jnp.sqrt(weight)[..., None]).reshape(-1, len(names))
        change = jnp.linalg.lstsq(scaled_slope, (off * jnp.sqrt(weight)).reshape(-1))[0]
        change = change * jnp.minimum(1.0, FARTHEST / jnp.maximum(jnp.abs(change).max(), 1e-30))
        # Where a single step of the log flips, no shorter way is better: then the whole one.
        tried = [change * 0.5**k for k in range(HALVINGS)]
        better = ((part, residuals(logs + part)) for part in tried)
        found = next((pair for pair in better if _cost(pair[1], width) <= _cost(off, width)), None)
        change, after = (change, residuals(logs + change)) if found is None else found
        logs, off = logs + change, after
        history.append(_rms(off))
    factors = dict(zip(names, (float(factor) for factor in jnp.exp(logs)), strict=True))
    return Fit(scaled(law, factors), factors, history)


def _cost(residuals: Any, width: Any) -> float:
    """Of residuals, where those far beyond a width count little."""
    return float(jnp.log1p((residuals / width) ** 2).sum())


def _rms(residuals: Any) -> float:
    return float(jnp.sqrt(jnp.mean(residuals * residuals)))


def _simulated(law: Law, interval_s: Any, motor: Any, anchor: Any, start: tuple[Any, Any]) -> Any:
    _, ends = simulate(law, profile(law, *start), interval_s, motor, anchor)
    return jnp.stack([ends.tension_in, ends.tension_out], axis=1)


_tensions = jax.jit(_simulated)


def _with_slope(law: Law, interval_s: Any, motor: Any, anchor: Any, start: tuple[Any, Any], names: tuple[str, ...]) -> Any:
    def tensions(logs: Any) -> tuple[Any, Any]:
        found = _simulated(scaled(law, dict(zip(names, jnp.exp(logs), strict=True))), interval_s, motor, anchor, start)
        return found, found

    slope, found = jax.jacfwd(tensions, has_aux=True)(jnp.zeros(len(names), motor.dtype))
    return found, slope


_both = jax.jit(_with_slope, static_argnames="names")
