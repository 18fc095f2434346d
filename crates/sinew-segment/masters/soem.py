#!/usr/bin/env python3
"""SOEM, through pysoem, against the simulated segment of `examples/serve.rs`: `soem.py INTERFACE`.

Reads every device's identity, EEPROM and object dictionary as `slaveinfo` does, brings the line to OP with
distributed clocks, enables the drives at a velocity and compares process data. Ends with 1 at the first difference.
"""

import ctypes
import struct
import sys
import time

import pysoem

VELOCITY = 20_000
problems = []


def check(condition, text):
    print(("ok    " if condition else "WRONG ") + text)
    if not condition:
        problems.append(text)


def emergency(message):
    problems.append(f"unexpected emergency {message}")


def read_dictionary(device):
    objects = entries = failed = 0
    for thing in device.od:
        objects += 1
        subs = thing.entries if thing.entries else [thing]
        for subindex, entry in enumerate(subs):
            if entry.bit_length == 0:
                continue
            entries += 1
            if entry.obj_access & 0x7 == 0:
                continue
            try:
                value = device.sdo_read(thing.index, subindex)
                if entry.data_type not in (0x9, 0xA) and len(value) != (entry.bit_length + 7) // 8:
                    problems.append(f"{device.name} {thing.index:#06x}:{subindex} has {len(value)} octets")
            except Exception as error:  # pysoem raises plain exceptions for packet errors
                failed += 1
                print("      ", hex(thing.index), subindex, error)
    return objects, entries, failed


def set_up(device, dc):
    def configure(position):
        if device.name == "SIM-DRV1":
            device.sdo_write(0x1C12, 0, b"\0")
            device.sdo_write(0x1C12, 1, struct.pack("<H", 0x1601))
            device.sdo_write(0x1C12, 0, b"\1")
            if dc:
                device.dc_sync(True, 2_000_000)

    return configure


def state_name(device):
    return f"{device.state:#04x} {pysoem.al_status_code_to_string(device.al_status)}"


def main():
    master = pysoem.Master()
    master.open(sys.argv[1])
    count = master.config_init()
    check(count > 0, f"{count} devices found")
    seen = set()
    for position, device in enumerate(master.slaves):
        device.add_emergency_callback(emergency)
        print(f"      {position} {device.name} {device.man:#x} {device.id:#x} {device.rev:#x}")
        alias_and_config = device.eeprom_read(8)
        check(alias_and_config == struct.pack("<I", device.man), "vendor in the EEPROM")
        if device.name in ("SIM-DRV1", "SIM-LC1") and device.name not in seen:
            seen.add(device.name)
            objects, entries, failed = read_dictionary(device)
            check(objects > 10 and failed == 0, f"{objects} objects, {entries} entries, {failed} not read")
            identity = device.sdo_read(0x1018, 0, ca=True)
            check(struct.unpack_from("<I", identity, 2)[0] == device.man, "identity in one transfer")
            long = device.sdo_read(0x1008, 0)
            check(long.decode() == device.name, "name by SDO")
        device.config_func = set_up(device, "dc" in sys.argv)
    size = master.config_map()
    print(f"      {size} octets of process data")
    check(master.config_dc(), "distributed clocks")
    reached = master.state_check(pysoem.SAFEOP_STATE, 500_000)
    check(reached == pysoem.SAFEOP_STATE, f"SAFE-OP {reached:#x}")
    if reached != pysoem.SAFEOP_STATE:
        master.read_state()
        for device in master.slaves:
            print("      ", device.name, state_name(device))
    master.send_processdata()
    master.receive_processdata(2000)
    master.state = pysoem.OP_STATE
    master.write_state()
    for _ in range(400):
        master.send_processdata()
        master.receive_processdata(2000)
        if master.state_check(pysoem.OP_STATE, 1000) == pysoem.OP_STATE:
            break
    master.read_state()
    check(all(device.state == pysoem.OP_STATE for device in master.slaves), "OP")
    for device in master.slaves:
        if device.state != pysoem.OP_STATE:
            print("      ", device.name, state_name(device))
    drives = [device for device in master.slaves if device.name == "SIM-DRV1"]
    wrong = late = 0
    start = time.monotonic()
    cycles = 2000
    for _ in range(cycles):
        for drive in drives:
            status = struct.unpack_from("<H", drive.input)[0] & 0x6F
            control = {0x40: 6, 0x21: 7}.get(status, 15)
            drive.output = struct.pack("<HibB", control, VELOCITY, 9, 0)
        master.send_processdata()
        counter = master.receive_processdata(2000)
        # -1 is no answer within the time: the processor was busy elsewhere.
        late += counter == -1
        wrong += counter not in (-1, master.expected_wkc)
        time.sleep(0.001)
    seconds = time.monotonic() - start
    check(wrong == 0, f"{wrong} wrong working counters of {cycles} cycles in {seconds:.1f} s, {late} late frames")
    for drive in drives:
        status, position, velocity, torque, mode, _, error = struct.unpack("<HiihbBH", drive.input)
        check(status & 0x6F == 0x27 and velocity == VELOCITY and mode == 9 and error == 0,
              f"drive: status {status:#x}, velocity {velocity}, position {position}, mode {mode}")
        check(position > 0.5 * VELOCITY * seconds, "the drive has moved")
    master.state = pysoem.INIT_STATE
    master.write_state()
    check(master.state_check(pysoem.INIT_STATE, 500_000) == pysoem.INIT_STATE, "INIT")
    master.close()
    print(f"{len(problems)} problems")
    for problem in problems:
        print(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
