"""A joint with Stribeck friction as an engine plugin, and a wheel that runs out on it."""

import math
from collections import namedtuple

from activesuit.hysteresis.engine import native

KEYS = ("joint", "coulomb", "static", "stribeck_rate")  # units: N·m, N·m, rad/s
# The compiled callback uses these fields of mjModel (m_) and of mjData (d_).
FIELDS = "m_jnt_dofadr m_plugin_stateadr d_qvel d_qfrc_passive d_plugin_state d_plugin_data"
Layout = namedtuple("Layout", FIELDS)


def build():
    """Returns what MuJoCo calls; m and d are the addresses of mjModel and mjData."""
    at = native.layout(Layout)

    def nstate(instance):  # size of an instance's part of mjData.plugin_state
        return 3

    def init(instance):
        return instance.find("joint", "joint")  # id of the joint, which no reset changes

    def reset(instance, state, joint):
        state[:] = [native.number(instance.config, key) for key in KEYS[1:]]

    @native.callback
    def compute(m, d, instance, capability):
        coulomb, static, scale = native.doubles(native.state_of(m, d, instance, at), 3)
        joint = native.word_of(d, instance, at)
        dof = native.int32_at(native.pointer_at(m + at.m_jnt_dofadr), joint)
        rate = native.doubles(native.pointer_at(d + at.d_qvel), dof + 1)[dof]
        force = native.doubles(native.pointer_at(d + at.d_qfrc_passive), dof + 1)
        strength = coulomb + (static - coulomb) * math.exp(-((rate / scale) ** 2))
        force[dof] -= strength * math.tanh(10 * rate / scale)

    return nstate, init, reset, compute


native.register_plugin("demo.stribeck", KEYS, build, native.STAGE_VEL)

import matplotlib.pyplot as plt
import mujoco
import numpy as np

WHEEL = """
<mujoco>
  <option timestep="0.001" gravity="0 0 0"/>
  <extension>
    <plugin plugin="demo.stribeck">
      <instance name="bearing">
        <config key="joint" value="axle"/> <config key="coulomb" value="0.4"/>
        <config key="static" value="0.7"/> <config key="stribeck_rate" value="0.2"/>
      </instance>
    </plugin>
  </extension>
  <worldbody><body><joint name="axle"/><geom size=".2" mass="20"/></body></worldbody>
</mujoco>"""
wheel = mujoco.MjData(mujoco.MjModel.from_xml_string(WHEEL))
wheel.qvel[0] = 1.5
run = []
while wheel.qvel[0] > 1e-3:
    mujoco.mj_step(wheel.model, wheel)
    run.append((wheel.time, wheel.qvel[0], -wheel.qfrc_passive[0]))
time, rate, friction = np.transpose(run)

figure, axes = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
axes[0].plot(time, rate)
axes[0].set(xlabel="time [s]", ylabel="rate [rad/s]")
axes[1].plot(rate, friction)
axes[1].set(xlabel="rate [rad/s]", ylabel="friction [N·m]")
for axis in axes:
    axis.grid(alpha=0.3)
figure.savefig("stribeck.png", dpi=110)
