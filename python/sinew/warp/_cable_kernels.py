"""The elastic cable, a thread for every world and cable: the law of `sinew::transmission::cable` in float32.

Names and order of computation are those of its modules `step`, `repair` and `travel`. Arrays of cells and nodes have the
shape `(cells, worlds, cables)`, so that neighbouring threads read neighbouring numbers; the first node has the place 1.
"""

import warp as wp

# mypy: ignore-errors
# Annotations of kernels must be types, not text: no `from __future__ import annotations` here.

#: Friction bound, N, below which a node cannot stick.
NO_FRICTION = wp.constant(1e-12)
#: Work, J, that friction at a node may do by rounding, and as a fraction of what passes there.
WORK, WORK_FRACTION = wp.constant(1e-10), wp.constant(4e-7)
#: Energy, J, that a step may create by rounding, and as a fraction of twice the cable's.
ROUNDING, ROUNDING_FRACTION = wp.constant(1e-12), wp.constant(4e-7)
#: Largest motion of an end in a step, m.
FARTHEST = wp.constant(0.1)
#: Places in an array of parameters, of every world and cable.
FRICTION, DRAG, COMPLIANCE, START = (wp.constant(k) for k in range(4))
FACTORS = ("friction", "drag", "compliance", "start_n")

Row = wp.array(dtype=float)
Rows = wp.array2d(dtype=float)
Cells = wp.array3d(dtype=float)


@wp.struct
class Law:
    """Cables as built: cells and nodes in rows, `(cells, 1 or worlds, cables)`; of every cable, `(1 or worlds, cables)`."""

    compliance: wp.array3d(dtype=float)
    friction: wp.array3d(dtype=float)
    loss: wp.array3d(dtype=float)
    viscous: wp.array3d(dtype=float)
    drag: wp.array3d(dtype=float)
    fade: wp.array2d(dtype=float)
    pretension: wp.array2d(dtype=float)
    factors: wp.array3d(dtype=float)


@wp.struct
class State:
    """What the next step follows from, and room for a step."""

    begun: wp.array2d(dtype=int)
    winch: wp.array2d(dtype=float)
    length: wp.array2d(dtype=float)
    stretch: wp.array2d(dtype=float)
    tension: wp.array3d(dtype=float)
    slip: wp.array3d(dtype=float)
    next: wp.array3d(dtype=float)
    sup: wp.array3d(dtype=float)
    rhs: wp.array3d(dtype=float)


@wp.func
def tanh_series(x: float) -> float:
    x = wp.clamp(x, -0.5, 0.5)
    z = x * x
    return x * (1.0 + z * (-1.0 / 3.0 + z * (2.0 / 15.0 + z * (-17.0 / 315.0))))


@wp.func
def built(law: Law, world: int) -> int:
    """Where the numbers of a world are: with its own, or with those of all."""
    return wp.min(world, law.pretension.shape[0] - 1)


@wp.func
def compliance_of(law: Law, j: int, world: int, k: int) -> float:
    return law.compliance[j, built(law, world), k] * law.factors[COMPLIANCE, world, k]


@wp.func
def half_angle_of(law: Law, i: int, world: int, k: int) -> float:
    return law.friction[i, built(law, world), k] * law.factors[FRICTION, world, k] + law.loss[i, built(law, world), k]


@wp.func
def ratio_of(law: Law, i: int, world: int, k: int, s: float) -> float:
    """Tension behind a sliding node over that in front of it."""
    grip = s * tanh_series(half_angle_of(law, i, world, k))
    return (1.0 - grip) / (1.0 + grip)


@wp.func
def settle(law: Law, state: State, world: int, k: int) -> float:
    """Tension at the anchor of a cable that has slid toward the motor; sets all tensions."""
    m = state.tension.shape[0]
    tension = wp.max(law.factors[START, world, k] - law.pretension[built(law, world), k], 0.0)
    stretch = float(0.0)
    for step in range(m):
        j = m - 1 - step
        if step > 0:
            tension = tension / ratio_of(law, j, world, k, 1.0)
        state.tension[j, world, k] = tension
        stretch += compliance_of(law, j, world, k) * tension
        state.slip[j, world, k] = 0.0
    state.stretch[world, k] = stretch
    return state.tension[m - 1, world, k]


