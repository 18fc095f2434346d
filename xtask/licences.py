"""Licences of all libraries in a program, each text once: `licences.py MANIFEST FEATURES TARGET`, from `cargo metadata`."""

import json
import pathlib
import subprocess
import sys

manifest, features, target = sys.argv[1:]
words = ["cargo", "metadata", "--locked", "--offline", "--format-version=1", "--manifest-path", manifest]
words += ["--features", features, "--filter-platform", target]
found = json.loads(subprocess.run(words, check=True, stdout=subprocess.PIPE).stdout)
nodes = {node["id"]: node["deps"] for node in found["resolve"]["nodes"]}
needed, waiting = set(), [found["resolve"]["root"]]
while waiting:
    one = waiting.pop()
    if one not in needed:
        needed.add(one)
        waiting += [dep["pkg"] for dep in nodes[one] if any(kind["kind"] != "dev" for kind in dep["dep_kinds"])]
texts: dict[str, list[str]] = {}
for package in sorted(found["packages"], key=lambda package: package["name"]):
    if package["id"] in needed and package["source"]:
        if not package["license"]:
            sys.exit(f"error: {package['name']} names no licence")
        folder = pathlib.Path(package["manifest_path"]).parent
        kinds = ("LICEN", "COPYING", "NOTICE", "UNLICENSE")
        files = sorted(file for file in folder.iterdir() if file.is_file() and file.name.upper().startswith(kinds))
        of = f"{package['name']} {package['version']}  {package['license']}  {package['repository'] or ''}"
        for text in [file.read_text(errors="replace").strip() for file in files] or ["(The crate contains no text.)"]:
            texts.setdefault(text, []).append(of)
print("Libraries of others in this program, with the licence that each names and the texts that it contains.\n")
for text, libraries in texts.items():
    print("=" * 100, *libraries, "", text, "", sep="\n")
