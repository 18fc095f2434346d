"""Reference values for the body and its muscles: one JSON file per robot, by MuJoCo and (chain7) by Pinocchio.

    python benches/peers/body_golden.py OUT [ROBOT.xml ...] [--poses N] [--random N]

Without a robot it writes those made here: tendon examples, ball and free joints, random trees. Each file
holds the robot as `sinew::body::Parts` reads it, taken from the compiled model, and for each pose coordinates,
velocities and accelerations with what MuJoCo finds for them.
"""

import argparse
import json
from pathlib import Path

import mujoco
import numpy as np

KINDS = {0: "Free", 1: "Ball", 2: "Slide", 3: "Hinge"}
SITE, SPHERE, CYLINDER, PULLEY, JOINT = (
    int(getattr(mujoco.mjtWrap, "mjWRAP_" + name)) for name in ("SITE", "SPHERE", "CYLINDER", "PULLEY", "JOINT")
)


def numbers(array):
    return [float(x) for x in np.asarray(array, float).ravel()]


def rotation(quaternion):
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, np.asarray(quaternion, float))
    return matrix.reshape(3, 3)


def route(model, tendon, wrap_of):
    first, count = model.tendon_adr[tendon], model.tendon_num[tendon]
    stations = range(first, first + count)
    if model.wrap_type[first] == JOINT:
        return {"Fixed": [[int(model.wrap_objid[k]), float(model.wrap_prm[k])] for k in stations]}
    path = []
    for k in stations:
        kind, thing, value = model.wrap_type[k], int(model.wrap_objid[k]), float(model.wrap_prm[k])
        if kind == SITE:
            path.append({"Site": thing})
        elif kind == PULLEY:
            path.append({"Pulley": value})
        else:
            side = round(value)
            path.append({"Wrap": {"wrap": wrap_of[thing], "side": side if side >= 0 else None}})
    return {"Spatial": path}


def body_part(model, b):
    axes = rotation(model.body_iquat[b])
    inertia = axes @ np.diag(model.body_inertia[b]) @ axes.T
    return {
        "name": model.body(b).name,
        "parent": int(model.body_parentid[b]),
        "position": numbers(model.body_pos[b]),
        "orientation": numbers(model.body_quat[b]),
        "mass": float(model.body_mass[b]),
        "center_of_mass": numbers(model.body_ipos[b]),
        "inertia": [float(inertia[i]) for i in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))],
    }


def joint_part(model, j):
    v, q = model.jnt_dofadr[j], model.jnt_qposadr[j]
    scalar = model.jnt_type[j] >= 2
    return {
        "name": model.joint(j).name,
        "body": int(model.jnt_bodyid[j]),
        "kind": KINDS[int(model.jnt_type[j])],
        "anchor": numbers(model.jnt_pos[j]),
        "axis": numbers(model.jnt_axis[j]),
        "reference": float(model.qpos0[q]) if scalar else 0.0,
        "range": numbers(model.jnt_range[j]) if model.jnt_limited[j] else None,
        "armature": float(np.ravel(model.dof_armature[v])[0]),
        "damping": float(np.ravel(model.dof_damping[v])[0]),
        "friction": float(np.ravel(model.dof_frictionloss[v])[0]),
        "stiffness": float(np.ravel(model.jnt_stiffness[j])[0]),
        "spring_reference": float(model.qpos_spring[q]) if scalar else 0.0,
    }


