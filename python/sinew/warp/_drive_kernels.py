"""Drives, sensors and what follows from an action: the laws of `sinew::drive`, `sinew::twin::arm` and `sinew_gym`.

Angles of a drive count hundreds of turns, of which encoders tell thousandths: they are float64, everything else float32.
Arrays of a world and muscle have the shape `(worlds, muscles)`, those with a history or nodes `(.., worlds, muscles)`.
"""

import warp as wp

from ._cable_kernels import Law, State
from ._kernels import turning_of

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
#: degrees Celsius; 1/K, of copper; 1/s, of the velocity loop; m/(N s), s and m/s, of the tension loop; of the current loop.
ROOM, COPPER, GAIN = wp.constant(25.0), wp.constant(0.00393), wp.constant(150.0)
ADMITTANCE, RESET_TIME, LARGEST_INTEGRAL, CORRECTION = (wp.constant(x) for x in (2e-3, 0.5, 0.05, 0.2))
#: Largest wrap at a joint that one node represents, rad.
LARGEST_WRAP = wp.constant(4.0)
#: Of splitmix64.
STRIDE, FIRST, SECOND = (
    wp.constant(wp.uint64(x)) for x in (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB)
)
HINGE, SLIDE = wp.constant(1), wp.constant(2)
TURN = wp.constant(wp.float64(6.283185307179586))

Row = wp.array(dtype=float)
Rows = wp.array2d(dtype=float)
Layers = wp.array3d(dtype=float)


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
    told: wp.array2d(dtype=float)


@wp.struct
class Motion:
    """What the next step of the drives and sensors follows from, and what was told last."""

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
    motor_told: wp.array2d(dtype=float)
    joint_told: wp.array2d(dtype=float)


@wp.func
def bits(state: wp.uint64) -> wp.uint64:
    z = (state ^ (state >> wp.uint64(30))) * FIRST
    z = (z ^ (z >> wp.uint64(27))) * SECOND
    return z ^ (z >> wp.uint64(31))


@wp.func
def normal(one: wp.uint64, other: wp.uint64) -> float:
    """The sum of eight numbers of 16 bits, of variance 1."""
    total = wp.uint64(0)
    mask = wp.uint64(0xFFFF)
    for part in range(4):
        total += (one >> wp.uint64(16 * part)) & mask
        total += (other >> wp.uint64(16 * part)) & mask
    return (float(total) - 4.0 * 65535.0) * (1.224744871391589 / 65536.0)


@wp.func
def passed(ring: Layers, now: int, steps: float, world: int, k: int, value: float) -> float:
    """Stores the present value and returns the one of so many steps ago, between steps by interpolation."""
    depth = ring.shape[0]
    whole = int(steps)
    ring[now, world, k] = value
    younger = ring[(now - whole + depth) % depth, world, k]
    older = ring[(now - whole - 1 + depth) % depth, world, k]
    return younger + (steps - float(whole)) * (older - younger)


@wp.func
def layer_of(design: Design, k: int, winch: wp.float64) -> int:
    layers = design.arms.shape[0]
    per_layer = wp.float64(design.numbers[FULL, k]) / wp.float64(layers)
    return wp.clamp(int(winch / per_layer), 0, layers - 1)


@wp.func
def wound_at(design: Design, k: int, winch: wp.float64) -> wp.float64:
    """Cable on the drum, m."""
    per_layer = wp.float64(design.numbers[FULL, k]) / wp.float64(design.arms.shape[0])
    layer = layer_of(design, k, winch)
    below = wp.float64(0.0)
    for j in range(layer):
        below += per_layer * design.arms[j, k]
    return below + (winch - wp.float64(layer) * per_layer) * design.arms[layer, k]


@wp.func
def position_at(design: Design, k: int, angle: wp.float64) -> float:
    """Cable on the drum beyond its half by the motor's encoder, m."""
    count = TURN / wp.float64(design.numbers[COUNTS, k])
    read = wp.rint((angle + wp.float64(design.numbers[ZERO, k])) / count) * count
    half = wound_at(design, k, wp.float64(0.5 * design.numbers[FULL, k]))
    return float(wound_at(design, k, read / wp.float64(design.numbers[RATIO, k])) - half)


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


