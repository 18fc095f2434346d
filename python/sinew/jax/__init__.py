"""The elastic cable as a differentiable function in JAX: identification, and sensitivities of a design.

Needs `pip install jax`. See docs/gradients.md.
"""

try:
    import jax as _jax  # noqa: F401
except ModuleNotFoundError as error:
    if error.name != "jax":
        raise
    raise ImportError("sinew.jax needs JAX: pip install jax", name="jax") from error

from ._cable import Ends, Law, State, cable_step, law_of, profile, scaled, simulate, state_of  # noqa: E402
from ._fit import Fit, identify, sensitivity  # noqa: E402

__all__ = [
    "Ends",
    "Fit",
    "Law",
    "State",
    "cable_step",
    "identify",
    "law_of",
    "profile",
    "scaled",
    "sensitivity",
    "simulate",
    "state_of",
]