def parts(model):
    geoms = sorted({int(g) for g, t in zip(model.wrap_objid, model.wrap_type) if t in (SPHERE, CYLINDER)})
    wrap_of = {geom: index for index, geom in enumerate(geoms)}
    equalities = [
        e for e in range(model.neq)
        if model.eq_type[e] == mujoco.mjtEq.mjEQ_JOINT and model.eq_active0[e]
    ]
    return {
        "name": "golden",
        "gravity": numbers(model.opt.gravity),
        "bodies": [body_part(model, b) for b in range(model.nbody)],
        "joints": [joint_part(model, j) for j in range(model.njnt)],
        "sites": [
            {
                "name": model.site(s).name,
                "body": int(model.site_bodyid[s]),
                "position": numbers(model.site_pos[s]),
                "orientation": numbers(model.site_quat[s]),
            }
            for s in range(model.nsite)
        ],
        "wraps": [
            {
                "name": model.geom(g).name,
                "body": int(model.geom_bodyid[g]),
                "kind": "Sphere" if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_SPHERE else "Cylinder",
                "radius": float(model.geom_size[g][0]),
                "position": numbers(model.geom_pos[g]),
                "orientation": numbers(model.geom_quat[g]),
            }
            for g in geoms
        ],
        "tendons": [
            {
                "name": model.tendon(t).name,
                "route": route(model, t, wrap_of),
                "sheath": None,
                "range": None,
                "damping": 0.0,
                "stiffness": 0.0,
                "spring_length": None,
            }
            for t in range(model.ntendon)
        ],
        "couplings": [
            {
                "follower": int(model.eq_obj1id[e]),
                "leader": int(model.eq_obj2id[e]) if model.eq_obj2id[e] >= 0 else None,
                "coefficients": numbers(model.eq_data[e][:5]),
            }
            for e in equalities
        ],
        "actuators": [],
        "keys": [],
    }


def random_pose(model, rng):
    q = np.array(model.qpos0)
    for j in range(model.njnt):
        at = model.jnt_qposadr[j]
        if model.jnt_type[j] < 2:
            if model.jnt_type[j] == 0:
                q[at : at + 3] = rng.normal(size=3)
                at += 3
            q[at : at + 4] = rng.normal(size=4)
            q[at : at + 4] /= np.linalg.norm(q[at : at + 4])
        elif model.jnt_limited[j]:
            q[at] = rng.uniform(*model.jnt_range[j])
        else:
            q[at] += rng.uniform(-1, 1) * (1.5 if model.jnt_type[j] == 3 else 0.1)
    return q


def dense_arms(model, data):
    arms = np.zeros((model.ntendon, model.nv))
    moments = np.ravel(data.ten_J)
    rows = getattr(data, "ten_J_rownnz", None)
    if moments.size == arms.size and not mujoco.mj_isSparse(model):
        return -moments.reshape(arms.shape)
    source = data if rows is not None else model
    for t in range(model.ntendon):
        first, count = source.ten_J_rowadr[t], source.ten_J_rownnz[t]
        arms[t, source.ten_J_colind[first : first + count]] = -moments[first : first + count]
    return arms


def case(model, data, rng):
    # Springs and dampers of tendons are not the body's.
    model.tendon_stiffness[:] = model.tendon_damping[:] = 0
    data.qpos[:] = random_pose(model, rng)
    data.qvel[:] = rng.normal(size=model.nv)
    data.qacc[:] = rng.normal(size=model.nv)
    mujoco.mj_forward(model, data)
    acceleration = rng.normal(size=model.nv)
    mass = np.zeros((model.nv, model.nv))
    for v in range(model.nv):
        unit, column = np.zeros(model.nv), np.zeros(model.nv)
        unit[v] = 1
        mujoco.mj_mulM(model, data, column, unit)
        mass[:, v] = column
    velocity = np.array(data.qvel)
    bias, passive = np.array(data.qfrc_bias), np.array(data.qfrc_passive)
    lengths, arms = np.array(data.ten_length), dense_arms(model, data)
    origins, sites = np.array(data.xpos), np.array(data.site_xpos)
    data.qvel[:] = 0
    mujoco.mj_forward(model, data)
    return {
        "q": numbers(data.qpos),
        "v": numbers(velocity),
        "a": numbers(acceleration),
        "lengths": numbers(lengths),
        "arms": [[t, v, arms[t, v]] for t, v in zip(*(map(int, k) for k in np.nonzero(arms)))],
        "mass": numbers(mass[np.tril_indices(model.nv)]),
        "bias": numbers(bias),
        "gravity": numbers(data.qfrc_bias),
        "passive": numbers(passive),
        "last_body": numbers(origins[-1]),
        "last_site": numbers(sites[-1]) if model.nsite else [0.0, 0.0, 0.0],
    }


