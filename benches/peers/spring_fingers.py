"""Random fingers that close against springs: what `machine new` and `track` make of them.

    python benches/peers/spring_fingers.py SINEW FOLDER [COUNT] [FIRST SEED] [one]

One flexor per joint; with `one` a single one over all joints, against springs of the joints with 4 to 9 N to the middle.

2 to 4 joints, links of 25 to 45 mm and 6 to 20 g; flexors over all joints before theirs, or sums of one joint; springs as
spatial tendons or sums of one joint, stretched in the straight finger against its weight. Prints a line for each.
"""
import json, pathlib, subprocess, sys
import numpy as np

OPEN, CLOSED = 0.0, 1.3

def finger(seed):
    r = np.random.default_rng(seed)
    n, single, springs_single = int(r.integers(2, 5)), r.random() < 0.5, r.random() < 0.4
    length, mass, arm = r.uniform(0.025, 0.045, n), r.uniform(0.006, 0.02, n), r.uniform(0.006, 0.010, n)
    joint = np.concatenate([[0], np.cumsum(length)[:-1]])
    weight = np.array([sum(9.81 * mass[i] * (joint[i] + length[i] / 2 - joint[j]) for i in range(j, n)) for j in range(n)])
    # Torques of the springs in the straight finger, Nm, and their stiffnesses, N/m.
    torque = weight * r.uniform(1.4, 2.0, n) + arm * 0.6
    if not single:
        for j in range(n - 2, -1, -1): torque[j] = max(torque[j], torque[j + 1] * arm[j] / arm[j + 1] * 1.15 + arm[j] * 0.6 + weight[j])
    k = torque * r.uniform(0.6, 1.2, n) / arm**2 / CLOSED
    if not single:
        for j in range(n - 2, -1, -1): k[j] = max(k[j], k[j + 1] * arm[j + 1] / arm[j] * 1.1)
    bodies, tendons, actuators = "", "", ""
    for j in range(n):
        inertia = mass[j] * length[j] ** 2 / 12 + mass[j] * 1e-5
        bodies += f'<body name="l{j}" pos="{length[j - 1] if j else 0:.5f} 0 0"><joint name="j{j}" axis="0 1 0" range="{OPEN} {CLOSED}" damping="0.0005"/>' \
            f'<inertial pos="{length[j] / 2:.5f} 0 0" mass="{mass[j]:.5f}" diaginertia="{mass[j] * 2e-5:.3g} {inertia:.4g} {inertia:.4g}"/>'
        if j + 1 < n: bodies += f'<site name="b{j + 1}" pos="{length[j] - 0.02:.5f} 0 {arm[j + 1]:.5f}"/>'
        bodies += f'<site name="f{j}" pos="{0.35 * length[j]:.5f} 0 {-arm[j]:.5f}"/><site name="e{j}" pos="{0.35 * length[j]:.5f} 0 {arm[j]:.5f}"/>' \
            f'<geom name="w{j}" type="cylinder" size="{0.8 * arm[j]:.5f} 0.004" zaxis="0 1 0" mass="0"/><site name="d{j}" pos="0 0 {1.2 * arm[j]:.5f}"/>'
        if single: tendons += f'<fixed name="flexor{j}"><joint joint="j{j}" coef="{-arm[j]:.5f}"/></fixed>'
        else: tendons += f'<spatial name="flexor{j}"><site site="pf"/>' + "".join(f'<site site="f{i}"/>' for i in range(j + 1)) + "</spatial>"
        actuators += f'<motor tendon="flexor{j}" gear="-1"/>'
        stretch = torque[j] / arm[j] / k[j]
        if single or springs_single:
            tendons += f'<fixed name="spring{j}" stiffness="{k[j]:.5g}" springlength="-1000 {-stretch:.6f}"><joint joint="j{j}" coef="{arm[j]:.5f}"/></fixed>'
        else:
            tendons += f'<spatial name="spring{j}" stiffness="{k[j]:.5g}" springlength="0 {0.02 + 0.35 * length[j] - stretch:.6f}">' \
                f'<site site="{f"b{j}" if j else "pe"}"/><geom geom="w{j}" sidesite="d{j}"/><site site="e{j}"/></spatial>'
    palm = f'<site name="pf" pos="-0.02 0 {-arm[0]:.5f}"/><site name="pe" pos="-0.02 0 {arm[0]:.5f}"/>'
    return f'<mujoco model="finger{seed}"><compiler angle="radian"/><worldbody>{palm}{bodies}<site name="endpoint" pos="{length[-1]:.5f} 0 0"/>' \
        f'{"</body>" * n}</worldbody><tendon>{tendons}</tendon><actuator>{actuators}</actuator></mujoco>'

