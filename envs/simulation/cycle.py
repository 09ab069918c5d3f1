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
from ..person.fatigue_kernels import loaded, tired
from .measurements import (
    CONTINUOUS,
    EFFORT,
    PEAK,
    TIME,
    TIME_CONSTANT,
    is_finite,
    measure,
)
from .wearer import EXTRA, act, foresee, learn, most


@njit(cache=True)
def drive(
    row: int,
    command: AnyArray,
    mean_square: AnyArray,
    ctrl: AnyArray,
    motors: AnyArray,
    ratings: AnyArray,
    dt: float,
) -> None:
    """Sets motor torques from normalized commands, clipped by the thermal limit."""
    for j in range(motors.shape[0]):
        ctrl[row, motors[j]] = within_heat(
            command[row, j] * ratings[PEAK, j],
            mean_square[row, j],
            ratings[CONTINUOUS, j],
            ratings[TIME_CONSTANT, j],
            dt,
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
    impedance: AnyArray,
    strength: AnyArray,
    shape: AnyArray,
    rates: AnyArray,
    dt: float,
) -> None:
    """Updates fatigue by the torque of the control period that has passed."""
    for j in range(4):
        torque, extra = actuator_force[row, human[j]], impedance[row, EXTRA, j]
        for way in range(2):
            sign = 1.0 if way == 1 else -1.0
            speed = sign * qvel[row, joints[j]]
            available = most(row, way, j, qpos[row, joints[j]], speed, strength, rested, shape)
            fatigued[row, way, j] = tired(
                fatigued[row, way, j],
                loaded(sign * torque + extra, available),
                rates[0, j],
                rates[1, j],
                rates[2, j],
                rates[3, j],
                dt,
            )


@njit(cache=True)
def strain(
    row: int,
    measured: AnyArray,
    qpos: AnyArray,
    actuator_force: AnyArray,
    rested: AnyArray,
    joints: AnyArray,
    human: AnyArray,
    impedance: AnyArray,
    strength: AnyArray,
    shape: AnyArray,
) -> None:
    """Measures effort: torque and extra co-contraction over the strength of a still joint."""
    for j in range(4):
        torque = actuator_force[row, human[j]]
        way = 1 if torque > 0.0 else 0
        available = most(row, way, j, qpos[row, joints[j]], 0.0, strength, rested, shape)
        measured[row, EFFORT + j] = (abs(torque) + impedance[row, EXTRA, j]) / available


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
    bias: AnyArray,
    step: AnyArray,
    angle: AnyArray,
    rate: AnyArray,
    acceleration: AnyArray,
    taught: AnyArray,
    gains: AnyArray,
    growing: AnyArray,
    features: AnyArray,
    past: AnyArray,
    seen: AnyArray,
    fed: AnyArray,
    held: AnyArray,
    answer: AnyArray,
    variation: AnyArray,
    fresh: AnyArray,
    fatigued: AnyArray,
    links: AnyArray,
    gravity: AnyArray,
    scratch: AnyArray,
    own: AnyArray,
    joints: AnyArray,
    human: AnyArray,
    motors: AnyArray,
    intention: AnyArray,
    impedance: AnyArray,
    strength: AnyArray,
    shape: AnyArray,
    spread: AnyArray,
    ringing: AnyArray,
    ratings: AnyArray,
    reflex: float,
    lead: float,
    lag: float,
    correction: float,
    noise: float,
    tremor: float,
    learning: float,
    forgetting: float,
    credit: int,
    dt: float,
) -> int:
    """Applies the actions of some rows: sets the commands of their motors and wearers.

    Returns:
        The first row whose action is not finite, in which case nothing has changed, or -1 if there
        is none.
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
            change[row, j] = new - command[row, j] if step[row] > 0 else 0.0
            command[row, j] = new
        clipped[row] += 1 if beyond else 0
        if diverged[row]:
            continue
        drive(row, command, mean_square, ctrl, motors, ratings, dt)
        i = int(min(step[row] + 1, angle.shape[1] - 1))
        foresee(
            row,
            i,
            angle,
            rate,
            acceleration,
            links,
            gravity,
            scratch,
            taught,
            gains,
            features,
            own,
        )
        act(
            row,
            qpos,
            qvel,
            ctrl,
            bias,
            step,
            angle,
            rate,
            past,
            seen,
            fed,
            held,
            answer,
            variation,
            fresh,
            fatigued,
            own,
            joints,
            human,
            intention,
            impedance,
            strength,
            shape,
            spread,
            ringing,
            reflex,
            lead,
            lag,
            correction,
            noise,
            tremor,
        )
        if learning > 0.0 and i > credit:
            learn(
                row,
                i - credit,
                angle,
                rate,
                acceleration,
                links,
                gravity,
                scratch,
                gains,
                growing,
                features,
                own,
                answer,
                learning,
                forgetting,
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
    impedance: AnyArray,
    strength: AnyArray,
    shape: AnyArray,
    rates: AnyArray,
    ratings: AnyArray,
    ahead: AnyArray,
    count: float,
    smoothing: float,
    dt: float,
    tires: bool,
) -> None:
    """Measures some rows; if they have `moved`, updates motor heat and fatigue first.

    A row that has diverged keeps its last valid measurements, except the time.
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
                mean_square[row, j] = heated(
                    mean_square[row, j], torque, ratings[TIME_CONSTANT, j], dt
                )
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
                    impedance,
                    strength,
                    shape,
                    rates,
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
            ratings,
            ahead,
            count,
            smoothing,
            dt,
            moved,
        )
        strain(
            row,
            measured,
            qpos,
            actuator_force,
            rested,
            joints,
            human,
            impedance,
            strength,
            shape,
        )
