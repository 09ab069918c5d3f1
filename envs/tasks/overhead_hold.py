"""Work above the head: a tool is kept in place for two minutes, and the muscles tire."""

from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from ...assets import JOINTS
from ..model.config import HEAVIEST_PAYLOAD
from ..model.workplace import draw, grip, holder
from ..provenance import setting
from ..simulation.kinematics import Arm
from ..simulation.plan import Plan
from .motions import posture
from .task import SUSTAINED, Task

RAISED = posture(1.2, 1.2)
SPREAD = 0.02  # [rad], spread of the postures


@dataclass(frozen=True, kw_only=True)
class OverheadHold(Task):
    """The raised arm holds a tool still.

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
        """Returns a constant posture; the hand is watched all the time."""
        del dt, arm
        raised = RAISED + np.array([0, *rng.uniform(-SPREAD, SPREAD, 2), 0])
        angle = np.tile(raised, (samples, 1))
        still = np.zeros((samples, len(JOINTS)))
        return Plan(
            (angle, still, still.copy()),
            mass=np.full(samples, self.load),
            watched=np.ones(samples, np.bool_),
        )


OVERHEAD_HOLD = OverheadHold(
    name="OverheadHold", duration=120.0, effort=SUSTAINED, tracking=0.1, hand_error=0.03
)
"""A tool of 1 kg, kept within 3 cm for 120 s by muscles that tire."""
