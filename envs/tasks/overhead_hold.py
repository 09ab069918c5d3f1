"""Work above the head: a tool is kept still at place after place, and the muscles tire."""

from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from ..model.config import HEAVIEST_PAYLOAD
from ..model.workplace import draw, grip, holder
from ..provenance import setting
from ..simulation.kinematics import Arm
from ..simulation.plan import Plan
from .motions import between, posture, through
from .task import SUSTAINED, Task

SHOULDER = ((0.85, 0.95), (1.1, 1.2))  # [rad], of lower and of higher places, in turn
ELBOW = (1.1, 1.3)  # rad
HOLD, MOVE, SETTLING = 6.0, 1.5, 0.5  # s, at a place, to the next one, and before the hand counts


@dataclass(frozen=True, kw_only=True)
class OverheadHold(Task):
    """The raised arm holds a tool still for six seconds, at one place after the other.

    Attributes:
        load: Mass of the tool [kg].
    """

    load: float = setting(1.0, "kg", 0, HEAVIEST_PAYLOAD)

    source: ClassVar[str] = "shoulder injuries in the EMU (Hilbert 2015); posture and load assumed"
    place: ClassVar[str] = "mars"
    carries: ClassVar[bool] = True
    fatigue: ClassVar[bool] = True

    def edit(self, spec: mujoco.MjSpec) -> None:
        """Draws the tool."""
        at = grip(spec).pos
        draw(
            holder(spec),
            mujoco.mjtGeom.mjGEOM_CAPSULE,
            "exo_steel",
            size=[0.02, 0, 0],
            fromto=[*(at + np.array([-0.04, 0, 0])), *(at + np.array([0.14, 0, 0]))],
        )

    def plan(self, rng: np.random.Generator, samples: int, dt: float, arm: Arm) -> Plan:
        """Returns a lower and a higher place in turn; the hand is watched at each."""
        del arm
        period, stops, windows = HOLD + MOVE, [], []
        for i in range(int(samples * dt / period) + 2):
            place = posture(rng.uniform(*SHOULDER[i % 2]), rng.uniform(*ELBOW))
            stops += [(i * period, place), (i * period + HOLD, place)]
            windows.append((i * period + SETTLING * (i > 0), i * period + HOLD))
        return Plan(
            through(stops, samples, dt),
            mass=np.full(samples, self.load),
            watched=between(windows, samples, dt),
        )


OVERHEAD_HOLD = OverheadHold(name="OverheadHold", duration=120.0, effort=SUSTAINED, hand_error=0.03)
"""A tool of 1 kg, kept within 3 cm at each place, for 120 s, by muscles that tire."""
