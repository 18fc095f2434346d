"""Compares what `sinew arm` makes of MJCF files with MuJoCo's own compiler.

    python benches/peers/description.py SINEW FILE.xml ...

Each file is converted to MJCF and to TOML and back to MJCF by SINEW (the program); MuJoCo compiles the original and
both results. Printed: the largest difference of masses, full inertia tensors, places, joints, sites, tendons, couplings, laws of
actuators and keys, and of lengths, moment arms, gravity torques and sites of `sinew machine evaluate` at 20 random poses, with some
joints left out and quaternions of any length.
"""
import csv, os, subprocess, sys, tempfile
import mujoco as mj
import numpy as np

def mat(q):
    m = np.zeros(9); mj.mju_quat2Mat(m, q); return m.reshape(3, 3)

def describe(m):
    tensor = [mat(m.body_iquat[b]) @ np.diag(m.body_inertia[b]) @ mat(m.body_iquat[b]).T for b in range(m.nbody)]
    on = m.actuator_trntype == 3
    hinge = np.isin(m.jnt_type, (2, 3))
    out = dict(mass=m.body_mass, com=m.body_ipos * (m.body_mass[:, None] > 0), tensor=np.array(tensor), body_pos=m.body_pos,
               body_rot=np.array([mat(q) for q in m.body_quat]), parent=m.body_parentid, jnt_type=m.jnt_type,
               jnt_axis=m.jnt_axis[hinge], jnt_pos=m.jnt_pos, limited=m.jnt_limited, range=m.jnt_range * m.jnt_limited[:, None],
               qpos0=m.qpos0, spring=m.qpos_spring, stiffness=m.jnt_stiffness, damping=m.dof_damping, armature=m.dof_armature,
               friction=m.dof_frictionloss, site_pos=m.site_pos, site_rot=np.array([mat(q) for q in m.site_quat]),
               site_body=m.site_bodyid, wrap_type=m.wrap_type, tendon_num=m.tendon_num, gravity=m.opt.gravity,
               tendon_range=m.tendon_range * m.tendon_limited[:, None], tendon_damping=m.tendon_damping,
               tendon_stiffness=m.tendon_stiffness, tendon_spring=m.tendon_lengthspring, length0=m.tendon_length0,
               eq=m.eq_data[(m.eq_type == 2) & m.eq_active0][:, :5], gear=m.actuator_gear[on][:, 0],
               gain=m.actuator_gainprm[on], bias=m.actuator_biasprm[on], dyn=m.actuator_dynprm[on],
               laws=np.stack([m.actuator_gaintype, m.actuator_biastype, m.actuator_dyntype])[:, on],
               lengths=m.actuator_lengthrange[on],
               ctrl=(m.actuator_ctrlrange * m.actuator_ctrllimited[:, None])[on],
               force=(m.actuator_forcerange * m.actuator_forcelimited[:, None])[on], key=m.key_qpos)
    return {k: np.asarray(v, float) for k, v in out.items()}

def difference(a, b):
    worst = {}
    for k in a:
        if a[k].shape != b[k].shape: worst[k] = f"shape {a[k].shape} {b[k].shape}"; continue
        d = float(np.abs(a[k] - b[k]).max()) if a[k].size else 0.0
        if d > 1e-12 * max(1.0, float(np.abs(a[k]).max()) if a[k].size else 1.0): worst[k] = d
    return worst

MANY = {0: ("x", "y", "z", "qw", "qx", "qy", "qz"), 1: ("qw", "qx", "qy", "qz")}

def columns(m, j):
    name = mj.mj_id2name(m, mj.mjtObj.mjOBJ_JOINT, j) or f"joint_{j}"
    return [f"{name}.{part}" for part in MANY[int(m.jnt_type[j])]] if int(m.jnt_type[j]) in MANY else [name]

