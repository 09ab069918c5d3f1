"""The control cycle: what happens to each row before and after the physics of a control period.

The functions of one row are written so that other compilers than numba read them too: scalars and
arrays with the row as their first index, no objects, nothing allocated.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import math

from numba import njit

from ...arrays import AnyArray
from ..model.motor_kernels import clipped as within_heat
from ..model.motor_kernels import heated
from ..person.control_kernels import pulled
from ..person.fatigue_kernels import loaded, tired
from ..person.strength_kernels import group_torque
from .inverse_dynamics import arm_torque
from .measurements import TIME, is_finite, measure

# Columns of `habits`, the wearer's settings.
LEARNING, FEEDBACK, NOISE, TREMOR = range(4)
# Places in `ringing`: how noise and tremor go on from one control period to the next.
SLOW, RING, COSINE, SINE, SLOW_DRIVE, RING_DRIVE = range(6)


@njit(cache=True)
def drive(
    row: int,
    command: AnyArray,
    mean_square: AnyArray,
    ctrl: AnyArray,
    motors: AnyArray,
    peak: AnyArray,
    continuous: AnyArray,
    time_constant: AnyArray,
    dt: float,
) -> None:
    """Sets motor torques from normalized commands, clipped by the thermal limit."""
    for j in range(motors.shape[0]):
        ctrl[row, motors[j]] = within_heat(
            command[row, j] * peak[j], mean_square[row, j], continuous[j], time_constant[j], dt
        )


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
def act(
    row: int,
    qpos: AnyArray,
    qvel: AnyArray,
    ctrl: AnyArray,
    step: AnyArray,
    angle: AnyArray,
    rate: AnyArray,
    resistance: AnyArray,
    past: AnyArray,
    variation: AnyArray,
    fresh: AnyArray,
    fatigued: AnyArray,
    own: AnyArray,
    joints: AnyArray,
    intention: AnyArray,
    stiffness: AnyArray,
    damping: AnyArray,
    strength: AnyArray,
    shape: AnyArray,
    habits: AnyArray,
    spread: AnyArray,
    ringing: AnyArray,
) -> None:
    """Gives the engine's actuators the intention of the coming period, and the added torque."""
    last, delay = angle.shape[1] - 1, past.shape[1]
    ahead = step[row] + 1
    i = min(ahead, last)
    if fresh.shape[1] > 0:
        vary(row, variation, fresh, step[row] % fresh.shape[1], ringing)
    for j in range(4):
        q, v = qpos[row, joints[j]], qvel[row, joints[j]]
        target = angle[row, i, j]
        target_rate = rate[row, i, j] if i == ahead else 0.0
        intrinsic = stiffness[row, j] * (target - q) + damping[row, j] * (target_rate - v)
        old = intrinsic
        if delay > 0:
            old = past[row, step[row] % delay, j]
            past[row, step[row] % delay, j] = intrinsic
        foreseen = own[row, j]
        if resistance.shape[1] > 0:
            foreseen += habits[row, LEARNING] * resistance[row, i, j]
        low = -most(row, 0, j, q, -v, strength, fatigued, shape)
        high = most(row, 1, j, q, v, strength, fatigued, shape)
        total = pulled(intrinsic, foreseen, habits[row, FEEDBACK], old, low, high)
        if fresh.shape[1] > 0:
            varied = habits[row, NOISE] * spread[j] * variation[row, 0, j]
            varied += habits[row, TREMOR] * variation[row, 1, j]
            total = max(low, min(total * (1.0 + varied), high))
        ctrl[row, intention[0, j]] = target
        ctrl[row, intention[1, j]] = target_rate
        ctrl[row, intention[2, j]] = total - intrinsic


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
    """Returns the greatest torque that fatigue has left to a muscle group [N·m]."""
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
def tire(
    row: int,
    qpos: AnyArray,
    qvel: AnyArray,
    actuator_force: AnyArray,
    fatigued: AnyArray,
    rested: AnyArray,
    joints: AnyArray,
    human: AnyArray,
    strength: AnyArray,
    shape: AnyArray,
    tiring: AnyArray,
    recovery: AnyArray,
    multiplier: AnyArray,
    resting: AnyArray,
    dt: float,
) -> None:
    """Updates fatigue by the torque of the control period that has passed."""
    for j in range(4):
        torque = actuator_force[row, human[j]]
        for way in range(2):
            sign = 1.0 if way == 1 else -1.0
            speed = sign * qvel[row, joints[j]]
            available = most(row, way, j, qpos[row, joints[j]], speed, strength, rested, shape)
            fatigued[row, way, j] = tired(
                fatigued[row, way, j],
                loaded(sign * torque, available),
                tiring[j],
                recovery[j],
                multiplier[j],
                resting[j],
                dt,
            )


