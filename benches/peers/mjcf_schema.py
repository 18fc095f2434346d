"""Writes MuJoCo's own list of MJCF elements and attributes where the import reads it.

One element per line, indented within its parent: name, how often (`!` once, `?` at most once, `*` any number,
`R` any number and within itself), attributes.
"""

import pathlib
import re

import mujoco

OUT = pathlib.Path(__file__).parents[2] / "crates/sinew/src/description/mjcf/schema.txt"

lines = []
for line in mujoco.mj_printSchema(False, False).splitlines():
    if not line.strip():
        continue
    head = re.match(r"^( *)(\S+) \((.)\)\s*(.*)$", line)
    if head:
        depth = len(head[1]) // 3
        lines.append([depth, head[2], head[3], head[4].split()])
    else:
        lines[-1][3] += line.split()
out = "".join(
    " " * depth + " ".join([name, kind, *attributes]) + "\n" for depth, name, kind, attributes in lines
)
OUT.write_text(out)
print(f"MuJoCo {mujoco.__version__}: {len(lines)} elements")
