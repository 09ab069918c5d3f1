"""The wearer's control in one control period, for one row (see `envs.person.control`).

Scalars and arrays with the row as their first index, as in `cycle`.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import math

from numba import njit

from ...arrays import AnyArray
from ..person.strength_kernels import group_torque
from .inverse_dynamics import arm_torque

# Rows of `impedance`.
BASE, SLOPE, DAMPING, RELAXATION, EXTRA = range(5)
# Entries of `ringing`: coefficients that advance noise and tremor by one control period.
SLOW, RING, COSINE, SINE, SLOW_DRIVE, RING_DRIVE = range(6)
FEATURES = 10  # number of features of the motion that predict the net load
STILL = 0.05  # [rad/s], least rate of a motion with a direction


@njit(cache=True)
def vary(row: int, variation: AnyArray, fresh: AnyArray, place: int, ringing: AnyArray) -> None:
    """Advances the noise of muscles: first-order autoregression and a driven, damped rotation."""
    for j in range(4):
        slow, x, y = variation[row, 0, j], variation[row, 1, j], variation[row, 2, j]
        variation[row, 0, j] = ringing[SLOW] * slow + ringing[SLOW_DRIVE] * fresh[row, place, 0, j]
        turned = ringing[RING] * (ringing[COSINE] * x - ringing[SINE] * y)
        variation[row, 1, j] = turned + ringing[RING_DRIVE] * fresh[row, place, 1, j]
        turned = ringing[RING] * (ringing[SINE] * x + ringing[COSINE] * y)
        variation[row, 2, j] = turned + ringing[RING_DRIVE] * fresh[row, place, 2, j]


@njit(cache=True)
def most(
    row: int,
    way: int,
    joint: int,
    angle: float,
    speed: float,
    strength: AnyArray,
    fatigued: AnyArray,
    shape: AnyArray,
) -> float:
    """Returns the greatest torque of a muscle group, reduced by its fatigue [N·m]."""
    return group_torque(
        strength[row, way, joint] * (1.0 - fatigued[row, way, joint]),
        angle,
        speed,
        shape[0, way, joint],
        shape[1, way, joint],
        shape[2, way, joint],
        shape[3, way, joint],
        shape[4, way, joint],
        shape[5, way, joint],
    )


@njit(cache=True)
def describe(
    row: int,
    sample: int,
    angle: AnyArray,
    rate: AnyArray,
    acceleration: AnyArray,
    own: AnyArray,
    features: AnyArray,
) -> None:
    """Computes features of the intended motion at a sample, which the net load depends on.

    Sines and cosines represent weight, rates friction and hysteresis, accelerations inertia.
    `own` is the bare arm's torque at the sample; features are (rows, 4, FEATURES).
    """
    upper = angle[row, sample, 1]
    lower = upper + angle[row, sample, 2]
    for j in range(4):
        speed = rate[row, sample, j]
        features[row, j, 0] = own[row, j] / 10.0
        features[row, j, 1] = math.sin(upper)
        features[row, j, 2] = math.cos(upper)
        features[row, j, 3] = math.sin(lower)
        features[row, j, 4] = math.cos(lower)
        features[row, j, 5] = speed
        features[row, j, 6] = math.tanh(speed / STILL)
        features[row, j, 7] = 1.0
        features[row, j, 8] = acceleration[row, sample, 1] / 5.0
        features[row, j, 9] = acceleration[row, sample, 2] / 5.0


@njit(cache=True)
def foreseen(row: int, joint: int, gains: AnyArray, features: AnyArray) -> float:
    """Returns the learned torque, which is the net load that gains and features predict [N·m]."""
    torque = 0.0
    for k in range(gains.shape[2]):
        torque += gains[row, joint, k] * features[row, joint, k]
    return torque


@njit(cache=True)
def foresee(
    row: int,
    sample: int,
    angle: AnyArray,
    rate: AnyArray,
    acceleration: AnyArray,
    links: AnyArray,
    gravity: AnyArray,
    scratch: AnyArray,
    taught: AnyArray,
    gains: AnyArray,
    features: AnyArray,
    own: AnyArray,
) -> None:
    """Computes the wearer's feed-forward torque in `own`: that of the bare arm plus the learned."""
    arm_torque(row, links, gravity, angle, rate, acceleration, sample, scratch, own)
    if gains.shape[2] > 0:
        describe(row, sample, angle, rate, acceleration, own, features)
    for j in range(4):
        if taught.shape[1] > 0:
            own[row, j] += taught[row, sample, j]
        if gains.shape[2] > 0:
            own[row, j] += foreseen(row, j, gains, features)


