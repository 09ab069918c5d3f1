"""The start of an episode: an arm at rest, with the wearer's torque that keeps it there."""

import numpy as np
from numba import njit

from ...arrays import AnyArray, Array
from ...kernels import inner
from .structs import Arms, Whole
from .wearer_control import BASE, RELAXATION, SLOPE, contraction, feed_forward
from .wearer_control import DAMPING as FIXED

MOST_CORRECTIONS = 30  # greatest number of steps of an exoskeleton on cuffs; four are usual
MOST_SLOPES = 4  # greatest number of slopes, where these steps do not converge
FARTHEST = 0.1  # [rad], longest step: far from equilibrium the slope is wrong
NUDGE = 1e-6  # [rad], step of finite differences
BALANCE = 1e-10  # [N·m], greatest net torque on an exoskeleton in equilibrium
FRESH, MOVED, DONE = range(3)


@njit(cache=True)
def begin(rows: Whole, arms: Arms) -> None:
    """Puts some arms at their first intention, and computes the feed-forward torque."""
    physics, at, intention = arms.physics, arms.at, arms.intention
    for k in range(rows.shape[0]):
        row = rows[k]
        feed_forward(row, np.int64(0), intention, arms.wearer)
        for j in range(4):
            physics.qpos[row, at.joints[j]] = intention.motion.angle[row, 0, j]
            physics.qpos[row, at.exo_joints[j]] = intention.motion.angle[row, 0, j]


@njit(cache=True)
def correct(
    rows: AnyArray,
    torque: AnyArray,
    inverse: AnyArray,
    qpos: AnyArray,
    dofs: AnyArray,
    moves: AnyArray,
    status: AnyArray,
) -> int:
    """Moves exoskeletons that are not in equilibrium by a step; returns their number.

    The step is quasi-Newton: Broyden's update improves the inverse slope, shape (k, d, d), of the
    net torque, shape (n, all dofs), with respect to the angles `dofs` of the exoskeleton alone.
    `moves` has the last step of each row, the torque before it, and two scratch vectors of the
    update, shape (k, 4, d). `status` is FRESH before the first step, MOVED after it, and `DONE` at
    the end.
    """
    n, unbalanced = dofs.shape[0], 0
    for k in range(rows.shape[0]):
        row = rows[k]
        if status[k] == DONE:
            continue
        largest = 0.0
        for i in range(n):
            largest = max(largest, abs(torque[row, dofs[i]]))
        if not largest > BALANCE:
            status[k] = DONE
            continue
        unbalanced += 1
        if status[k] == MOVED:
            _improve(k, row, torque, inverse, dofs, moves)
        farthest = 0.0
        for i in range(n):
            move = 0.0
            for j in range(n):
                move -= inverse[k, i, j] * torque[row, dofs[j]]
            moves[k, 0, i] = move
            moves[k, 1, i] = torque[row, dofs[i]]
            farthest = max(farthest, abs(move))
        share = FARTHEST / max(farthest, FARTHEST)
        for i in range(n):
            moves[k, 0, i] *= share
            qpos[row, dofs[i]] += moves[k, 0, i]
        status[k] = MOVED
    return unbalanced


@inner(forceinline=True)
def _improve(
    k: int, row: int, torque: AnyArray, inverse: AnyArray, dofs: AnyArray, moves: AnyArray
) -> None:
    """Broyden's good update: the inverse B then maps the last change y of torque to the move s.

    B += (s - B y) (s' B) / (s' B y), Broyden 1965, Math. Comp. 19(92).
    """
    n, denominator = dofs.shape[0], 0.0
    for i in range(n):
        mapped = 0.0
        for j in range(n):
            mapped += inverse[k, i, j] * (torque[row, dofs[j]] - moves[k, 1, j])
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
def hold(rows: Whole, rest: Array, arms: Arms) -> None:
    """Lets wearers hold still: the correction starts at the torque that feed-forward lacks.

    `rest` is the net torque on arms at rest, without the wearer's [N·m], shape (n, dofs).
    """
    physics, at, intention, feedback = arms.physics, arms.at, arms.intention, arms.wearer.feedback
    ctrl, impedance = physics.ctrl, arms.muscles.impedance
    for k in range(rows.shape[0]):
        row = rows[k]
        for j in range(4):
            needed = -rest[row, at.joints[j]]
            feedback.correction[row, j] = needed - arms.wearer.arm.torque[row, j]
            feedback.correction_goals[row, :, j] = feedback.correction[row, j]
            tension = abs(needed) + contraction(row, np.int64(0), j, arms)
            stiffness = impedance[row, BASE, j] + impedance[row, SLOPE, j] * tension
            damping = impedance[row, FIXED, j] + impedance[row, RELAXATION, j] * stiffness
            physics.biasprm[row, at.human[j], 1] = -stiffness
            physics.biasprm[row, at.human[j], 2] = -damping
            ctrl[row, at.intention[0, j]] = intention.motion.angle[row, 0, j]
            ctrl[row, at.intention[1, j]] = 0.0
            ctrl[row, at.intention[2, j]] = needed
