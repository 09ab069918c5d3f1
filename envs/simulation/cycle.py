"""The control cycle: what happens to each row before and after the physics of a control period."""

from numba import njit

from ...arrays import Array
from ..model.motors import clipped as within_heat
from ..model.motors import heated
from ..person.fatigue import RATES, loaded, tired
from .measurements import CONTINUOUS, EFFORT, PEAK, TIME, TIME_CONSTANT, is_finite, measure
from .structs import Arms, Index, Whole
from .wearer_control import COCONTRACTION, act, contraction, feed_forward, learn, most


@njit(inline="always")
def drive(row: int, arms: Arms) -> None:
    """Sets motor torques from normalized commands, clipped by the thermal limit.

    In the first control period motors have their torque at once, and the wearer, who has held the
    arm alone, gives up as much. A rigid exoskeleton so begins without a jerk; on cuffs, which bear
    nothing yet, the arm yields by some 0.01 rad.
    """
    physics, at, motors, feedback = arms.physics, arms.at, arms.motors, arms.wearer.feedback
    step, dt, ratings = arms.episode.step[row], arms.episode.dt, motors.ratings
    for j in range(at.motors.shape[0]):
        torque = within_heat(
            motors.command[row, j] * ratings[PEAK, j],
            motors.mean_square[row, j],
            ratings[CONTINUOUS, j],
            ratings[TIME_CONSTANT, j],
            dt,
        )
        torque = 0.0 if step * dt >= motors.fails[j] else torque
        physics.ctrl[row, at.motors[j]] = torque
        if step == 0:
            physics.act[row, j] = torque
            feedback.correction[row, at.assisted[j]] -= torque
            for k in range(feedback.correction_goals.shape[1]):
                feedback.correction_goals[row, k, at.assisted[j]] -= torque


@njit(inline="always")
def tire(row: int, now: Index, arms: Arms) -> None:
    """Updates fatigue by the torque of the control period that has passed."""
    physics, at, muscles = arms.physics, arms.at, arms.muscles
    fatigued = muscles.fatigued
    for j in range(4):
        torque = physics.actuator_force[row, at.human[j]]
        opposed = muscles.impedance[row, COCONTRACTION, j] + contraction(row, now, j, arms)
        angle = physics.qpos[row, at.joints[j]]
        for way in range(2):
            sign = 1.0 if way == 1 else -1.0
            speed = sign * physics.qvel[row, at.joints[j]]
            available = most(muscles.strength[row, way, j], way, j, angle, speed)
            fatigued[row, way, j] = tired(
                fatigued[row, way, j],
                loaded(sign * torque + opposed, available),
                RATES[0, j],
                RATES[1, j],
                RATES[2, j],
                RATES[3, j],
                arms.episode.dt,
            )


@njit(inline="always")
def strain(row: int, now: Index, arms: Arms) -> None:
    """Measures effort: the load of the more loaded muscle group over its strength at rest."""
    physics, at, muscles = arms.physics, arms.at, arms.muscles
    for j in range(4):
        torque = physics.actuator_force[row, at.human[j]]
        opposed = muscles.impedance[row, COCONTRACTION, j] + contraction(row, now, j, arms)
        angle, effort = physics.qpos[row, at.joints[j]], 0.0
        for way in range(2):
            pull = torque if way == 1 else -torque
            available = most(muscles.strength[row, way, j], way, j, angle, 0.0)
            effort = max(effort, (max(pull, 0.0) + opposed) / available)
        arms.sensors.measured[row, EFFORT + j] = effort


@njit(cache=True, nogil=True)
def before(rows: Whole, action: Array, arms: Arms) -> None:
    """Applies the actions of some rows: sets the commands of their motors and wearers.

    `action` is the torque of the motors over their peaks, finite, shape (n, motors).
    """
    episode, intention, motors = arms.episode, arms.intention, arms.motors
    learning = arms.wearer.learning
    for k in range(rows.shape[0]):
        row = rows[k]
        beyond, step = False, episode.step[row]
        for j in range(action.shape[1]):
            given = action[row, j]
            new = max(-1.0, min(given, 1.0))
            beyond = beyond or new != given
            motors.change[row, j] = new - motors.command[row, j] if step > 0 else 0.0
            motors.command[row, j] = new
        episode.clipped[row] += 1 if beyond else 0
        if episode.diverged[row]:
            continue
        drive(row, arms)
        i = int(min(step + 1, intention.motion.angle.shape[1] - 1))
        feed_forward(row, i, intention, arms.wearer)
        act(row, arms)
        if learning.rate > 0.0 and i > learning.ahead:
            learn(row, i - learning.ahead, intention, arms.wearer)


@njit(cache=True, nogil=True)
def after(rows: Whole, moved: bool, arms: Arms) -> None:
    """Measures some rows; if they have `moved`, updates motor heat and fatigue first.

    A row that has diverged keeps its last valid measurements, except the time.
    """
    physics, at, episode, motors = arms.physics, arms.at, arms.episode, arms.motors
    for k in range(rows.shape[0]):
        row = rows[k]
        if moved:
            episode.step[row] += 1
        now = int(min(episode.step[row], arms.intention.motion.angle.shape[1] - 1))
        arms.sensors.measured[row, TIME] = episode.step[row] * episode.dt
        warned = 0
        for j in range(physics.warning.shape[1]):
            warned += physics.warning[row, j]
        episode.diverged[row] = warned > 0 or not is_finite(row, physics, at)
        if episode.diverged[row]:
            continue
        if moved:
            for j in range(at.assist.shape[0]):
                torque = float(physics.actuator_force[row, at.assist[j]])
                motors.mean_square[row, j] = heated(
                    motors.mean_square[row, j], torque, motors.ratings[TIME_CONSTANT, j], episode.dt
                )
            if arms.muscles.tires:
                tire(row, now, arms)
        measure(row, moved, arms)
        strain(row, now, arms)
