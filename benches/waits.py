#!/usr/bin/env python3
"""How long people wait: the wall time of every verb on the built-in machines and on generated logs.

usage: benches/waits.py [SINEW] [--runs N] [--machines NAME,..] [--only WORD] [--limit SECONDS] [--json]

SINEW is the program, by default target/release/sinew. Every command runs N times (3) in a folder of its own; the least time
stands in the table. One that takes 2 s or more runs once more on a pseudo-terminal, which tells the longest time for which
nothing was shown there: `silent`. Verbs that wait for others (live, run on a real clock, scans, simulated devices) are not
among them. `--only` chooses commands that contain a word, `--limit` ends one after so many seconds (600). Exit codes other
than 0 stand in the table: 3 is a machine that cannot do what it was asked for.
"""

import argparse
import datetime
import json
import os
import pathlib
import platform
import pty
import select
import shutil
import subprocess
import sys
import tempfile
import time

#: From when on a program should show what it does, s.
PATIENCE = 2.0
MODELS = pathlib.Path(__file__).resolve().parents[1] / "models"

#: What is prepared before the others are timed; `{out}` is where a command writes, `{log}` what these have written.
PREPARED = (
    ("demo", "demo --out {out}"),
    ("bench", "twin bench --out {out}/bench.csv"),
    ("wanted", "twin plan --out {out}/wanted.csv"),
)
#: Commands without a machine.
PLAIN = (
    "demo --out {out}",
    "twin bench --out {out}/bench.csv",
    "twin plan --out {out}/plan.csv",
    "twin cable --out {out}/cable.csv",
    "identify {log}/bench/bench.csv --far tension_out_n --out {out}",
    "evaluate {log}/demo/model.json {log}/bench/bench.csv",
    "predict {log}/demo/model.json {log}/bench/bench.csv --out {out}/predicted.csv",
    "adapt {log}/demo/model.json {log}/bench/bench.csv --out {out}",
    "export {log}/demo/model.json --to c --out {out}",
    "design drive --tension 300 --speed 0.2 --acceleration 4 --stroke 0.3",
    "reproduce --quick --out {out}",
    "example bench --out {out}/example",
    "example hand --out {out}/example",
    "doctor",
    "man --out {out}/man",
)
#: Commands of every machine; recordings are those of its `run`.
OF_MACHINE = (
    "machine show {machine}",
    "machine body {machine}",
    "machine tune {machine}",
    "machine map {machine}",
    "machine new {body} --out {out}/new.toml",
    "export machine {machine} --to fmu --out {out}",
    "calibrate plan {machine} --out {out}/poses.csv",
    "calibrate {machine} --out {out}",
    "track {machine}",
    "track {machine} --path tour",
    "run {machine} --virtual-time --path tour --repeats 1 --record {out}/run.mcap",
    "log info {record}",
    "log export {record} --out {out}/run.csv",
    "log plot {record} --report {out}/run.html",
    "log replay {record}",
)


def once(program, words, limit):
    """Exit code and wall time, s; none for one that was ended."""
    began = time.perf_counter()
    try:
        done = subprocess.run([program, *words], capture_output=True, timeout=limit)
    except subprocess.TimeoutExpired:
        return None, time.perf_counter() - began, ""
    return done.returncode, time.perf_counter() - began, done.stderr.decode(errors="replace")


def silence(program, words, limit):
    """Longest time for which a program shows nothing on a terminal, s."""
    ours, theirs = pty.openpty()
    shown = began = time.perf_counter()
    longest = 0.0
    with subprocess.Popen([program, *words], stdin=theirs, stdout=theirs, stderr=theirs) as process:
        os.close(theirs)
        while True:
            ready = select.select([ours], [], [], 0.1)[0]
            now = time.perf_counter()
            try:
                if ready and not os.read(ours, 65536):
                    break
            except OSError:  # Linux: the other side was closed
                break
            if ready:
                longest, shown = max(longest, now - shown), now
            elif process.poll() is not None or now - began > limit:
                break
        process.kill()
    os.close(ours)
    return max(longest, time.perf_counter() - shown)


