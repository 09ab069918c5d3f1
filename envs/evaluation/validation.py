"""Validation of a believed suit against the true one: its torque along real motions, then relief.

Torque comes first, because motors and wearer blur it: a torque that is 20 % too large everywhere
still gives back 93 % of what the true model does.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ...arrays import Array
from ...assets import JOINTS, AnySuit, SuitJoint
from ...checks import at_least
from ...errors import InputError
from ...tables import Rows
from ..belief import Belief
from ..domain.levels import NOMINAL
from ..making import make_arms
from ..model import ASSISTED, resisting_joints
from ..policies import AnyPolicy, PolicySpec, make_policy, needed_options, policy_spec
from ..policies.registry import PolicyKind
from .compare import Evaluation, evaluate
from .core import FIRST_SEED
from .rollout import Trace
from .statistics import FEWEST_MOTIONS, Interval, interval_of, mean_interval

LIMITS = {"valid": 0.05, "usable": 0.15}
"""Largest NRMSE of the torque for each verdict.

A torque that is 20 % wrong everywhere has an NRMSE of 0.10, since the torque is mostly below its
peak. So a valid model errs about as much as one that is 10 % wrong everywhere, and a usable one as
one that is 30 % wrong. The straight spring through the middle of a loop has 0.22 to 0.28: a model
without hysteresis is not valid.
"""
NOT_VALID = "not valid"
RULE = (
    "The verdict is by the root mean square of the torque error over the largest true torque, of "
    "the joint where the upper end of the 95 % interval is highest: "
    + ", ".join(f"{name} up to {limit:.0%}" for name, limit in LIMITS.items())
    + f", {NOT_VALID} beyond; and it holds for these angles only."
)
# Options with which the simulated suit is the one that is named.
AS_IS = {"pressure": None, "preconditioned": False, "level": NOMINAL}
TRUE, BOUND = "true model", "best-known-plan"
LEAST_TORQUE = 0.01  # [N·m], least resistance of a joint that is judged
FARTHEST = 0.2  # [s], greatest lag that is sought
FINEST = 0.001  # s, its resolution


@dataclass(frozen=True, kw_only=True)
class TorqueError:
    """Believed less true resistance along motions, with intervals over the motions.

    Of several joints the errors are taken together: the root mean square and the mean over all of
    them, and the largest of any.

    Attributes:
        rms: Root mean square [N·m].
        peak: Largest size in a motion, the mean over motions [N·m].
        bias: Mean [N·m].
        lag: Time by which the believed torque comes later than the true one [ms], to 1 ms, up to
            200 ms: where the two correlate best.
        nrmse: Root mean square, each joint's over the largest true torque in all motions, which is
            taken as given.
    """

    rms: Interval
    peak: Interval
    bias: Interval
    lag: Interval
    nrmse: Interval


@dataclass(frozen=True, kw_only=True)
class TorqueErrors:
    """Torque errors of a believed suit along motions, and what they say of it.

    Attributes:
        joints: Torque error of each joint that is judged: an assisted one that both suits resist.
        together: Torque error of these joints together; None without any.
        covered: Lowest and highest angle of the motions [rad], by joint.
        noise: Root mean square of what the fit of the believed joint left of its curves [N·m], by
            joint; None where the suit file does not tell it.
    """

    joints: dict[str, TorqueError]
    together: TorqueError | None
    covered: dict[str, tuple[float, float]]
    noise: dict[str, float | None]

    @property
    def nrmse(self) -> Interval | None:
        """NRMSE of the worst joint (highest upper limit), which sets the verdict; None if none."""
        found = [error.nrmse for error in self.joints.values()]
        return max(found, key=lambda one: one.high, default=None)

    @property
    def verdict(self) -> str | None:
        """The verdict by the upper end of `nrmse`; None without joints."""
        return None if self.nrmse is None else verdict(self.nrmse.high)


@dataclass(frozen=True, kw_only=True)
class Validation:
    """What a believed suit is worth where another one is the true one.

    Attributes:
        same: Whether the believed suit is the true one, or the true one is a sample of it: then
            there is no verdict, since a suit says nothing against itself.
        torque: Torque errors along the motions under the controller that believes.
        relief: Relief of that controller; see `Evaluation.relief`.
        difference: Its relief less that with the true model, motion by motion.
        share_of_true: Its relief over that with the true model.
        share_of_bound: Its relief over that of the best known plan.
    """

    same: bool
    torque: TorqueErrors
    relief: Interval | None
    difference: Interval | None
    share_of_true: Interval | None
    share_of_bound: Interval | None

    @property
    def verdict(self) -> str | None:
        """The verdict by the torque; None of a suit about itself, or without joints."""
        return None if self.same else self.torque.verdict

    def to_dict(self) -> dict[str, Any]:
        """Returns everything as plain values, the verdict first."""
        nrmse = self.torque.nrmse
        return {"verdict": self.verdict, "nrmse": nrmse and nrmse.to_dict(), **asdict(self)}


@dataclass(frozen=True, kw_only=True)
class CurveError:
    """Predicted less measured torque of one curve.

    Attributes:
        curve: Name of the curve.
        rms: Root mean square [N·m].
        peak: Largest size [N·m].
        bias: Mean [N·m].
        nrmse: Root mean square over the largest measured torque of the curve.
    """

    curve: str
    rms: float
    peak: float
    bias: float
    nrmse: float


def verdict(nrmse: float) -> str:
    """Returns "valid", "usable" or "not valid" for a torque error, as `LIMITS` says."""
    return next((name for name, limit in LIMITS.items() if nrmse <= limit), NOT_VALID)


def compare_beliefs(
    env_id: str,
    believed: Mapping[str, AnySuit],
    *,
    policy: AnyPolicy = "feedforward",
    motions: int = 20,
    seed: int = FIRST_SEED,
    on_policy: Callable[[str, list[Trace]], None] = lambda name, traces: None,
    **env_options: Any,
) -> tuple[Evaluation, dict[str, Validation]]:
    """Runs a policy that believes each of some suits in an arm that wears another one.

    Args:
        env_id: Id of a registered environment.
        believed: Believed suits, by names of your choice.
        policy: Policy, which believes a suit if it takes the option `suit`, such as "compensation";
            the others are run as they are.
        motions: Number of motions, at least 8.
        seed: Seed of the first motion.
        on_policy: Function that is called after each policy with its name and its motions.
        **env_options: Options of the environment; `suit` is the true one.

    Returns:
        The evaluation, in which "by NAME" is the policy with that suit beside "true model"
        and "best-known-plan"; and the validation of each believed suit.

    Raises:
        InputError: There are fewer than 8 motions, a suit resists none of the assisted joints that
            the true one resists, its model has no torque somewhere on the way, or `evaluate`
            raises it.
    """
    at_least("motions", motions, FEWEST_MOTIONS)
    joints = believed_joints(env_id, believed, policy, **env_options)
    policies: dict[str, Any] = {TRUE: policy, BOUND: BOUND}
    policies |= {f"by {name}": with_belief(policy, suit) for name, suit in believed.items()}
    options = {"motions": motions, "seed": seed, "on_policy": on_policy, **env_options}
    found = evaluate(env_id, policies, **options)
    as_is = all(env_options.get(other, usual) == usual for other, usual in AS_IS.items())
    return found, {
        name: Validation(
            same=env_options.get("suit") == believed[name] and as_is,
            torque=torque_errors(joints[name], found.traces[one]),
            relief=found.relief(one),
            difference=found.relief_difference(one, TRUE),
            share_of_true=found.share_of_bound(one, TRUE),
            share_of_bound=found.share_of_bound(one, BOUND),
        )
        for name, one in ((name, f"by {name}") for name in believed)
    }


def with_belief(policy: AnyPolicy, suit: AnySuit) -> PolicySpec:
    """Returns a policy that believes a suit, if it takes the option `suit`; otherwise as it is."""
    spec = policy_spec(policy)
    if "suit" in spec.options:
        raise InputError(
            f"the policy {str(spec)!r} has a suit: leave that out, as the believed suits are given"
        )
    if "suit" not in PolicyKind.of(spec.name).options:
        return spec
    return PolicySpec(spec.name, {**spec.options, "suit": suit})


def believed_joints(
    env_id: str, believed: Mapping[str, AnySuit], policy: AnyPolicy, **env_options: Any
) -> dict[str, dict[str, SuitJoint]]:
    """Returns the assisted joints that each believed suit and the true one resist, as believed."""
    arms = make_arms(env_id, 1, **{**env_options, **needed_options(policy)})
    config, found = arms.episodes.simulation.config, {}
    needed = [joint for joint in ASSISTED if joint in resisting_joints(config)]
    for name, suit in believed.items():
        make_policy(with_belief(policy, suit), arms)
        joints = resisting_joints(Belief(suit=suit).of(config))
        found[name] = {joint: joints[joint] for joint in needed if joint in joints}
        if needed and not found[name]:
            raise InputError(
                f"the believed suit {name!r} does not resist {' or '.join(needed)}, which the true "
                "suit does: give one with a model of an assisted joint"
            )
    arms.close()
    return found


def torque_errors(believed: Mapping[str, SuitJoint], traces: Sequence[Trace]) -> TorqueErrors:
    """Compares believed joints with the true torque along at least 8 motions.

    The models follow the true angles of each control period, from the beginning of their memory.

    Args:
        believed: Believed joints, by their names.
        traces: The motions.

    Raises:
        InputError: There are fewer than 8 motions.
        PoleError: A motion meets the pole of an uncertified model.
    """

    def along(name: str, motions: Callable[[Trace], Array]) -> list[Array]:
        return [motions(one)[:, JOINTS.index(name)] for one in traces]

    angles = {name: along(name, lambda one: one.angle) for name in believed}
    true = {name: along(name, lambda one: -one.suit_torque) for name in believed}
    judged = {
        name: joint
        for name, joint in believed.items()
        if max(float(np.abs(one).max()) for one in true[name]) >= LEAST_TORQUE
    }
    expected = {
        name: [
            joint.response(angle, time=one.time)
            for angle, one in zip(angles[name], traces, strict=True)
        ]
        for name, joint in judged.items()
    }
    dt = float(traces[0].time[0])

    def error(names: Sequence[str]) -> TorqueError:
        one, other = (
            [np.stack(motion, axis=1) for motion in zip(*(of[name] for name in names), strict=True)]
            for of in (expected, true)
        )
        return torque_error(one, other, dt)

    whole = {name: np.concatenate(angles[name]) for name in judged}
    return TorqueErrors(
        joints={name: error([name]) for name in judged},
        together=error([*judged]) if judged else None,
        covered={name: (float(one.min()), float(one.max())) for name, one in whole.items()},
        noise={name: noise_of(joint) for name, joint in judged.items()},
    )


def torque_error(believed: Sequence[Array], true: Sequence[Array], dt: float) -> TorqueError:
    """Compares believed with true torque in at least 8 motions.

    Args:
        believed: Believed resistance in each motion [N·m], shape (n, joints).
        true: True resistance [N·m], of the same shapes.
        dt: Time between samples [s].
    """
    largest = np.max([np.abs(one).max(axis=0) for one in true], axis=0)
    pairs = list(zip(believed, true, strict=True))
    apart = [one - other for one, other in pairs]
    return TorqueError(
        rms=_root_interval([float(np.mean(error**2)) for error in apart]),
        peak=mean_interval([np.abs(error).max() for error in apart]),
        bias=mean_interval([error.mean() for error in apart]),
        lag=mean_interval([1e3 * lag_of(*pair, dt) for pair in pairs]),
        nrmse=_root_interval([float(np.mean((error / largest) ** 2)) for error in apart]),
    )


def lag_of(late: Array, early: Array, dt: float) -> float:
    """Returns the time by which one record comes later than another [s].

    That is the shift, to 1 ms and up to 0.2 s, with which the two correlate best over the middle of
    the record; 0 where one of them is constant there.

    Args:
        late: One record, shape (n, columns); the correlations of the columns are summed.
        early: The other one, of the same shape.
        dt: Time between samples [s].
    """
    time = dt * np.arange(len(late))
    farthest = min(FARTHEST, time[-1] / 4)
    middle = (time >= farthest) & (time <= time[-1] - farthest)
    shifts = FINEST * np.arange(-round(farthest / FINEST), round(farthest / FINEST) + 1)
    alike = np.zeros_like(shifts)
    for one, other in zip(late.T, early.T, strict=True):
        shifted = np.interp(time[middle] + shifts[:, None], time, one)
        alike += _correlation(shifted, other[middle])
    best = np.flatnonzero(alike >= alike.max() - 1e-12)
    return float(shifts[best[np.abs(shifts[best]).argmin()]])


def curve_errors(joint: SuitJoint, curves: Mapping[str, tuple[Array, Array]]) -> list[CurveError]:
    """Compares a joint with curves that were measured, each from the beginning of its memory.

    Args:
        joint: Joint of a believed suit.
        curves: Angles [rad] and measured torques [N·m] of each curve, by its name.

    Raises:
        InputError: The torque of a curve is 0 everywhere.
        PoleError: A curve meets the pole of an uncertified model.
    """
    found = []
    for name, (angle, torque) in curves.items():
        error, largest = joint.response(angle) - torque, np.abs(torque).max()
        if largest == 0:
            raise InputError(f"curve {name!r} has no torque: leave it out")
        rms, peak = float(np.sqrt(np.mean(error**2))), float(np.abs(error).max())
        sizes = {"rms": rms, "peak": peak, "bias": float(error.mean())}
        found.append(CurveError(curve=name, **sizes, nrmse=rms / float(largest)))
    return found


def noise_of(joint: SuitJoint) -> float | None:
    """Returns the root mean square of what a fit left of its curves [N·m]; None if it is not known.

    The file has it over the largest torque of the curves, which is taken to be that of the model
    along one loading and unloading over its range.
    """
    if joint.fit_nrmse is None:
        return None
    low, high = joint.range
    loop = np.concatenate([np.linspace(low, high, 100), np.linspace(high, low, 100)])
    return joint.fit_nrmse * float(np.abs(joint.response(loop)).max())


def _root_interval(squares: Sequence[float]) -> Interval:
    """Returns the interval of a root mean square from mean squares of motions."""
    found = interval_of(lambda mean: np.sqrt(np.maximum(mean, 0)), squares)
    return Interval(found.value, max(0.0, found.low), found.high)


def _correlation(rows: Array, one: Array) -> Array:
    """Returns the correlation of each row with one record; 0 where one is constant."""
    rows, one = rows - rows.mean(axis=1, keepdims=True), one - one.mean()
    size = np.linalg.norm(rows, axis=1) * np.linalg.norm(one)
    return np.divide(rows @ one, size, out=np.zeros_like(size), where=size > 0)


@dataclass(frozen=True, kw_only=True)
class CurvePrediction:
    """What suits predict of measured curves.

    Attributes:
        errors: Errors of each curve, by suit and joint.
        notes: Curves that test nothing, as sentences.
    """

    errors: Mapping[str, Mapping[str, list[CurveError]]]
    notes: Sequence[str] = ()

    @property
    def _curves(self) -> dict[tuple[str, str], list[CurveError]]:
        """The errors by suit and joint."""
        return {(suit, joint): one for suit, of in self.errors.items() for joint, one in of.items()}

    def to_dict(self) -> dict[str, Any]:
        """Returns everything as plain values."""
        found: dict[str, dict[str, Any]] = {suit: {} for suit in self.errors}
        for (suit, joint), errors in self._curves.items():
            curves = [asdict(one) for one in errors]
            found[suit][joint] = {"verdict": _worst(errors), "curves": curves}
        return {"limits": LIMITS, "suits": found}

    def tables(self) -> dict[str, Rows]:
        """Returns the errors of all curves, by title."""
        header = ["suit", "joint", "curve", "RMS\n[N·m]", "largest\n[N·m]", "bias\n[N·m]"]
        rows = []
        for names, errors in self._curves.items():
            for one in errors:
                sizes = (f"{value:z.2f}" for value in (one.rms, one.peak, one.bias))
                rows.append([*names, one.curve, *sizes, f"{100 * one.nrmse:.1f}"])
        return {"Torque, predicted less measured": ([*header, "RMS of the\npeak [%]"], rows)}

    def sentences(self) -> list[str]:
        """Returns the verdict on each joint of each suit."""
        found = self._curves.items()
        verdicts = [f"{suit}, {joint}: {_worst(errors)}" for (suit, joint), errors in found]
        return [*self.notes, *verdicts, f"{RULE} Of curves, the worst one decides."]


def _worst(errors: Sequence[CurveError]) -> str:
    return verdict(max(error.nrmse for error in errors))
