"""The reward of a control period: costs of effort, tracking error and unsteady assist."""

# pyright: reportCallIssue=false

from numba import njit

from ..arrays import AnyArray
from .simulation.measurements import ANGLE, HUMAN, TARGET

TERMS = ("effort", "tracking", "smoothness")
EFFORT_SCALE = (20.0, 10.0)  # N·m at shoulder and elbow that cost 1
ERROR_SCALE = 0.1  # rad that cost 1
SMOOTHNESS = 0.1
LOST = 1.0  # rad of tracking error at which an episode ends


@njit(cache=True)
def judge(
    rows: AnyArray,
    measured: AnyArray,
    change: AnyArray,
    diverged: AnyArray,
    step: AnyArray,
    limit: AnyArray,
    plugin_state: AnyArray,
    faults: AnyArray,
    assisted: AnyArray,
    terms: AnyArray,
    reward: AnyArray,
    terminated: AnyArray,
    truncated: AnyArray,
) -> None:
    """Rewards the last control period of some rows, and says which episodes have ended.

    The terms are minus the squares of the wearer's torque at the assisted joints, of their tracking
    error and of the change of the command; the reward is their sum. The wearer's torque and the
    motors' command are limited, and an error counts `LOST` at most, as it does where the physics
    has diverged: no reward of the default wearer is below -271.

    An episode terminates when the arm is lost, in a suit whose torque met its pole, or diverged.
    """
    for k in range(rows.shape[0]):
        row = rows[k]
        effort, tracking, unsteady, worst = 0.0, 0.0, 0.0, 0.0
        for j in range(assisted.shape[0]):
            joint = assisted[j]
            scaled = measured[row, HUMAN + joint] / EFFORT_SCALE[j]
            effort += scaled * scaled
            error = abs(measured[row, ANGLE + joint] - measured[row, TARGET + joint])
            if diverged[row]:
                error = LOST
            worst = max(worst, error)
            scaled = min(error, LOST) / ERROR_SCALE
            tracking += scaled * scaled
        for j in range(change.shape[1]):
            unsteady += change[row, j] * change[row, j]
        terms[row, 0] = -effort
        terms[row, 1] = -tracking
        terms[row, 2] = -SMOOTHNESS * unsteady
        reward[row] = terms[row, 0] + terms[row, 1] + terms[row, 2]
        ended = worst > LOST or diverged[row]
        for j in range(faults.shape[0]):
            ended = ended or plugin_state[row, faults[j]] == 1.0
        terminated[row] = ended
        truncated[row] = step[row] >= limit[row]
