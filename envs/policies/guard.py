"""The passivity guard: a wrapper that limits the energy which any policy gives to the arm."""

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ..belief import Belief
from ..plant import Plant
from .base import Policy, Seen, TorquePolicy
from .model_based import Compensation

RESERVE = 1.0  # [J], energy that motors may give beyond the belief: 1 kg lifted by 10 cm
STILLEST = 1e-6  # [rad²/s²], greatest squared rate at which work is neglected


class Guard(TorquePolicy):
    """Lets a policy give the arm no more energy than its believed suit, weight and friction take.

    Law: the ledger of an arm grows by the work of the believed compensation and falls by the work
    of the motors, both over shoulder and elbow. The ledger is never above the reserve, so that help
    not given is no credit. A torque that would bring the ledger below 0 is reduced by the least
    sufficient damping, as in the passivity controllers of Hannaford and Ryu (2002). So in any time
    the motors give at most the reserve more than the belief stores and dissipates.

    Attributes:
        acted: Number of control periods since the reset with a reduced torque, shape (n,).
    """

    def __init__(self, plant: Plant, policy: Policy, belief: Belief | None = None) -> None:
        super().__init__(plant)
        self._policy = policy
        self._needed = Compensation(plant, belief)
        self._needed.lead = 0.0  # the ledger needs the work of this period

    def reset(self) -> None:
        """Clears the memory of guard and policy."""
        super().reset()
        self._policy.reset()
        self._needed.reset()

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the policy's action, as far as the ledger allows it."""
        self._wanted = np.asarray(self._policy.act(observation), np.float64).reshape(-1, 2)
        return super().act(observation)

    def begin(self, seen: Seen) -> None:
        """Begins with a full reserve."""
        self._needed.begin(seen)
        rows = len(seen["angle"])
        self._ledger, self.acted = np.full(rows, RESERVE), np.zeros(rows, np.int64)

    def torque(self, seen: Seen) -> Array:
        """Returns the guarded torque [N·m], shape (n, 2)."""
        rate = seen["rate"][:, self.assisted]
        given, wanted = seen["motor_torque"] * self.peak, self._wanted * self.peak
        needed = self._needed.torque(seen)
        self._ledger = updated_ledger(self._ledger, needed, given, rate, self.dt)
        found, lessened = lessen(wanted, needed, rate, self._ledger, self.dt)
        self.acted += lessened
        return found


def updated_ledger(ledger: Array, needed: Array, given: Array, rate: Array, dt: float) -> Array:
    """Returns ledgers [J], (n,), after a control period of needed and given torques, (n, 2)."""
    return np.minimum(ledger + ((needed - given) * rate).sum(axis=1) * dt, RESERVE)


def lessen(
    wanted: Array, needed: Array, rate: Array, ledger: Array, dt: float
) -> tuple[Array, NDArray[np.bool_]]:
    """Returns torques that leave no ledger below 0 [N·m], (n, 2), and which rows were reduced.

    The policy wants, and the belief needs, a torque [N·m], (n, 2); ledgers [J] are (n,).
    """
    over = ((wanted - needed) * rate).sum(axis=1) * dt - ledger
    turning, power = (rate**2).sum(axis=1), (wanted * rate).sum(axis=1)
    lessened = (over > 0) & (turning > STILLEST) & (power > 0)
    damping = np.where(lessened, over / np.where(lessened, turning * dt, 1.0), 0.0)
    # Damping beyond a torque without work would brake the wearer.
    most = np.where(lessened, power / np.where(lessened, turning, 1.0), 0.0)
    return wanted - np.minimum(damping, most)[:, None] * rate, lessened
