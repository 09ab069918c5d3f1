"""The state of all rows between two resets, beside the state of the physics."""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...assets import JOINTS
from .measurements import NOISES, WIDTH
from .wearer import FEATURES

STRETCH = 64  # control periods for which muscle noise is drawn at once


@dataclass(eq=False)
class Memory:
    """The state of episodes, as arrays with a leading axis of rows.

    A state that is saved, restored or checked consists of these fields and the state of the
    physics.

    Attributes:
        seed: Seed of the row, from which all its random numbers follow, shape (n,).
        episode: Number of the episode since the row was seeded, shape (n,).
        step: Number of control periods since the reset, shape (n,).
        limit: Number of control periods after which the episode is truncated, shape (n,).
        clipped: Number of actions that were outside [-1, 1], shape (n,).
        diverged: Whether the physics has diverged, shape (n,).
        angle: Intended joint angles [rad], shape (n, samples, 4).
        rate: Their rates [rad/s], the same shape.
        acceleration: Their accelerations [rad/s²], the same shape.
        taught: Learned torque of the wearer, added to that of the bare arm [N·m], the same shape;
            without samples in simulations that take none.
        gains: Gains from the features of the motion to the learned torque, shape
            (n, 4, FEATURES); without features for wearers who never learn.
        growing: The same gains as learned so far, which act from the next episode on, the same
            shape.
        command: Last action, shape (n, motors).
        change: Its change since the action before, shape (n, motors).
        mean_square: Running mean square of the motors' torques [N²·m²], shape (n, motors).
        past: Delayed inputs of the reflex [N·m], a ring buffer indexed by the step, shape
            (n, delay, 4).
        seen: Delayed inputs of the slow correction [N·m], a ring buffer as well, shape
            (n, delay, 4).
        fed: Torque of the reflex [N·m], shape (n, 4).
        held: Torque of the slow correction [N·m], shape (n, 4).
        variation: Slow noise of the muscles, tremor, and tremor a quarter period later, each with
            variance 1 in the long run, shape (n, 3, 4).
        fresh: Random numbers that drive `variation`, shape (n, STRETCH, 3, 4); none without noise.
        felt: Measured torque between person and suit [N·m], a ring buffer indexed by the step,
            shape (n, delay + 1, 4); one unused place without noisy sensors.
        shaken: Random numbers of the sensors' noise, shape (n, STRETCH, NOISES); none without.
        loudness: Factor of the noise of sensors, shape (n,).
        fatigued: Fatigued part of every muscle group, shape (n, 2, 4).
        counts: Counts that the encoders showed last, shape (n, 4).
        wearer: Number of the wearer, where rows have wearers of their own, shape (n,).
        misalignment: Displacement of the exoskeleton from its configured position [m], where rows
            have one of their own, shape (n, 3).
        load: Mass at the hand [kg], where rows have loads of their own, shape (n,).
        carried: Mass at the hand at every sample of the intention [kg], shape (n, samples); no
            samples where loads do not change.
        push: Force on the grip at every sample [N], shape (n, samples, 3); no samples without.
        fall: Acceleration of free fall [m/s²], where rows have places of their own, shape (n,).
        offset: Error of the encoders' zeros [rad], shape (n, 4).
        dissipated_before: Energy that the suit had dissipated at the reset [J], shape (n,).
        told: Reward terms and costs of the episode so far, shape (n, size), as `Episodes` sizes it.
        watched: Samples at which the task judges the hand, bool, shape (n, samples), as `Episodes`
            sizes it.
        places: Intended places of the hand in the world [m], sized likewise, shape (n, samples, 3).
        hand: Place of the hand one control period ago [m], shape (n, 3).
        measured: Last valid measurements, shape (n, WIDTH).
        believed: Memory of a believed suit, shape (n, size), as `Episodes` sizes it.
        shown: Observations before the last one, newest first, shape (n, count, size), as `Episodes`
            sizes it.
    """

    seed: NDArray[np.int64]
    episode: NDArray[np.int64]
    step: NDArray[np.int64]
    limit: NDArray[np.int64]
    clipped: NDArray[np.int64]
    diverged: NDArray[np.bool_]
    angle: Array
    rate: Array
    acceleration: Array
    taught: Array
    gains: Array
    growing: Array
    command: Array
    change: Array
    mean_square: Array
    past: Array
    seen: Array
    fed: Array
    held: Array
    variation: Array
    fresh: Array
    felt: Array
    shaken: Array
    loudness: Array
    fatigued: Array
    counts: Array
    wearer: NDArray[np.int64]
    misalignment: Array
    load: Array
    carried: Array
    push: Array
    fall: Array
    offset: Array
    dissipated_before: Array
    told: Array
    watched: NDArray[np.bool_]
    places: Array
    hand: Array
    measured: Array
    believed: Array
    shown: NDArray[np.float32]

    @classmethod
    def empty(
        cls,
        n: int,
        *,
        samples: int,
        motors: int,
        delay: int,
        sight: int,
        taught: bool,
        learns: bool,
        noisy: bool,
        felt: int | None,
        carries: bool,
        pushed: bool,
    ) -> "Memory":
        """Returns the memory of `n` rows before their first reset.

        Args:
            n: Number of rows.
            samples: Number of samples of an intention.
            motors: Number of motors.
            delay: Delay of the wearer's reflex [control periods].
            sight: Delay of the wearer's slow correction [control periods].
            taught: Whether wearers take a learned torque.
            learns: Whether wearers learn from episode to episode.
            noisy: Whether the wearer's muscles have noise or tremor.
            felt: Delay of the torque between person and suit [control periods]; None without
                sensors that have noise.
            carries: Whether loads change during an episode.
            pushed: Whether forces act on the grip.
        """
        joints = len(JOINTS)
        motion = (n, samples, joints)
        return cls(
            seed=np.zeros(n, np.int64),
            episode=np.full(n, -1),
            step=np.zeros(n, np.int64),
            limit=np.full(n, samples - 1),
            clipped=np.zeros(n, np.int64),
            diverged=np.zeros(n, np.bool_),
            angle=np.zeros(motion),
            rate=np.zeros(motion),
            acceleration=np.zeros(motion),
            taught=np.zeros((n, samples if taught else 0, joints)),
            gains=np.zeros((n, joints, FEATURES if learns else 0)),
            growing=np.zeros((n, joints, FEATURES if learns else 0)),
            command=np.zeros((n, motors)),
            change=np.zeros((n, motors)),
            mean_square=np.zeros((n, motors)),
            past=np.zeros((n, delay, joints)),
            seen=np.zeros((n, sight, joints)),
            fed=np.zeros((n, joints)),
            held=np.zeros((n, joints)),
            variation=np.zeros((n, 3, joints)),
            fresh=np.zeros((n, STRETCH if noisy else 0, 3, joints)),
            felt=np.zeros((n, 1 if felt is None else felt + 1, joints)),
            shaken=np.zeros((n, 0 if felt is None else STRETCH, NOISES)),
            loudness=np.ones(n),
            fatigued=np.zeros((n, 2, joints)),
            counts=np.zeros((n, joints)),
            wearer=np.zeros(n, np.int64),
            misalignment=np.zeros((n, 3)),
            load=np.zeros(n),
            carried=np.zeros((n, samples if carries else 0)),
            push=np.zeros((n, samples if pushed else 0, 3)),
            fall=np.zeros(n),
            offset=np.zeros((n, joints)),
            dissipated_before=np.zeros(n),
            told=np.zeros((n, 0)),
            watched=np.zeros((n, 0), np.bool_),
            places=np.zeros((n, 0, 3)),
            hand=np.zeros((n, 3)),
            measured=np.zeros((n, WIDTH)),
            believed=np.zeros((n, 0)),
            shown=np.zeros((n, 0, 0), np.float32),
        )

    def arrays(self) -> dict[str, NDArray]:
        """Returns the arrays themselves, by the names of their fields."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def clear(self, rows: NDArray[np.int64]) -> None:
        """Clears the last episode of some rows, but keeps their seeds and learned gains."""
        kept = ("seed", "episode", "limit", "angle", "rate", "acceleration", "growing")
        for name, values in self.arrays().items():
            if name not in kept:
                values[rows] = 0
