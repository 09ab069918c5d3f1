"""MyoArm, the musculoskeletal arm of myo-sim, in our joint angles (needs the extra `muscles`).

MyoArm (MyoSuite; after the arm of Saul et al. 2015) is the average man's arm. For a wearer of
another stature all lengths are scaled by one factor; for a wearer of another strength all torques
are. Torque is force times moment arm, power force times speed, and muscle mass in proportion to
force times length. Forces scale with strength over stature, so that torques, powers and masses
depend on strength alone.

Lengths, moment arms and forces are MuJoCo's own: `mj_tendon` and `mj_fwdActuation` compute them.
The shoulder girdle follows elevation, as the equalities of the model say.
"""

import os
import warnings
from collections import deque
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from typing import NamedTuple

import mujoco
import numpy as np

from ...arrays import AnyArray, Array
from ...errors import InputError
from .mapping import AXES, shoulder, shoulder_rates

EXTRA = "the extra activesuit[muscles] (pip install 'activesuit[muscles]')"

GROUPS: dict[str, tuple[str, ...]] = {
    "deltoid": ("DELT1", "DELT2", "DELT3"),
    "rotator cuff": ("SUPSP", "INFSP", "SUBSC", "TMIN"),
    "chest and back": ("TMAJ", "PECM1", "PECM2", "PECM3", "LAT1", "LAT2", "LAT3", "CORB"),
    "triceps": ("TRIlong", "TRIlat", "TRImed", "ANC"),
    "elbow flexors": ("BIClong", "BICshort", "BRA", "BRD"),
    "forearm rotation": ("SUP", "PT", "PQ"),
    "wrist": ("ECRL", "ECRB", "ECU", "FCR", "FCU", "PL"),
}
"""The muscles that move shoulder, elbow and wrist, by group; 31 others move fingers and thumb."""

MUSCLES = tuple(name for group in GROUPS.values() for name in group)

JOINTS = (
    *("elv_angle_r", "shoulder_elv_r", "shoulder_rot_r", "elbow_flexion_r", "pro_sup_r"),
    *("flexion_r", "deviation_r"),
)
"""MyoArm's joints, in the order of the axes."""

FOREARM = -np.pi / 2  # [rad], of pro_sup_r: the palm looks forward where the arm hangs, as ours
CHEST, BODIES = "chest_r", ("humerus_r", "ulna_r", "lunate_r", "3proxph_r")
"""The chest, and the bodies that begin at shoulder, elbow, wrist and knuckle."""

BATCH = 250  # samples that a thread takes at a time
HANGING = 0.3  # [rad], elevation below which the plane of elevation may be any
TOLERANCE = 1e-6  # [rad], by which a posture may miss a range


class Geometry(NamedTuple):
    """The muscles along a motion of the average man; shapes are (samples, muscles)."""

    length: Array  # length of the fibres over the optimal length
    speed: Array  # rate of lengthening [m/s]
    arms: Array  # moment arms [m], with the sign of the torque, shape (samples, axes, muscles)
    full: Array  # force at full activation [N]
    isometric: Array  # force at full activation and speed 0 [N]
    passive: Array  # force without activation [N]
    outside: AnyArray  # whether a posture is outside a range of MyoArm, shape (samples,)