@wp.kernel(enable_backward=False)
def ease(
    design: Design,
    specimen: Specimen,
    motion: Motion,
    law: Law,
    state: State,
    timestep: wp.array(dtype=float),
    wrap_adr: wp.array2d(dtype=int),
    wrap_num: wp.array2d(dtype=int),
    wrap_xpos: wp.array2d(dtype=wp.spatial_vector),
    wrap_obj: wp.array2d(dtype=wp.vec2i),
    xquat: wp.array2d(dtype=wp.quat),
) -> None:
    """Friction of the next step of the cables: by the wrap at the joint in the present pose, and less at speed."""
    world, k = wp.tid()
    tendon = design.tendon[k]
    axis = specimen.axis[world, k]
    q = xquat[world, design.sheath_body[k]]
    # Along the end of the sheath; MuJoCo's order is w, x, y, z.
    first = wp.quat_rotate(wp.quat(q[1], q[2], q[3], q[0]), axis)
    bend = turning_of(wrap_adr[world, tendon], wrap_num[world, tendon], world, wrap_xpos, wrap_obj, first)
    more = 0.5 * specimen.mu[world, k] * (wp.min(bend, LARGEST_WRAP) - specimen.wrap[world, k])
    slow = specimen.weakening[world, k]
    h = timestep[0]
    for i in range(motion.slow.shape[0]):
        friction = specimen.friction[i, world, k]
        if i == specimen.pulley[world, k]:
            friction = wp.max(friction + more, 0.0)
        speed = motion.slow[i, world, k]
        if state.begun[world, k] == 0:
            # It begins without, as the profile of steady sliding.
            motion.slow[i, world, k] = 0.0
        elif slow[0] > 0.0:
            ratio = speed / slow[1]
            if slow[3] > 0.0:
                friction *= 1.0 + slow[0] * wp.exp(-0.6931472 * ratio * ratio)
            else:
                friction *= 1.0 + slow[0] / (1.0 + ratio * ratio)
            motion.slow[i, world, k] = speed + h / (slow[2] + h) * (wp.abs(state.slip[i + 1, world, k]) / h - speed)
        law.friction[i, world, k] = friction


@wp.kernel(enable_backward=False)
def press(
    design: Design,
    specimen: Specimen,
    motion: Motion,
    begun: int,
    qpos: wp.array2d(dtype=float),
    qvel: wp.array2d(dtype=float),
    applied: wp.array2d(dtype=float),
) -> None:
    """Forces on a joint from its stops, and from outside: of a push start, duration, s, joint, and torque, Nm, or force, N.

    `begun`: how many steps of the drives before the present one the clock counts too much.
    """
    world, joint = wp.tid()
    stop = specimen.stops[world, joint]
    q, v = qpos[world, design.coordinate[joint]], qvel[world, design.freedom[joint]]
    beyond = wp.max(q - stop[1], 0.0) + wp.min(q - stop[0], 0.0)
    total = float(0.0)
    if beyond > 0.0:
        total = wp.min(-stop[2] * beyond - stop[3] * v, 0.0)
    elif beyond < 0.0:
        total = wp.max(-stop[2] * beyond - stop[3] * v, 0.0)
    time = float(motion.clock[world] - begun) * design.part
    for j in range(specimen.pushes.shape[1]):
        elapsed = time - specimen.pushes[world, j, 0]
        if int(specimen.pushes[world, j, 2]) == joint and elapsed >= 0.0 and elapsed < specimen.pushes[world, j, 1]:
            total += specimen.pushes[world, j, 3]
    applied[world, design.freedom[joint]] = total