def one_cable(seed):
    r = np.random.default_rng(seed)
    n = int(r.integers(2, 5))
    length, mass = 0.045 * 0.75 ** np.arange(n) * r.uniform(0.85, 1.15, n), 0.018 * 0.55 ** np.arange(n) * r.uniform(0.7, 1.3, n)
    arm = r.uniform(0.007, 0.011) * np.cumprod(np.concatenate([[1], r.uniform(0.6, 0.95, n - 1)]))
    rest = -r.uniform(0.4, 0.9, n)
    k = r.uniform(4, 9) * arm / (r.uniform(0.5, 0.8, n) - rest)
    bodies = "".join(f'<body name="l{j}" pos="{length[j - 1] if j else 0:.5f} 0 0"><joint name="j{j}" axis="0 1 0" range="-0.4 1.7" '
        f'damping="{1e-3 * 0.6 ** j:.3g}" armature="{2e-6 * 0.7 ** j:.3g}" stiffness="{k[j]:.5g}" springref="{rest[j]:.4f}"/>'
        f'<inertial pos="{length[j] / 2:.5f} 0 0" mass="{mass[j]:.5f}" diaginertia="{mass[j] * length[j] ** 2 / 96:.3g} '
        f'{mass[j] * length[j] ** 2 / 12:.3g} {mass[j] * length[j] ** 2 / 12:.3g}"/>' for j in range(n))
    terms = "".join(f'<joint joint="j{j}" coef="{-arm[j]:.5f}"/>' for j in range(n))
    return f'<mujoco model="finger{seed}"><compiler angle="radian"/><worldbody>{bodies}<site name="tip" pos="{length[-1]:.5f} 0 0"/>' \
        f'{"</body>" * n}</worldbody><tendon><fixed name="flexor">{terms}</fixed></tendon><actuator><motor tendon="flexor" gear="-1"/></actuator></mujoco>'

def main():
    body_of = one_cable if sys.argv[-1] == "one" else finger
    if body_of is one_cable: sys.argv.pop()
    sinew, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    count, first = (int(word) for word in (sys.argv[3:] + ["20", "9710"][len(sys.argv) - 3:])[:2])
    folder.mkdir(parents=True, exist_ok=True)
    call = lambda *words: subprocess.run([sinew, *map(str, words)], capture_output=True, text=True)
    for seed in range(first, first + count):
        body, file = folder / f"{seed}.xml", folder / f"{seed}.toml"
        body.write_text(body_of(seed))
        new = call("machine", "new", body, "--out", file, "--force")
        if new.returncode: print(seed, "refused", " ".join((new.stderr + new.stdout).split())[-300:], flush=True); continue
        run = call("track", file, "--path", "tour", "--repeats", 1, "--seed", seed + 1, "--json")
        found = json.loads(run.stdout).get("tracking", {}).get("observer", {}) if run.stdout else {}
        error, closure = found.get("joint_error_rad") or {}, found.get("closure_error_m") or {}
        print(seed, run.returncode, found.get("ended"), error.get("mean"), error.get("max"), closure.get("mean"), closure.get("max"),
            " ".join(run.stderr.split())[-200:], flush=True)

main()
