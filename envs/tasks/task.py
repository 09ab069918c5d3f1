"""A task: the intention of the wearer, the loads on the hand, and the limits of success."""

import json
from dataclasses import asdict, dataclass
from typing import Any, ClassVar

import mujoco
import numpy as np

from ...errors import InputError, shown
from ..model.workplace import Edits
from ..provenance import check_settings, setting
from ..simulation.episode_plan import Motion, Plan
from ..simulation.kinematics import Arm

SHORTEST, LONGEST = 0.02, 3600.0  # [s], limits of an episode
FARTHEST = 10.0  # m and rad, of tolerances
# Limits of effort, shares of strength. That of the published work envelope is 0.15 of net torque
# (Schmidt 2001), to which usual co-contraction adds 0.02; a shoulder bears 0.30 for 144 s (Frey-Law
# et al. 2012).
SUSTAINED, LOADED = 0.17, 0.30
ROUNDING = 1e-3  # excess of a motor's load that its protection, once a period, does not prevent
STEADY = 0.03  # [rad], error of a joint that moves the hand by 2 cm, as far as the arm reaches


@dataclass(frozen=True)
class Limit:
    """A limit of success."""

    # Name of a cost in `envs.interface.reward.COSTS`; or "lost", which is 1 if the arm is lost, at
    # a pole of the suit's torque, or diverged.
    name: str
    value: float  # greatest cost with which an episode succeeds
    unit: str  # unit of both, "1" for a ratio


TOLERANCES = {
    "tracking": ("worst_joint", "rad"),
    "effort": ("effort", "1"),
    "hand_error": ("hand_error", "m"),
    "tilt": ("tilt", "rad"),
    "slowness": ("slowness", "1"),
}
"""Costs that a task limits and their units, by the fields of the task."""

EVERYWHERE = (
    Limit("lost", 0.0, "1"),
    Limit("cuff_force", 1.0, "1"),  # over what a person should bear
    Limit("heat", 1.0 + ROUNDING, "1"),  # greatest load of a motor over its continuous torque
)
"""Limits of success in every task."""


@dataclass(frozen=True, kw_only=True)
class Task:
    """A task; derive from it, and override `motion` or `plan`.

    A task is plain data: all that differs between episodes comes from the random generator.

    Attributes:
        name: Name of the task.
        duration: Duration of an episode [s].
        tracking: Root mean square over time of the tracking error of the worst joint, up to which
            an episode succeeds [rad].
        effort: Root mean square of the wearer's torque over strength, over time and four joints, up
            to which an episode succeeds.
        hand_error: Largest distance of the hand from its place where the plan watches it, up to
            which an episode succeeds [m].
        tilt: Largest error of the hand's pitch there [rad].
        slowness: Largest share of its intended speed that the hand may lack there.
        fatigue: Whether the wearer's muscles tire, unless the environment says otherwise.
        place: Place whose gravity acts, unless the environment says otherwise.
        source: Source of motion, loads and rule of success.
        carries: Whether plans have a mass (of the class).
        period: Time of one cycle where the work is cyclic [s], the same in all episodes, so that a
            controller may know the period; when the first cycle begins is drawn.
    """

    name: str
    duration: float = setting(10.0, "s", SHORTEST, LONGEST)
    tracking: float = setting(STEADY, "rad", 0, FARTHEST)
    effort: float = setting(LOADED, "of strength", 0, FARTHEST)
    hand_error: float = setting(FARTHEST, "m", 0, FARTHEST)
    tilt: float = setting(FARTHEST, "rad", 0, FARTHEST)
    slowness: float = setting(FARTHEST, "of the speed", 0, FARTHEST)

    source: ClassVar[str] = "your own"
    carries: ClassVar[bool] = False
    period: ClassVar[float | None] = None
    fatigue: ClassVar[bool] = False
    place: ClassVar[str] = "earth"

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise InputError(f"the task's name is {shown(self.name)}: give it one")
        check_settings(self, "the task's ")

    def edit(self, spec: mujoco.MjSpec) -> None:
        """Adds what the task needs to the specification of the right arm; by default nothing.

        `envs.model.workplace` has the usual parts. Tools belong to the body `holder(spec)`.
        """

    def motion(self, rng: np.random.Generator, samples: int, dt: float) -> Motion:
        """Returns the intended angles [rad] of an episode and two derivatives, (samples, 4) each.

        Args:
            rng: Random generator of this episode's motion.
            samples: Number of samples, the first at the reset.
            dt: Time between samples [s].
        """
        raise InputError(f"the task {self.name!r} has no motion: override motion or plan")

    def plan(self, rng: np.random.Generator, samples: int, dt: float, arm: Arm) -> Plan:
        """Returns the plan of an episode; by default `motion` without a load.

        Args:
            rng: Random generator of this episode's motion.
            samples: Number of samples, the first at the reset.
            dt: Time between samples [s].
            arm: The wearer's arm, which knows where the hand is.
        """
        return Plan(self.motion(rng, samples, dt))

    @property
    def watches(self) -> bool:
        """Whether success depends on where the hand is."""
        return min(self.hand_error, self.tilt, self.slowness) < FARTHEST

    @property
    def limits(self) -> tuple[Limit, ...]:
        """Limits of success: an episode succeeds where no cost is above its limit."""
        own = (Limit(cost, getattr(self, name), unit) for name, (cost, unit) in TOLERANCES.items())
        return (*EVERYWHERE, *(one for one in own if one.value < FARTHEST))

    @property
    def about(self) -> str:
        """Description of the motion: the first sentences of the class."""
        return " ".join((type(self).__doc__ or "").partition("\n\n")[0].split())

    @property
    def rule(self) -> str:
        """Description of success in this task."""
        parts = [f"each joint within {1000 * self.tracking:g} mrad"]
        for value, words in (
            (self.effort, f"effort at most {100 * self.effort:g} % of strength"),
            (self.hand_error, f"hand within {100 * self.hand_error:g} cm where it is watched"),
            (self.tilt, f"tilt within {self.tilt:g} rad there"),
            (self.slowness, f"at most {100 * self.slowness:g} % too slow there"),
        ):
            if value < FARTHEST:
                parts.append(words)
        return ", ".join(parts)

    @property
    def edits(self) -> Edits | None:
        """Additions of the task to a model; None for no additions."""
        if type(self).edit is Task.edit:
            return None
        return Edits(
            json.dumps(self.identity(), sort_keys=True, default=np.ndarray.tolist), self.edit
        )

    def identity(self) -> dict[str, Any]:
        """Returns class and fields as plain values."""
        kind = type(self)
        return {"task_class": f"{kind.__module__}.{kind.__qualname__}", **asdict(self)}