@wp.kernel(enable_backward=False)
def drive(design: Design, specimen: Specimen, motion: Motion, law: Law, state: State, actions: wp.array2d(dtype=float)) -> None:
    """One step of a drive: its sensors read, its loops command, its shaft and winch move."""
    world, k = wp.tid()
    n, h = design.numbers, design.part
    if k == 0:
        motion.clock[world] += 1
    tension = wp.max(state.tension[0, world, k], 0.0)
    far = state.tension[state.tension.shape[0] - 1, world, k] + law.pretension[world, k]
    # What its sensors show: the state at the beginning of the step, later.
    one = motion.noise[world, k] + STRIDE
    other = one + STRIDE
    motion.noise[world, k] = other
    cell = specimen.gain[world, k] * tension + n[OFFSET, k] + n[NOISE, k] * normal(bits(one), bits(other))
    if n[RESOLUTION, k] > 0.0:
        cell = wp.rint(cell / n[RESOLUTION, k]) * n[RESOLUTION, k]
    cell = wp.clamp(cell, -0.1 * n[RANGE, k], n[RANGE, k])
    now, delay = motion.now[world, k], specimen.delay[world, k]
    angle = motion.angle[world, k]
    motion.position[world, k] = passed(motion.positions, now, delay, world, k, position_at(design, k, angle))
    seen = passed(motion.tensions, now, delay, world, k, cell)
    motion.tension[world, k] = seen
    motion.now[world, k] = (now + 1) % motion.positions.shape[0]

    # Torque that is asked for.
    winch, speed = motion.winch[world, k], motion.speed[world, k]
    arm = float(design.arms[layer_of(design, k, winch), k])
    most = n[TORQUE, k] * n[PEAK, k]
    action = wp.clamp(actions[world, k], -1.0, 1.0)
    command = n[LOW, k] + 0.5 * (action + 1.0) * (n[HIGH, k] - n[LOW, k])
    torque = float(0.0)
    if design.actuation == CURRENT:
        torque = wp.clamp(n[TORQUE, k] * command, -most, most)
    else:
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
        turns = n[RATIO, k] / arm
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
        torque = holding + given

    # Winding and shaft, coupled implicitly.
    warmth, current, constant = motion.warmth[world, k], motion.current[world, k], n[TORQUE, k]
    resistance = n[RESISTANCE, k] * wp.max(1.0 + COPPER * warmth[0], 0.1)
    lags = wp.max(h * resistance / wp.max(n[INDUCTANCE, k], 1e-12), 1e-3)
    left = wp.exp(-lags)
    mean = (1.0 - left) / lags
    amperes = wp.clamp(torque / constant, -n[PEAK, k], n[PEAK, k])
    beside = n[RESISTANCE, k] * (amperes - left * current) / wp.max(1.0 - left, 1e-6) + motion.correction[world, k]
    load = tension * arm
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

    # A cable under tension keeps the winch on one flank.
    angle += wp.float64(h * after)
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
    if broken or inner > n[HOTTEST, k] - ROOM or float(wound) > n[FULL, k] or float(wound) < 0.0:
        motion.failed[world] = 1


@wp.kernel(enable_backward=False)
def wind(design: Design, motion: Motion, left: float, control: wp.array(dtype=int), ctrl: wp.array2d(dtype=float)) -> None:
    """Displacement of the winches in the next substep; `left`: the fraction of the motion of this step that is still to come."""
    world, k = wp.tid()
    half = wound_at(design, k, wp.float64(0.5 * design.numbers[FULL, k]))
    there = float(wound_at(design, k, motion.winch[world, k]) - half)
    ctrl[world, control[k]] = there - left * motion.moved[world, k]


@wp.kernel(enable_backward=False)
def read_joints(design: Design, specimen: Specimen, motion: Motion, qpos: wp.array2d(dtype=float)) -> None:
    """A joint's encoder, after its delay."""
    world, k = wp.tid()
    q = qpos[world, design.coordinate[design.encoded[k]]]
    off, count = specimen.encoder[world, k], design.resolution[k]
    read = wp.rint((q + off[0] + off[1] * wp.sin(q) + off[2] * wp.cos(q)) / count) * count
    now = motion.joint_now[world, k]
    motion.joint[world, k] = passed(motion.joints, now, specimen.joint_delay[world], world, k, read)
    motion.joint_now[world, k] = (now + 1) % motion.joints.shape[0]


@wp.func
def end_point(design: Design, world: int, qpos: wp.array2d(dtype=float)) -> wp.vec3:
    """The end point in the present pose, by the design, m."""
    frame = wp.transform_identity()
    for j in range(design.kind.shape[0]):
        frame = wp.transform_multiply(frame, design.place[j])
        if design.kind[j] == HINGE:
            turn = wp.quat_from_axis_angle(design.axis[j], qpos[world, design.link[j]] - design.zero[j])
            anchor = design.anchor[j]
            frame = wp.transform_multiply(frame, wp.transform(anchor - wp.quat_rotate(turn, anchor), turn))
        elif design.kind[j] == SLIDE:
            way = design.axis[j] * (qpos[world, design.link[j]] - design.zero[j])
            frame = wp.transform_multiply(frame, wp.transform(way, wp.quat_identity()))
    return wp.transform_get_translation(frame)