@dataclass(frozen=True, eq=False)
class MyoArm:
    """MyoArm with the 32 muscles that move shoulder, elbow and wrist.

    Attributes:
        model: Its MuJoCo model.
        muscles: Names of the muscles, in the order of all arrays.
        coupled: Angles of all joints per angle of `JOINTS`, shape (joints, 7).
        trunk: Forward, up and right of the shoulder in the frame of the chest, as columns, shape
            (3, 3): the axes of elevation and its plane, which are 4 degrees off the chest's.
        signs: +1 where our axis has the direction of MyoArm's axis, -1 where the directions are
            opposite, shape (7,).
        optimal: Optimal length of the fibres [m], shape (muscles,).
        peak: Greatest isometric force [N], shape (muscles,).
        fastest: Greatest speed of shortening over optimal length [1/s], shape (muscles,).
    """

    model: mujoco.MjModel
    muscles: tuple[str, ...]
    coupled: Array
    trunk: Array
    signs: Array
    optimal: Array
    peak: Array
    fastest: Array

    @classmethod
    @lru_cache(maxsize=1)
    def load(cls) -> "MyoArm":
        """Returns the arm; the first call takes some seconds."""
        model = lean(myoarm_spec())
        coupled, trunk, gain = _coupled(model), _trunk(model), model.actuator_gainprm
        low, high = model.actuator_lengthrange.T
        return cls(
            model=model,
            muscles=tuple(model.actuator(i).name for i in range(model.nu)),
            coupled=coupled,
            trunk=trunk,
            signs=_signs(model, coupled, trunk),
            optimal=(high - low) / (gain[:, 1] - gain[:, 0]),
            peak=gain[:, 2],
            fastest=gain[:, 6],
        )

    def angles(self, angle: Array) -> Array:
        """Returns MyoArm's angles [rad], (samples, 7), of our joint angles [rad], (samples, 4)."""
        found = np.zeros((len(angle), len(JOINTS)))
        found[:, :3] = shoulder(angle)
        found[:, 3], found[:, 4], found[:, 5] = angle[:, 2], FOREARM, angle[:, 3]
        return found

    def geometry(self, angle: Array, rate: Array, *, threads: int = 0) -> Geometry:
        """Returns the muscles along a motion.

        Args:
            angle: Our joint angles [rad], shape (samples, 4).
            rate: Joint rates [rad/s], the same shape.
            threads: Number of threads; 0 uses all cores.
        """
        theirs = self.angles(angle)
        turned = np.tile(np.diag(self.signs), (len(angle), 1, 1))
        turned[:, :3, :3] = shoulder_rates(angle, theirs[:, :3])
        starts = range(0, len(angle), BATCH)
        parts = ([of[i : i + BATCH] for i in starts] for of in (theirs, turned, rate))
        workers = threads or os.cpu_count() or 1
        with ThreadPoolExecutor(min(workers, max(len(starts), 1))) as pool:
            found = list(pool.map(self._part, *parts))
        numbers = (np.concatenate(one) for one in zip(*found, strict=True))
        return Geometry(*numbers, outside=self._outside(theirs))

    def places(self, angle: Array) -> Array:
        """Returns the positions of shoulder, elbow, wrist and knuckle at our joint angles [m].

        Coordinates are forward, up and right from the shoulder. Angles [rad] have the shape
        (samples, 4), positions the shape (samples, 4, 3).
        """
        data, model = mujoco.MjData(self.model), self.model
        bodies = [model.body(name).id for name in BODIES]
        found = np.empty((len(angle), len(bodies), 3))
        for i, theirs in enumerate(self.angles(angle)):
            data.qpos[:] = self.coupled @ theirs
            mujoco.mj_kinematics(model, data)
            chest = data.body(CHEST).xmat.reshape(3, 3)
            found[i] = (data.xpos[bodies] - data.xpos[bodies[0]]) @ chest @ self.trunk
        return found

    def _part(self, theirs: Array, turned: Array, rate: Array) -> tuple[Array, ...]:
        model, data = self.model, mujoco.MjData(self.model)
        n, muscles = len(theirs), model.nu
        length, speed, full, still, slack = np.empty((5, n, muscles))
        arms = np.empty((n, len(AXES), muscles))
        moment = np.zeros((muscles, model.nv))
        low, span = model.actuator_lengthrange[:, 0], model.actuator_gainprm[:, 0]
        own = turned[:, :, [0, 1, 3, 5]]
        for i in range(n):
            data.qpos[:] = self.coupled @ theirs[i]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_tendon(model, data)
            mujoco.mj_transmission(model, data)
            sparse = (data.moment_rownnz, data.moment_rowadr, data.moment_colind)
            mujoco.mju_sparse2dense(moment, data.actuator_moment, *sparse)
            lengthening = moment @ self.coupled
            length[i] = span + (data.actuator_length - low) / self.optimal
            speed[i] = lengthening @ (own[i] @ rate[i])
            arms[i] = -(lengthening @ turned[i]).T
            states = (0.0, 0.0, slack), (1.0, 0.0, still), (1.0, speed[i], full)
            for activation, velocity, force in states:
                data.act[:], data.actuator_velocity[:] = activation, velocity
                mujoco.mj_fwdActuation(model, data)
                force[i] = -data.actuator_force
        return length, speed, arms, full - slack, still - slack, slack

    def _outside(self, theirs: Array) -> AnyArray:
        ranges = np.array([self.model.joint(name).range for name in JOINTS])
        missed = (theirs < ranges[:, 0] - TOLERANCE) | (theirs > ranges[:, 1] + TOLERANCE)
        # In a hanging arm plane and rotation depend on rounding.
        missed[:, [0, 2]] &= theirs[:, 1, None] >= HANGING
        return np.any(missed, axis=1)