@wp.func
def eliminate(law: Law, state: State, world: int, k: int, rate: float, motor: float, anchor: float) -> None:
    """Forward elimination: each row is formed at the displacements of the last step and eliminated at once."""
    m = state.tension.shape[0]
    driven = -1.0
    if motor + anchor >= 0.0:
        driven = 1.0
    fade = 2.0 * law.fade[built(law, world), k]
    sup_done = float(0.0)
    rhs_done = float(0.0)
    before = motor
    w = state.slip[1, world, k]
    for i in range(m - 1):
        beyond = anchor
        if i + 2 < m:
            beyond = state.slip[i + 2, world, k]
        kl = 1.0 / compliance_of(law, i, world, k)
        kr = 1.0 / compliance_of(law, i + 1, world, k)
        left = state.tension[i, world, k] + (before - w) * kl
        right = state.tension[i + 1, world, k] + (w - beyond) * kr
        both = left + right
        total = wp.max(both, 0.0)
        difference = left - right
        h = half_angle_of(law, i, world, k)
        bound = total * tanh_series(h)
        trial = difference + (kl + kr) * w
        sign = float(0.0)
        if bound <= NO_FRICTION:
            sign = driven
        elif trial > bound:
            sign = 1.0
        elif trial < -bound:
            sign = -1.0
        sub = float(0.0)
        sup = float(0.0)
        main = float(1.0)
        rhs = -w
        if sign != 0.0:
            drag = law.drag[i, built(law, world), k] * law.factors[DRAG, world, k]
            resistance = (law.viscous[i, built(law, world), k] * law.factors[FRICTION, world, k] + drag / (total + fade)) * rate
            tau = tanh_series(sign * h + resistance * w)
            sub = (1.0 - tau) * kl
            sup = (1.0 + tau) * kr
            main = sub + sup + total * (1.0 - tau * tau) * resistance
            rhs = difference - tau * both
        inverse = 1.0 / (main - sub * sup_done)
        rhs_done = (rhs + sub * rhs_done) * inverse
        sup_done = sup * inverse
        state.sup[i + 1, world, k] = sup_done
        state.rhs[i + 1, world, k] = rhs_done
        before = w
        w = beyond


@wp.func
def substitute_back(law: Law, state: State, world: int, k: int, motor: float, anchor: float) -> float:
    """Displacements and tensions of a step; returns the scale that makes the total stretch exact."""
    m = state.tension.shape[0]
    x = state.rhs[m - 1, world, k]
    solved = state.slip[m - 1, world, k] + x
    beyond = anchor
    right = state.tension[m - 1, world, k] + (solved - beyond) / compliance_of(law, m - 1, world, k)
    total = float(0.0)
    for step in range(m - 1):
        j = m - 2 - step
        # Node 0 is the winch, which moves as it is told.
        w = motor
        if j > 0:
            x = state.rhs[j, world, k] + state.sup[j, world, k] * x
            w = state.slip[j, world, k] + x
        left = state.tension[j, world, k] + (w - solved) / compliance_of(law, j, world, k)
        # A node whose friction would do work on the cable is held.
        accepted = solved
        if (left - right) * solved < -(WORK + WORK_FRACTION * (wp.abs(left) + wp.abs(right)) * wp.abs(solved)):
            accepted = 0.0
        c = compliance_of(law, j + 1, world, k)
        t = wp.max(state.tension[j + 1, world, k] + (accepted - beyond) / c, 0.0)
        state.next[j + 1, world, k] = t
        state.slip[j + 1, world, k] = accepted
        total += c * t
        beyond = accepted
        solved = w
        right = left
    c = compliance_of(law, 0, world, k)
    t = wp.max(state.tension[0, world, k] + (motor - beyond) / c, 0.0)
    state.next[0, world, k] = t
    total += c * t
    stretch = state.stretch[world, k]
    if stretch > 0.0 and total > 0.0:
        return stretch / total
    return 0.0


@wp.func
def retension(law: Law, state: State, world: int, k: int, motor: float, anchor: float) -> None:
    """Tensions of a cable that was slack: sliding everywhere with the total stretch."""
    m = state.tension.shape[0]
    s = -1.0
    if motor + anchor >= 0.0:
        s = 1.0
    ratio = float(1.0)
    total = float(0.0)
    for j in range(m):
        if j > 0:
            ratio *= ratio_of(law, j - 1, world, k, s)
            state.slip[j, world, k] = motor + (anchor - motor) * (float(j) / float(m))
        state.next[j, world, k] = ratio
        total += compliance_of(law, j, world, k) * ratio
    for j in range(m):
        state.next[j, world, k] = state.next[j, world, k] * (state.stretch[world, k] / total)


@wp.func
def move_end(law: Law, state: State, world: int, k: int, distance: float, far: bool) -> None:
    """Moves an end, positive pulls, while the other is held: exact for Coulomb friction."""
    m = state.next.shape[0]
    if distance == 0.0:
        return
    s = -1.0
    if distance > 0.0:
        s = 1.0
    # Tension of a cell over that at the end, where everything between slides.
    ratio = float(1.0)
    for place in range(m):
        j = place
        if far:
            j = m - 1 - place
        if place > 0:
            node = j - 1
            if far:
                node = j
            ratio *= ratio_of(law, node, world, k, s)
        state.rhs[j, world, k] = ratio
    target = float(0.0)
    sliding = int(-1)
    done = bool(False)
    for _ in range(m + 1):
        if not done:
            stretch = distance
            weight = float(0.0)
            count = int(0)
            for j in range(m):
                t = state.next[j, world, k]
                e = state.rhs[j, world, k]
                if sliding < 0 or s * (target * e - t) > 0.0:
                    c = compliance_of(law, j, world, k)
                    stretch += c * t
                    weight += c * e
                    count += 1
            if count == 0 or count == sliding:
                done = True
            else:
                target = wp.max(stretch / weight, 0.0)
                sliding = count
    for j in range(m):
        slid = target * state.rhs[j, world, k]
        if s * (slid - state.next[j, world, k]) > 0.0:
            state.next[j, world, k] = slid