@wp.func
def tell(design: Design, observations: Rows, world: int, part: int, j: int, value: float) -> None:
    """Writes an entry of a part of the observation, within its bounds."""
    if design.starts[part] >= 0:
        entry = design.starts[part] + j
        observations[world, entry] = wp.clamp(value, design.bounds[entry][0], design.bounds[entry][1])


@wp.kernel(enable_backward=False)
def conclude(
    design: Design,
    specimen: Specimen,
    motion: Motion,
    actions: wp.array2d(dtype=float),
    qpos: wp.array2d(dtype=float),
    observations: wp.array2d(dtype=float),
    outcomes: wp.array2d(dtype=float),
) -> None:
    """What follows from an action: `outcomes` are error, reward, whether it terminated, and whether it was truncated."""
    world = wp.tid()
    joints, muscles = design.ranges.shape[0], actions.shape[1]
    last = specimen.targets.shape[1] - 1
    step = motion.step[world]
    # The pose that was desired for this time was told before the action.
    asked = wp.min(step, last)
    squares = float(0.0)
    if design.endpoint != 0:
        point = end_point(design, world, qpos)
        for j in range(3):
            off = design.axes[j] * (point[j] - specimen.targets[world, asked, 2 * joints + j])
            squares += off * off
    else:
        for j in range(joints):
            width = wp.max(design.ranges[j][1] - design.ranges[j][0], 1e-6)
            off = (qpos[world, design.coordinate[j]] - specimen.targets[world, asked, j]) / width
            squares += off * off / float(joints)
    error = wp.sqrt(squares)
    effort = float(0.0)
    for k in range(muscles):
        action = wp.clamp(actions[world, k], -1.0, 1.0)
        effort += action * action / float(muscles)
    terminated = motion.failed[world] != 0 or not wp.isfinite(error)
    reward = float(0.0)
    if not terminated:
        reward = 1.0 / (1.0 + error * error / (design.half_error * design.half_error)) - design.effort * effort
    if not wp.isfinite(error):
        error = 3.0e38
    outcomes[world, 0] = error
    outcomes[world, 1] = reward
    outcomes[world, 2] = wp.where(terminated, 1.0, 0.0)
    outcomes[world, 3] = wp.where(step + 1 >= design.steps, 1.0, 0.0)
    asked = wp.min(step + 1, last)
    motion.step[world] = step + 1

    rate = 1.0 / design.interval
    for k in range(muscles):
        motor = motion.begin[world, k] + motion.position[world, k] / specimen.winch[world, k]
        tell(design, observations, world, 0, k, motor)
        tell(design, observations, world, 1, k, rate * (motor - motion.motor_told[world, k]))
        motion.motor_told[world, k] = motor
        tension = motion.tension[world, k]
        if design.numbers[HAS_CELL, k] == 0.0:
            tension = -3.0e38
        tell(design, observations, world, 2, k, tension)
        tell(design, observations, world, 8, k, wp.clamp(actions[world, k], -1.0, 1.0))
    for k in range(design.encoded.shape[0]):
        joint = motion.joint[world, k]
        tell(design, observations, world, 3, k, joint)
        tell(design, observations, world, 4, k, rate * (joint - motion.joint_told[world, k]))
        motion.joint_told[world, k] = joint
    for j in range(joints):
        tell(design, observations, world, 5, j, specimen.targets[world, asked, j])
        tell(design, observations, world, 6, j, specimen.targets[world, asked, joints + j])
    entry = int(0)
    for j in range(3):
        if design.axes[j] > 0.0:
            tell(design, observations, world, 7, entry, specimen.targets[world, asked, 2 * joints + j])
            entry += 1


@wp.kernel(enable_backward=False)
def begin(mask: wp.array(dtype=bool), design: Design, specimen: Specimen, motion: Motion) -> None:
    """Drives and sensors of the worlds of a mask at the beginning of an episode; `specimen.told`: motors, tensions, joints."""
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
        position, tension = position_at(design, k, angle), specimen.told[world, muscles + k]
        for j in range(motion.positions.shape[0]):
            motion.positions[j, world, k] = position
            motion.tensions[j, world, k] = tension
        motion.begin[world, k] = specimen.told[world, k] - position / specimen.winch[world, k]
        motion.motor_told[world, k] = specimen.told[world, k]
    for k in range(design.encoded.shape[0]):
        joint = specimen.told[world, 2 * muscles + k]
        for j in range(motion.joints.shape[0]):
            motion.joints[j, world, k] = joint
        motion.joint_now[world, k] = 0
        motion.joint_told[world, k] = joint
