"""Kernels of sheaths: a thread for every world and tendon, or friction constraint."""

import warp as wp

from ..batch._table import LARGEST_ANGLE, PARAMETERS

# mypy: ignore-errors
# Annotations of kernels must be types, not text: no `from __future__ import annotations` here.

#: `mjCNSTR_FRICTION_TENDON`; a pulley in the list of a path; no constraint.
TENDON_FRICTION, PULLEY, NONE = wp.constant(2), wp.constant(-2), wp.constant(-1)
LARGEST = wp.constant(LARGEST_ANGLE)
MU, BEND, TURNING, EFFICIENCY, PRETENSION, RISE, SPEED = (wp.constant(k) for k in range(len(PARAMETERS)))


@wp.kernel(enable_backward=False)
def find_rows(
    ne: wp.array(dtype=int),
    nf: wp.array(dtype=int),
    row_type: wp.array2d(dtype=int),
    row_id: wp.array2d(dtype=int),
    found: wp.array2d(dtype=int),
) -> None:
    """Notes the friction constraint of every tendon of a world; `found` is `NONE` before."""
    world, place = wp.tid()
    if place >= nf[world]:
        return
    row = ne[world] + place
    # More constraints than there is place for are counted, not made.
    if row < row_type.shape[1] and row_type[world, row] == TENDON_FRICTION:
        found[world, row_id[world, row]] = row


@wp.func
def point_of(xpos: wp.spatial_vector, half: int) -> wp.vec3:
    if half == 0:
        return wp.vec3(xpos[0], xpos[1], xpos[2])
    return wp.vec3(xpos[3], xpos[4], xpos[5])


@wp.func
def turning_of(
    begin: int,
    count: int,
    world: int,
    wrap_xpos: wp.array2d(dtype=wp.spatial_vector),
    wrap_obj: wp.array2d(dtype=wp.vec2i),
    first: wp.vec3,
) -> float:
    """Sum of the angles at the points of a path, rad, as of the plugin: broken at pulleys, coincident points once.

    `first`: in which direction the path begins, zero where that does not count.
    """
    total = float(0.0)
    begun = bool(False)
    last = wp.vec3()
    before = 1.0 * first
    for k in range(begin, begin + count):
        if wrap_obj[world, k // 2][k % 2] == PULLEY:
            begun = False
            before = wp.vec3()
            continue
        point = point_of(wrap_xpos[world, k // 2], k % 2)
        if not begun:
            last = point
            begun = True
            continue
        piece = point - last
        if wp.length_sq(piece) == 0.0:
            continue
        if wp.length_sq(before) > 0.0:
            total += wp.atan2(wp.length(wp.cross(before, piece)), wp.dot(before, piece))
        before = piece
        last = point
    return total


@wp.kernel(enable_backward=False)
def rub(
    parameters: wp.array3d(dtype=float),
    sheathed: wp.array(dtype=bool),
    own: wp.array(dtype=float),
    begins: wp.array(dtype=int),
    pulls: wp.array(dtype=int),
    gear: wp.array(dtype=float),
    limits: wp.array(dtype=wp.vec2),
    velocity: wp.array2d(dtype=float),
    wrap_adr: wp.array2d(dtype=int),
    wrap_num: wp.array2d(dtype=int),
    wrap_xpos: wp.array2d(dtype=wp.spatial_vector),
    wrap_obj: wp.array2d(dtype=wp.vec2i),
    row_d: wp.array2d(dtype=float),
    row_force: wp.array2d(dtype=float),
    found: wp.array2d(dtype=int),
    last_row: wp.array2d(dtype=int),
    force: wp.array2d(dtype=float),
    bound: wp.array2d(dtype=float),
    aref: wp.array2d(dtype=float),
) -> None:
    """Forces with friction, bounds of the friction constraints, and where these pull: toward the force of the last step.

    `found` becomes `NONE`, `last_row` what it was.
    """
    world, tendon = wp.tid()
    if not sheathed[tendon]:
        return
    row = found[world, tendon]
    # Rows change places from step to step; their forces are those of the last solution until the next one.
    earlier = last_row[world, tendon]
    held = float(0.0)
    if earlier >= 0:
        held = row_force[world, earlier]
    found[world, tendon] = NONE
    last_row[world, tendon] = row

    pull = float(0.0)
    for k in range(begins[tendon], begins[tendon + 1]):
        actuator = pulls[k]
        limit = limits[actuator]
        limited = wp.clamp(force[world, actuator], limit[0], limit[1])
        force[world, actuator] = limited
        pull -= limited * gear[actuator]

    # Without its constraint, where the tendon sleeps, there is no friction.
    if row >= 0:
        largest = own[tendon]
        if pull > 0.0:
            wrap = parameters[BEND, world, tendon]
            fraction = parameters[TURNING, world, tendon]
            if fraction > 0.0:
                begin, count = wrap_adr[world, tendon], wrap_num[world, tendon]
                psi = turning_of(begin, count, world, wrap_xpos, wrap_obj, wp.vec3())
                wrap += fraction * psi
            ratio = velocity[world, tendon] / parameters[SPEED, world, tendon]
            weakening = 1.0 + parameters[RISE, world, tendon] / (1.0 + ratio * ratio)
            loss = -wp.log(parameters[EFFICIENCY, world, tendon])
            theta = wp.min(LARGEST, parameters[MU, world, tendon] * wrap * weakening + loss)
            mean = wp.cosh(theta)
            for k in range(begins[tendon], begins[tendon + 1]):
                force[world, pulls[k]] *= mean
            largest += pull * wp.sinh(theta)
        bound[world, row] = largest
        aref[world, row] += wp.clamp(held, -largest, largest) / row_d[world, row]

    pretension = parameters[PRETENSION, world, tendon]
    if pretension > 0.0:
        given = bool(False)
        for k in range(begins[tendon], begins[tendon + 1]):
            actuator = pulls[k]
            if not given and gear[actuator] != 0.0:
                force[world, actuator] -= pretension / gear[actuator]
                given = True


@wp.kernel(enable_backward=False)
def forget(mask: wp.array(dtype=bool), last_row: wp.array2d(dtype=int)) -> None:
    """The worlds of a mask begin without a force of the last step."""
    world, tendon = wp.tid()
    if mask[world]:
        last_row[world, tendon] = NONE


@wp.kernel(enable_backward=False)
def put(
    place: int,
    values: wp.array2d(dtype=float),
    mask: wp.array(dtype=bool),
    parameters: wp.array3d(dtype=float),
) -> None:
    """Writes a parameter of the worlds of a mask; `values` may have one world."""
    world, tendon = wp.tid()
    if mask[world]:
        parameters[place, world, tendon] = values[world % values.shape[0], tendon]


@wp.kernel(enable_backward=False)
def place(mask: wp.array(dtype=bool), start: wp.array2d(dtype=float), qpos: wp.array2d(dtype=float)) -> None:
    """Puts the worlds of a mask into a pose; `start` may have one world."""
    world, k = wp.tid()
    if mask[world]:
        qpos[world, k] = start[world % start.shape[0], k]
