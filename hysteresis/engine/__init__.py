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

A reset brings the parameters and the start back that the joint was compiled with. Until then
`replace_model` gives one simulation a model of its own, and `take_off` removes the torque.

Importing this module registers one plugin for each model, once per process. MJCF can name it too:

    <extension>
      <plugin plugin="activesuit.jiles_atherton">
        <instance name="elbow_suit">
          <config key="joint" value="elbow"/>
          <config key="Ms" value="11.4488"/> <config key="a" value="128.97"/>
          <config key="alpha" value="-0.0515"/> <config key="c" value="6.4043"/>
          <config key="k" value="23.0945"/> <config key="angle_unit" value="deg"/>
        </instance>
      </plugin>
    </extension>
    <sensor><plugin name="elbow_torque" instance="elbow_suit"/></sensor>

    plugin                          config keys (radians and N·m; * may be left out)
    activesuit.jiles_atherton       Ms a alpha c k angle_unit form* clamp*
    activesuit.bouc_wen             elastic hysteretic A beta gamma n rest_angle*
    activesuit.prandtl_ishlinskii   stiffness rest_angle* thresholds weights
    activesuit.hinged_stops         stiffness rest_angle* thresholds weights knots slopes offset*
    activesuit.preisach             levels density elastic*
    activesuit.dahl                 spring stiffness friction
    activesuit.duhem                spring stiffness friction_up friction_down

Each plugin also has the keys `joint`, `start_angle`*, `start_torque`*, `start_path`* (angles that
the memory goes through before the first step), `polynomial`* (coefficients of an elastic torque),
`angle_range`* (the torque is constant outside), `viscoelastic`* (damping, relaxation stiffness
and relaxation time), `gap`* (of the play between joint and model), `allow_uncertified`* ("true")
and `taken_off`* ("true" for a model without torque until `replace_model` puts one of its kind
on). Lists are numbers with blanks between them; `density` has its rows one after the other. The
name of a sensor ends in `torque`, `stiffness` or `energy`, which is what it measures.

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
