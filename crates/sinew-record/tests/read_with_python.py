"""Reads a recording with the packages `mcap` and `mcap-protobuf-support`, by the schemas in it alone.

    python read_with_python.py RECORDING.mcap [EXPORT.csv]

With the table that `sinew log export` has written of all cycles, every column is compared: bit for bit after snapping to
the grid of its sensor as docs/recording.md says, and within a resolution or half a count before.
"""

import csv
import json
import sys
from collections import Counter

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory


def half_up(x):
    return int(abs(x) + 0.5) * (1 if x >= 0 else -1)


def snap(grid, x):
    pitch = grid["scale"] * grid.get("factor", 1.0) / grid.get("divisor", 1.0) * grid.get("arm", 1.0)
    k = half_up((x - grid.get("offset", 0.0)) / pitch)
    x = k * grid["scale"] * grid.get("factor", 1.0) / grid.get("divisor", 1.0) * grid.get("arm", 1.0)
    inner = grid.get("inner", 0.0)
    if inner:
        x = half_up(x / inner) * inner
    return x + grid.get("offset", 0.0), abs(pitch)


def numbers(message):
    """Columns of a message, by the names of its fields; identical to those of the table for plain names."""
    for field in message.DESCRIPTOR.fields:
        value = getattr(message, field.name)
        if field.message_type is None:
            yield field.name, value
        else:
            yield from ((f"{field.name}:{part.name}", getattr(value, part.name)) for part in field.message_type.fields)


def main(path, table=None):
    topics, columns, blocks = Counter(), {}, []
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for schema, channel, _, message in reader.iter_decoded_messages():
            topics[channel.topic] += 1
            if schema.name == "sinew.Block":
                blocks.append(message)
            if schema.name == "sinew.Cycle":
                for name, value in numbers(message):
                    columns.setdefault(name, []).append(value)
    with open(path, "rb") as file:
        attachments = {attachment.name: attachment.data for attachment in make_reader(file).iter_attachments()}
    head = json.loads(attachments["head.json"])
    specs = {spec["name"]: (place, spec["coding"]) for place, spec in enumerate(head["fast"])}
    assert "setup.json" in attachments and {*columns, "deadline_us"} == {*specs}
    if table:
        with open(table, newline="") as file:
            rows = list(csv.DictReader(file))
        assert len(rows) == topics["/sinew/cycle"] == sum(block.count for block in blocks)
        which = [block for block in blocks for _ in range(block.count)]
        for name, column in columns.items():
            place, coding = specs[name]
            for row, value, block in zip(rows, column, which):
                if row[name] == "":
                    assert value != value, (name, value)
                    continue
                exported = float(row[name])
                if "exact" in coding:
                    grid = block.grids[place]
                    found, near = snap(coding["exact"][grid - 1], value) if grid else (value, 0.0)
                    assert found == exported, (name, exported, found)
                    near *= 0.5
                else:
                    near = 1.001 * coding["rounded"]
                assert abs(value - exported) <= near, (name, exported, value)
    print(json.dumps({"cycles": topics["/sinew/cycle"], "topics": topics, "compared": bool(table)}))


main(*sys.argv[1:])