@njit(cache=True)
def learn(
    row: int,
    sample: int,
    angle: AnyArray,
    rate: AnyArray,
    acceleration: AnyArray,
    links: AnyArray,
    gravity: AnyArray,
    scratch: AnyArray,
    gains: AnyArray,
    growing: AnyArray,
    features: AnyArray,
    own: AnyArray,
    answer: AnyArray,
    learning: float,
    forgetting: float,
) -> None:
    """Updates the learned gains by the torque that was needed now, at the features of `sample`.

    The rule is normalized least mean squares; it converges where learning and forgetting balance.
    It updates `growing`, which takes effect in the next episode; in this one reflex and correction
    already carry the load. `answer` is the torque that was needed beside the feed-forward torque.
    """
    arm_torque(row, links, gravity, angle, rate, acceleration, sample, scratch, own)
    describe(row, sample, angle, rate, acceleration, own, features)
    for j in range(4):
        size = 0.0
        for k in range(gains.shape[2]):
            size += features[row, j, k] * features[row, j, k]
        load = answer[row, j] + foreseen(row, j, gains, features)
        missing = load - (1.0 + forgetting) * foreseen(row, j, growing, features)
        step = learning * missing / size
        for k in range(gains.shape[2]):
            growing[row, j, k] += step * features[row, j, k]


@njit(cache=True)
def act(
    row: int,
    qpos: AnyArray,
    qvel: AnyArray,
    ctrl: AnyArray,
    bias: AnyArray,
    step: AnyArray,
    angle: AnyArray,
    rate: AnyArray,
    past: AnyArray,
    seen: AnyArray,
    fed: AnyArray,
    held: AnyArray,
    answer: AnyArray,
    variation: AnyArray,
    fresh: AnyArray,
    fatigued: AnyArray,
    own: AnyArray,
    joints: AnyArray,
    human: AnyArray,
    intention: AnyArray,
    impedance: AnyArray,
    strength: AnyArray,
    shape: AnyArray,
    spread: AnyArray,
    ringing: AnyArray,
    reflex: float,
    lead: float,
    lag: float,
    correction: float,
    noise: float,
    tremor: float,
) -> None:
    """Sets intention, impedance and added torque of the wearer's actuators for the coming period.

    `own` is the feed-forward torque; `fed` and `held` are the torques of reflex and correction.
    """
    last = angle.shape[1] - 1
    ahead = step[row] + 1
    i = int(min(ahead, last))
    if fresh.shape[1] > 0:
        vary(row, variation, fresh, step[row] % fresh.shape[1], ringing)
    for j in range(4):
        q, v = qpos[row, joints[j]], qvel[row, joints[j]]
        target = angle[row, i, j]
        target_rate = rate[row, i, j] if i == ahead else 0.0
        error, slip = target - q, target_rate - v
        low = -most(row, 0, j, q, -v, strength, fatigued, shape)
        high = most(row, 1, j, q, v, strength, fatigued, shape)
        muscle = max(low, min(own[row, j] + fed[row, j] + held[row, j], high))
        stiffness = impedance[row, BASE, j] + impedance[row, SLOPE, j] * abs(muscle)
        damping = impedance[row, DAMPING, j] + impedance[row, RELAXATION, j] * stiffness
        intrinsic = stiffness * error + damping * slip
        total = max(low, min(muscle + intrinsic, high))
        answer[row, j] = total - own[row, j]
        if fresh.shape[1] > 0:
            varied = noise * spread[j] * variation[row, 0, j] + tremor * variation[row, 1, j]
            total = max(low, min(total * (1.0 + varied), high))
        ctrl[row, intention[0, j]] = target
        ctrl[row, intention[1, j]] = target_rate
        ctrl[row, intention[2, j]] = total - intrinsic
        bias[row, human[j], 1] = -stiffness
        bias[row, human[j], 2] = -damping
        sensed, place = stiffness * (error + lead * slip), 0
        if past.shape[1] > 0:
            place = step[row] % past.shape[1]
            sensed, past[row, place, j] = past[row, place, j], sensed
        fed[row, j] += lag * (reflex * sensed - fed[row, j])
        place = step[row] % seen.shape[1]
        held[row, j] = max(low, min(held[row, j] + correction * seen[row, place, j], high))
        seen[row, place, j] = stiffness * error
