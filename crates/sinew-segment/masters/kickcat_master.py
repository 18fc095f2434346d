#!/usr/bin/env python3
"""KickCAT against the simulated segment of `examples/serve.rs`: `kickcat_master.py INTERFACE`.

KickCAT 2.5 reads the first PDO of a terminal without mailbox only and takes its sync manager 1 for inputs, so the line has
to be one without encoders. Reads objects, brings the line to OP, enables the drives in torque mode and compares process data. Ends with 1 at a
difference.
"""

import struct
import sys
import time
from datetime import timedelta

import kickcat

TORQUE = 123
problems = []


def check(condition, text):
    print(("ok    " if condition else "WRONG ") + text)
    if not condition:
        problems.append(text)


def error(*_):
    problems.append("a datagram that was not answered")


def cycle(bus):
    bus.process_data()
    time.sleep(0.001)


def main():
    link = kickcat.create_link(sys.argv[1], "")
    link.set_timeout(timedelta(milliseconds=50))
    bus = kickcat.Bus(link)
    bus.init(timedelta(milliseconds=2000))
    devices = bus.slaves()
    check(len(devices) > 0, f"{len(devices)} devices in PRE-OP")
    second = timedelta(seconds=1)
    name = bus.read_sdo(devices[1], 0x1008, 0, kickcat.Access.PARTIAL, 64, second)
    check(name == b"SIM-DRV1", f"name by SDO {name}")
    whole = bus.read_sdo(devices[1], 0x1018, 0, kickcat.Access.COMPLETE, 64, second)
    each = bus.read_sdo(devices[1], 0x1018, 0, kickcat.Access.EMULATE_COMPLETE, 64, second)
    check(len(whole) == 18 and len(each) > 0, f"identity {whole.hex()} {each.hex()}")
    print("     ", bus.read_object_description(devices[1], 0x6041))
    print("     ", bus.read_entry_description(devices[1], 0x6041, 0))
    bus.create_mapping()
    bus.request_state(kickcat.State.SAFE_OP)
    bus.wait_for_state(kickcat.State.SAFE_OP, second)
    check(True, "SAFE-OP")
    print("      octets in and out", [(device.input_size, device.output_size) for device in devices])
    bus.request_state(kickcat.State.OPERATIONAL)
    bus.wait_for_state(kickcat.State.OPERATIONAL, second, lambda: cycle(bus))
    check(True, "OP")
    drives = [device for device in devices if device.output_size == 6]
    for _ in range(1000):
        for drive in drives:
            status = struct.unpack_from("<H", drive.input_data)[0] & 0x6F
            control = {0x40: 6, 0x21: 7}.get(status, 15)
            drive.set_output_bytes(struct.pack("<HhbB", control, TORQUE, 10, 0))
        cycle(bus)
    for drive in drives:
        status, mode = struct.unpack("<Hiihb", drive.input_data[:13])[0::4]
        check(status & 0x6F == 0x27 and mode == 10, f"drive {drive.address}: status {status:#x}, mode {mode}")
    check(len(drives) == 3, f"{len(drives)} drives")
    print(f"{len(problems)} problems")
    for problem in problems:
        print(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
