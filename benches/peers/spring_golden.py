"""Springs of tendons in random hands: energy, torques and equilibria of MuJoCo, for `crates/sinew/tests/sinew/springs.rs`.

    python benches/peers/spring_golden.py [COUNT] > crates/sinew/tests/golden/springs/hands.json

Every hand is a chain of hinges and slides with springs of its own, muscles, and passive tendons: spatial ones around
spheres and over pulleys, sums of joints; with a dead band, of one length, or of the length at rest.
"""
import json, sys
import mujoco as mj
import numpy as np

def hand(r):
    f = lambda low, high: f"{r.uniform(low, high):.6g}"
    vec = lambda scale: " ".join(f"{x:.6g}" for x in scale * r.normal(size=3))
    n = int(r.integers(2, 5))
    bodies = sites = ""
    for k in range(n):
        slide = r.random() < 0.2
        rest = f(-0.02, 0.02) if slide else f(-0.4, 0.4)
        bodies += f'<body name="b{k}" pos="0.05 0 0"><joint name="j{k}" type="{"slide" if slide else "hinge"}" axis="{vec(1)}" ' \
            f'ref="{f(-0.01, 0.01)}" springref="{rest}" stiffness="{f(100, 400) if slide else f(0.05, 0.3)}" damping="{f(0, 0.02)}"/>' \
            f'<inertial pos="0.025 0 0" mass="{f(0.01, 0.05)}" diaginertia="1e-5 2e-5 2e-5"/>' \
            f'<geom name="w{k}" size="0.006" mass="0"/><site name="a{k}" pos="{vec(0.012)}"/><site name="c{k}" pos="{vec(0.012)}"/>'
    slack = lambda: r.choice(["", f' springlength="{f(0.01, 0.06)}"', f' springlength="{f(0.0, 0.03)} {f(0.03, 0.09)}"',
        f' springlength="-1000 {f(0.0, 0.05)}"'])
    law = lambda: f' stiffness="{f(50, 800)}" damping="{f(0, 0.5)}"{slack()}'
    tendons = actuators = ""
    for k in range(n):
        tendons += f'<fixed name="muscle{k}"{law() if r.random() < 0.4 else ""}><joint joint="j{k}" coef="{f(0.005, 0.01)}"/></fixed>'
        actuators += f'<motor tendon="muscle{k}" gear="-1"/>'
        over = int(r.integers(k, n))
        pulley = '<pulley divisor="2"/>' if r.random() < 0.3 else ""
        tendons += f'<spatial name="s{k}"{law()}><site site="p"/><geom geom="w{k}"/><site site="a{k}"/>' + \
            (f'{pulley}<site site="p"/><site site="c{over}"/>' if pulley else f'<site site="c{over}"/>' if over != k else "") + "</spatial>"
    terms = "".join(f'<joint joint="j{k}" coef="{f(-0.01, 0.01)}"/>' for k in range(n))
    tendons += f'<fixed name="sum"{law()}>{terms}</fixed><fixed name="cord"><joint joint="j0" coef="0.01"/></fixed>'
    return f'<mujoco><compiler angle="radian"/><worldbody><site name="p" pos="0 0 0.02"/>{bodies}{"</body>" * n}</worldbody>' \
        f'<tendon>{tendons}</tendon><actuator>{actuators}</actuator></mujoco>'

def torque(m, d, q, v):
    d.qpos[:], d.qvel[:] = q, v
    mj.mj_forward(m, d)
    return d.qfrc_bias - d.qfrc_passive

def equilibrium(m, d, q):
    """By Newton's method with a slope of central differences; none where it does not end."""
    rest = np.zeros(m.nv)
    for _ in range(60):
        tau = torque(m, d, q, rest)
        if np.abs(tau).max() < 1e-13: return q
        step = 1e-6 * np.eye(m.nv)
        slope = np.array([torque(m, d, q + e, rest) - torque(m, d, q - e, rest) for e in step]).T / 2e-6
        change = np.linalg.solve(slope, tau)
        q = q - change * min(1.0, 0.3 / np.abs(change).max())
    return None

def main():
    found = []
    for seed in range(int(sys.argv[1]) if len(sys.argv) > 1 else 12):
        r = np.random.default_rng(seed)
        text = hand(r)
        m = mj.MjModel.from_xml_string(text)
        m.opt.enableflags |= mj.mjtEnableBit.mjENBL_ENERGY
        d, cases = mj.MjData(m), []
        for _ in range(6):
            q, v = r.uniform(-0.8, 0.8, m.nq) * np.where(m.jnt_type == 2, 0.05, 1), r.normal(size=m.nv)
            tau = torque(m, d, q, v)
            cases.append({"q": list(q), "v": list(v), "torque": list(tau), "energy": float(d.energy[0])})
        rests = [equilibrium(m, d, np.array(case["q"])) for case in cases]
        found.append({"mjcf": text, "cases": cases, "rests": [list(q) for q in rests if q is not None]})
    json.dump(found, sys.stdout, separators=(",", ":"))

main()
