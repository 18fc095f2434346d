"""Bodies of which something holds weight: `qfrc_gravcomp` of MuJoCo, for `crates/sinew/tests/sinew/gravity_compensation.rs`.

    python benches/peers/gravcomp_golden.py [COUNT] > crates/sinew/tests/golden/gravcomp/bodies.json

Random trees of hinges, slides, balls and free bodies; a part of the bodies has `gravcomp`, of up to twice their weight.
"""
import json, sys
import mujoco as mj
import numpy as np

def tree(r):
    vec = lambda scale: " ".join(f"{x:.4g}" for x in scale * r.normal(size=3))
    free = r.random() < 0.2
    def body(k, left):
        kind = "free" if free and k == 0 else r.choice(["hinge", "hinge", "slide", "ball"], p=[0.35, 0.35, 0.2, 0.1])
        joint = "" if r.random() < 0.15 and k else "<freejoint/>" if kind == "free" else \
            f'<joint type="{kind}" axis="{vec(1)}" pos="{vec(0.05)}"/>'
        held = f' gravcomp="{r.choice([1, r.uniform(0, 2)]):.4g}"' if r.random() < 0.6 else ""
        own = f'<body pos="{vec(0.2)}" euler="{vec(40)}"{held}>{joint}<inertial pos="{vec(0.1)}" mass="{r.uniform(0.1, 3):.4g}" ' \
            'diaginertia=".02 .02 .02"/>'
        while left:
            part = int(r.integers(1, left + 1))
            own, left = own + body(k + 1, part - 1), left - part
        return own + "</body>"
    return f'<mujoco><option gravity="{vec(6)}"/><worldbody>{body(0, int(r.integers(0, 5)))}</worldbody></mujoco>'

def main():
    found = []
    for seed in range(int(sys.argv[1]) if len(sys.argv) > 1 else 100):
        r = np.random.default_rng(seed)
        text = tree(r)
        m = mj.MjModel.from_xml_string(text)
        d = mj.MjData(m)
        mj.mj_integratePos(m, d.qpos, r.normal(size=m.nv), 1.0)
        d.qvel[:] = r.normal(size=m.nv)
        mj.mj_forward(m, d)
        found.append({"mjcf": text, "q": list(d.qpos), "v": list(d.qvel), "held": list(d.qfrc_gravcomp),
            "needed": list(d.qfrc_bias - d.qfrc_passive)})
    json.dump(found, sys.stdout, separators=(",", ":"))

main()
