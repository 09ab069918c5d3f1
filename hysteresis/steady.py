"""The steady cycle of a model: the loop that the model repeats after enough cycles."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import polynomial as poly

from ..arrays import Array
from ..errors import InputError
from .certificate import checked_range
from .protocol import HysteresisModel

TOLERANCE = 1e-6  # largest change from one cycle to the next, over the range of the torque
MOST_CYCLES = 128
FEWEST_CYCLES = 8  # first number of cycles of the search, which doubles them
SAMPLES = 201  # number of samples per branch


@dataclass(frozen=True, eq=False, kw_only=True)
class SteadyCycle:
    """A closed cycle between two angles, which repeats itself.

    Attributes:
        angle: Angles from the lower end to the upper one [rad], shape (n,).
        rising: Torque on the way up [N·m], shape (n,).
        falling: Torque at the same angles on the way down [N·m], shape (n,).
        cycles: Number of cycles, from the first loading to the first that repeats its predecessor.
    """

    angle: Array
    rising: Array
    falling: Array
    cycles: int

    @cached_property
    def dissipated(self) -> float:
        """Energy that one cycle dissipates, the closed integral of torque over angle [J]."""
        return float(np.trapezoid(self.rising - self.falling, self.angle))

    @cached_property
    def loading_work(self) -> float:
        """Work on the joint in one cycle, counted where the torque resists the motion [J]."""
        against = np.maximum(self.rising, 0) + np.maximum(-self.falling, 0)
        return float(np.trapezoid(against, self.angle))

    @property
    def loss_factor(self) -> float:
        """Dissipated energy over loading work: 0 for a spring or a gas, 1 where nothing returns."""
        return self.dissipated / self.loading_work if self.loading_work > 0 else 0.0

    def spring(self) -> tuple[float, float]:
        """Returns the torque at angle 0 [N·m] and the stiffness [N·m/rad] of the elastic part.

        Both describe the line of least squares through the middle of the two branches.
        """
        offset, stiffness = poly.polyfit(self.angle, (self.rising + self.falling) / 2, 1)
        return float(offset), float(stiffness)


def steady_cycle(
    model: HysteresisModel,
    angle_range: tuple[float, float],
    *,
    start_angle: float | None = None,
    start_torque: float = 0.0,
) -> SteadyCycle:
    """Follows a model through cycles between two angles until a cycle repeats the previous cycle.

    Two cycles are the same where their torques differ by less than 1e-6 of the torque's range.

    Args:
        model: Any hysteresis model.
        angle_range: Lowest and highest angle of the cycles [rad].
        start_angle: Angle at which the memory begins [rad]; by default the lowest angle.
        start_torque: Resistance at that angle [N·m].

    Raises:
        InputError: 128 cycles do not become steady.
        PoleError: The motion meets the pole of an uncertified model.
    """
    low, high = checked_range(angle_range)
    if not np.isfinite(high - low):
        raise InputError(f"angle_range is {angle_range}: give two finite angles (rad)")
    angle = np.linspace(low, high, SAMPLES)
    cycle = np.concatenate([angle, angle[::-1]])
    start = low if start_angle is None else start_angle
    count = FEWEST_CYCLES
    while True:
        path = np.append(start, np.tile(cycle, count))
        torque = model.response(path, start_torque)[1:].reshape(count, cycle.size)
        change = np.abs(np.diff(torque, axis=0)).max(axis=1)
        same = np.flatnonzero(change <= TOLERANCE * np.ptp(torque[1:], axis=1))
        if same.size:
            last = int(same[0]) + 1
            rising, falling = torque[last].reshape(2, SAMPLES)
            return SteadyCycle(angle=angle, rising=rising, falling=falling[::-1], cycles=last + 1)
        if count == MOST_CYCLES:
            raise InputError(
                f"the {model.name} model's torque still changes by "
                f"{change[-1] / np.ptp(torque[-1]):.2g} of its range from cycle to cycle after "
                f"{MOST_CYCLES} cycles from {low:.4g} to {high:.4g} rad, and {TOLERANCE:g} would "
                "be steady: give a wider range, or start from the virgin curve"
            )
        count *= 2
