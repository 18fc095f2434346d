"""What follows from an action: observation, error and reward; the law of `sinew_gym`."""

import warp as wp

from ._layout import HAS_CELL, HINGE, SLIDE, Design, Motion, Specimen

# mypy: ignore-errors
# Annotations of kernels must be types, not text: no `from __future__ import annotations` here.

Rows = wp.array2d(dtype=float)


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
def write(design: Design, observations: Rows, world: int, part: int, j: int, value: float) -> None:
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
    # The pose that was desired for this time was given before the action.
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
        write(design, observations, world, 0, k, motor)
        write(design, observations, world, 1, k, rate * (motor - motion.last_motor[world, k]))
        motion.last_motor[world, k] = motor
        tension = motion.tension[world, k]
        if design.numbers[HAS_CELL, k] == 0.0:
            tension = -3.0e38
        write(design, observations, world, 2, k, tension)
        write(design, observations, world, 8, k, wp.clamp(actions[world, k], -1.0, 1.0))
    for k in range(design.encoded.shape[0]):
        joint = motion.joint[world, k]
        write(design, observations, world, 3, k, joint)
        write(design, observations, world, 4, k, rate * (joint - motion.last_joint[world, k]))
        motion.last_joint[world, k] = joint
    for j in range(joints):
        write(design, observations, world, 5, j, specimen.targets[world, asked, j])
        write(design, observations, world, 6, j, specimen.targets[world, asked, joints + j])
    entry = int(0)
    for j in range(3):
        if design.axes[j] > 0.0:
            write(design, observations, world, 7, entry, specimen.targets[world, asked, 2 * joints + j])
            entry += 1
