"""Encoders of the exoskeleton: the angle of a count, and the delay."""

import math

import mujoco
import numpy as np


def count_of(bits: int) -> float:
    """Returns the angle of one count [rad] of an encoder with that number of bits."""
    return math.tau / 2**bits


def delay_encoders(spec: mujoco.MjSpec, delay: float) -> None:
    """Delays the angles and rates that the encoders of `spec` report by `delay` [s].

    A reset sets the encoders' memory to zeros, and `start_encoders` then fills this memory.
    """
    if delay > 0:
        for sensor in spec.sensors:
            if sensor.name.startswith("encoder_"):
                sensor.delay = delay
                sensor.nsample = math.ceil(delay / spec.option.timestep - 1e-9)


def start_encoders(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Fills the memory of delayed encoders after a reset with the present state of `data`."""
    for i in np.flatnonzero(model.sensor_delay):
        if not model.sensor(i).name.startswith("encoder_"):
            continue
        joint = model.sensor_objid[i]
        if model.sensor_type[i] == mujoco.mjtSensor.mjSENS_JOINTPOS:
            now = data.qpos[model.jnt_qposadr[joint]]
        else:
            now = data.qvel[model.jnt_dofadr[joint]]
        values = np.full((model.sensor_history[i, 0], 1), now)
        mujoco.mj_initSensorHistory(model, data, i, None, values, 0.0)