def vector(rng, size=1.0):
    return " ".join(f"{x:.4f}" for x in rng.normal(size=3) * size)


def random_robot(seed):
    """A random tree: every kind of joint, bodies without joints, tendons of every kind through it."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(4, 9))
    children = {k: [] for k in range(count + 1)}
    for k in range(1, count + 1):
        children[int(rng.integers(max(0, k - 3), k))].append(k)
    names = []

    def body(k):
        joints, scalars = "", []
        kind = rng.choice(["hinge", "hinge", "two", "slide", "ball", "free", "weld"])
        if kind == "free" and k not in children[0]:
            kind = "ball"
        if kind in ("ball", "free"):
            extra = f'pos="{vector(rng, 0.05)}" stiffness="0.3"' if kind == "ball" else ""
            joints = f'<joint name="j{k}" type="{kind}" {extra} damping="0.2" armature="0.01"/>'
        elif kind != "weld":
            for m in range(2 if kind == "two" else 1):
                shape = "slide" if kind == "slide" else "hinge"
                joints += (
                    f'<joint name="j{k}_{m}" type="{shape}" axis="{vector(rng)}" pos="{vector(rng, 0.05)}" '
                    f'ref="{rng.normal():.3f}" springref="{rng.normal():.3f}" stiffness="0.5" damping="0.1" '
                    f'armature="{rng.uniform(0, 0.02):.4f}"/>'
                )
                scalars.append(f"j{k}_{m}")
        names.extend(scalars)
        moments = rng.uniform(0.01, 0.02, 3)
        inner = "".join(body(child) for child in children[k])
        return (
            f'<body name="b{k}" pos="{vector(rng, 0.15)}" quat="{vector(rng)} 0.5">{joints}'
            f'<inertial pos="{vector(rng, 0.05)}" quat="{vector(rng)} 0.3" mass="{rng.uniform(0.2, 2):.3f}" '
            f'diaginertia="{" ".join(f"{m:.4f}" for m in moments)}"/>'
            f'<site name="s{k}a" pos="{vector(rng, 0.08)}"/><site name="s{k}b" pos="{vector(rng, 0.08)}"/>'
            f'<site name="s{k}c" pos="{vector(rng, 0.01)}"/>'
            f'<geom name="g{k}a" type="sphere" size="{rng.uniform(0.03, 0.09):.4f}" pos="{vector(rng, 0.03)}" mass="0"/>'
            f'<geom name="g{k}b" type="cylinder" size="{rng.uniform(0.03, 0.09):.4f} 0.1" quat="{vector(rng)} 0.4" '
            f'pos="{vector(rng, 0.03)}" mass="0"/>{inner}</body>'
        )

    bodies = "".join(body(k) for k in children[0])
    tendons = ""
    for t in range(12):
        path, last = "", None
        for leg in range(int(rng.integers(2, 5))):
            site = f"s{rng.integers(1, count + 1)}{rng.choice(['a', 'b'])}"
            if last is not None:
                if last == site:
                    continue
                wrap = rng.choice(["none", "g", "side", "inside"])
                geom = f"g{rng.integers(1, count + 1)}{rng.choice(['a', 'b'])}"
                if wrap == "g":
                    path += f'<geom geom="{geom}"/>'
                elif wrap == "side":
                    path += f'<geom geom="{geom}" sidesite="s{rng.integers(1, count + 1)}a"/>'
                elif wrap == "inside":
                    path += f'<geom geom="{geom}" sidesite="s{geom[1:-1]}c"/>'
            path += f'<site site="{site}"/>'
            last = site
        if path.count("<site ") < 2:
            continue
        if t % 4 == 0:
            a, b, c = rng.choice(count, 3, replace=False) + 1
            path += f'<pulley divisor="2"/><site site="s{a}a"/><geom geom="g{c}a"/><site site="s{b}b"/>'
            path += f'<pulley divisor="3"/><site site="s{b}b"/><site site="s{c}a"/>'
        tendons += f'<spatial name="t{t}">{path}</spatial>'
    if names:
        terms = "".join(f'<joint joint="{name}" coef="{rng.normal():.3f}"/>' for name in names[:3])
        tendons += f'<fixed name="fixed">{terms}</fixed>'
    return f"<mujoco><compiler angle='radian'/><worldbody>{bodies}</worldbody><tendon>{tendons}</tendon></mujoco>"


FINGER = """
<mujoco><compiler angle="radian"/><worldbody>
  <site name="root" pos="-0.02 0 0.03"/><site name="root2" pos="-0.02 0.01 -0.03"/>
  <body name="first"><joint name="one" axis="0 1 0" ref="0.1" range="-0.3 1.6" limited="true"/>
    <joint name="side" axis="0 0 1" range="-0.4 0.4" limited="true"/>
    <inertial pos="0.03 0 0" mass="0.1" diaginertia="2e-5 9e-5 9e-5"/>
    <geom name="knuckle" type="sphere" size="0.012" mass="0"/>
    <geom name="roll" type="cylinder" size="0.008 0.02" pos="0.06 0 0" euler="1.5707963 0 0" mass="0"/>
    <geom name="ring" type="cylinder" size="0.005 0.01" pos="0.03 0 0.012" euler="0 1.5707963 0.2" mass="0"/>
    <geom name="hoop" type="sphere" size="0.004" pos="0.03 0 -0.014" mass="0"/>
    <site name="a" pos="0.02 0.002 0.014"/><site name="b" pos="0.045 -0.003 0.013"/>
    <site name="c" pos="0.02 0.002 -0.013"/><site name="d" pos="0.05 0.004 -0.012"/>
    <site name="over" pos="0 0 0.02"/><site name="under" pos="0.06 0 -0.02"/><site name="on" pos="0.06 0 0.02"/>
    <site name="through" pos="0.03 0 0.012"/><site name="within" pos="0.03 0 -0.014"/>
    <body name="second" pos="0.06 0 0"><joint name="two" axis="0 1 0" range="-0.1 1.9" limited="true"/>
      <inertial pos="0.02 0 0" mass="0.05" diaginertia="5e-6 3e-5 3e-5"/>
      <site name="tip" pos="0.03 0.004 0.006"/><site name="palm" pos="0.03 0 -0.006"/>
    </body></body></worldbody>
  <tendon>
    <spatial name="extensor"><site site="root"/><geom geom="knuckle" sidesite="over"/><site site="a"/>
      <geom geom="ring" sidesite="through"/><site site="b"/><geom geom="roll" sidesite="on"/><site site="tip"/></spatial>
    <spatial name="flexor"><site site="root2"/><geom geom="knuckle"/><site site="c"/>
      <geom geom="hoop" sidesite="within"/><site site="d"/><geom geom="roll" sidesite="under"/><site site="palm"/></spatial>
    <spatial name="ring_across"><site site="root"/><geom geom="ring" sidesite="through"/><site site="tip"/></spatial>
    <spatial name="hoop_across"><site site="root2"/><geom geom="hoop" sidesite="within"/><site site="palm"/></spatial>
    <spatial name="free_roll"><site site="a"/><geom geom="roll"/><site site="palm"/></spatial>
    <spatial name="tackle"><site site="root"/><site site="a"/><pulley divisor="2"/><site site="b"/>
      <geom geom="roll"/><site site="tip"/><pulley divisor="2"/><site site="d"/><site site="palm"/></spatial>
    <fixed name="sum"><joint joint="one" coef="0.01"/><joint joint="two" coef="-0.02"/></fixed>
  </tendon>
  <equality><joint joint1="side" joint2="one" polycoef="0.1 0.2 -0.1 0.05 0"/></equality>
