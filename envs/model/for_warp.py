"""The arm as a MuJoCo model that MuJoCo Warp 4.0 accepts."""

import mujoco
import numpy as np

from ...errors import InputError
from .compose import _built
from .config import ArmConfig
from .lean import make_lean

PID, FIXED = mujoco.mjtGain.mjGAIN_PID, mujoco.mjtGain.mjGAIN_FIXED
AUTORESET = int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)


def for_warp(config: ArmConfig) -> mujoco.MjModel:
    """Builds the arm and the exoskeleton of a configuration for MuJoCo Warp.

    It has no drawings, no plugins and no keyframes. `activesuit.hysteresis.warp.attach` adds the
    suit's torque: models and starts are those of `resisting_joints(config)`. Each of the wearer's
    four actuators has one input u instead of three. Its torque is u - kp q - kv v within the same
    limits, where kp and kv are `-actuator_biasprm[i, 1:3]`. So u = kp q* + kv v* + ff gives the
    torque that `compose` gives with the inputs q*, v* and ff, to the last bit in MuJoCo. The ranges
    of those three inputs are for the caller to keep.

    Args:
        config: Configuration of the model.

    Returns:
        Model, the inputs of which are the wearer's four joints and then the motors.

    Raises:
        InputError: The exoskeleton is connected by cuffs.
    """
    if config.coupling == "cuffs":
        raise InputError(
            "coupling is 'cuffs', whose forces are a plugin, which MuJoCo Warp has not: use "
            "'rigid' or 'none'"
        )
    spec = _built(config, None, drawn=False)
    for key in [*spec.keys]:
        spec.delete(key)
    for motor in spec.actuators:
        if motor.gaintype == PID:
            motor.gaintype, motor.gainprm, motor.ctrlspec = FIXED, np.eye(10)[0], 0
    spec.option.disableflags &= ~AUTORESET
    make_lean(spec)
    return spec.compile()
