"""What a controller may know of the arms that it drives."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import gymnasium

from ..arrays import AnyArray, Array
from ..errors import InputError
from .belief import Belief, BelievedArm
from .episodes import Episodes
from .model import ArmConfig
from .model.workplace import Edits


@dataclass(frozen=True, eq=False, kw_only=True)
class Plant:
    """What a controller may know: its sensors and motors, and what it believes of the arm.

    A policy gets a plant in place of the environment. The plant lacks the intention of the wearer,
    the physics, and the measurements that no sensor makes.

    Attributes:
        layout: Parts of an observation by name.
        observation_space: Space of the observations of one arm.
        sensors: Names of the sensor suites.
        normalized: Whether observations are divided by constants.
        motors: Number of motors.
        assisted: Indices of the assisted joints, shoulder and elbow, among the four.
        peak: Peak torque of the motors [N·m], shape (motors,).
        dt: Control period [s].
        period: Time of one cycle where the work of the task is cyclic [s]; else None.
        config: Arm that the options describe, or the believed one.
        edits: Tools of the task, as changes of a model.
    """

    layout: Mapping[str, slice]
    observation_space: gymnasium.spaces.Box
    sensors: tuple[str, ...]
    normalized: bool
    motors: int
    assisted: AnyArray
    peak: Array
    dt: float
    period: float | None
    config: ArmConfig
    edits: Edits | None = field(repr=False)

    @classmethod
    def of(cls, episodes: Episodes) -> "Plant":
        """Returns what a controller may know of the arms of an environment, from `env.episodes`."""
        simulation, observer = episodes.simulation, episodes.observer
        return cls(
            layout=dict(observer.layout),
            observation_space=observer.space,
            sensors=observer.sensors,
            normalized=observer.normalized,
            motors=episodes.motors,
            assisted=simulation.addresses.assisted.copy(),
            peak=simulation.addresses.peak_torque.copy(),
            dt=simulation.control_dt,
            period=episodes.task.period,
            config=simulation.config,
            edits=episodes.task.edits,
        )

    def believed(self, belief: Belief | None = None) -> BelievedArm:
        """Returns the arm that a controller believes in; `belief` replaces parts of `config`."""
        return BelievedArm(self.config, self.edits, self.dt, belief)

    def __getattr__(self, name: str) -> Any:
        if name in ("episodes", "unwrapped", "env", "envs", "simulation", "get_state", "step"):
            raise InputError(
                f"a policy asks for {name!r} of the environment: it gets the plant instead, which "
                f"has {', '.join(self.__dataclass_fields__)}; use observations for all else"
            )
        raise AttributeError(f"a plant has no attribute {name!r}")
