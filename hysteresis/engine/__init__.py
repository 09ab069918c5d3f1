"""Hysteretic joint torque inside MuJoCo: an engine plugin compiled by numba, and `attach`.

The torque on a joint is that of `HysteresisModel.response` along the angles of the steps, to the
last bit, under every integrator. Parameters and memory of each joint are in `data.plugin_state`, so
MuJoCo saves, copies and batches them with the rest of the state:

    spec = mujoco.MjSpec.from_file("arm.xml")
    attach(spec, "elbow", TABLE_2["elbow-sa-pso"])
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 100)
    torque = data.sensor("elbow_suit_torque").data  # as of the last mj_forward

A reset brings back the parameters and the start of the compiled joint. Until then `replace_model`
gives one simulation a model of its own, and `take_off` removes the torque.

Importing this module registers one plugin for each model, once per process. MJCF can name the
plugins too: docs/robot.md has an example, and a table of the config keys. A further key of each
plugin is `taken_off` ("true"), for no torque until a `replace_model`. The name of a plugin's sensor
ends in `torque`, `stiffness` or `energy`, which is the measured quantity.

A process that reads a saved or pickled MjModel with such joints must import this module first:
MuJoCo finds the plugin's code in the process, not in the file. `envs.model.load_model` does so.
Without the import, MuJoCo 4.0 ends the process by a segmentation fault where the file is a .mjb.
"""

from . import native
from ._attach import attach, fault_slots, replace_model, same_layout, take_off
from ._callbacks import register

PLUGIN_NAMES = tuple(register())
"""The plugins that this module registers."""

__all__ = [
    "PLUGIN_NAMES",
    "attach",
    "fault_slots",
    "native",
    "register",
    "replace_model",
    "same_layout",
    "take_off",
]
