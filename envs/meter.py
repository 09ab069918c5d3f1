"""Measurements on the simulated arm that no sensor makes: true angles, torques and energies."""

import mujoco

from ..arrays import Array
from .wiring import Wiring

ENERGIES = ("assist_energy", "human_energy")


class Meter:
    """Reads angles and torques of the physics, and adds up energies.

    Args:
        wiring: Addresses of the model.
        dt: Control period [s].

    Attributes:
        values: Last readings, by their name in `info`.
        energy: Energies of motors and wearer since the reset, sums of |power| [J].
        dissipated_at_reset: Energy that the suit had dissipated at the reset, by its own count [J].
    """

    def __init__(self, wiring: Wiring, dt: float) -> None:
        self._wiring, self._dt = wiring, dt
        self._driven = wiring.exo_joints[wiring.assisted]

    def begin(self, data: mujoco.MjData) -> None:
        """Starts all counts at zero."""
        self.energy = dict.fromkeys(ENERGIES, 0.0)
        self.dissipated_at_reset = self.dissipated_in(data)

    def dissipated_in(self, data: mujoco.MjData) -> float:
        """Returns the energy that the suit has dissipated by its own count [J]."""
        return sum(data.sensordata[self._wiring.dissipated].tolist(), 0.0)

    def read(self, data: mujoco.MjData, target_angle: Array, others: dict[str, Array]) -> None:
        """Reads the physics of this instant, to which the values in `others` belong as well."""
        wiring = self._wiring
        self.values = {
            "angle": data.qpos[wiring.joints],
            "rate": data.qvel[wiring.joints],
            "target_angle": target_angle,
            "human_torque": data.actuator_force[wiring.human],
            "suit_torque": wiring.suit_torque_of(data),
            "assist_torque": wiring.assist_torque_of(data),
            **others,
        }
        if wiring.cuffs.size:
            self.values["cuff_force"] = data.sensordata[wiring.cuffs]
        self._dissipated = self.dissipated_in(data)

    def count(self, data: mujoco.MjData) -> None:
        """Adds the energies of the control period that ended with the last reading."""
        human = self.values["human_torque"] * self.values["rate"]
        assist = self.values["assist_torque"] * data.qvel[self._driven]
        self.energy["human_energy"] += sum(map(abs, human.tolist())) * self._dt
        self.energy["assist_energy"] += sum(map(abs, assist.tolist())) * self._dt

    def report(self) -> dict[str, Array | float]:
        """Returns copies of the readings and energies."""
        return {
            **{name: values.copy() for name, values in self.values.items()},
            **self.energy,
            "dissipated_energy": self._dissipated - self.dissipated_at_reset,
        }
