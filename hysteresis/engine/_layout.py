"""The fields of MuJoCo's structs that a hysteretic joint reads and writes."""

from typing import NamedTuple


class Layout(NamedTuple):
    """Byte offsets of fields in mjModel (m_) and mjData (d_), and values of some enums.

    `stamp` distinguishes versions of a model's kernels and of the engine, so that numba's cache
    does not give back machine code of an older version.
    """

    m_opt__timestep: int
    m_nsensor: int
    m_njnt: int
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
    d_sensordata: int
    d_plugin_state: int
    d_plugin_data: int
    mjOBJ_JOINT: int
    mjJNT_SLIDE: int
    mjJNT_HINGE: int
    mjSENS_PLUGIN: int
    mjPLUGIN_PASSIVE: int
    stamp: int = 0
