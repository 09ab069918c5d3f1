"""Hand over hand along a rail: the hand pulls the body along, then takes hold anew."""

from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from ...arrays import Array
from ..model.workplace import add_pushes, draw, place_of
from ..simulation.kinematics import Arm, through_places
from ..simulation.plan import Plan
from .motions import between, minimum_jerk, posture, repeated, through
from .task import SUSTAINED, Task, check_range

FAR, NEAR = posture(1.1, 0.6), posture(0.45, 1.4)  # postures at the grip and at the release
HOLD = 2.0  # [s], grip of one hand
RISE = 0.3  # [s], rise and fall of the pull


@dataclass(frozen=True, kw_only=True)
class Handrail(Task):
    """The hand pulls along a straight rail for two seconds, and reaches out again for two.

    Attributes:
        pull: Least and greatest force along the rail [N]; each cycle has another one.
    """

    pull: tuple[float, float] = (30.0, 50.0)

    source: ClassVar[str] = "BVAD (translation takes 12 to 34 % of suited time); forces assumed"
    place: ClassVar[str] = "microgravity"
    period: ClassVar[float | None] = 2 * HOLD

    def __post_init__(self) -> None:
        super().__post_init__()
        check_range("the task's pull", self.pull, " N")

    def edit(self, spec: mujoco.MjSpec) -> None:
        """Adds the motors of the pull, and draws the rail."""
        add_pushes(spec)
        hand = spec.site("hand_grip").pos
        ends = [place_of(spec, angles[1:], hand) for angles in (FAR, NEAR)]
        beyond = 0.35 * (ends[0] - ends[1])
        draw(
            spec.body("torso"),
            mujoco.mjtGeom.mjGEOM_CAPSULE,
            "exo_accent",
            size=[0.016, 0, 0],
            fromto=[*(ends[0] + beyond), *(ends[1] - beyond)],
        )

    def plan(self, rng: np.random.Generator, samples: int, dt: float, arm: Arm) -> Plan:
        """Returns cycles of pull and reach; the path is watched while the hand pulls."""
        far, near = arm.places(np.array([FAR, NEAR]))
        stops = repeated([(0.0, far), (HOLD, near)], 2 * HOLD, samples * dt)
        starts = [time for time, _ in stops[::2]]
        time, force = dt * np.arange(samples), np.zeros(samples)
        for start in starts:
            force += rng.uniform(*self.pull) * _pulse(time - start)
        along = (far - near) / np.linalg.norm(far - near)
        motion = through_places(arm, through(stops, samples, dt)[0], FAR, dt)
        windows = [(start, start + HOLD) for start in starts]
        return Plan(motion, push=force[:, None] * along, watched=between(windows, samples, dt))


def _pulse(time: Array) -> Array:
    """Returns a smooth rise to 1 and fall to 0 within the time that a hand holds."""
    rise = minimum_jerk(np.clip(time / RISE, 0, 1))[0]
    return rise - minimum_jerk(np.clip((time - HOLD + RISE) / RISE, 0, 1))[0]


HANDRAIL = Handrail(name="Handrail", duration=20.0, effort=SUSTAINED, tracking=0.1, hand_error=0.03)
"""Five pulls; the hand stays within 3 cm of the rail while it pulls."""
