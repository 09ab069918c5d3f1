"""Finds the fields that a plugin touches, by the introspection of MuJoCo's own bindings.

Callbacks get raw pointers to mjModel and mjData. The byte offsets of their fields follow from
`mujoco.introspect.structs`, which ships with the wheel, and are checked against real addresses
before anything is registered: a mismatch is an error message, not a crash.
"""

import ctypes
from functools import cache
from typing import Any, TypeVar

import mujoco
import numpy as np
from mujoco.introspect import ast_nodes, enums, structs

SCALARS: dict[str, Any] = {
    "char": ctypes.c_char,
    "unsigned char": ctypes.c_ubyte,
    "mjtByte": ctypes.c_ubyte,
    "mjtBool": ctypes.c_bool,
    "int": ctypes.c_int,
    "unsigned int": ctypes.c_uint,
    "float": ctypes.c_float,
    "double": ctypes.c_double,
    "mjtNum": ctypes.c_double,
    "mjtSize": ctypes.c_int64,
    "int64_t": ctypes.c_int64,
    "uint64_t": ctypes.c_uint64,
    "size_t": ctypes.c_size_t,
    "uintptr_t": ctypes.c_size_t,
}

NESTED = {"opt": "mjOption"}  # structs inside mjModel, by field
SENSOR, PASSIVE = 2, 4  # mjPLUGIN_SENSOR, mjPLUGIN_PASSIVE, which the bindings do not export
CALLBACKS = (  # members of mjpPlugin with addresses of functions, in order
    "nstate nsensordata init destroy copy reset compute advance visualize actuator_act_dot "
    "sdf_distance sdf_gradient sdf_staticdistance sdf_attribute sdf_aabb".split()
)


class Plugin(ctypes.Structure):
    """The C struct mjpPlugin of mujoco/mjplugin.h."""

    _fields_ = [
        ("name", ctypes.c_char_p),
        ("nattribute", ctypes.c_int),
        ("attributes", ctypes.POINTER(ctypes.c_char_p)),
        ("capabilityflags", ctypes.c_int),
        ("needstage", ctypes.c_int),
        *((name, ctypes.c_void_p) for name in CALLBACKS),
    ]


PROBE = """<mujoco><worldbody><body>
  <joint name="probe"/><geom size=".1"/><site/></body></worldbody>
  <sensor><jointpos name="probe" joint="probe"/></sensor></mujoco>"""

Layout = TypeVar("Layout", bound=tuple[Any, ...])


def layout(kind: type[Layout]) -> Layout:
    """Returns the fields that a plugin asks for, found in the installed MuJoCo and checked.

    `kind` is a named tuple class of integers. `m_NAME` becomes the byte offset of the field NAME in
    mjModel, and `d_NAME` the byte offset of NAME in mjData. `m_opt__NAME` is a field of a struct
    inside mjModel. The name of a value of a MuJoCo enum, as `mjOBJ_JOINT`, becomes that value.
    Other fields keep their defaults.
    """
    found: dict[str, int] = {}
    fields: Any = kind
    for name in fields._fields:
        if name.startswith(("m_", "d_")):
            found[name] = _offset(name)
        elif name.startswith("mj"):
            found[name] = _enum_value(name)
    return fields(**found)


@cache
def struct(name: str) -> type[ctypes.Structure]:
    """Returns the ctypes class of a MuJoCo C struct."""
    return _structure(structs.STRUCTS[name])


@cache
def _offset(name: str) -> int:
    """Returns the byte offset of a field, checked against a real model and its data."""
    outer, *inner = name[2:].split("__")
    try:
        field = getattr(struct("mjModel" if name[0] == "m" else "mjData"), outer)
        offset = field.offset
        for part in inner:
            offset += getattr(struct(NESTED[outer]), part).offset
    except AttributeError:
        raise RuntimeError(
            f"MuJoCo {mujoco.__version__} has no field {name!r}; the engine plugins support "
            "mujoco>=4.0,<5: install one of those"
        ) from None
    owner = _probe()[0 if name[0] == "m" else 1]
    there: float = ctypes.c_int64.from_address(owner._address + offset).value
    value: Any = getattr(owner, outer, None)
    for part in inner:
        value = getattr(value, part)
    if isinstance(value, np.ndarray) and value.size:
        expected = value.ctypes.data
    elif isinstance(value, float):
        expected, there = value, ctypes.c_double.from_address(owner._address + offset).value
    elif isinstance(value, int):
        expected = value
    else:
        return offset  # empty without a plugin, or bytes: no address to compare with
    if there != expected:
        raise RuntimeError(
            f"{type(owner).__name__}.{name[2:]} is not where MuJoCo {mujoco.__version__} says; "
            "the engine plugins support mujoco>=4.0,<5: install one of those"
        )
    return offset


@cache
def _probe() -> tuple[Any, Any]:
    model = mujoco.MjModel.from_xml_string(PROBE)
    return model, mujoco.MjData(model)


def _enum_value(name: str) -> int:
    for enum in enums.ENUMS.values():
        if name in enum.values:
            return enum.values[name]
    raise RuntimeError(
        f"MuJoCo {mujoco.__version__} has no enum value {name!r}; the engine plugins support "
        "mujoco>=4.0,<5: install one of those"
    )


def _structure(declaration: Any) -> type[ctypes.Structure]:
    members = [(field.name, _ctype(field.type)) for field in declaration.fields]
    name = getattr(declaration, "name", "anonymous")
    return type(name, (ctypes.Structure,), {"_fields_": members})


def _ctype(declared: Any) -> Any:
    if isinstance(declared, ast_nodes.PointerType):
        return ctypes.c_void_p
    if isinstance(declared, ast_nodes.ArrayType):
        element = _ctype(declared.inner_type)
        for extent in reversed(declared.extents):
            element = element * extent
        return element
    if isinstance(declared, ast_nodes.AnonymousStructDecl):
        return _structure(declared)
    if declared.name in SCALARS:
        return SCALARS[declared.name]
    if declared.name in enums.ENUMS or declared.name.rstrip("_") in enums.ENUMS:
        return ctypes.c_int
    return struct(declared.name)