def follow(m, given, q):
    """Joints that no column gives stay at their reference or follow their coupling."""
    for _ in range(m.neq):
        for e in range(m.neq):
            if m.eq_type[e] != mj.mjtEq.mjEQ_JOINT or not m.eq_active0[e] or m.eq_obj1id[e] in given: continue
            a, b = m.jnt_qposadr[m.eq_obj1id[e]], m.eq_obj2id[e]
            x = q[m.jnt_qposadr[b]] - m.qpos0[m.jnt_qposadr[b]] if b >= 0 else 0.0
            q[a] = m.qpos0[a] + np.polyval(m.eq_data[e][:5][::-1], x)

def evaluate(sinew, file, m, folder, seed=0):
    """Random poses, quaternions not of unit length, some joints left out."""
    rng = np.random.default_rng(seed); d = mj.MjData(m); worst = [0.0, 0.0, 0.0, 0.0]
    for _ in range(20):
        given = [j for j in range(m.njnt) if rng.random() < 0.8] or [0]; rng.shuffle(given)
        q = m.qpos0.copy(); header, row = [], []
        for j in given:
            at, parts = m.jnt_qposadr[j], columns(m, j)
            lo, hi = m.jnt_range[j] if m.jnt_limited[j] and len(parts) == 1 else (-1.5, 1.5)
            value = rng.uniform(lo, hi, len(parts)); q[at:at + len(parts)] = value
            if len(parts) > 1: q[at + len(parts) - 4:at + len(parts)] /= np.linalg.norm(value[-4:])
            header += parts; row += [repr(float(x)) for x in value]
        follow(m, given, q)
        table = os.path.join(folder, "poses.csv"); out = os.path.join(folder, "out.csv")
        open(table, "w").write(",".join(header) + "\n" + ",".join(row) + "\n")
        subprocess.run([sinew, "machine", "evaluate", file, "--poses", table, "--out", out], check=True, capture_output=True)
        names, row = list(csv.reader(open(out)))
        d.qpos[:] = q; d.qvel[:] = 0; mj.mj_fwdPosition(m, d); mj.mj_fwdVelocity(m, d)
        J = np.zeros((m.ntendon, m.nv)); adr, cnt, ind = m.ten_J_rowadr, m.ten_J_rownnz, m.ten_J_colind
        for t in range(m.ntendon):
            for k in range(cnt[t]): J[t, ind[adr[t] + k]] = d.ten_J.ravel()[adr[t] + k]
        of = lambda kind: np.array([float(x) for n, x in zip(names, row) if n.startswith(kind)])
        scale = max(1e-6, np.abs(d.qfrc_bias).max(initial=1e-6))
        for k, error in enumerate((of("length_m:") - d.ten_length, of("moment_arm_m:") + J.ravel(),
                                   (of("gravity_torque_nm:") - d.qfrc_bias + d.qfrc_gravcomp) / scale,
                                   np.stack([of(f"{x}_m:") for x in "xyz"], 1) - d.site_xpos)):
            worst[k] = max(worst[k], np.abs(error).max(initial=0))
    return worst

def compare(sinew, file):
    """Prints how one file differs from what MuJoCo makes of it."""
    with tempfile.TemporaryDirectory() as folder:
        one, toml, two = (os.path.join(folder, n) for n in ("one.xml", "two.toml", "two.xml"))
        try:
            m = mj.MjModel.from_xml_path(file)
            for a, b in ((file, one), (file, toml), (toml, two)):
                subprocess.run([sinew, "machine", "convert", a, b], check=True, capture_output=True, text=True)
            a = describe(m)
            print(os.path.basename(file), "differs beyond 1e-12:", difference(a, describe(mj.MjModel.from_xml_path(one))),
                  "by TOML:", difference(a, describe(mj.MjModel.from_xml_path(two))), "same bytes:", open(one).read() == open(two).read())
            print("   length m, moment arm m, gravity relative, sites m:", *evaluate(sinew, file, m, folder))
        except subprocess.CalledProcessError as e: print(os.path.basename(file), "SINEW:", e.stderr)
        except Exception as e: print(os.path.basename(file), type(e).__name__, e)
if __name__ == "__main__":
    for file in sys.argv[2:]: compare(sys.argv[1], file)
