"""The wearer's control in one control period, for one row (see `envs.person.control`)."""

import math

from numba import njit

from ...arrays import Array
from ...kernels import inner
from ..person.control import NOISE_SIZE
from ..person.strength import SHAPE, group_torque
from .inverse_dynamics import arm_torque
from .structs import Arms, Feedback, Index, Intention, MuscleNoise, Wearer

# Rows of `impedance`.
BASE, SLOPE, DAMPING, RELAXATION, COCONTRACTION = range(5)
# Entries of `recursion`: coefficients that advance noise and tremor by one control period.
SLOW, RING, COSINE, SINE, SLOW_DRIVE, RING_DRIVE = range(6)
# Rows of `persistence`.
STUCK, RESTED, PUSHES, SIDE, PUSHED, AIM, FARTHEST, CALMED, LAST_SIDE, HARDENED = range(10)
PERSISTENCE = 10  # number of these rows
FEATURES = 10  # number of features of the motion that predict the net load
UNMOVED = 0.3  # [s], time at the start in which nobody pushes
STILL = 0.05  # [rad/s], least rate of a motion with a direction


@njit(inline="always")
def vary(row: int, step: int, noise: MuscleNoise) -> None:
    """Advances the noise of muscles: first-order autoregression and a driven, damped rotation."""
    varied, draws, by = noise.muscle_noise, noise.muscle_draws, noise.recursion
    place = step % draws.shape[1]
    for j in range(4):
        slow, x, y = varied[row, 0, j], varied[row, 1, j], varied[row, 2, j]
        varied[row, 0, j] = by[SLOW] * slow + by[SLOW_DRIVE] * draws[row, place, 0, j]
        turned = by[RING] * (by[COSINE] * x - by[SINE] * y)
        varied[row, 1, j] = turned + by[RING_DRIVE] * draws[row, place, 1, j]
        turned = by[RING] * (by[SINE] * x + by[COSINE] * y)
        varied[row, 2, j] = turned + by[RING_DRIVE] * draws[row, place, 2, j]


@inner(forceinline=True)
def most(isometric: float, way: int, joint: int, angle: float, speed: float) -> float:
    """Returns the greatest torque of a muscle group with some isometric strength [N·m]."""
    return group_torque(isometric, angle, speed, SHAPE, way, joint)


@inner(forceinline=True)
def describe(row: int, sample: Index, intention: Intention, wearer: Wearer) -> None:
    """Computes the features of the intended motion at a sample, on which the net load depends.

    Sines and cosines represent weight, rates friction and hysteresis, accelerations inertia. The
    torque of the bare arm at the sample must be in `wearer.arm.torque`.
    """
    motion, features = intention.motion, wearer.learning.features
    upper = motion.angle[row, sample, 1]
    lower = upper + motion.angle[row, sample, 2]
    for j in range(4):
        speed = motion.rate[row, sample, j]
        features[row, j, 0] = wearer.arm.torque[row, j] / 10.0
        features[row, j, 1] = math.sin(upper)
        features[row, j, 2] = math.cos(upper)
        features[row, j, 3] = math.sin(lower)
        features[row, j, 4] = math.cos(lower)
        features[row, j, 5] = speed
        features[row, j, 6] = math.tanh(speed / STILL)
        features[row, j, 7] = 1.0
        features[row, j, 8] = motion.acceleration[row, sample, 1] / 5.0
        features[row, j, 9] = motion.acceleration[row, sample, 2] / 5.0


@inner(forceinline=True)
def predicted(row: int, joint: int, gains: Array, features: Array) -> float:
    """Returns the learned torque, which is the net load that gains and features predict [N·m]."""
    torque = 0.0
    for k in range(gains.shape[2]):
        torque += gains[row, joint, k] * features[row, joint, k]
    return torque


@inner(forceinline=True)
def feed_forward(row: int, sample: Index, intention: Intention, wearer: Wearer) -> None:
    """Computes the wearer's feed-forward torque in `wearer.arm.torque`: bare arm plus learned."""
    torque, learning, learned = wearer.arm.torque, wearer.learning, intention.learned_torque
    arm_torque(row, sample, wearer.arm, intention.motion)
    if learning.gains.shape[2] > 0:
        describe(row, sample, intention, wearer)
    for j in range(4):
        if learned.shape[1] > 0:
            torque[row, j] += learned[row, sample, j]
        if learning.gains.shape[2] > 0:
            torque[row, j] += predicted(row, j, learning.gains, learning.features)


@inner(forceinline=True)
def learn(row: int, sample: int, intention: Intention, wearer: Wearer) -> None:
    """Updates the learned gains by the torque that was needed now, at the features of `sample`.

    The rule is normalized least mean squares; the gains converge where learning and forgetting
    balance. The rule updates `next_gains`, which take effect in the next episode; in the present
    episode reflex and correction already carry the load. `feedback.needed` is the torque that was
    needed beside the feed-forward torque.
    """
    learning = wearer.learning
    gains, next_gains, features = learning.gains, learning.next_gains, learning.features
    arm_torque(row, sample, wearer.arm, intention.motion)
    describe(row, sample, intention, wearer)
    for j in range(4):
        size = 0.0
        for k in range(gains.shape[2]):
            size += features[row, j, k] * features[row, j, k]
        load = wearer.feedback.needed[row, j] + predicted(row, j, gains, features)
        missing = load - (1.0 + learning.forgetting) * predicted(row, j, next_gains, features)
        step = learning.rate * missing / size
        for k in range(gains.shape[2]):
            next_gains[row, j, k] += step * features[row, j, k]


