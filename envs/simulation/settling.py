"""How an episode begins: an arm at rest, held by feedback where its torque is not foreseen."""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

from numba import njit

from ...arrays import AnyArray
from .cycle import FEEDBACK, LEARNING
from .inverse_dynamics import arm_torque

MOST_CORRECTIONS = 30  # to settle an arm; four are usual
NUDGE = 1e-6  # rad, for derivatives
BALANCE = 1e-10  # N·m, at which an arm has settled
FRESH, MOVED, SETTLED = range(3)


@njit(cache=True)
def begin(
    rows: AnyArray,
    qpos: AnyArray,
    angle: AnyArray,
    rate: AnyArray,
    acceleration: AnyArray,
    resistance: AnyArray,
    links: AnyArray,
    gravity: AnyArray,
    scratch: AnyArray,
    own: AnyArray,
    joints: AnyArray,
    exo_joints: AnyArray,
    habits: AnyArray,
) -> None:
    """Puts some arms at their first intention, and computes the torque that wearers foresee."""
    for k in range(rows.shape[0]):
        row = rows[k]
        arm_torque(row, links, gravity, angle, rate, acceleration, 0, scratch, own)
        for j in range(4):
            qpos[row, joints[j]] = angle[row, 0, j]
            qpos[row, exo_joints[j]] = angle[row, 0, j]
            if resistance.shape[1] > 0:
                own[row, j] += habits[row, LEARNING] * resistance[row, 0, j]


@njit(cache=True)
def imbalance(
    rows: AnyArray,
    torque: AnyArray,
    qpos: AnyArray,
    qfrc_passive: AnyArray,
    qfrc_bias: AnyArray,
    angle: AnyArray,
    own: AnyArray,
    joints: AnyArray,
    stiffness: AnyArray,
    habits: AnyArray,
) -> None:
    """Computes the torque that is left on some arms at rest [N·m], shape (n, dofs)."""
    for k in range(rows.shape[0]):
        row = rows[k]
        for i in range(qpos.shape[1]):
            torque[row, i] = qfrc_passive[row, i] - qfrc_bias[row, i]
        for j in range(4):
            intrinsic = stiffness[row, j] * (angle[row, 0, j] - qpos[row, joints[j]])
            held = intrinsic + (own[row, j] + habits[row, FEEDBACK] * intrinsic)
            torque[row, joints[j]] += held


@njit(cache=True)
def correct(
    rows: AnyArray,
    torque: AnyArray,
    inverse: AnyArray,
    qpos: AnyArray,
    moves: AnyArray,
    status: AnyArray,
) -> int:
    """Moves arms that have not settled by the inverse slope; returns how many there are.

    The inverse slope improves by Broyden's update.

    Args:
        rows: The rows, shape (k,).
        torque: Torque that is left [N·m], shape (n, dofs).
        inverse: Inverse of its derivatives by the angles, shape (k, dofs, dofs).
        qpos: Angles, shape (n, dofs).
        moves: The last move of each arm and the torque before it, and room for the update, shape
            (k, 4, dofs).
        status: FRESH before the first move, MOVED after it, SETTLED at the end, shape (k,).
    """
    n, unsettled = qpos.shape[1], 0
    for k in range(rows.shape[0]):
        row = rows[k]
        if status[k] == SETTLED:
            continue
        largest = 0.0
        for i in range(n):
            largest = max(largest, abs(torque[row, i]))
        if not largest > BALANCE:
            status[k] = SETTLED
            continue
        unsettled += 1
        if status[k] == MOVED:
            _improve(k, row, torque, inverse, moves, n)
        for i in range(n):
            move = 0.0
            for j in range(n):
                move -= inverse[k, i, j] * torque[row, j]
            moves[k, 0, i] = move
            moves[k, 1, i] = torque[row, i]
            qpos[row, i] += move
        status[k] = MOVED
    return unsettled


@njit(cache=True)
def _improve(
    k: int, row: int, torque: AnyArray, inverse: AnyArray, moves: AnyArray, n: int
) -> None:
    """Broyden's good update: the inverse B then maps the last change y of torque to the move s.

    B += (s - B y) (s' B) / (s' B y), Broyden 1965, Math. Comp. 19(92).
    """
    denominator = 0.0
    for i in range(n):
        mapped = 0.0
        for j in range(n):
            mapped += inverse[k, i, j] * (torque[row, j] - moves[k, 1, j])
        moves[k, 2, i] = moves[k, 0, i] - mapped
        denominator += moves[k, 0, i] * mapped
    if denominator == 0.0:
        return
    for j in range(n):
        left = 0.0
        for i in range(n):
            left += moves[k, 0, i] * inverse[k, i, j]
        moves[k, 3, j] = left
    for i in range(n):
        for j in range(n):
            inverse[k, i, j] += moves[k, 2, i] * moves[k, 3, j] / denominator


@njit(cache=True)
def hold(
    rows: AnyArray,
    qpos: AnyArray,
    ctrl: AnyArray,
    past: AnyArray,
    angle: AnyArray,
    own: AnyArray,
    joints: AnyArray,
    intention: AnyArray,
    stiffness: AnyArray,
    habits: AnyArray,
) -> None:
    """Lets wearers hold still where their arms have settled, as they have done for a while."""
    for k in range(rows.shape[0]):
        row = rows[k]
        for j in range(4):
            intrinsic = stiffness[row, j] * (angle[row, 0, j] - qpos[row, joints[j]])
            for i in range(past.shape[1]):
                past[row, i, j] = intrinsic
            ctrl[row, intention[0, j]] = angle[row, 0, j]
            ctrl[row, intention[1, j]] = 0.0
            ctrl[row, intention[2, j]] = own[row, j] + habits[row, FEEDBACK] * intrinsic
