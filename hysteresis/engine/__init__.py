"""Hysteretic joint torque inside MuJoCo: an engine plugin compiled by numba, and `attach`.

Importing this module registers the plugin `activesuit.jiles_atherton`, once per process. Use it
from Python with `attach`, or from MJCF:

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

Optional keys are `start_angle` (rad), `start_torque` (N·m) and `allow_uncertified` ("true"). The
name of a sensor ends in `torque`, `stiffness` or `energy`, which is what it measures.

A process that reads a saved or pickled MjModel with such joints must import this module first:
MuJoCo finds the plugin's code in the process, not in the file.
"""

from ._attach import attach, fault_slots
from ._registration import PLUGIN_NAME, register

__all__ = ["PLUGIN_NAME", "attach", "fault_slots", "register"]

register()
