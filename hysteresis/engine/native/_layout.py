"""Where MuJoCo keeps the fields that our plugins touch, read from the bindings' own introspection.

Their callbacks get raw pointers to mjModel and mjData. The byte offsets of their fields
follow from `mujoco.introspect.structs`, which ships with the wheel, and are checked against real
addresses before anything is registered: a mismatch is an error message, not a crash.
"""

import ctypes
from functools import cache
from typing import Any, NamedTuple

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

SENSOR, PASSIVE = 2, 4  # mjPLUGIN_SENSOR, mjPLUGIN_PASSIVE: the bindings do not export them


class Plugin(ctypes.Structure):
    """The C struct mjpPlugin of mujoco/mjplugin.h."""

    _fields_ = [
        ("name", ctypes.c_char_p),
        ("nattribute", ctypes.c_int),
        ("attributes", ctypes.POINTER(ctypes.c_char_p)),
        ("capabilityflags", ctypes.c_int),
        ("needstage", ctypes.c_int),
        *(
            (name, ctypes.c_void_p)
            for name in (
                "nstate",
                "nsensordata",
                "init",
                "destroy",
                "copy",
                "reset",
                "compute",
                "advance",
                "visualize",
                "actuator_act_dot",
                "sdf_distance",
                "sdf_gradient",
                "sdf_staticdistance",
                "sdf_attribute",
                "sdf_aabb",
            )
        ),
    ]


PROBE = """<mujoco><worldbody><body>
  <joint name="probe"/><geom size=".1"/><site/></body></worldbody>
  <sensor><jointpos name="probe" joint="probe"/></sensor></mujoco>"""


class Layout(NamedTuple):
    """Byte offsets of fields in mjModel (m_), mjData (d_), mjpPlugin (p_); values of some enums."""

    m_nsensor: int
    m_njnt: int
    m_nsite: int
    m_body_parentid: int
    m_body_rootid: int
    m_body_dofnum: int
    m_body_dofadr: int
    m_dof_parentid: int
    m_site_bodyid: int
    m_jnt_type: int
    m_jnt_qposadr: int
    m_jnt_dofadr: int
    m_qpos0: int
    m_sensor_type: int
    m_sensor_plugin: int
    m_sensor_adr: int
    m_plugin: int
    m_plugin_stateadr: int
    m_plugin_statenum: int
    m_plugin_attr: int
    m_plugin_attradr: int
    m_names: int
    m_name_sensoradr: int
    d_qpos: int
    d_qvel: int
    d_qfrc_passive: int
    d_site_xpos: int
    d_site_xmat: int
    d_subtree_com: int
    d_cdof: int
    d_cvel: int
    d_sensordata: int
    d_plugin_state: int
    d_plugin_data: int
    object_joint: int
    object_site: int
    joint_slide: int
    joint_hinge: int
    sensor_plugin: int
    passive: int
    p_attributes: int


@cache
def struct(name: str) -> type[ctypes.Structure]:
    """Returns the ctypes twin of a MuJoCo C struct."""
    return _structure(structs.STRUCTS[name])


def layout() -> Layout:
    """Returns the checked layout of the installed MuJoCo.

    Raises:
        RuntimeError: the introspected layout disagrees with the library.
    """
    fields = [name for name in Layout._fields if name[:2] in ("m_", "d_")]
    found = {name: _field(name).offset for name in fields}
    model = mujoco.MjModel.from_xml_string(PROBE)
    data = mujoco.MjData(model)
    for name, offset in found.items():
        owner, attribute = (model if name[0] == "m" else data), name[2:]
        there = ctypes.c_int64.from_address(owner._address + offset).value
        value = getattr(owner, attribute)
        if isinstance(value, np.ndarray) and value.size:
            expected = value.ctypes.data
        elif isinstance(value, int):
            expected = value
        else:
            continue  # empty without a plugin, or bytes: no address to compare with
        if there != expected:
            raise RuntimeError(
                f"{type(owner).__name__}.{attribute} is not where MuJoCo {mujoco.__version__} says "
                "it is; the engine plugins support mujoco>=4.0,<5: install one of those"
            )
    return Layout(
        **found,
        object_joint=int(mujoco.mjtObj.mjOBJ_JOINT),
        object_site=int(mujoco.mjtObj.mjOBJ_SITE),
        joint_slide=int(mujoco.mjtJoint.mjJNT_SLIDE),
        joint_hinge=int(mujoco.mjtJoint.mjJNT_HINGE),
        sensor_plugin=int(mujoco.mjtSensor.mjSENS_PLUGIN),
        passive=PASSIVE,
        p_attributes=Plugin.attributes.offset,
    )


def _field(name: str) -> Any:
    return getattr(struct("mjModel" if name[0] == "m" else "mjData"), name[2:])


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