@wp.func
def sweep_both_ends(law: Law, state: State, world: int, k: int, motor: float, anchor: float) -> None:
    """Moves the ends one after the other from the tensions before the step, the one that tightens first."""
    m = state.tension.shape[0]
    for j in range(m):
        state.next[j, world, k] = state.tension[j, world, k]
        state.slip[j, world, k] = 0.0
    if motor > 0.0:
        move_end(law, state, world, k, motor, False)
        move_end(law, state, world, k, -anchor, True)
    else:
        move_end(law, state, world, k, -anchor, True)
        move_end(law, state, world, k, motor, False)


@wp.func
def gained(law: Law, state: State, world: int, k: int, scale: float) -> wp.vec2:
    """Elastic energy that a step added, J, and twice the energy, J: products of differences, which do not cancel."""
    gain = float(0.0)
    twice = float(0.0)
    for j in range(state.tension.shape[0]):
        t = state.tension[j, world, k]
        after = state.next[j, world, k] * scale
        c = compliance_of(law, j, world, k)
        gain += c * (after - t) * (after + t)
        twice += c * after * after
    return wp.vec2(0.5 * gain, twice)


@wp.func
def advance(law: Law, state: State, world: int, k: int, interval: float, motor: float, anchor: float) -> float:
    """One step of the law; returns the tension at the anchor without the pretension."""
    m = state.tension.shape[0]
    before = state.stretch[world, k]
    state.stretch[world, k] = before + (motor - anchor)
    eliminate(law, state, world, k, 1.0 / interval, motor, anchor)
    scale = substitute_back(law, state, world, k, motor, anchor)
    near = state.next[0, world, k] * scale
    far = state.next[m - 1, world, k] * scale
    change = gained(law, state, world, k, scale)
    lost = near * motor - far * anchor - change[0]
    if before <= 0.0 and state.stretch[world, k] > 0.0:
        retension(law, state, world, k, motor, anchor)
        scale = 1.0
    elif lost < -(ROUNDING + ROUNDING_FRACTION * change[1]):
        sweep_both_ends(law, state, world, k, motor, anchor)
        scale = 1.0
    slack = state.stretch[world, k] <= 0.0
    for j in range(m):
        state.tension[j, world, k] = state.next[j, world, k] * scale
        if slack:
            state.slip[j, world, k] = 0.0
    return state.tension[m - 1, world, k]


@wp.kernel(enable_backward=False)
def pull(
    law: Law,
    state: State,
    tendon: wp.array(dtype=int),
    actuator: wp.array(dtype=int),
    control: wp.array(dtype=int),
    activation: wp.array(dtype=int),
    gear: wp.array(dtype=float),
    substeps: int,
    timestep: wp.array(dtype=float),
    ctrl: wp.array2d(dtype=float),
    act: wp.array2d(dtype=float),
    ten_length: wp.array2d(dtype=float),
    force: wp.array2d(dtype=float),
) -> None:
    """Steps every cable to the present place of its ends; its tension is the force of its actuator."""
    world, k = wp.tid()
    winch = float(0.0)
    if activation[k] >= 0:
        winch = act[world, activation[k]]
    else:
        winch = ctrl[world, control[k]]
    length = ten_length[world, tendon[k]]
    far = float(0.0)
    if state.begun[world, k] == 0:
        far = settle(law, state, world, k)
        state.begun[world, k] = 1
    else:
        fraction = 1.0 / float(substeps)
        motor = wp.clamp((winch - state.winch[world, k]) * fraction, -FARTHEST, FARTHEST)
        # The anchor moves away from the motor where the tendon grows longer.
        anchor = wp.clamp((state.length[world, k] - length) * fraction, -FARTHEST, FARTHEST)
        interval = timestep[world % timestep.shape[0]] * fraction
        for _ in range(substeps):
            far = advance(law, state, world, k, interval, motor, anchor)
    state.winch[world, k] = winch
    state.length[world, k] = length
    force[world, actuator[k]] = -(far + law.pretension[built(law, world), k]) / gear[k]


@wp.kernel(enable_backward=False)
def begin_anew(mask: wp.array(dtype=bool), begun: wp.array2d(dtype=int)) -> None:
    """The cables of the worlds of a mask are laid at their start."""
    world, k = wp.tid()
    if mask[world]:
        begun[world, k] = 0
