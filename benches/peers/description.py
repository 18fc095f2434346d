"""Compares what `sinew arm` makes of MJCF files with MuJoCo's own compiler.

    python benches/peers/description.py SINEW FILE.xml ...

Each file is converted to MJCF and to TOML and back to MJCF by SINEW (the program); MuJoCo compiles the original and
both results. Printed: the largest difference of masses, full inertia tensors, places, joints, sites, tendons, couplings,
actuators and keys, and of lengths, moment arms and gravity torques of `sinew arm evaluate` at 20 random poses.
"""
import csv, os, subprocess, sys, tempfile
import mujoco as mj
import numpy as np

def mat(q):
    m = np.zeros(9); mj.mju_quat2Mat(m, q); return m.reshape(3, 3)

def describe(m):
    tensor = [mat(m.body_iquat[b]) @ np.diag(m.body_inertia[b]) @ mat(m.body_iquat[b]).T for b in range(m.nbody)]
    hinge = np.isin(m.jnt_type, (2, 3))
    out = dict(mass=m.body_mass, com=m.body_ipos * (m.body_mass[:, None] > 0), tensor=np.array(tensor), body_pos=m.body_pos,
               body_rot=np.array([mat(q) for q in m.body_quat]), parent=m.body_parentid, jnt_type=m.jnt_type,
               jnt_axis=m.jnt_axis[hinge], jnt_pos=m.jnt_pos, limited=m.jnt_limited, range=m.jnt_range * m.jnt_limited[:, None],
               qpos0=m.qpos0, spring=m.qpos_spring, stiffness=m.jnt_stiffness, damping=m.dof_damping, armature=m.dof_armature,
               friction=m.dof_frictionloss, site_pos=m.site_pos, site_rot=np.array([mat(q) for q in m.site_quat]),
               site_body=m.site_bodyid, wrap_type=m.wrap_type, tendon_num=m.tendon_num, gravity=m.opt.gravity,
               tendon_range=m.tendon_range * m.tendon_limited[:, None], tendon_damping=m.tendon_damping,
               tendon_stiffness=m.tendon_stiffness, tendon_spring=m.tendon_lengthspring, length0=m.tendon_length0,
               eq=m.eq_data[m.eq_type == 2][:, :5], gear=m.actuator_gear[m.actuator_trntype == 3][:, 0],
               ctrl=(m.actuator_ctrlrange * m.actuator_ctrllimited[:, None])[m.actuator_trntype == 3],
               force=(m.actuator_forcerange * m.actuator_forcelimited[:, None])[m.actuator_trntype == 3], key=m.key_qpos)
    return {k: np.asarray(v, float) for k, v in out.items()}

def difference(a, b):
    worst = {}
    for k in a:
        if a[k].shape != b[k].shape: worst[k] = f"shape {a[k].shape} {b[k].shape}"; continue
        d = float(np.abs(a[k] - b[k]).max()) if a[k].size else 0.0
        if d > 1e-12 * max(1.0, float(np.abs(a[k]).max()) if a[k].size else 1.0): worst[k] = d
    return worst

def evaluate(sinew, file, m, folder):
    rng = np.random.default_rng(0); d = mj.MjData(m)
    single = [j for j in range(m.njnt) if m.jnt_type[j] in (2, 3)]
    names = {j: mj.mj_id2name(m, mj.mjtObj.mjOBJ_JOINT, j) or f"joint_{j}" for j in single}
    poses = []
    for _ in range(20):
        q = m.qpos0.copy()
        for j in single:
            lo, hi = m.jnt_range[j] if m.jnt_limited[j] else (-1.5, 1.5)
            q[m.jnt_qposadr[j]] = rng.uniform(lo, hi)
        poses.append(q)
    table = os.path.join(folder, "poses.csv"); out = os.path.join(folder, "out.csv")
    with open(table, "w") as f:
        f.write(",".join(names[j] for j in single) + "\n")
        for q in poses: f.write(",".join(repr(float(q[m.jnt_qposadr[j]])) for j in single) + "\n")
    subprocess.run([sinew, "arm", "evaluate", file, "--poses", table, "--out", out], check=True, capture_output=True)
    rows = list(csv.reader(open(out)))[1:]; worst = [0.0, 0.0, 0.0]
    for q, row in zip(poses, rows):
        row = np.array(row, float); nt, nv = m.ntendon, m.nv
        d.qpos[:] = q; d.qvel[:] = 0; mj.mj_forward(m, d)
        J = np.zeros((nt, nv))
        mj.mj_tendon(m, d)
        adr, cnt, ind = m.ten_J_rowadr, m.ten_J_rownnz, m.ten_J_colind
        for t in range(nt):
            for k in range(cnt[t]): J[t, ind[adr[t] + k]] = d.ten_J.ravel()[adr[t] + k]
        length, arms = row[:nt], row[nt:nt + nt * nv].reshape(nt, nv); grav = row[2 * nt + nt * nv:2 * nt + nt * nv + nv]
        worst[0] = max(worst[0], np.abs(length - d.ten_length).max(initial=0))
        worst[1] = max(worst[1], np.abs(arms + J).max(initial=0))
        worst[2] = max(worst[2], np.abs(grav - d.qfrc_bias).max(initial=0) / max(1e-9, np.abs(d.qfrc_bias).max(initial=1e-9)))
    return worst

sinew, files = sys.argv[1], sys.argv[2:]
for file in files:
    with tempfile.TemporaryDirectory() as folder:
        one, toml, two = (os.path.join(folder, n) for n in ("one.xml", "two.toml", "two.xml"))
        try:
            m = mj.MjModel.from_xml_path(file)
            for a, b in ((file, one), (file, toml), (toml, two)):
                subprocess.run([sinew, "arm", "convert", a, b], check=True, capture_output=True, text=True)
            a = describe(m)
            print(os.path.basename(file), "differs beyond 1e-12:", difference(a, describe(mj.MjModel.from_xml_path(one))),
                  "by TOML:", difference(a, describe(mj.MjModel.from_xml_path(two))), "same bytes:", open(one).read() == open(two).read())
            print("   length m, moment arm m, gravity relative:", *evaluate(sinew, file, m, folder))
        except subprocess.CalledProcessError as e: print(os.path.basename(file), "SINEW:", e.stderr)
        except Exception as e: print(os.path.basename(file), type(e).__name__, e)
