"""The adapted wearer, who has repeated a motion until nothing is left to learn.

Learning ends where u = (forgetting · own + rate · torque) / (forgetting + rate), with the torque
that the motion takes under the policy. That torque is read from rollouts of an arm which stiff
hands lead along the intention. Two are enough: the second one starts from what the first one found.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ...arrays import Array
from ...assets import JOINTS
from ...errors import InputError
from ..making import make_arms
from ..person import VoluntaryControl
from ..person.control import FORGETTING, RATE
from ..policies import Policy
from .rollout import Trace, rollout

ROLLOUTS = 2
SMOOTHING = 2  # control periods, by which torque is smoothed: nobody learns faster changes
SHARE = RATE / (RATE + FORGETTING)  # share of a load that is learned in the end


class ArmLost(InputError):
    """A policy ends an episode although the arm is guided, so that no wearer can adapt."""


class Wearers:
    """Wearers of one kind of arm in three states: unadapted, guided by stiff hands, and adapted.

    Args:
        env_id: Id of a registered environment.
        rows: Number of motions.
        **options: Options of the environment.

    Attributes:
        arms: Rows of arms that take learned torques; policies are made for them.
    """

    def __init__(self, env_id: str, rows: int, **options: Any) -> None:
        control = options.pop("control", None)
        if isinstance(control, VoluntaryControl):
            control = asdict(control)
        elif not isinstance(control, Mapping | None):
            raise InputError(f"control is {control!r}: give a dict of its fields")
        usual = {**(control or {}), "adaptation": 0.0}
        calm = {**usual, "stiff": True, "noise": 0.0, "tremor": 0.0}
        self.arms = make_arms(env_id, rows, **options, control=usual, learned_torque=True)
        self._guided = make_arms(env_id, rows, **options, control=calm, learned_torque=True)

    def unadapted(self, policy: Policy, seeds: Sequence[int]) -> list[Trace]:
        """Returns the motions of wearers who foresee nothing but their own arm."""
        return rollout(self.arms, policy, seeds)

    def adapted(self, make: Callable[[], Policy], seeds: Sequence[int]) -> list[Trace]:
        """Returns the motions of wearers who have learned them under the policy.

        Args:
            make: Function that makes the policy anew, for each rollout: only the wearers learn the
                motions, the policy meets each for the first time.
            seeds: Seed of each motion.

        Raises:
            ArmLost: The policy ends episodes although the arm is guided.
        """
        torque = self.learned_torque(make, seeds)
        return rollout(self.arms, make(), seeds, learned_torque=torque)

    def learned_torque(
        self, make: Callable[[], Policy], seeds: Sequence[int], *, rollouts: int = ROLLOUTS
    ) -> Array:
        """Returns what wearers learn of the net load under a policy [N·m].

        Args:
            make: Function that makes the policy anew, for each rollout.
            seeds: Seed of each motion.
            rollouts: Number of guided rollouts.

        Returns:
            The torque beside that of the bare arm, shape (rows, samples, 4).

        Raises:
            ArmLost: The policy ends episodes although the arm is guided.
        """
        torque = np.zeros((len(seeds), self._guided.episodes.simulation.samples, len(JOINTS)))
        for _ in range(rollouts):
            torque = self.learned(self.guided(make(), seeds, torque))
        return torque

    def learned(self, traces: Sequence[Trace]) -> Array:
        """Returns what wearers learn of guided motions, as `learned_torque` does [N·m]."""
        own = self._guided.episodes.simulation.own_torque(np.arange(len(traces)))
        torque = smoothed([trace.human_torque for trace in traces], own.shape[1])
        return SHARE * (torque - own)

    def guided(self, policy: Policy, seeds: Sequence[int], torque: Array) -> list[Trace]:
        """Returns the motions of arms that stiff hands lead along the intention.

        Raises:
            ArmLost: The policy ends episodes although the arm is guided.
        """
        traces = rollout(self._guided, policy, seeds, learned_torque=torque)
        for seed, trace in zip(seeds, traces, strict=True):
            if trace.terminated:
                raise ArmLost(
                    f"the policy loses the arm after {trace.time[-1]:g} s (seed {seed}) even where "
                    "it is guided along the motion, so that no wearer can adapt: use "
                    "adapted=False, or mend the policy"
                )
        return traces

    def close(self) -> None:
        """Frees the arms."""
        self.arms.close()
        self._guided.close()


def smoothed(series: Sequence[Array], samples: int) -> Array:
    """Returns series of all control periods with a first sample before, smoothed over time.

    Where episodes are shorter than the intention, the last value stays.

    Args:
        series: Values of each motion, shape (periods, size).
        samples: Number of samples of the intention.
    """
    from scipy.ndimage import gaussian_filter1d  # slow to import

    found = [np.pad(one, ((1, samples - 1 - len(one)), (0, 0)), mode="edge") for one in series]
    return gaussian_filter1d(np.array(found), SMOOTHING, axis=1, mode="nearest")
