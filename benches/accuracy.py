#!/usr/bin/env python3
"""Accuracy of identification on measured logs of published rigs: the table of FEATURES.md.

usage: benches/accuracy.py FOLDER [SINEW]

FOLDER holds logs of four rigs, none of which is part of this repository:
  giraffe_sheath/log_A.csv               jerluenn/RAL2024-GIRAFFE: t_s, T_in_N, T_out_N
  vio_sheath_bend/sheath_{000..240}.csv  nhoyh/hysteresis_compensation_ROS: t_s, q_des_deg, q_act_deg, T1, T2, sheath_deg
  mrd_davinci_tool/tool_4_100Hz.csv      MRDLab/mis-tool-characterization: trial, freq_hz, load_pct, t_s, p_in_rad, T_in_Nm, p_out_rad, T_out_Nm
  wy_catheter/f0*_data*.csv              wy-yuan/hysteresis-fnn-lstm: t_s, stroke_mm, tension_N
SINEW is the program, by default target/release/sinew. Every split trains on some of the logs and is scored on the others. The splits
were also used in development, so that the figures flatter.
"""

import csv
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

if len(sys.argv) < 2 or sys.argv[1] in ("-h", "--help"):
    sys.exit(__doc__)
data, program = pathlib.Path(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else "target/release/sinew"
scratch = pathlib.Path(tempfile.mkdtemp())


def part(source, name, keep):
    """Rows of a log for which `keep` is true, as a log of its own."""
    with open(data / source, newline="") as file:
        rows = list(csv.DictReader(file))
    path = scratch / f"{name}.csv"
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(row for row in rows if keep(row))
    return path


def sinew(*words):
    return json.loads(subprocess.run([program, *map(str, words), "--json"], capture_output=True, check=True, text=True).stdout)


def half_width(model, test, far):
    """Median half width of the 95 % band over that of the constant one that holds 95 % of the errors."""
    widths, errors = [], []
    for log in test:
        out = scratch / "predictions.csv"
        sinew("predict", model, log, "--out", out)
        with open(out, newline="") as file, open(log, newline="") as truth:
            for row, true in zip(csv.DictReader(file), csv.DictReader(truth)):
                if row["prediction"] and true[far]:
                    widths.append(1.96 * float(row["standard_deviation"]))
                    errors.append(abs(float(row["prediction"]) - float(true[far])))
    return statistics.median(widths) / sorted(errors)[int(0.95 * len(errors))]


def task(name, train, test, flags):
    start = time.perf_counter()
    out = scratch / "model"
    found = sinew("identify", *train, *flags.split(), "--out", out)
    seconds = time.perf_counter() - start
    model = out / "model.json"
    score = sinew("evaluate", model, *test)["overall"]
    expected = score["expected"]
    print(
        f"| {name} | {score['percent_of_range']:.2f} % | {100 * expected / found['far_range']:.2f} % | {score['rmse'] / expected:.2f} "
        f"| {100 * score['coverage95']:.1f} % | {half_width(model, test, found['far']):.1f} | {100 * score['out_of_range']:.0f} % "
        f"| {found['grade'].replace('_', ' ')} | {found['chosen']['name']} | {seconds:.0f} s |",
        flush=True,
    )


print("| task | RMSE, % of range | expected | actual / expected | inside the 95 % band | its half width / ideal | out of range | advice | model chosen | time |")
print("|---|---|---|---|---|---|---|---|---|---|")

giraffe = "giraffe_sheath/log_A.csv"
before = part(giraffe, "before", lambda row: float(row["t_s"]) < 85)
after = part(giraffe, "after", lambda row: float(row["t_s"]) >= 85)
task("sheath, tension to tension: before 85 s to after", [before], [after], "--far T_out_N --effort T_in_N")

sheaths = {bend: data / f"vio_sheath_bend/sheath_{bend:03}.csv" for bend in (0, 60, 120, 180, 240)}
joint = "--far q_act_deg --motion q_des_deg --effort T1,T2 --given sheath_deg"
for held in sheaths:
    task(f"sheath joint, angle, bend of {held} degrees not seen", [log for bend, log in sheaths.items() if bend != held], [sheaths[held]], joint)
for held, known in ((240, (0, 60, 120)), (180, (0, 60, 120)), (0, (120, 180, 240)), (60, (120, 180, 240))):
    task(f"sheath joint, angle, {known} to {held} degrees", [sheaths[bend] for bend in known], [sheaths[held]], joint)

tool = "mrd_davinci_tool/tool_4_100Hz.csv"
with open(data / tool, newline="") as file:
    rows = list(csv.DictReader(file))
for column, positions, name in (("load_pct", (2, 6), "loads 3 and 7 of ten"), ("freq_hz", (1, 4), "frequencies 2 and 5 of five")):
    values = sorted({row[column] for row in rows}, key=float)
    held = {values[k] for k in positions}
    train = part(tool, "train", lambda row: row[column] not in held)
    test = part(tool, "test", lambda row: row[column] in held)
    task(f"instrument, torque, {name} not seen", [train], [test], "--far T_out_Nm --effort T_in_Nm --motion p_in_rad --trial trial")
    task(f"instrument, angle, {name} not seen", [train], [test], "--far p_out_rad --effort T_in_Nm --motion p_in_rad --trial trial")

loads = ((80, lambda load: load <= 60), (100, lambda load: load <= 60), (30, lambda load: load >= 50), (10, lambda load: load >= 50))
for held, known in loads:
    train = part(tool, "train", lambda row: known(float(row["load_pct"])))
    test = part(tool, "test", lambda row: float(row["load_pct"]) == held)
    side = "up to 60" if held > 60 else "from 50 on"
    task(f"instrument, torque, loads {side} to {held} %", [train], [test], "--far T_out_Nm --effort T_in_Nm --motion p_in_rad --trial trial")

catheter = sorted((data / "wy_catheter").glob("f*.csv"))
for frequency in ("f002", "f010", "f015", "f020"):
    train = [log for log in catheter if not log.name.startswith(frequency)]
    test = [log for log in catheter if log.name.startswith(frequency)]
    task(f"catheter, tension from stroke, {frequency} not seen, an outlier log among the others", train, test, "--far tension_N --motion stroke_mm")