@njit(cache=True, nogil=True)
def before(
    rows: AnyArray,
    action: AnyArray,
    command: AnyArray,
    change: AnyArray,
    clipped: AnyArray,
    diverged: AnyArray,
    mean_square: AnyArray,
    qpos: AnyArray,
    qvel: AnyArray,
    ctrl: AnyArray,
    step: AnyArray,
    angle: AnyArray,
    rate: AnyArray,
    acceleration: AnyArray,
    resistance: AnyArray,
    past: AnyArray,
    variation: AnyArray,
    fresh: AnyArray,
    fatigued: AnyArray,
    links: AnyArray,
    gravity: AnyArray,
    scratch: AnyArray,
    own: AnyArray,
    joints: AnyArray,
    motors: AnyArray,
    intention: AnyArray,
    stiffness: AnyArray,
    damping: AnyArray,
    strength: AnyArray,
    shape: AnyArray,
    habits: AnyArray,
    spread: AnyArray,
    ringing: AnyArray,
    peak: AnyArray,
    continuous: AnyArray,
    time_constant: AnyArray,
    dt: float,
) -> int:
    """Takes the actions of some rows, and lets motors and wearers act on them.

    Returns:
        The first row whose action is not of finite numbers, and then nothing has changed; -1 if
        there is none.
    """
    for k in range(rows.shape[0]):
        for j in range(action.shape[1]):
            if not math.isfinite(action[rows[k], j]):
                return rows[k]
    for k in range(rows.shape[0]):
        row = rows[k]
        beyond = False
        for j in range(action.shape[1]):
            given = action[row, j]
            new = max(-1.0, min(given, 1.0))
            beyond = beyond or new != given
            change[row, j] = new - command[row, j]
            command[row, j] = new
        clipped[row] += 1 if beyond else 0
        if diverged[row]:
            continue
        drive(row, command, mean_square, ctrl, motors, peak, continuous, time_constant, dt)
        i = int(min(step[row] + 1, angle.shape[1] - 1))
        arm_torque(row, links, gravity, angle, rate, acceleration, i, scratch, own)
        act(
            row,
            qpos,
            qvel,
            ctrl,
            step,
            angle,
            rate,
            resistance,
            past,
            variation,
            fresh,
            fatigued,
            own,
            joints,
            intention,
            stiffness,
            damping,
            strength,
            shape,
            habits,
            spread,
            ringing,
        )
    return -1


@njit(cache=True, nogil=True)
def after(
    rows: AnyArray,
    moved: bool,
    measured: AnyArray,
    qpos: AnyArray,
    qvel: AnyArray,
    sensordata: AnyArray,
    actuator_force: AnyArray,
    warning: AnyArray,
    angle: AnyArray,
    step: AnyArray,
    diverged: AnyArray,
    command: AnyArray,
    mean_square: AnyArray,
    fatigued: AnyArray,
    rested: AnyArray,
    counts: AnyArray,
    offset: AnyArray,
    dissipated_before: AnyArray,
    joints: AnyArray,
    driven: AnyArray,
    assisted: AnyArray,
    human: AnyArray,
    assist: AnyArray,
    encoders: AnyArray,
    cuffs: AnyArray,
    suited: AnyArray,
    suit_torque: AnyArray,
    dissipated: AnyArray,
    strength: AnyArray,
    shape: AnyArray,
    tiring: AnyArray,
    recovery: AnyArray,
    multiplier: AnyArray,
    resting: AnyArray,
    peak: AnyArray,
    continuous: AnyArray,
    time_constant: AnyArray,
    ahead: AnyArray,
    count: float,
    smoothing: float,
    dt: float,
    tires: bool,
) -> None:
    """Measures some rows; if they have `moved`, heats motors and tires wearers before.

    A row that has diverged keeps its last valid measurements, but the time.
    """
    for k in range(rows.shape[0]):
        row = rows[k]
        if moved:
            step[row] += 1
        measured[row, TIME] = step[row] * dt
        warned = 0
        for j in range(warning.shape[1]):
            warned += warning[row, j]
        diverged[row] = warned > 0 or not is_finite(
            row, qpos, qvel, sensordata, suit_torque, dissipated
        )
        if diverged[row]:
            continue
        if moved:
            for j in range(assist.shape[0]):
                torque = float(actuator_force[row, assist[j]])
                mean_square[row, j] = heated(mean_square[row, j], torque, time_constant[j], dt)
            if tires:
                tire(
                    row,
                    qpos,
                    qvel,
                    actuator_force,
                    fatigued,
                    rested,
                    joints,
                    human,
                    strength,
                    shape,
                    tiring,
                    recovery,
                    multiplier,
                    resting,
                    dt,
                )
        measure(
            row,
            measured,
            qpos,
            qvel,
            sensordata,
            actuator_force,
            angle,
            step,
            command,
            mean_square,
            fatigued,
            counts,
            offset,
            dissipated_before,
            joints,
            driven,
            assisted,
            human,
            assist,
            encoders,
            cuffs,
            suited,
            suit_torque,
            dissipated,
            peak,
            continuous,
            ahead,
            count,
            smoothing,
            dt,
            moved,
        )
