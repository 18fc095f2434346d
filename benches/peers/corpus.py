"""Walks a folder of robot files and compares what `sinew` makes of each with MuJoCo: loaded, refused or wrong.

    python benches/peers/corpus.py [--all] [--poses N] SINEW FOLDER ...

Every MJCF and URDF file below the folders that MuJoCo compiles is tried; files with tendons alone, unless `--all` is given.
Wrong is a file whose moving masses differ by more than 1e-6 of the whole, lengths by 1e-8 m, moment arms by 1e-7 m, or gravity
torques by 1e-7 of the largest, in random poses of all joints. Printed: a line for every file that is refused, with the
reason, or wrong, and the counts. The exit status is 1 where one is wrong.
"""
import argparse, collections, csv, os, pathlib, re, subprocess, sys, tempfile
import mujoco as mj
import numpy as np
from description import columns, follow

BARS = {"mass": 1e-6, "length m": 1e-8, "moment arm m": 1e-7, "gravity": 1e-7}

def models(folder):
    for path in sorted(pathlib.Path(folder).rglob("*")):
        if path.suffix not in (".xml", ".urdf") or not path.is_file(): continue
        if re.search(r"<(mujoco|robot)\b", path.read_text(errors="replace")): yield path

def poses(m, count):
    """Names of coordinates, rows of them, and the positions of MuJoCo."""
    rng, header, rows, positions = np.random.default_rng(0), [], [], []
    led = {int(m.eq_obj1id[e]) for e in range(m.neq) if m.eq_type[e] == mj.mjtEq.mjEQ_JOINT and m.eq_active0[e]}
    given = [j for j in range(m.njnt) if j not in led]
    header = [name for j in given for name in columns(m, j)]
    for _ in range(count):
        q, row = m.qpos0.copy(), []
        for j in given:
            at, parts = m.jnt_qposadr[j], len(columns(m, j))
            low, high = m.jnt_range[j] if m.jnt_limited[j] and parts == 1 else (-1.0, 1.0)
            value = rng.uniform(low, high, parts)
            if parts > 1: value[-4:] /= np.linalg.norm(value[-4:])
            q[at:at + parts] = value; row += [repr(float(x)) for x in value]
        follow(m, given, q); rows.append(row); positions.append(q)
    return header, rows, positions

def jacobian(m, d):
    dense = np.zeros((m.ntendon, m.nv))
    for t in range(m.ntendon):
        at = slice(m.ten_J_rowadr[t], m.ten_J_rowadr[t] + m.ten_J_rownnz[t])
        dense[t, m.ten_J_colind[at]] = d.ten_J.ravel()[at]
    return dense

def run(*command):
    """What a run of the program prints; raises with the reason of a refusal."""
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode: raise RuntimeError(" ".join(done.stderr.split()).removeprefix("error: "))
    return done.stdout

def differences(sinew, file, m, count):
    """The largest differences, by the names of `BARS`."""
    with tempfile.TemporaryDirectory() as folder:
        converted, table, out = (os.path.join(folder, name) for name in ("body.xml", "poses.csv", "out.csv"))
        run(sinew, "machine", "convert", file, converted)
        header, rows, positions = poses(m, count)
        with open(table, "w") as stream: csv.writer(stream, lineterminator="\n").writerows([header, *rows])
        run(sinew, "machine", "evaluate", file, "--poses", table, "--out", out)
        again = mj.MjModel.from_xml_path(converted)
        names, *found = csv.reader(open(out))
    worst = dict.fromkeys(BARS, 0.0)
    moving = [float(x.body_mass[x.body_dofnum[x.body_weldid] > 0].sum()) for x in (again, m)]
    worst["mass"] = abs(moving[0] / max(moving[1], 1e-9) - 1.0) if moving[1] else moving[0]
    d = mj.MjData(m)
    for q, row in zip(positions, found, strict=True):
        d.qpos[:] = q; d.qvel[:] = 0; mj.mj_fwdPosition(m, d); mj.mj_fwdVelocity(m, d)
        of = lambda kind: np.array([float(x) for name, x in zip(names, row, strict=True) if name.startswith(kind)])
        errors = {"length m": of("length_m:") - d.ten_length, "moment arm m": of("moment_arm_m:") + jacobian(m, d).ravel(),
                  "gravity": (of("gravity_torque_nm:") - d.qfrc_bias + d.qfrc_gravcomp) / max(np.abs(d.qfrc_bias).max(initial=0.0), 1e-6)}
        for kind, error in errors.items(): worst[kind] = max(worst[kind], float(np.abs(error).max(initial=0.0)))
    return worst

def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--all", action="store_true", help="also files without tendons")
    parser.add_argument("--poses", type=int, default=5)
    parser.add_argument("sinew")
    parser.add_argument("folders", nargs="+")
    given, seen = parser.parse_args(), collections.Counter()
    for path in (path for folder in given.folders for path in models(folder)):
        try: m = mj.MjModel.from_xml_path(str(path))
        except ValueError: seen["no model for MuJoCo"] += 1; continue
        if not given.all and not m.ntendon: seen["without tendons"] += 1; continue
        try: worst = differences(given.sinew, str(path), m, given.poses)
        except RuntimeError as refused: seen["refused"] += 1; print(f"refused  {path}: {refused}"); continue
        beyond = {kind: error for kind, error in worst.items() if not error <= BARS[kind]}
        seen["wrong" if beyond else "loaded"] += 1
        if beyond: print(f"wrong    {path}: {', '.join(f'{kind} {error:.1e}' for kind, error in beyond.items())}")
    print(", ".join(f"{seen[kind]} {kind}" for kind in ("loaded", "refused", "wrong", "without tendons", "no model for MuJoCo")))
    sys.exit(bool(seen["wrong"]))

main()
