"""Random serial machines of four sizes as plain MJCF with opposing tendons: what `machine new` makes of them.

    python benches/serial_machines.py SINEW FOLDER [COUNT] [FIRST SEED] [--size NAME] [machine new's options]

Every machine is designed, planned, verified and tracked on the tour of its ranges with a seed of its own. Prints one
line a machine, then for every size how many were refused and how well the others were tracked.
"""
import json, pathlib, statistics, subprocess, sys
import random

# Link, m; mass of the first link, kg; joints.
SIZES = {"arm": (0.28, 0.8, (2, 4)), "leg": (0.42, 2.0, (2, 3)), "finger": (0.045, 0.02, (2, 4)), "wrist": (0.02, 0.006, (2, 3))}


def machine(seed, size):
    r = random.Random(seed)
    length, mass, joints = SIZES[size]
    lengths = [length * r.uniform(0.8, 1.2)]
    for _ in range(1, r.randint(*joints)):
        lengths.append(lengths[-1] * r.uniform(0.7, 1.0))
    arm = r.uniform(0.12, 0.4) * lengths[0]
    # On either side of a joint: outside of it on the body before, so on the one behind.
    before = [[] for _ in range(len(lengths) + 1)]
    tendons, joints = [], []
    for k, l in enumerate(lengths):
        yaw = r.random() < 0.5
        middle, half = r.uniform(-0.3, 0.3), r.uniform(0.4, 0.9)
        joints.append((yaw, middle - half, middle + half))
        at = 0.0 if k == 0 else lengths[k - 1]
        wrapped = r.random() < 0.5
        for side, name in ((1, "f"), (-1, "e")):
            radius = arm * r.uniform(0.85, 1.15)
            place = lambda x, y: f"{x:.6g} {side * y:.6g} 0" if yaw else f"{x:.6g} 0 {-side * y:.6g}"
            along, out = (1.5 * radius, 0.5 * radius) if wrapped else (0.6 * radius, radius)
            tag = f"{name}{k}"
            before[k].append(f'<site name="{tag}a" pos="{place(at - along, out)}"/>')
            before[k + 1].append(f'<site name="{tag}b" pos="{place(along, out)}"/>')
            path = [f'<site site="{tag}a"/>']
            if wrapped:
                before[k].append(f'<site name="{tag}s" pos="{place(at, 3 * radius)}"/>')
                axis = "" if yaw else ' euler="90 0 0"'
                before[k].append(f'<geom name="{tag}w" type="cylinder" size="{radius:.6g} {radius:.6g}" pos="{at:.6g} 0 0"{axis} mass="0"/>')
                path.append(f'<geom geom="{tag}w" sidesite="{tag}s"/>')
            path.append(f'<site site="{tag}b"/>')
            tendons.append(f'<spatial name="{tag}">{"".join(path)}</spatial>')
    mass *= r.uniform(0.7, 1.4)
    text = ""
    for k in reversed(range(len(lengths))):
        l = lengths[k]
        m = mass * (l / lengths[0]) ** 2
        at = 0.0 if k == 0 else lengths[k - 1]
        yaw, low, high = joints[k]
        damping = 0.01 * m * l * l
        end = f'<site name="endpoint" pos="{l:.6g} 0 0"/>' if k + 1 == len(lengths) and r.random() < 0.5 else ""
        text = (f'<body name="link{k}" pos="{at:.6g} 0 0"><joint name="j{k}" axis="{"0 0 1" if yaw else "0 1 0"}" '
                f'range="{low:.5g} {high:.5g}" damping="{damping:.4g}"/>'
                f'<geom type="capsule" size="{0.1 * l:.5g}" fromto="0 0 0 {l:.6g} 0 0" mass="{m:.5g}"/>{end}'
                f'{"".join(before[k + 1])}{text}</body>')
    return (f'<mujoco model="{size}_{seed}"><compiler angle="radian" autolimits="true"/><worldbody>{"".join(before[0])}{text}'
            f'</worldbody><tendon>{"".join(tendons)}</tendon></mujoco>').replace('euler="90 0 0"', 'euler="1.5707963267949 0 0"')


def call(sinew, *words):
    done = subprocess.run([sinew, "--json", *map(str, words)], capture_output=True, text=True)
    try:
        answer = json.loads(done.stdout)
    except json.JSONDecodeError:
        answer = {}
    return done.returncode, answer, done.stderr.strip().splitlines()


def one(sinew, folder, seed, size, options):
    body, file = folder / f"{size}_{seed}.xml", folder / f"{size}_{seed}.toml"
    body.write_text(machine(seed, size))
    code, new, words = call(sinew, "machine", "new", body, "--out", file, "--force", *options)
    if not file.exists():
        return "refused", None, "machine new: " + " ".join(words)[-200:]
    code, run, words = call(sinew, "track", file, "--path", "tour", "--repeats", 1, "--seed", seed)
    run = run.get("tracking", {}).get("observer", {})
    error = run.get("joint_error_rad") or {}
    if not error:
        return "refused", None, " ".join(words)[-300:]
    ended = run.get("ended")
    return ("tracked" if code == 0 else f"{ended}"), error, " ".join(words)[-200:] if code else ""


def main():
    words = sys.argv[1:]
    sizes = list(SIZES)
    if "--size" in words:
        at = words.index("--size")
        sizes = [words[at + 1]]
        del words[at : at + 2]
    numbers = []
    while len(words) > 2 and words[2].isdigit():
        numbers.append(int(words.pop(2)))
    sinew, folder, options = words[0], pathlib.Path(words[1]), words[2:]
    folder.mkdir(parents=True, exist_ok=True)
    count, first = numbers[0] if numbers else 60, numbers[1] if len(numbers) > 1 else 0
    found = {size: [] for size in sizes}
    for k in range(count):
        size = sizes[k % len(sizes)]
        ended, error, why = one(sinew, folder, first + k, size, options)
        found[size].append((ended, error))
        mrad = "" if error is None else f"{1e3 * error['mean']:.2f} {1e3 * error['max']:.2f} mrad"
        print(f"{first + k} {size} {ended} {mrad} {why}", flush=True)
    for size, runs in found.items():
        mean = [1e3 * error["mean"] for ended, error in runs if ended == "tracked"]
        most = [1e3 * error["max"] for ended, error in runs if ended == "tracked"]
        middle = lambda x: f"{statistics.median(x):.2f}" if x else "-"
        print(f"{size}: {len(runs)} sampled, {sum(ended == 'refused' for ended, _ in runs)} refused, {len(mean)} tracked, "
              f"median of mean {middle(mean)} mrad, of largest {middle(most)} mrad, p90 of mean "
              f"{sorted(mean)[int(0.9 * (len(mean) - 1))] if mean else float('nan'):.2f}")


main()
