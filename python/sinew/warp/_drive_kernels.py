"""Drives: their loops and limits, winding, shaft and heat; the laws of `sinew::drive`."""

import warp as wp

from ._cable_kernels import Law, State
from ._layout import (
    ACCELERATION,
    BACKLASH,
    CURRENT,
    DRY,
    EFFICIENCY,
    FULL,
    HAS_CELL,
    HIGH,
    HOTTEST,
    HOUSING,
    INDUCTANCE,
    INERTIA,
    LEAST,
    LOW,
    MOST,
    PEAK,
    PER_TURN,
    RATIO,
    RESISTANCE,
    RIPPLE,
    SPEED,
    TO_AIR,
    TO_HOUSING,
    TOP,
    TORQUE,
    VISCOUS,
    VOLTAGE,
    WINDING,
    Design,
    Motion,
    Specimen,
)
from ._sensor_kernels import position_at, sense
from ._winch_kernels import layer_of, wound_at

# mypy: ignore-errors
# Annotations of kernels must be types, not text: no `from __future__ import annotations` here.

#: degrees Celsius; 1/K, of copper; 1/s, of the velocity loop; m/(N s), s and m/s, of the tension loop; of the current loop.
ROOM, COPPER, GAIN = wp.constant(25.0), wp.constant(0.00393), wp.constant(150.0)
ADMITTANCE, RESET_TIME, LARGEST_INTEGRAL, CORRECTION = (wp.constant(x) for x in (2e-3, 0.5, 0.05, 0.2))


@wp.func
def turned(
    design: Design, k: int, speed: float, angle: wp.float64, torque: float, brake: float, load: float, h: float
) -> float:
    """Speed of the shaft after a step under a torque at the motor and a load at the winch: friction is implicit."""
    n = design.numbers
    heavy = n[INERTIA, k] + h * (n[VISCOUS, k] + brake)
    free = n[INERTIA, k] * speed + h * (torque - load / n[RATIO, k])
    sign = -1.0
    fraction = 1.0 - n[EFFICIENCY, k]
    if free > 0.0:
        sign = 1.0
        if load > 0.0:
            fraction = 1.0 / n[EFFICIENCY, k] - 1.0
    ripple = 1.0 + n[RIPPLE, k] * float(wp.cos(wp.float64(n[PER_TURN, k]) * angle))
    loss = n[DRY, k] + load / n[RATIO, k] * fraction * ripple
    return sign * (wp.abs(free) - wp.min(h * loss, wp.abs(free))) / heavy


@wp.func
def torque_asked(
    design: Design, specimen: Specimen, motion: Motion, world: int, k: int, action: float, seen: float, arm: float
) -> float:
    """Torque that the loops of a drive ask for; `seen`: tension at the load cell, N; `arm`: of the winch, m."""
    n, h = design.numbers, design.part
    most = n[TORQUE, k] * n[PEAK, k]
    command = n[LOW, k] + 0.5 * (action + 1.0) * (n[HIGH, k] - n[LOW, k])
    if design.actuation == CURRENT:
        return wp.clamp(n[TORQUE, k] * command, -most, most)
    velocity = float(0.0)
    if design.actuation == SPEED:
        velocity = specimen.winch[world, k] * command
    elif n[HAS_CELL, k] > 0.0:
        lack = wp.clamp(command, n[LEAST, k], n[MOST, k]) - seen
        integral = motion.tension_integral[world, k] + h * ADMITTANCE / RESET_TIME * lack
        integral = wp.clamp(integral, -LARGEST_INTEGRAL, LARGEST_INTEGRAL)
        motion.tension_integral[world, k] = integral
        velocity = ADMITTANCE * lack + integral
    holding = float(0.0)
    if n[HAS_CELL, k] > 0.0:
        if seen > n[MOST, k]:
            velocity = wp.min(velocity, 0.0)
        elif seen < n[LEAST, k]:
            velocity = wp.max(velocity, 0.0)
        holding = wp.max(seen, 0.0) * arm / n[RATIO, k]
    speed, turns = motion.speed[world, k], n[RATIO, k] / arm
    desired = wp.clamp(velocity * turns, -n[TOP, k], n[TOP, k])
    reference = motion.reference[world, k]
    fastest = n[ACCELERATION, k] * turns * h
    change = wp.clamp(desired - reference, -fastest, fastest)
    error = reference + change - speed
    raw = n[INERTIA, k] * (change / h + GAIN * error) + motion.integral[world, k]
    given = wp.clamp(raw, -most - holding, most - holding)
    if given == raw:
        motion.reference[world, k] = reference + change
        motion.integral[world, k] += h * n[INERTIA, k] * 0.25 * GAIN * GAIN * error
    else:
        lead = 2.0 * most / (n[INERTIA, k] * GAIN)
        motion.reference[world, k] = wp.clamp(reference + change, speed - lead, speed + lead)
    return holding + given