@inner
def push(
    row: int, step: int, joint: int, elastic: float, target_rate: float, feedback: Feedback
) -> None:
    """Advances a persistent wearer's push at a joint that the friction of a gear holds.

    A push begins where the intention rests and a joint that is felt to be off does not approach
    it. The torque rises until the joint gives, and falls by the friction as the joint arrives, to
    the middle of the torques at which friction holds the joint. The push fades as the intention
    moves on. `elastic` is the stiffness with the reflex [N·m/rad].
    """
    by, ring = feedback.persistence, feedback.correction_delay
    memory, friction, dt = by.persistence, by.friction[joint], by.dt
    if not friction > 0.0 or step * dt <= UNMOVED:
        return
    size, place = ring.shape[1], step % ring.shape[1]
    felt = ring[row, (place - by.late) % size, joint]
    before = ring[row, (place - by.late - by.window) % size, joint]
    rate = target_rate - (felt - before) / (by.window * dt)
    torque, side = memory[row, PUSHED, joint], memory[row, SIDE, joint]
    memory[row, RESTED, joint] += dt
    if abs(target_rate) > by.still:
        memory[row, RESTED, joint] = memory[row, STUCK, joint] = 0.0
        memory[row, PUSHES, joint] = 0.0
        memory[row, PUSHED, joint] = torque - torque * min(1.0, dt / by.fade)
        return
    if memory[row, PUSHES, joint] == 0.0:
        side = 1.0 if felt > 0.0 else -1.0
        is_off = abs(felt) > feedback.least + feedback.late * abs(target_rate)
        stuck = memory[row, STUCK, joint] + dt if is_off and side * rate < by.still else 0.0
        memory[row, STUCK, joint] = stuck
        if stuck > by.wait and memory[row, RESTED, joint] > by.rest:
            memory[row, PUSHES, joint], memory[row, SIDE, joint] = 1.0, side
            memory[row, AIM, joint], memory[row, FARTHEST, joint] = torque, abs(felt)
        return
    if memory[row, PUSHES, joint] == 1.0:
        gone, far = side * (torque - memory[row, AIM, joint]), memory[row, FARTHEST, joint]
        far = memory[row, FARTHEST, joint] = max(far, side * felt)
        if side * felt - by.ahead * max(side * rate, 0.0) < feedback.least:
            let_go = max(0.0, min(friction, gone - elastic * far))
            memory[row, AIM, joint] = torque - side * let_go
            memory[row, PUSHES, joint] = -1.0
        elif side * rate < by.still and gone < by.most * friction:
            torque += dt * side * by.pace * friction
    if memory[row, PUSHES, joint] == -1.0:
        change = memory[row, AIM, joint] - torque
        change = max(-by.release * dt, min(change, by.release * dt))
        torque += change
        if change == 0.0:
            memory[row, PUSHES, joint] = memory[row, STUCK, joint] = 0.0
    memory[row, PUSHED, joint] = torque


@inner
def settle(
    row: int, joint: int, seen: float, target_rate: float, hardest: float, feedback: Feedback
) -> float:
    """Advances a persistent wearer's co-contraction; returns the share of the gain that is left.

    Each time that the seen error changes its side, the share falls. `hardest` is the greatest
    co-contraction [N·m].
    """
    by = feedback.persistence
    memory, dt = by.persistence, by.dt
    if abs(seen) > feedback.least:
        side = 1.0 if seen > 0.0 else -1.0
        if memory[row, LAST_SIDE, joint] * side < 0.0:
            memory[row, CALMED, joint] = 1.0 - (1.0 - memory[row, CALMED, joint]) * by.calm
        memory[row, LAST_SIDE, joint] = side
    memory[row, CALMED, joint] -= memory[row, CALMED, joint] * dt / by.recovery
    over = max(0.0, abs(seen) - feedback.least - feedback.late * abs(target_rate))
    hard = memory[row, HARDENED, joint]
    hard += dt * (by.stiffening * over - hard / by.relaxing)
    memory[row, HARDENED, joint] = min(hardest, hard)
    return 1.0 - memory[row, CALMED, joint]


