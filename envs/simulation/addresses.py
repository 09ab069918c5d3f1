"""The addresses in MuJoCo's arrays of everything that a simulation reads and writes."""

import re
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...assets import JOINTS
from ...hysteresis.engine import fault_slots
from ..model import ASSISTED
from ..model.cuffs import CUFFS
from ..model.workplace import PUSHES

Indices = NDArray[np.int64]


class Addresses(NamedTuple):
    """Indices into mjData, in the order of `JOINTS` or `ASSISTED`.

    The arrays of motors are empty without an exoskeleton, and those of cuff forces without cuffs.

    Attributes:
        joints: Angles of the arm in qpos, and rates in qvel (all joints are hinges), shape (4,).
        exo_joints: Angles of the exoskeleton in qpos, shape (4,); those of the arm if it is rigid.
        driven: Those of the exoskeleton's joints that carry a motor, shape (2,).
        assisted: Positions of the assisted joints in `JOINTS`, shape (2,).
        human: Torques of the wearer in actuator_force, shape (4,).
        intention: Controls of the wearer: position, velocity, feed-forward, shape (3, 4).
        encoders: Angles of the encoders in sensordata, shape (4,).
        assist: Torques of the motors in actuator_force, shape (2,).
        motors: Controls of the motors, which are torques [N·m], shape (2,).
        peak_torque: Largest torque of each motor [N·m], shape (2,).
        pushes: Controls of the forces on the grip, shape (3,); none where a task has none.
        hand: Place of the grip in sensordata, shape (3,).
        cuffs: Forces on upper arm, forearm and hand in sensordata, shape (9,).
        suited: Positions in `JOINTS` of the joints that suits resist, shape (n,); a joint occurs
            once for each kind of model that it may have, of which one is active.
        suit_torque: Torques of these models in sensordata, shape (n,).
        dissipated: Energies that they have dissipated in sensordata, shape (n,).
        faults: Fault flags of these models in plugin_state, shape (n,).
    """

    joints: Indices
    exo_joints: Indices
    driven: Indices
    assisted: Indices
    human: Indices
    intention: Indices
    encoders: Indices
    assist: Indices
    motors: Indices
    peak_torque: Array
    pushes: Indices
    hand: Indices
    cuffs: Indices
    suited: Indices
    suit_torque: Indices
    dissipated: Indices
    faults: Indices

    @classmethod
    def of(cls, model: mujoco.MjModel) -> "Addresses":
        """Returns the addresses of a model, which are found by name."""
        actuators = {model.actuator(i).name: i for i in range(model.nactuator)}
        sensors = {model.sensor(i).name: model.sensor_adr[i] for i in range(model.nsensor)}
        joints = {model.joint(i).name: model.jnt_qposadr[i] for i in range(model.njnt)}
        human = [actuators[f"human_{joint}"] for joint in JOINTS]
        motors = [f"assist_{joint}" for joint in ASSISTED]
        assist = _indices(actuators[motor] for motor in motors if motor in actuators)
        cuffs = [f"cuff_{segment}_force" for segment in CUFFS]
        forces = _indices(sensors[cuff] for cuff in cuffs if cuff in sensors)
        found = [re.fullmatch(r"(.*)(_suit(?:_\d+)?)_torque", sensor) for sensor in sensors]
        resisting = sorted((JOINTS.index(match[1]), match[2]) for match in found if match)
        suits = [f"{JOINTS[i]}{suit}" for i, suit in resisting]
        exo_joints = _indices(joints.get(f"exo_{joint}", joints[joint]) for joint in JOINTS)
        assisted = _indices(JOINTS.index(joint) for joint in ASSISTED)
        return cls(
            joints=_indices(joints[joint] for joint in JOINTS),
            exo_joints=exo_joints,
            driven=exo_joints[assisted],
            assisted=assisted,
            human=_indices(human),
            intention=_indices(model.actuator_ctrladr[human]) + np.arange(3)[:, None],
            encoders=_indices(sensors[f"encoder_{joint}"] for joint in JOINTS),
            assist=assist,
            motors=_indices(model.actuator_ctrladr[assist]),
            peak_torque=model.actuator_forcerange[assist, 1],
            pushes=_indices(
                model.actuator_ctrladr[actuators[push]] for push in PUSHES if push in actuators
            ),
            hand=sensors["hand_position"] + np.arange(3),
            cuffs=(forces[:, None] + np.arange(3)).ravel(),
            suited=_indices(i for i, _ in resisting),
            suit_torque=_indices(sensors[f"{suit}_torque"] for suit in suits),
            dissipated=_indices(sensors[f"{suit}_dissipated_energy"] for suit in suits),
            faults=fault_slots(model),
        )


def _indices(values) -> Indices:
    return np.array(list(values), dtype=np.int64)
