"""Numbers of machines in worlds, and where each stands: what all worlds share, what differs, what changes in a step.

Angles of a drive count hundreds of turns, of which encoders tell thousandths: they are float64, everything else float32.
Arrays of a world and muscle have the shape `(worlds, muscles)`, those with a history or nodes `(.., worlds, muscles)`.
"""

import warp as wp

# mypy: ignore-errors
# Annotations of kernels must be types, not text: no `from __future__ import annotations` here.

#: Rows of the numbers of a drive as designed.
NUMBERS = (
    *("torque_constant", "resistance", "inductance", "inertia", "voltage", "peak_current", "top_speed"),
    *("winding_to_housing", "housing_to_air", "winding_capacity", "housing_capacity", "hottest"),
    *("ratio", "efficiency", "friction", "viscous", "backlash", "ripple", "ripple_per_turn"),
    *("full", "counts", "zero", "offset", "noise", "resolution", "range", "has_load_cell"),
    *("acceleration", "max_tension", "min_tension", "low", "high"),
)
TORQUE, RESISTANCE, INDUCTANCE, INERTIA, VOLTAGE, PEAK, TOP = (wp.constant(k) for k in range(7))
TO_HOUSING, TO_AIR, WINDING, HOUSING, HOTTEST = (wp.constant(k) for k in range(7, 12))
RATIO, EFFICIENCY, DRY, VISCOUS, BACKLASH, RIPPLE, PER_TURN = (wp.constant(k) for k in range(12, 19))
FULL, COUNTS, ZERO, OFFSET, NOISE, RESOLUTION, RANGE, HAS_CELL = (wp.constant(k) for k in range(19, 27))
ACCELERATION, MOST, LEAST, LOW, HIGH = (wp.constant(k) for k in range(27, 32))
#: What actions command.
CURRENT, SPEED, TENSION = (wp.constant(k) for k in range(3))
HINGE, SLIDE = wp.constant(1), wp.constant(2)


@wp.struct
class Design:
    """What all worlds share: numbers of drives, layers of drums, encoders of joints, the chain to the end point, the task."""

    numbers: wp.array2d(dtype=float)
    arms: wp.array2d(dtype=wp.float64)
    tendon: wp.array(dtype=int)
    sheath_body: wp.array(dtype=int)
    coordinate: wp.array(dtype=int)
    freedom: wp.array(dtype=int)
    encoded: wp.array(dtype=int)
    resolution: wp.array(dtype=float)
    ranges: wp.array(dtype=wp.vec2)
    place: wp.array(dtype=wp.transform)
    kind: wp.array(dtype=int)
    axis: wp.array(dtype=wp.vec3)
    anchor: wp.array(dtype=wp.vec3)
    link: wp.array(dtype=int)
    zero: wp.array(dtype=float)
    axes: wp.vec3
    endpoint: int
    half_error: float
    effort: float
    steps: int
    actuation: int
    interval: float
    part: float
    bounds: wp.array(dtype=wp.vec2)
    starts: wp.array(dtype=int)


@wp.struct
class Specimen:
    """What differs from world to world, drawn at the beginning of an episode."""

    friction: wp.array3d(dtype=float)
    mu: wp.array2d(dtype=float)
    wrap: wp.array2d(dtype=float)
    pulley: wp.array2d(dtype=int)
    axis: wp.array2d(dtype=wp.vec3)
    weakening: wp.array2d(dtype=wp.vec4)
    breaks: wp.array2d(dtype=float)
    winch: wp.array2d(dtype=float)
    gain: wp.array2d(dtype=float)
    delay: wp.array2d(dtype=float)
    encoder: wp.array2d(dtype=wp.vec3)
    joint_delay: wp.array(dtype=float)
    stops: wp.array2d(dtype=wp.vec4)
    pushes: wp.array3d(dtype=float)
    targets: wp.array3d(dtype=float)
    noise: wp.array2d(dtype=wp.uint64)
    first: wp.array2d(dtype=float)


@wp.struct
class Motion:
    """What the next step of the drives and sensors follows from, and what was observed last."""

    angle: wp.array2d(dtype=wp.float64)
    winch: wp.array2d(dtype=wp.float64)
    speed: wp.array2d(dtype=float)
    current: wp.array2d(dtype=float)
    warmth: wp.array2d(dtype=wp.vec2)
    correction: wp.array2d(dtype=float)
    reference: wp.array2d(dtype=float)
    integral: wp.array2d(dtype=float)
    tension_integral: wp.array2d(dtype=float)
    moved: wp.array2d(dtype=float)
    noise: wp.array2d(dtype=wp.uint64)
    begin: wp.array2d(dtype=float)
    positions: wp.array3d(dtype=float)
    tensions: wp.array3d(dtype=float)
    joints: wp.array3d(dtype=float)
    now: wp.array2d(dtype=int)
    joint_now: wp.array2d(dtype=int)
    position: wp.array2d(dtype=float)
    tension: wp.array2d(dtype=float)
    joint: wp.array2d(dtype=float)
    slow: wp.array3d(dtype=float)
    failed: wp.array(dtype=int)
    clock: wp.array(dtype=int)
    step: wp.array(dtype=int)
    last_motor: wp.array2d(dtype=float)
    last_joint: wp.array2d(dtype=float)
