"""Predictive sampling: the motors' torque with the least effort of a believed wearer."""

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from ...arrays import Array
from ...assets import JOINTS
from ...checks import check_seed, within
from ..belief import Belief
from ..person import isometric_strength
from ..person.control import STIFF
from ..plant import Plant
from ..simulation.structs import Addresses
from .base import Seen
from .model_based import Compensation
from .observers import LowPass

PERIOD = 0.05  # [s], time from plan to plan
KNOTS = 3  # number of knots of a plan over its horizon
QUICKNESS = 3.0  # [Hz], bandwidth of estimated accelerations
SHRINKING = 0.8  # factor of the last plan, which is of an earlier state
ELITE = 4  # the best quarter of the plans is averaged, which is less random than the best plan
SMOOTHNESS = 1.0  # cost of a correction as large as the motor's peak, over that of full effort
FEWEST, MOST = 4, 64  # samples
COARSENESS = 2.5  # steps of a believed arm over those of the simulated one


class PredictiveSampling(Compensation):
    """Compensates, and adds the best of sampled corrections on the believed arm.

    Law: twenty times a second, plans of corrections (the last plan, shrunk, and random plans around
    the last one, with three knots over the horizon) are simulated on a batch of believed arms, in
    steps two and a half times as long, whose wearers continue the present motion. The policy
    follows the mean of the quarter of plans with the least torque over strength of the wearer
    (predictive sampling, Howell et al. 2022, arXiv 2212.00541). Encoders and motors give the state;
    the suit's memory is that of a simulated arm which follows the encoders.
    Tuning: spread of the samples and horizon, several times the motors' lag.

    With the true suit as belief the policy is a bound for its kind, and no controller.

    Args:
        samples: Number of plans, 4 to 64.
        horizon: Time that a plan covers [s], 0.02 to 0.5.
        spread: Standard deviation of the knots over the motors' peaks, 0 to 0.5.
        seed: Seed of the samples.
    """

    def __init__(
        self,
        plant: Plant,
        belief: Belief | None = None,
        *,
        samples: int = 8,
        horizon: float = 0.1,
        spread: float = 0.01,
        seed: int = 0,
    ) -> None:
        super().__init__(plant, belief)
        within("samples", samples, FEWEST, MOST)
        within("horizon", horizon, 0.02, 0.5, " s")
        within("spread", spread, 0, 0.5)
        check_seed(seed)
        arm = plant.believed(belief)
        self._model, self._samples, self._seed = arm.model(), samples, seed
        self._model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_SENSOR  # plans measure nothing
        self._at = Addresses.of(self._model)
        self._ahead, self._every = round(horizon / self.dt), max(1, round(PERIOD / self.dt))
        self._substeps = max(1, round(self.dt / (COARSENESS * self._model.opt.timestep)))
        self._model.opt.timestep = self.dt / self._substeps
        self._strength = isometric_strength(arm.config.wearer).mean(axis=0)
        self._spread, self._slow = spread * self.peak, LowPass(QUICKNESS, self.dt)
        # Share of each knot of a correction in every period of the horizon.
        place = np.linspace(0, KNOTS - 1, self._ahead)
        self._blend = np.clip(1 - np.abs(place[:, None] - np.arange(KNOTS)), 0, 1)

    def begin(self, seen: Seen) -> None:
        """Begins with believed arms at the measured angles, and plans of zero correction."""
        super().begin(seen)
        rows = len(seen["angle"])
        batch = self._batch = Batch(self._model, rows * (1 + self._samples), nthread=1)
        batch.reset()
        names = ("qpos", "qvel", "act", "ctrl", "actuator_force")
        self._physics = {name: batch.bind(name) for name in names}
        bias = batch.expand("actuator_biasprm")
        bias[:, self._at.human, 1], bias[:, self._at.human, 2] = -STIFF[0], -STIFF[1]
        self._rng = np.random.default_rng(self._seed)  # a row is equal to a single arm
        self._knots = np.zeros((rows, KNOTS, len(self.peak)))
        self._planned = 0
        self._turned = seen["rate"]
        self._slow.begin(np.zeros_like(seen["rate"]))
        self._given = np.zeros((rows, len(self.peak)))

    def torque(self, seen: Seen) -> Array:
        """Returns compensation plus the plan's correction [N·m], shape (n, 2)."""
        nominal = super().torque(seen)
        self._speeding = self._slow.step((seen["rate"] - self._turned) / self.dt)
        self._turned = seen["rate"]
        self._follow(seen)
        if self._planned % self._every == 0:
            self._plan(seen, nominal)
        place = min(self._planned % self._every, self._ahead - 1)
        self._planned += 1
        correction = np.einsum("k,nkm->nm", self._blend[place], self._knots)
        self._given = np.clip(nominal + correction, -self.peak, self.peak)
        return nominal + correction

    def _follow(self, seen: Seen) -> None:
        """Moves the believed arms along the measured motion, which their suits remember."""
        rows, at = np.arange(len(seen["angle"])), self._at
        if self._planned:
            self._intend(rows, seen["angle"], np.zeros_like(seen["angle"]))
            self._physics["ctrl"][rows[:, None], at.motors] = self._given
            self._batch.step(ids=rows, nstep=self._substeps)
        for joints in (at.joints, at.exo_joints):
            self._physics["qpos"][rows[:, None], joints] = seen["angle"]
            self._physics["qvel"][rows[:, None], joints] = seen["rate"]
        self._physics["act"][rows] = seen["motor_torque"] * self.peak

    def _plan(self, seen: Seen, nominal: Array) -> None:
        """Simulates plans on the believed arms, and keeps the mean of the best for each arm."""
        rows, count, batch = len(nominal), self._samples, self._batch
        trial = np.arange(rows, rows * (1 + count))
        source = np.repeat(np.arange(rows), count)
        batch.state[trial] = batch.state[source]
        away = self._rng.standard_normal((count, KNOTS, len(self.peak)))
        knots = self._knots[:, None] + away * self._spread
        knots[:, 0] = SHRINKING * self._knots
        plans = np.einsum("hk,nckm->hncm", self._blend, knots).reshape(self._ahead, -1, 2)
        cost = SMOOTHNESS * np.mean((knots / self.peak) ** 2, axis=(2, 3)).ravel()
        angle, rate = seen["angle"][source], seen["rate"][source]
        speeding = self._speeding[source]
        needed = self._needed(seen, nominal)
        for i in range(self._ahead):
            later = (i + 1) * self.dt
            turning = rate + later * speeding
            self._intend(trial, angle + later * (rate + turning) / 2, turning)
            command = needed[i][source] + plans[i]
            self._physics["ctrl"][trial[:, None], self._at.motors] = np.clip(
                command, -self.peak, self.peak
            )
            batch.step(ids=trial, nstep=self._substeps)
            human = self._physics["actuator_force"][trial[:, None], self._at.human]
            cost += np.mean((human / self._strength) ** 2, axis=1) / self._ahead
        cost = np.where(np.isfinite(cost), cost, np.inf).reshape(rows, count)
        best = np.argsort(cost, axis=1, kind="stable")[:, : max(1, count // ELITE)]
        self._knots = np.take_along_axis(knots, best[:, :, None, None], axis=1).mean(axis=1)

    def _needed(self, seen: Seen, nominal: Array) -> Array:
        """Returns compensation along the motion at the present rate [N·m], (horizon, n, 2)."""
        memory, found = self._memory, [nominal]
        self._memory = memory.copy()
        for i in range(1, self._ahead):
            there = seen["angle"] + i * self.dt * seen["rate"]
            found.append(super().torque({**seen, "angle": there}))
        self._memory = memory
        return np.array(found)

    def _intend(self, rows: NDArray[np.int64], angle: Array, rate: Array) -> None:
        """Sets the intended angles [rad] and rates of some believed wearers, shape (k, 4) each."""
        place, ctrl = self._at.intention, self._physics["ctrl"]
        ctrl[rows[:, None], place[0]], ctrl[rows[:, None], place[1]] = angle, rate
        ctrl[rows[:, None], place[2]] = np.zeros((1, len(JOINTS)))