def myoarm_spec() -> mujoco.MjSpec:
    """Returns MyoArm of myo-sim without keyframes; raises InputError without the extra."""
    try:
        import myo_sim
    except ImportError:
        raise InputError(f"muscles need {EXTRA}: install it") from None
    with quiet():
        try:
            spec = myo_sim.load_spec("myoarm_r")
        except (ValueError, AttributeError, OSError) as error:
            raise _unfit(f"no arm 'myoarm_r' ({error})") from None
    has = {part.name for part in (*spec.joints, *spec.actuators, *spec.bodies)}
    for kind, names in (("joint", JOINTS), ("muscle", MUSCLES), ("body", (CHEST, *BODIES))):
        for name in names:
            if name not in has:
                raise _unfit(f"an arm without the {kind} {name!r}")
    for key in spec.keys:
        spec.delete(key)
    return spec


def _unfit(what: str) -> InputError:
    installed = version("myo-sim")
    return InputError(f"myo-sim {installed} has {what}: install version 0.2.3 or newer")


@contextmanager
def quiet() -> Iterator[None]:
    """Drops the warnings with which myo-sim puts its parts together."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(deque(maxlen=0).append)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        mujoco.set_mju_user_warning(before)


def lean(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """Compiles the arm with its 32 muscles only."""
    by_name = {actuator.name: actuator for actuator in spec.actuators}
    for name in by_name.keys() - set(MUSCLES):
        spec.delete(by_name[name])
    kept = {actuator.target for actuator in spec.actuators}
    for tendon in list(spec.tendons):
        if tendon.name not in kept:
            spec.delete(tendon)
    with quiet():
        return spec.compile()


def _coupled(model: mujoco.MjModel) -> Array:
    """Returns the angles of all joints per angle of `JOINTS`, from linear equalities."""
    found = np.eye(model.nv)
    for i in range(model.neq):
        line = model.eq_data[i]
        if model.eq_type[i] != mujoco.mjtEq.mjEQ_JOINT or line[[0, 2, 3, 4]].any():
            raise _unfit("an arm with an equality that is no line between two joints")
        one, other = (model.jnt_dofadr[ids[i]] for ids in (model.eq_obj1id, model.eq_obj2id))
        found[one] = 0
        found[one, other] = line[1]
    return found[:, [model.joint(name).dofadr[0] for name in JOINTS]]


def _trunk(model: mujoco.MjModel) -> Array:
    """Returns the axes of the shoulder in the frame of the chest, as columns."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    plane, elevation = (data.joint(name).xaxis for name in JOINTS[:2])
    axes = np.column_stack([-elevation, plane, np.cross(-elevation, plane)])
    return data.body(CHEST).xmat.reshape(3, 3).T @ axes


def _signs(model: mujoco.MjModel, coupled: Array, trunk: Array) -> Array:
    """Returns the signs of MyoArm's axes along our axes, from MyoArm's hanging posture."""
    ours = [[0, 0, 1], [0, 1, 0], [0, 0, 1], [1, 0, 0]]  # elbow, forearm, wrist, deviation
    data = mujoco.MjData(model)
    data.qpos[:] = FOREARM * coupled[:, JOINTS.index("pro_sup_r")]
    mujoco.mj_kinematics(model, data)
    theirs = np.array([data.joint(name).xaxis for name in JOINTS[3:]])
    along = (theirs @ data.body(CHEST).xmat.reshape(3, 3) @ trunk * ours).sum(axis=1)
    return np.concatenate([np.ones(3), np.sign(along)])