@wp.func
def turn(design: Design, motion: Motion, world: int, k: int, torque: float, load: float) -> float:
    """Winding, shaft and heat, coupled implicitly; returns the speed of the shaft after the step."""
    n, h = design.numbers, design.part
    speed, angle = motion.speed[world, k], motion.angle[world, k]
    warmth, current, constant = motion.warmth[world, k], motion.current[world, k], n[TORQUE, k]
    resistance = n[RESISTANCE, k] * wp.max(1.0 + COPPER * warmth[0], 0.1)
    lags = wp.max(h * resistance / wp.max(n[INDUCTANCE, k], 1e-12), 1e-3)
    left = wp.exp(-lags)
    mean = (1.0 - left) / lags
    amperes = wp.clamp(torque / constant, -n[PEAK, k], n[PEAK, k])
    beside = n[RESISTANCE, k] * (amperes - left * current) / wp.max(1.0 - left, 1e-6) + motion.correction[world, k]
    end = beside / resistance
    after = turned(design, k, speed, angle, constant * (end + (current - end) * mean), 0.0, load, h)
    volts = beside + constant * after
    if wp.abs(volts) <= n[VOLTAGE, k]:
        motion.correction[world, k] += CORRECTION * n[RESISTANCE, k] * (amperes - current)
    else:
        # The voltage is saturated: the back-EMF reduces the current and acts as a brake.
        full = wp.sign(volts) * n[VOLTAGE, k]
        end = full / resistance
        brake = constant * constant * (1.0 - mean) / resistance
        after = turned(design, k, speed, angle, constant * (end + (current - end) * mean), brake, load, h)
        end = (full - constant * after) / resistance
    off = current - end
    motion.current[world, k] = end + off * left
    square = end * end + 2.0 * end * off * mean + off * off * 0.5 * mean * (1.0 + left)
    to_housing = h / wp.max(n[TO_HOUSING, k], 1e-3) * (warmth[0] - warmth[1])
    to_air = h / n[TO_AIR, k] * warmth[1]
    inner = warmth[0] + (resistance * square * h - to_housing) / n[WINDING, k]
    motion.warmth[world, k] = wp.vec2(inner, warmth[1] + (to_housing - to_air) / n[HOUSING, k])
    return after


@wp.kernel(enable_backward=False)
def drive(design: Design, specimen: Specimen, motion: Motion, law: Law, state: State, actions: wp.array2d(dtype=float)) -> None:
    """One step of a drive: its sensors read, its loops command, its shaft and winch move."""
    world, k = wp.tid()
    n = design.numbers
    if k == 0:
        motion.clock[world] += 1
    tension = wp.max(state.tension[0, world, k], 0.0)
    far = state.tension[state.tension.shape[0] - 1, world, k] + law.pretension[world, k]
    seen = sense(design, specimen, motion, world, k, tension)
    winch = motion.winch[world, k]
    arm = float(design.arms[layer_of(design, k, winch), k])
    action = wp.clamp(actions[world, k], -1.0, 1.0)
    torque = torque_asked(design, specimen, motion, world, k, action, seen, arm)
    after = turn(design, motion, world, k, torque, tension * arm)

    # A cable under tension keeps the winch on one flank.
    angle = motion.angle[world, k] + wp.float64(design.part * after)
    motion.angle[world, k] = angle
    motion.speed[world, k] = after
    behind = angle / wp.float64(n[RATIO, k])
    half = wp.float64(0.5 * n[BACKLASH, k])
    wound = behind - half
    if tension <= 0.0:
        wound = wp.clamp(winch, behind - half, behind + half)
    # In this order: Warp reads an element where its value is used.
    motion.moved[world, k] = float(wound_at(design, k, wound) - wound_at(design, k, winch))
    motion.winch[world, k] = wound
    broken = wp.max(tension, far) > specimen.breaks[world, k]
    hot = motion.warmth[world, k][0] > n[HOTTEST, k] - ROOM
    if broken or hot or float(wound) > n[FULL, k] or float(wound) < 0.0:
        motion.failed[world] = 1


@wp.kernel(enable_backward=False)
def begin(mask: wp.array(dtype=bool), design: Design, specimen: Specimen, motion: Motion) -> None:
    """Drives and sensors of the worlds of a mask at the beginning of an episode; `specimen.first`: motors, tensions, joints."""
    world = wp.tid()
    if not mask[world]:
        return
    motion.failed[world] = 0
    motion.clock[world] = 0
    motion.step[world] = 0
    muscles = design.tendon.shape[0]
    for k in range(muscles):
        n = design.numbers
        winch = wp.float64(0.5 * n[FULL, k])
        angle = (winch + wp.float64(0.5 * n[BACKLASH, k])) * wp.float64(n[RATIO, k])
        motion.winch[world, k] = winch
        motion.angle[world, k] = angle
        motion.speed[world, k] = 0.0
        motion.current[world, k] = 0.0
        motion.warmth[world, k] = wp.vec2(0.0, 0.0)
        motion.correction[world, k] = 0.0
        motion.reference[world, k] = 0.0
        motion.integral[world, k] = 0.0
        motion.tension_integral[world, k] = 0.0
        motion.moved[world, k] = 0.0
        motion.noise[world, k] = specimen.noise[world, k]
        motion.now[world, k] = 0
        position, tension = position_at(design, k, angle), specimen.first[world, muscles + k]
        for j in range(motion.positions.shape[0]):
            motion.positions[j, world, k] = position
            motion.tensions[j, world, k] = tension
        motion.begin[world, k] = specimen.first[world, k] - position / specimen.winch[world, k]
        motion.last_motor[world, k] = specimen.first[world, k]
    for k in range(design.encoded.shape[0]):
        joint = specimen.first[world, 2 * muscles + k]
        for j in range(motion.joints.shape[0]):
            motion.joints[j, world, k] = joint
        motion.joint_now[world, k] = 0
        motion.last_joint[world, k] = joint