@inner(forceinline=True)
def correct(
    row: int,
    step: int,
    joint: int,
    stiffness: float,
    error: float,
    target_rate: float,
    limits: tuple[float, float],
    feedback: Feedback,
) -> None:
    """Advances the voluntary correction of a joint; a new correction may begin in this period.

    The seen error does not show the effect of the last two goals yet. A change has the course of
    minimum jerk, and its goal is within strength.
    """
    place = step % feedback.correction_delay.shape[1]
    seen = feedback.correction_delay[row, place, joint]
    feedback.correction_delay[row, place, joint] = error
    goals, gain, pushes, pushed = feedback.correction_goals, feedback.correction_gain, False, 0.0
    if feedback.persistence.persistence.shape[1] > 0:
        elastic = stiffness * (1.0 + feedback.reflex_gain)
        push(row, step, joint, elastic, target_rate, feedback)
        hardest = 0.5 * (limits[1] - limits[0]) * feedback.persistence.hardest
        gain *= settle(row, joint, seen, target_rate, hardest, feedback)
        pushes = feedback.persistence.persistence[row, PUSHES, joint] != 0.0
        pushed = feedback.persistence.persistence[row, PUSHED, joint]
    phase = step % feedback.correction_periods
    if phase == 0:
        elastic = stiffness * (1.0 + feedback.reflex_gain)
        remains = seen - (goals[row, 0, joint] - goals[row, 2, joint]) / elastic
        goals[row, 2, joint] = goals[row, 1, joint]
        goals[row, 1, joint] = goals[row, 0, joint]
        if abs(remains) > feedback.least + feedback.late * abs(target_rate) and not pushes:
            wanted = goals[row, 0, joint] + gain * elastic * remains
            goals[row, 0, joint] = max(limits[0], min(wanted, limits[1]))
    s = (phase + 1) / feedback.correction_periods
    share = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
    begin, end = goals[row, 1, joint], goals[row, 0, joint]
    feedback.correction[row, joint] = begin + share * (end - begin) + pushed


@inner(forceinline=True)
def contraction(row: int, sample: Index, joint: int, arms: Arms) -> float:
    """Returns the co-contraction that was learned for a sample, and a persistent wearer's [N·m].

    Both are beyond the usual co-contraction.
    """
    learned = arms.intention.learned_contraction
    given = arms.wearer.feedback.persistence.persistence
    contracted = learned[row, sample, joint] if learned.shape[1] > 0 else 0.0
    return contracted + given[row, HARDENED, joint] if given.shape[1] > 0 else contracted


@njit(inline="always")
def act(row: int, arms: Arms) -> None:
    """Sets intention, impedance and added torque of the wearer's actuators for the coming period.

    `wearer.arm.torque` is the feed-forward torque.
    """
    physics, at, wearer, muscles = arms.physics, arms.at, arms.wearer, arms.muscles
    feedback, motion, noise = wearer.feedback, arms.intention.motion, wearer.noise
    ctrl, impedance = physics.ctrl, muscles.impedance
    reflex, correction = feedback.reflex, feedback.correction
    noisy, delayed = noise.muscle_draws.shape[1] > 0, feedback.reflex_delay.shape[1] > 0
    step, ahead = arms.episode.step[row], arms.episode.step[row] + 1
    i = int(min(ahead, motion.angle.shape[1] - 1))
    if noisy:
        vary(row, step, noise)
    for j in range(4):
        q, v = physics.qpos[row, at.joints[j]], physics.qvel[row, at.joints[j]]
        own = wearer.arm.torque[row, j]
        target = motion.angle[row, i, j]
        target_rate = motion.rate[row, i, j] if i == ahead else 0.0
        error, slip = target - q, target_rate - v
        low, high = 0.0, 0.0
        for way in range(2):
            isometric = muscles.strength[row, way, j] * (1.0 - muscles.fatigued[row, way, j])
            if way == 1:
                high = most(isometric, way, j, q, v)
            else:
                low = -most(isometric, way, j, q, -v)
        muscle = max(low, min(own + reflex[row, j] + correction[row, j], high))
        tension = abs(muscle) + contraction(row, i, j, arms)
        stiffness = impedance[row, BASE, j] + impedance[row, SLOPE, j] * tension
        damping = impedance[row, DAMPING, j] + impedance[row, RELAXATION, j] * stiffness
        intrinsic = stiffness * error + damping * slip
        total = max(low, min(muscle + intrinsic, high))
        feedback.needed[row, j] = total - own
        if noisy:
            varied = noise.noise * NOISE_SIZE[j] * noise.muscle_noise[row, 0, j]
            varied += noise.tremor * noise.muscle_noise[row, 1, j]
            total = max(low, min(total * (1.0 + varied), high))
        ctrl[row, at.intention[0, j]] = target
        ctrl[row, at.intention[1, j]] = target_rate
        ctrl[row, at.intention[2, j]] = total - intrinsic
        physics.biasprm[row, at.human[j], 1] = -stiffness
        physics.biasprm[row, at.human[j], 2] = -damping
        sensed = stiffness * (error + feedback.lead * slip)
        if delayed:
            place = step % feedback.reflex_delay.shape[1]
            now, sensed = sensed, feedback.reflex_delay[row, place, j]
            feedback.reflex_delay[row, place, j] = now
        reflex[row, j] += feedback.lag * (feedback.reflex_gain * sensed - reflex[row, j])
        correct(row, step, j, stiffness, error, target_rate, (low, high), feedback)
