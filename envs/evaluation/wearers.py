"""The adapted wearer, who has repeated a motion until learning has converged.

Learning converges to u = (forgetting · own + rate · torque) / (forgetting + rate), with the torque
that the motion takes under the policy. This torque is measured in rollouts of an arm which stiff
hands guide along the intention. Two rollouts are enough: the second starts from the first's result.
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
from ..person.control import FORGETTING, HARDEST, RATE, RELAXING, STIFFENING
from ..policies import Policy
from ..simulation.wearer_control import BASE, SLOPE
from .rollout import Trace, rollout
from .scores import root_mean_square

ROLLOUTS = 2
UNSURE = 0.25  # [s], time by which an error may come earlier or later in the next motion
STIFFENINGS = 2  # greatest number of rollouts from which co-contraction is learned
CHANGE = 0.01  # [share of strength], least root mean square change of co-contraction
TORQUE, CONTRACTION = "learned_torque", "learned_contraction"
SMOOTHING = 2  # [control periods], width of smoothing: a person learns no faster changes
SHARE = RATE / (RATE + FORGETTING)  # share of a load in converged learning


class ArmLost(InputError):
    """Error: a policy ends an episode although the arm is guided, so that no wearer can adapt."""


class Wearers:
    """Wearers of one kind of arm in three states: unadapted, guided by stiff hands, and adapted.

    Attributes:
        arms: Rows of arms that take learned torques; policies are made for these arms.
        unlearning: Options of `arms` with which wearers learn nothing in an episode.
    """

    def __init__(self, env_id: str, rows: int, **options: Any) -> None:
        control = options.pop("control", None)
        if isinstance(control, VoluntaryControl):
            control = asdict(control)
        elif not isinstance(control, Mapping | None):
            raise InputError(f"control is {control!r}: give a dict of its fields")
        usual = {**(control or {}), "adaptation": 0.0}
        calm = {**usual, "stiff": True, "noise": 0.0, "tremor": 0.0}
        self.unlearning: dict[str, Any] = {"control": usual, "learned_torque": True}
        self.arms = make_arms(env_id, rows, **options, **self.unlearning)
        self._guided = make_arms(env_id, rows, **options, control=calm, learned_torque=True)

    def unadapted(self, policy: Policy, seeds: Sequence[int]) -> list[Trace]:
        """Returns the motions of wearers who have learned only the torques of their own arm."""
        return rollout(self.arms, policy, seeds)

    def adapted(self, make: Callable[[], Policy], seeds: Sequence[int]) -> list[Trace]:
        """Returns motions of wearers who have learned these under the policy; raises `ArmLost`.

        `make` makes a policy for each rollout, which knows no other: only the wearers learn.
        """
        return self.learn(make, seeds)[1]

    def learn(
        self, make: Callable[[], Policy], seeds: Sequence[int]
    ) -> tuple[dict[str, Array], list[Trace]]:
        """Returns the learned torques of adapted wearers, for `rollout`, and their motions."""
        learned = {TORQUE: self.learned_torque(make, seeds)}
        contraction = np.zeros_like(learned[TORQUE])
        traces = rollout(self.arms, make(), seeds, learned=learned)
        strength = self.arms.episodes.simulation.state.muscles.strength.min(axis=1)[:, None]
        for _ in range(STIFFENINGS):
            before, contraction = contraction, self.contraction(traces, contraction)
            if root_mean_square((contraction - before) / strength) < CHANGE:
                break
            learned[CONTRACTION] = contraction
            traces = rollout(self.arms, make(), seeds, learned=learned)
        return learned, traces

    def learned_torque(
        self, make: Callable[[], Policy], seeds: Sequence[int], *, rollouts: int = ROLLOUTS
    ) -> Array:
        """Returns the torque that wearers learn in guided rollouts under a policy [N·m].

        The torque is that beyond the bare arm's torque, shape (rows, samples, 4).
        """
        torque = np.zeros((len(seeds), self._guided.episodes.simulation.samples, len(JOINTS)))
        for _ in range(rollouts):
            traces = self.guided(make(), seeds, torque)
            own = self._guided.episodes.simulation.own_torque(np.arange(len(traces)))
            given = smoothed([trace.human_torque for trace in traces], own.shape[1])
            torque = SHARE * (given - own)
        return torque

    def guided(self, policy: Policy, seeds: Sequence[int], torque: Array) -> list[Trace]:
        """Returns the motions of arms that stiff hands guide; raises `ArmLost`."""
        traces = rollout(self._guided, policy, seeds, learned={TORQUE: torque})
        for seed, trace in zip(seeds, traces, strict=True):
            if trace.terminated:
                raise ArmLost(
                    f"the policy loses the arm after {trace.time[-1]:g} s (seed {seed}) although "
                    "the arm is guided along the motion, so that no wearer can adapt: use "
                    "adapted=False, or repair the policy"
                )
        return traces

    def contraction(self, traces: Sequence[Trace], before: Array) -> Array:
        """Returns the co-contraction at which stiffening and relaxing balance [N·m].

        Co-contractions, beyond the usual one, have the shape (rows, samples, 4); `before` are those
        of the motions. The largest error within a quarter of a second counts, since a wearer cannot
        foresee the time of an error. The error is assumed to be in inverse proportion to stiffness
        at rest. With gain = strength · stiffening / relaxing the balance c = gain · max(0, |e| K /
        (K0 + K1 c) - tolerated) is then a quadratic equation, with the stiffness K of the motions
        and the usual stiffness K0.
        """
        from scipy.ndimage import maximum_filter1d, minimum_filter1d  # slow to import

        episodes, simulation = self.arms.episodes, self.arms.episodes.simulation
        samples, muscles = simulation.samples, simulation.state.muscles
        if simulation.control.stiff:
            return np.zeros((len(traces), samples, len(JOINTS)))
        near = round(2 * UNSURE / simulation.control_dt)
        error = smoothed([np.abs(trace.angle - trace.target_angle) for trace in traces], samples)
        error = maximum_filter1d(error, near, axis=1)
        tolerated = minimum_filter1d(episodes.tolerated(), near, axis=1)
        usual, slope = muscles.impedance[:, None, BASE], muscles.impedance[:, None, SLOPE]
        stiffness = usual + slope * before
        strength = muscles.strength.min(axis=1)[:, None]
        gain = strength * STIFFENING / RELAXING
        half = (slope * gain * tolerated - usual) / 2
        found = np.sqrt(half**2 + slope * gain * error * stiffness) - half
        return np.clip((found - usual) / slope, 0.0, HARDEST * strength)

    def close(self) -> None:
        """Frees the arms."""
        self.arms.close()
        self._guided.close()


def smoothed(series: Sequence[Array], samples: int) -> Array:
    """Returns smoothed series of all control periods, shape (periods, size) each.

    The series get one more sample at the beginning, and the last value of a shorter episode is
    repeated, up to the number of samples of the intention.
    """
    from scipy.ndimage import gaussian_filter1d  # slow to import

    found = [padded(one, samples) for one in series]
    return gaussian_filter1d(np.array(found), SMOOTHING, axis=1, mode="nearest")


def padded(series: Array, samples: int) -> Array:
    """Returns a series with one more sample at its beginning, and its last value to the end.

    The series has the shape (periods, ...), the result (samples, ...).
    """
    ends = (1, samples - 1 - len(series)), *[(0, 0)] * (series.ndim - 1)
    return np.pad(series, ends, mode="edge")