</mujoco>"""


def chain(seed, joints=7):
    """A serial arm as a URDF has it, with the values of Pinocchio."""
    import pinocchio

    rng, model = np.random.default_rng(seed), pinocchio.Model()
    world = {"name": "world", "parent": 0, "position": [0.0] * 3, "orientation": [1.0, 0.0, 0.0, 0.0],
             "mass": 0.0, "center_of_mass": [0.0] * 3, "inertia": [0.0] * 6}
    bodies, described, parent = [world], [], 0
    for k in range(joints):
        placement, axis = pinocchio.SE3.Random(), rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        placement.translation = rng.normal(size=3) * 0.2
        placement.rotation = pinocchio.exp3(rng.normal(size=3))
        mass, center, moments = rng.uniform(0.5, 3), rng.normal(size=3) * 0.1, rng.uniform(0.02, 0.035, 3)
        axes = pinocchio.exp3(rng.normal(size=3))
        inertia = axes @ np.diag(moments) @ axes.T
        parent = model.addJoint(parent, pinocchio.JointModelRevoluteUnaligned(axis), placement, f"j{k + 1}")
        model.appendBodyToJoint(parent, pinocchio.Inertia(mass, center, inertia), pinocchio.SE3.Identity())
        turn = pinocchio.Quaternion(placement.rotation)
        bodies.append({
            "name": f"b{k + 1}", "parent": k, "position": numbers(placement.translation),
            "orientation": [turn.w, turn.x, turn.y, turn.z], "mass": mass, "center_of_mass": numbers(center),
            "inertia": [float(inertia[i]) for i in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))],
        })
        described.append({
            "name": f"j{k + 1}", "body": k + 1, "kind": "Hinge", "anchor": [0.0] * 3, "axis": numbers(axis),
            "reference": 0.0, "range": None, "armature": 0.0, "damping": 0.0, "friction": 0.0,
            "stiffness": 0.0, "spring_reference": 0.0,
        })
    empty = {key: [] for key in ("sites", "wraps", "tendons", "couplings", "actuators", "keys")}
    parts = {"name": "chain", "gravity": numbers(model.gravity.linear), "bodies": bodies, "joints": described, **empty}
    data, cases = model.createData(), []
    for _ in range(6):
        q, v, a, tau = rng.uniform(-3, 3, joints), *rng.normal(size=(3, joints))
        mass = pinocchio.crba(model, data, q)
        mass = np.triu(mass) + np.triu(mass, 1).T
        cases.append({
            "q": numbers(q), "v": numbers(v), "a": numbers(a), "mass": numbers(mass[np.tril_indices(joints)]),
            "inverse": numbers(pinocchio.rnea(model, data, q, v, a)), "tau": numbers(tau),
            "forward": numbers(pinocchio.aba(model, data, q, v, tau)),
        })
    return {"parts": parts, "cases": cases}


def write(name, model, out, poses, seed):
    rng, data = np.random.default_rng(seed), mujoco.MjData(model)
    # Contacts and limits are not part of it.
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    content = {"parts": parts(model), "cases": [case(model, data, rng) for _ in range(poses)]}
    path = out / f"{name}.json"
    path.write_text(json.dumps(content, separators=(",", ":")) + "\n")
    print(f"{path.name}: {path.stat().st_size} bytes, nv {model.nv}, tendons {model.ntendon}")


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    arguments.add_argument("out", type=Path)
    arguments.add_argument("robots", type=Path, nargs="*")
    arguments.add_argument("--poses", type=int, default=6)
    arguments.add_argument("--random", type=int, default=5, help="how many random robots")
    given = arguments.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    for robot in given.robots:
        write(robot.stem, mujoco.MjModel.from_xml_path(str(robot)), given.out, given.poses, 1)
    if given.robots:
        return
    write("finger", mujoco.MjModel.from_xml_string(FINGER), given.out, 2 * given.poses, 2)
    path = given.out / "chain7.json"
    path.write_text(json.dumps(chain(3), separators=(",", ":")) + "\n")
    for seed in range(given.random):
        write(f"random_{seed}", mujoco.MjModel.from_xml_string(random_robot(seed)), given.out, given.poses, seed)


if __name__ == "__main__":
    main()
