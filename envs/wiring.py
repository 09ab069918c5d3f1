"""Where a composed model keeps what the environment reads and writes."""

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..assets import JOINTS
from ..hysteresis.engine import fault_slots
from .composition import ASSISTED

Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Wiring:
    """Indices into mjData, in the order of `JOINTS` or `ASSISTED`.

    Attributes:
        joints: joint angles in qpos and rates in qvel (all joints are hinges), shape (4,).
        assisted: the assisted joints among `JOINTS`, shape (2,).
        human: the wearer's forces in actuator_force, shape (4,).
        intention: the wearer's controls: position, velocity, feed-forward, shape (4, 3).
        stiffness: the wearer's position gains [N·m/rad], shape (4,).
        assist: the motors' forces in actuator_force, shape (2,).
        motors: the motors' controls, shape (2,).
        peak_torque: the motors' torque at control 1 [N·m], shape (2,).
        suited: the joints among `JOINTS` that a suit resists, shape (n,).
        suit_torque: their torque in sensordata, shape (n,).
        dissipated: their dissipated energy in sensordata, shape (n,).
        faults: fault flags in plugin_state, shape (n,).
    """

    joints: Indices
    assisted: Indices
    human: Indices
    intention: Indices
    stiffness: NDArray[np.float64]
    assist: Indices
    motors: Indices
    peak_torque: NDArray[np.float64]
    suited: Indices
    suit_torque: Indices
    dissipated: Indices
    faults: Indices

    @classmethod
    def of(cls, model: mujoco.MjModel) -> "Wiring":
        """Looks everything up by name."""
        human = [model.actuator(f"human_{joint}").id for joint in JOINTS]
        assist = [model.actuator(f"assist_{joint}").id for joint in ASSISTED]
        sensors = {model.sensor(i).name: model.sensor_adr[i] for i in range(model.nsensor)}
        suited = [i for i, joint in enumerate(JOINTS) if f"{joint}_suit_torque" in sensors]
        return cls(
            joints=_indices(model.joint(joint).qposadr[0] for joint in JOINTS),
            assisted=_indices(JOINTS.index(joint) for joint in ASSISTED),
            human=_indices(human),
            intention=_indices(model.actuator_ctrladr[human])[:, None] + np.arange(3),
            stiffness=-model.actuator_biasprm[human, 1],
            assist=_indices(assist),
            motors=_indices(model.actuator_ctrladr[assist]),
            peak_torque=model.actuator_gainprm[assist, 0] * model.actuator_gear[assist, 0],
            suited=_indices(suited),
            suit_torque=_indices(sensors[f"{JOINTS[i]}_suit_torque"] for i in suited),
            dissipated=_indices(sensors[f"{JOINTS[i]}_suit_dissipated_energy"] for i in suited),
            faults=fault_slots(model),
        )

    def suit_torque_of(self, data: mujoco.MjData) -> NDArray[np.float64]:
        """Returns the suit's torque on each of `JOINTS` [N·m]; zero where it does not resist."""
        torque = np.zeros(len(JOINTS))
        torque[self.suited] = data.sensordata[self.suit_torque]
        return torque


def _indices(values) -> Indices:
    return np.array(list(values), dtype=np.int64)
