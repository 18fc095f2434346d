"""Where MuJoCo keeps the fields of its structures: computed from its own description, compared with its arrays."""

from __future__ import annotations

import ctypes
from typing import Any, NamedTuple

import numpy as np

from .._sinew import mujoco_fields


class Place(NamedTuple):
    """Offset of a field, bytes, and the width of its number, negative for a floating-point number."""

    offset: int
    width: int


class Mismatch(Exception):
    """The description of MuJoCo's structures and its memory disagree."""


#: Widths of C's types in MuJoCo's description; others are structures of it, or enumerations, which are `int`.
WIDTHS = {
    "char": 1, "mjtByte": 1, "mjtBool": 1, "bool": 1, "_Bool": 1, "uint8_t": 1,
    "int": 4, "unsigned int": 4, "float": -4, "int32_t": 4, "uint32_t": 4,
    "mjtNum": -8, "double": -8, "mjtSize": 8, "size_t": 8, "uintptr_t": 8, "int64_t": 8, "uint64_t": 8,
}  # fmt: skip
ADDRESS = 8

#: Anything that makes every array of the plugins' interest longer than zero, with friction and, by default, islands.
CHECK = """<mujoco>{extension}
  <option timestep="0.00125" integrator="RK4"/>
  <worldbody><site name="a"/>
    <body><joint name="j" type="slide"/><geom size=".1"/><site name="b" pos=".1 .2 .3"/></body>
    <body pos="1 0 0"><joint name="k" type="slide"/><geom size=".1"/></body></worldbody>
  <tendon><spatial name="s" frictionloss="1"><site site="a"/><site site="b"/></spatial>
    <fixed name="t" frictionloss="1"><joint joint="j" coef="1"/><joint joint="k" coef="1"/></fixed></tendon>
  <actuator>{plugin}<general tendon="s" dyntype="integrator" gear="-1"/><motor tendon="t"/><motor joint="k"/></actuator>
</mujoco>"""


class Layout:
    """Offsets of all fields of `mjModel` and `mjData`, those of their structures included."""

    def __init__(self) -> None:
        from mujoco.introspect.structs import STRUCTS

        self._structs = STRUCTS
        self.model = self._fields("mjModel")
        self.data = self._fields("mjData")

    def _fields(self, struct: str) -> dict[str, Place]:
        found: dict[str, Place] = {}
        self._lay(self._structs[struct].fields, "", 0, found)
        return found

    def _lay(self, fields: Any, prefix: str, start: int, found: dict[str, Place]) -> tuple[int, int]:
        """Lays out the fields of a structure from `start` on; returns its end and its alignment."""
        at, most, end = start, 1, start
        for field in fields:
            inner: dict[str, Place] = {}
            size, alignment, width = self._size(field.type, inner)
            at = start + -(-(at - start) // alignment) * alignment
            found[prefix + field.name] = Place(at, width)
            for name, place in inner.items():
                found[f"{prefix}{field.name}.{name}"] = Place(at + place.offset, place.width)
            at, most = at + size, max(most, alignment)
        end = start + -(-(at - start) // most) * most
        return end, most

    def _size(self, kind: Any, inner: dict[str, Place]) -> tuple[int, int, int]:
        """Size, alignment and width of a type; the fields of a structure go to `inner`."""
        match type(kind).__name__:
            case "PointerType":
                return ADDRESS, ADDRESS, ADDRESS
            case "ArrayType":
                size, alignment, _ = self._size(kind.inner_type, {})
                return size * int(np.prod(kind.extents)), alignment, 0
            case "AnonymousStructDecl":
                end, alignment = self._lay(kind.fields, "", 0, inner)
                return end, alignment, 0
            case "ValueType" if "*" in kind.name:
                return ADDRESS, ADDRESS, ADDRESS
            case "ValueType":
                if kind.name in self._structs:
                    end, alignment = self._lay(self._structs[kind.name].fields, "", 0, inner)
                    return end, alignment, 0
                width = WIDTHS.get(kind.name, 4)
                return abs(width), abs(width), width
            case other:
                raise Mismatch(f"a field has the unknown type {other}")

    def places(self) -> list[Place]:
        """Places of the fields that the plugins use, in their order."""
        missing = Place(-1, ADDRESS)
        found = []
        for path, _, required in mujoco_fields():
            struct, _, name = path.partition(".")
            place = (self.model if struct == "mjModel" else self.data).get(name, missing)
            if required and place is missing:
                raise Mismatch(f"it has no field {path}")
            found.append(place)
        return found

    def check(self, mujoco: Any) -> int:
        """Compares with the memory of a small model; returns how many fields were compared."""
        model = small_model(mujoco)
        data = mujoco.MjData(model)
        mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        compared = _compare(model, model._address, self.model, "mjModel")
        compared |= _compare(data, data._address, self.data, "mjData")
        have_plugin = model.nplugin > 0
        for path, _, required in mujoco_fields():
            struct, _, name = path.partition(".")
            there = name in (self.model if struct == "mjModel" else self.data)
            # Arrays of plugins are empty where MuJoCo came without its own; those of islands where it found none.
            empty = not have_plugin and "plugin" in name or "iefc" in name and data.nisland == 0
            if there and path not in compared and (required or not empty) and not (empty and "plugin" in name):
                raise Mismatch(f"its field {path} cannot be compared")
        return len(compared)


def small_model(mujoco: Any) -> Any:
    """The model of the comparison, with one of MuJoCo's own plugins where its library is there."""
    config = "".join(f'<config key="{key}" value="1"/>' for key in ("kp", "ki", "imax", "slewmax"))
    extension = f'<extension><plugin plugin="mujoco.pid"><instance name="p">{config}</instance></plugin></extension>'
    plugin = '<plugin plugin="mujoco.pid" instance="p" joint="j"/>'
    try:
        return mujoco.MjModel.from_xml_string(CHECK.format(extension=extension, plugin=plugin))
    except ValueError:
        return mujoco.MjModel.from_xml_string(CHECK.format(extension="", plugin=""))


def _compare(owner: Any, address: int, places: dict[str, Place], struct: str) -> set[str]:
    compared = set()
    texts: list[tuple[str, int, bytes]] = []
    for name, place in places.items():
        value: Any = owner
        for part in name.split("."):
            value = getattr(value, part, None)
        at = address + place.offset
        if isinstance(value, bytes) and place.width == ADDRESS:
            texts.append((name, ctypes.c_size_t.from_address(at).value, value))
            continue
        if isinstance(value, np.ndarray) and place.width == ADDRESS:
            inside = ctypes.c_void_p.from_address(at).value
            if value.size == 0 or inside is None:
                continue  # nothing there
            if inside != value.__array_interface__["data"][0]:
                raise Mismatch(f"its field {struct}.{name} is not where its description has it")
        elif isinstance(value, (int, float)) and place.width in (4, 8, -8):
            kinds: dict[int, Any] = {4: ctypes.c_int32, 8: ctypes.c_int64, -8: ctypes.c_double}
            if kinds[place.width].from_address(at).value != value:
                raise Mismatch(f"its field {struct}.{name} is not where its description has it")
        else:
            continue
        compared.add(f"{struct}.{name}")
    # Python copies texts: their content is compared, once everything around them is where it should be.
    for name, at, text in texts:
        if text and ctypes.string_at(at, len(text)) != text:
            raise Mismatch(f"its field {struct}.{name} is not where its description has it")
        compared.add(f"{struct}.{name}")
    return compared
