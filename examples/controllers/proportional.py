"""Proportional assist: the motors give a share of the wearer's voluntary torque."""

from activesuit.arrays import Array
from activesuit.checks import within
from activesuit.envs.plant import Plant
from activesuit.envs.policies import Seen, Transparent

GAIN = 0.5  # half of the gain at which learning no longer settles (see the rule)


class ProportionalAssist(Transparent):
    """Gives a multiple of the wearer's voluntary torque that the EMG tells, beside transparency.

    Law: transparent + gain times the estimated torque, which acts 0.05 s after it is measured.
    Tuning rule: below 1. A wearer who learns a motion gives less by the help; where help
    is as much as the wearer's own torque, learning swings from repetition to repetition and
    does not settle. The default is half of that.
    Signals needed: encoders and EMG.
    Source: Lenzi et al. 2012, Intention-based EMG control for powered exoskeletons, IEEE T-BME 59.

    Args:
        plant: What the policy may know of the arms.
        gain: Torque of the motors over that of the wearer, 0 to 1.
    """

    sensors = ("encoders", "emg")

    def __init__(self, plant: Plant, *, gain: float = GAIN) -> None:
        super().__init__(plant)
        within("gain", gain, 0, 1)
        self._gain = gain

    def torque(self, seen: Seen) -> Array:
        """Returns transparency and a share of the wearer's torque [N·m], shape (n, 2)."""
        return super().torque(seen) + self._gain * seen["emg"][:, self.assisted]
