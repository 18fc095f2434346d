"""Reads a recording with the packages `mcap` and `mcap-protobuf-support` and decodes its blocks as docs/recording.md says.

    python read_with_python.py RECORDING.mcap [EXPORT.csv]

With the table that `sinew log export` has written of all cycles, every exact column is compared to the last bit.
"""

import csv
import json
import struct
import sys
from collections import Counter

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

MASK = (1 << 64) - 1


def signed(x):
    x &= MASK
    return x - (1 << 64) if x >> 63 else x


def residuals(data, k):
    place = 0

    def bits(count):
        nonlocal place
        value = 0
        for _ in range(count):
            value = value << 1 | data[place >> 3] >> (7 - (place & 7)) & 1
            place += 1
        return value

    while True:
        ones = 0
        while ones < 24 and bits(1):
            ones += 1
        u = bits(64) if ones == 24 else ones << k | bits(k)
        yield u >> 1 ^ -(u & 1)


def integers(column, count):
    values = [column.first]
    if not column.residuals:
        return values * count
    predictor, coded = column.mode & 3, residuals(column.residuals, column.mode >> 2 & 63)
    smooth = signed(16 * column.first)
    for _ in range(1, count):
        last, before = values[-1], values[-2] if len(values) > 1 else values[-1]
        predicted = (0, last, 2 * last - before, signed(smooth + 8) >> 4)[predictor]
        x = signed(predicted + next(coded))
        smooth = signed(smooth + (signed(16 * x - smooth) >> 3))
        values.append(x)
    return values


def on_grid(grid, k):
    x = k * grid["scale"] * grid.get("factor", 1.0) / grid.get("divisor", 1.0) * grid.get("arm", 1.0)
    inner = grid.get("inner", 0.0)
    if inner:
        count = abs(x / inner)
        count = int(count) + (count - int(count) >= 0.5)
        x = (count if x / inner >= 0 else -count) * inner
    return x + grid.get("offset", 0.0)


def exact(spec, counts, deviations, number):
    grid = spec["coding"]["exact"][number - 1] if number else None
    for count, deviation in zip(counts, deviations):
        base = struct.unpack("<q", struct.pack("<d", on_grid(grid, count)))[0] if grid else 0
        yield struct.unpack("<d", struct.pack("<Q", base + deviation & MASK))[0]


def main(path, table=None):
    topics, columns = Counter(), {}
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        attachments = {attachment.name: attachment.data for attachment in reader.iter_attachments()}
        head = json.loads(attachments["head.json"])
        assert "setup.json" in attachments
        for _, channel, _, block in reader.iter_decoded_messages():
            topics[channel.topic] += 1
            if channel.topic != "/sinew/cycles":
                continue
            coded = iter(block.fast)
            for spec in head["fast"]:
                column = next(coded)
                counts = integers(column, block.count)
                if "exact" in spec["coding"]:
                    deviations = integers(next(coded), block.count)
                    values = exact(spec, counts, deviations, column.mode >> 8)
                    columns.setdefault(spec["name"], []).extend(values)
    cycles = len(next(iter(columns.values())))
    assert all(len(column) == cycles for column in columns.values())
    if table:
        with open(table, newline="") as file:
            rows = list(csv.DictReader(file))
        assert len(rows) == cycles, (len(rows), cycles)
        for name, column in columns.items():
            for row, value in zip(rows, column):
                assert value != value and row[name] == "" or float(row[name]) == value, (name, row[name], value)
    print(json.dumps({"cycles": cycles, "topics": topics, "compared": bool(table)}))


main(*sys.argv[1:])
