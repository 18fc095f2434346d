"""Writes random robots as MJCF, with all that `sinew` says it reads: for `description.py` to compare.

    python benches/peers/random_robots.py FOLDER [COUNT] [FIRST SEED]

Only what MuJoCo itself compiles is kept.
"""
import os, re, sys
import mujoco as mj
import numpy as np

class Robot:
    def __init__(self, seed):
        self.r = np.random.default_rng(seed); r = self.r
        self.degrees = r.random() < 0.6
        self.joints, self.sites, self.wraps, self.names, self.tendons = [], [], [], 0, []
        self.classes = ["main", "outer", "inner"]

    def chance(self, p): return self.r.random() < p
    def pick(self, *a): return a[self.r.integers(len(a))]
    def vec(self, n, s=1.0): return " ".join(f"{x:.6g}" for x in s * self.r.normal(size=n))
    def name(self, kind): self.names += 1; return f"{kind}{self.names}"
    def angle(self, low, high): return self.r.uniform(low, high) * (180 / np.pi if self.degrees else 1)

    def turn(self, p=0.6):
        if not self.chance(p): return ""
        match self.r.integers(5):
            case 0: return f' quat="{self.vec(4)}"'
            case 1: return f' axisangle="{self.vec(3)} {self.angle(-3, 3):.6g}"'
            case 2: return f' xyaxes="{self.vec(6)}"'
            case 3: return f' zaxis="{self.pick(self.vec(3), "0 0 -1", "0 0 1", self.vec(3))}"'
            case _: return ' euler="' + " ".join(f"{self.angle(-3, 3):.6g}" for _ in range(3)) + '"'

    def place(self, s=0.2): return (f' pos="{self.vec(3, s)}"' if self.chance(0.85) else "") + self.turn()
    def of_class(self, p=0.25): return f' class="{self.pick(*self.classes)}"' if self.chance(p) else ""

    def geom(self, wrap=False):
        kind = self.pick("sphere", "cylinder") if wrap else self.pick("sphere", "capsule", "cylinder", "ellipsoid", "box", "box")
        sizes = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}[kind]
        ends = kind != "sphere" and self.chance(0.3)
        size = " ".join(f"{x:.5g}" for x in self.r.uniform(0.01, 0.06, 1 if ends else sizes))
        at = f' fromto="{self.vec(6, 0.1)}"' if ends else self.place(0.1)
        weigh = self.pick("", f' mass="{self.r.uniform(0.01, 2):.5g}"', f' density="{self.r.uniform(100, 5000):.5g}"', ' mass="0"' if wrap else "")
        if not wrap: weigh += self.pick("", "", "", ' shellinertia="true"', f' group="{self.r.integers(6)}"')
        name = self.name("g"); 
        if wrap: self.wraps.append((name, kind))
        return f'<geom name="{name}" type="{kind}" size="{size}"{at}{weigh}{self.of_class(0.15)}/>'

    def joint(self, top):
        kind = self.pick("hinge", "hinge", "hinge", "slide", "ball", "free" if top else "hinge")
        if kind == "free": return self.pick("<freejoint/>", '<joint type="free"/>', f'<freejoint name="{self.name("f")}"/>')
        name = self.name("j"); out = f'<joint name="{name}" type="{kind}"{self.of_class()}'
        single = kind != "ball"
        scale = (180 / np.pi if self.degrees else 1) if kind != "slide" else 0.1
        if single:
            self.joints.append(name)
            if self.chance(0.9): out += f' axis="{self.pick(self.vec(3), "1 0 0", "0 1 0", "0 -1 0")}"'
            if self.chance(0.3): out += f' ref="{scale * self.r.uniform(-1, 1):.5g}"'
            if self.chance(0.3): out += f' springref="{scale * self.r.uniform(-1, 1):.5g}"'
        if self.chance(0.5): out += f' pos="{self.vec(3, 0.05)}"'
        if self.chance(0.6):
            out += f' range="{"0" if kind == "ball" else f"{-scale * self.r.uniform(0.1, 2):.5g}"} {scale * self.r.uniform(0.1, 2):.5g}"'
            out += self.pick("", ' limited="true"', ' limited="auto"', ' limited="false"') if self.auto else ' limited="true"'
        for what in ("stiffness", "damping", "armature", "frictionloss"):
            if self.chance(0.3): out += f' {what}="{self.r.uniform(0, 2):.5g}"'
        return out + "/>"

    def inside(self, joints=True):
        out = []
        for _ in range(self.r.integers(1, 3)):
            name = self.name("s"); self.sites.append(name)
            out.append(f'<site name="{name}"{self.pick(self.place(0.15), self.place(0.15), f""" type="capsule" size=".01" fromto="{self.vec(6, .1)}" """)}{self.of_class()}/>')
        for _ in range(self.r.integers(0, 3)): out.append(self.geom())
        if self.chance(0.6): out.append(self.geom(wrap=True))
        if self.chance(0.2): out.append('<light/>')
        self.r.shuffle(out)
        if self.chance(0.3):
            out.append(f'<frame{self.place()}{self.pick("", " childclass=" + chr(34) + "inner" + chr(34))}>' + "".join(self.inside()) + "</frame>")
        return out

    def inertial(self):
        out = f'<inertial mass="{self.r.uniform(0.1, 3):.5g}" pos="{self.vec(3, 0.1)}"'
        i = self.r.uniform(0.5, 1, 3) * 10 ** self.r.uniform(-4, 0)
        if self.chance(0.4):
            q, _ = np.linalg.qr(self.r.normal(size=(3, 3))); t = q @ np.diag(i) @ q.T
            return out + f' fullinertia="{t[0,0]!r} {t[1,1]!r} {t[2,2]!r} {t[0,1]!r} {t[0,2]!r} {t[1,2]!r}"/>'.replace("np.float64(", "").replace(")", "")
        if self.balance and self.chance(0.3): i[0] *= 3
        return out + self.turn() + ' diaginertia="' + " ".join(f"{x:.6g}" for x in i) + '"/>'

    def body(self, depth):
        self.bodies += 1
        out = [f'<body name="{self.name("b")}"{self.place()}{self.pick("", "", " childclass=" + chr(34) + self.pick(*self.classes) + chr(34))}>']
        top = depth == 0
        joints = [self.joint(top) for _ in range(self.r.integers(0, 3))]
        if any("free" in j for j in joints): joints = [next(j for j in joints if "free" in j)]
        out += joints
        if self.chance(0.4): out.append(self.inertial())
        out += [f'<geom type="sphere" size="{self.r.uniform(.02, .08):.5g}" pos="{self.vec(3, .05)}"{self.of_class(.1)}/>'] + self.inside()
        while depth < 5 and self.bodies < 9 and self.chance(0.75): out.append(self.body(depth + 1))
        return "".join(out) + "</body>"

    def tendon(self):
        name = self.name("t"); self.tendons.append(name); r = self.r
        more = self.of_class()
        if self.chance(0.3): more += f' range="{r.uniform(0, .2):.5g} {r.uniform(.3, 1):.5g}"' + ("" if self.auto else ' limited="true"')
        for what in ("stiffness", "damping"):
            if self.chance(0.3): more += f' {what}="{r.uniform(0, 5):.5g}"'
        if self.chance(0.2): more += f' springlength="{self.pick("0.3", "0.1 0.4")}"'
        if self.joints and self.chance(0.2):
            terms = "".join(f'<joint joint="{j}" coef="{r.normal():.6g}"/>' for j in r.choice(self.joints, min(3, len(self.joints)), replace=False))
            return f'<fixed name="{name}"{more}>{terms}</fixed>'
        last = [""]
        def site():
            last[0] = self.pick(*sorted(set(self.sites) - set(last))); return f'<site site="{last[0]}"/>'
        out = [site()]
        for k in range(r.integers(1, 5)):
            if self.wraps and self.chance(0.6):
                geom, _ = self.pick(*self.wraps)
                side = f' sidesite="{self.side[geom] if geom in self.side and self.chance(.7) else self.pick(*self.sites)}"' if self.chance(0.5) else ""
                out.append(f'<geom geom="{geom}"{side}/>')
            out.append(site())
            if self.chance(0.2): out += [f'<pulley divisor="{self.pick("2", "1", "3", "0.5")}"/>', site(), site()]
        return f'<spatial name="{name}"{more}>' + "".join(out) + "</spatial>"

    def actuator(self):
        out = f' name="{self.name("a")}" tendon="{self.pick(*self.tendons)}"'
        if self.chance(0.5): out += f' gear="{self.r.normal():.5g}"'
        if self.chance(0.5): out += f' ctrlrange="{-self.r.uniform():.5g} {self.r.uniform():.5g}" ctrllimited="true"'
        if self.chance(0.4): out += f' forcerange="{-self.r.uniform():.5g} {self.r.uniform():.5g}" forcelimited="true"'
        match self.r.integers(5):
            case 0: return f"<motor{out}/>"
            case 1: return f'<muscle{out} timeconst="0.02 0.05" force="{self.r.uniform(10, 500):.5g}" range="0.7 1.1" lengthrange="0.1 0.9"/>'
            case 2: return f'<position{out} kp="{self.r.uniform(1, 100):.5g}" kv="0.5"/>'
            case 3: return f'<velocity{out} kv="{self.r.uniform(1, 100):.5g}"/>'
            case _: return f'<general{out} gaintype="affine" gainprm="{self.vec(3)}" biastype="affine" biasprm="{self.vec(3)}" dyntype="filter" dynprm="{abs(self.r.normal()):.5g}"/>'

    def file(self):
        r = self.r; self.bodies = 0; self.side = {}
        self.auto, self.balance = self.chance(0.7), self.chance(0.3)
        settings = f'angle="{"degree" if self.degrees else "radian"}" eulerseq="{"".join(r.permutation(list(self.pick("xyz", "XYZ", "xyx", "ZYX", "xYz"))))}"'
        settings += f' autolimits="{str(self.auto).lower()}" balanceinertia="{str(self.balance).lower()}"'
        settings += f' inertiafromgeom="{self.pick("auto", "auto", "true", "false")}"' if self.chance(0.6) else ""
        if self.chance(0.3): settings += f' boundmass="{r.uniform(.01, 1):.5g}"'
        if self.chance(0.3) or "false" in settings: settings += f' boundinertia="{r.uniform(1e-4, 1e-2):.5g}"'
        if "false" in settings and "boundmass" not in settings: settings += ' boundmass="0.1"'
        if self.chance(0.2): settings += f' settotalmass="{r.uniform(1, 20):.5g}"'
        if self.chance(0.2): settings += f' inertiagrouprange="0 {r.integers(1, 5)}"'
        classes = '<default><joint damping="0.3"/><geom density="800"/><site size="0.01"/><tendon damping="0.2"/>'
        classes += f'<default class="outer"><joint armature="0.07" axis="{self.vec(3)}"/><geom{self.turn(1)} density="1200"/><site{self.turn()}/><tendon stiffness="3"/><motor gear="2"/>'
        classes += f'<default class="inner"><joint stiffness="2" frictionloss=".1" damping="0"/><geom group="3"{self.turn(1)}/><site{self.turn(1)}/><tendon range="0.1 0.9" limited="true"/></default></default></default>'
        world = "".join(self.inside() + [self.body(0) for _ in range(r.integers(1, 3))])
        out = f'<mujoco model="r"><compiler {settings}/><option gravity="{self.vec(3, 9)}"/>{classes}<worldbody>{world}</worldbody>'
        out += "<tendon>" + "".join(self.tendon() for _ in range(r.integers(1, 7))) + "</tendon>"
        free = list(r.permutation(self.joints))
        if len(free) > 1:
            out += "<equality>"
            while len(free) > 1 and self.chance(0.5):
                follower, leader = free.pop(), f' joint2="{free[0]}"' if self.chance(0.8) else ""
                poly = f' polycoef="{self.vec(self.r.integers(1, 6), .3)}"' if self.chance(0.8) else ""
                out += f'<joint joint1="{follower}"{leader}{poly}{self.pick("", "", " active=" + chr(34) + "false" + chr(34))}/>'
            out += "</equality>"
        out += "<actuator>" + "".join(self.actuator() for _ in range(r.integers(0, 4))) + "</actuator>"
        return out.replace("><", ">\n<") + "</mujoco>"

def main():
    folder, count, seed = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 100, int(sys.argv[3]) if len(sys.argv) > 3 else 0
    os.makedirs(folder, exist_ok=True); made, refused = 0, {}
    while made < count:
        text = Robot(seed).file(); seed += 1
        try: m = mj.MjModel.from_xml_string(text)
        except ValueError as e: key = re.sub("[0-9]+", "", str(e))[:50]; refused[key] = refused.get(key, 0) + 1; continue
        if m.nv == 0: continue
        q = mj.MjData(m).qpos; key = m.qpos0.copy()
        key += 0.1 * np.random.default_rng(seed).normal(size=m.nq)
        text = text.replace("</mujoco>", f'<keyframe>\n<key name="k" qpos="{" ".join(repr(float(x)) for x in key)}"/>\n</keyframe>\n</mujoco>')
        open(os.path.join(folder, f"r{seed - 1}.xml"), "w").write(text); made += 1
    print(made, "made; refused by MuJoCo:", refused)

main()