def measured(program, command, places, options):
    """The row of one command."""
    best, code, error = None, None, ""
    for _ in range(options.runs):
        out = pathlib.Path(tempfile.mkdtemp(dir=places["scratch"]))
        words = [word.format(**places, out=out) for word in command.split()]
        code, seconds, error = once(program, words, options.limit)
        best = seconds if best is None else min(best, seconds)
        kept = out / "run.mcap"
        if kept.exists():
            shutil.move(kept, places["record"])
        shutil.rmtree(out)
        if code is None or seconds > options.limit / options.runs:
            break
    row = {"command": command.format(**places | {"out": "D", "log": "LOGS", "record": "RUN.mcap"}), "seconds": best, "exit": code}
    if code not in (0, 3):
        row["error"] = error.strip().splitlines()[0] if error.strip() else f"ended after {options.limit:.0f} s"
    elif best >= PATIENCE:
        out = tempfile.mkdtemp(dir=places["scratch"])
        row["silent"] = silence(program, [word.format(**places, out=out) for word in command.split()], options.limit)
        shutil.rmtree(out)
    return row


def processor():
    """Name and number of cores."""
    try:
        lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
        name = next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        name = platform.processor() or platform.machine()
    return f"{name}, {os.cpu_count()} cores"


def print_row(row):
    silent = f"{row['silent']:6.1f}" if "silent" in row else 6 * " "
    note = {0: "", 3: "  (exit code 3)"}.get(row["exit"], f"  {row.get('error')}")
    print(f"{row['seconds']:8.2f} {silent}  {row['command']}{note}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", default="target/release/sinew")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--machines", default=",".join(sorted(path.stem for path in MODELS.glob("*.toml") if path.stem not in ("Cargo", "motors"))))
    parser.add_argument("--only", default="")
    parser.add_argument("--limit", type=float, default=600.0)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    program = shutil.which(options.program)
    if program is None:
        parser.error(f"SINEW must be a program, but there is none at {options.program}")
    if options.runs < 1 or not options.limit > 0.0:
        parser.error("--runs must be at least 1, --limit a number of seconds > 0")
    scratch = pathlib.Path(tempfile.mkdtemp(prefix="waits"))
    rows = []
    about = {
        "version": subprocess.run([program, "--version"], capture_output=True, check=True, text=True).stdout.strip(),
        "machine": processor(),
        "date": datetime.date.today().isoformat(),
        "runs": options.runs,
        "load": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
    }
    try:
        if not options.json:
            print(f"{about['version']}, {about['machine']}, {about['date']}, least of {options.runs}, load {about['load']}")
            print("       s  silent  command")
        for name, command in PREPARED:
            (scratch / name).mkdir()
            code, _, error = once(program, command.format(out=scratch / name).split(), options.limit)
            if code != 0:
                sys.exit(f"{command}: {error}")
        places = {"scratch": scratch, "log": scratch, "record": scratch / "none.mcap", "machine": "", "body": ""}
        jobs = [(command, places) for command in PLAIN]
        for name in filter(None, options.machines.split(",")):
            of_machine = places | {"machine": name, "body": MODELS / f"{name}.toml", "record": scratch / f"{name}.mcap"}
            jobs += [(command, of_machine) for command in OF_MACHINE]
        for command, at in jobs:
            # A recording is made whatever is chosen, by the first run of its machine.
            if options.only in command.format(**at | {"out": "D"}):
                if "{record}" in command and not at["record"].exists():
                    once(program, f"run {at['machine']} --virtual-time --path tour --repeats 1 --record {at['record']}".split(), options.limit)
                rows.append(measured(program, command, at, options))
                if not options.json:
                    print_row(rows[-1])
    finally:
        shutil.rmtree(scratch)
    if options.json:
        print(json.dumps(about | {"rows": rows}, indent=1))
        return
    print(f"\nwithout a word for more than {PATIENCE:.0f} s:")
    for row in sorted((row for row in rows if row.get("silent", 0.0) > PATIENCE + 0.5), key=lambda row: -row["silent"]):
        print_row(row)


main()
