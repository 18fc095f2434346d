"""Reference values for URDF robots by Pinocchio: random trees and an arm of seven joints.

    python benches/peers/urdf_golden.py crates/sinew/tests/sinew/description/pinocchio.json

For each robot: the file, its moving joints, and poses with velocities, accelerations, forces (inverse dynamics), mass
matrix (row by row) and the accelerations that other forces cause (forward dynamics), all in the order of `joints`.
"""

import json
import sys

import numpy as np
import pinocchio as pin

rng = np.random.default_rng(7)


def triple(v):
    return " ".join(repr(float(x)) for x in v)


def link(name, mass, center, moments, turn):
    ixx, iyy, izz = moments
    return (
        f'  <link name="{name}">\n    <inertial>\n      <origin xyz="{triple(center)}" rpy="{triple(turn)}"/>\n'
        f'      <mass value="{mass!r}"/>\n      <inertia ixx="{ixx!r}" ixy="0" ixz="0" iyy="{iyy!r}" iyz="0" '
        f'izz="{izz!r}"/>\n    </inertial>\n  </link>\n'
    )


def joint(name, kind, parent, child, place, turn, axis):
    limit = "" if kind in ("fixed", "continuous") else '    <limit lower="-2.5" upper="2.5" effort="100" velocity="3"/>\n'
    axis = "" if kind == "fixed" else f'    <axis xyz="{triple(axis)}"/>\n'
    return (
        f'  <joint name="{name}" type="{kind}">\n    <parent link="{parent}"/>\n    <child link="{child}"/>\n'
        f'    <origin xyz="{triple(place)}" rpy="{triple(turn)}"/>\n{axis}{limit}  </joint>\n'
    )


def body(name, size):
    mass = float(rng.uniform(0.1, 4.0))
    a, b, c = (float(x) for x in rng.uniform(0.1, 1.0, 3) * size**2 * mass)
    return link(name, mass, rng.uniform(-size, size, 3), (a + b, a + c, b + c), rng.uniform(-3, 3, 3))


def tree(index):
    count = int(rng.integers(4, 13))
    text = body("link_0", 0.1)
    for k in range(1, count):
        kind = str(rng.choice(["revolute", "revolute", "continuous", "prismatic", "fixed"]))
        parent = f"link_{int(rng.integers(max(0, k - 3), k))}"
        text += body(f"link_{k}", 0.1)
        place, turn, axis = rng.uniform(-0.5, 0.5, 3), rng.uniform(-3, 3, 3), rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        if k % 3 == 0:
            axis = np.eye(3)[k % 2]
        text += joint(f"joint_{k}", kind, parent, f"link_{k}", place, turn, axis)
    return f'<robot name="random_{index}">\n{text}</robot>\n'


def arm():
    """Seven hinges, each square to the last, with the lengths and masses of an arm as they are sold."""
    text = link("base", 4.0, (0, 0, 0.07), (0.05, 0.05, 0.03), (0, 0, 0))
    lengths, masses = (0.1575, 0.2025, 0.2045, 0.2155, 0.1845, 0.2155, 0.081), (4.0, 4.0, 3.0, 2.7, 1.7, 1.8, 0.3)
    half, last = float(np.pi / 2), "base"
    turns = ((0, 0, 0), (half, 0, 0), (-half, 0, 0), (-half, 0, 0), (half, 0, 0), (half, 0, 0), (-half, 0, 0))
    for k, (length, mass, turn) in enumerate(zip(lengths, masses, turns), 1):
        moments = (mass * 0.012, mass * 0.011, mass * 0.003)
        text += link(f"link_{k}", mass, (0.0003 * k, 0.03, 0.04), moments, (0.01 * k, 0, 0.02))
        place = (0, 0, length) if k % 2 else (0, length, 0)
        text += joint(f"joint_{k}", "revolute", last, f"link_{k}", place, turn, (0, 0, 1))
        last = f"link_{k}"
    return f'<robot name="seven">\n{text}</robot>\n'


def numbers(x):
    return [float(v) for v in np.asarray(x).ravel()]


def cases(text, count):
    model = pin.buildModelFromXML(text)
    data = model.createData()
    names = list(model.names)[1:]
    order = [model.joints[model.getJointId(name)].idx_v for name in names]
    out = []
    for _ in range(count):
        angles, v, a, tau = (rng.uniform(-2, 2, len(names)) for _ in range(4))
        q = pin.neutral(model)
        for name, angle in zip(names, angles):
            one = model.joints[model.getJointId(name)]
            q[one.idx_q : one.idx_q + one.nq] = [angle] if one.nq == 1 else [np.cos(angle), np.sin(angle)]
        back = np.empty(len(names), int)
        back[order] = np.arange(len(names))
        to = lambda x: np.asarray(x)[back]
        mass = pin.crba(model, data, q)
        mass = np.triu(mass) + np.triu(mass, 1).T
        out.append(
            dict(
                q=numbers(angles), v=numbers(v), a=numbers(a), tau=numbers(tau),
                inverse=numbers(pin.rnea(model, data, q, to(v), to(a))[order]),
                mass=numbers(mass[np.ix_(order, order)]),
                forward=numbers(pin.aba(model, data, q, to(v), to(tau))[order]),
            )
        )
    return dict(urdf=text, joints=names, cases=out)


robots = [cases(arm(), 20)] + [cases(tree(index), 4) for index in range(10)]
with open(sys.argv[1], "w") as file:
    json.dump(dict(pinocchio=pin.__version__, robots=robots), file)
