"""A study of methods, joints and trials: what to run, one trial of it, and how it is saved.

Everything a trial does follows from the configuration, its key and the curves, so a study gives
the same numbers on any number of workers and whether or not it was interrupted.
"""

import hashlib
import json
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import AliasChoices, BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from ...checks import at_least, check_seed
from ...errors import InputError, shortened, unknown_name
from ...hysteresis.loops import reversals
from ...json_files import parse_json
from ..curves import Curve, Curves
from ..fits.certified import certified_fit
from ..objective import FEWEST_SAMPLES, CurveObjective
from ..optimizers.registry import SWARMS
from ..trials import run_optimizer

Count = Annotated[int, Field(ge=0, le=10**15)]
Error = Annotated[FiniteFloat, Field(ge=0)]
STUDY_METHODS = (*SWARMS, "certified")
CONVERGED = 1.01  # ratio to the final fitness at convergence


class TrialKey(NamedTuple):
    """Which trial of a study."""

    joint: str
    method: str
    number: int

    @property
    def file_name(self) -> str:
        """The name of its file; no method has a dot in it, so no two keys share one."""
        return f"{self.joint}.{self.method}.{self.number:04d}.json"


@dataclass(frozen=True, kw_only=True)
class StudyConfig:
    """What a study runs. Converts to JSON and back without loss.

    Attributes:
        methods: Names from `STUDY_METHODS`.
        joints: A fingerprint of the curves by joint name.
        trials: Number of independent runs of each method on each joint.
        seed: Seed of all random numbers.
        swarm_size: Number of particles of a swarm.
        iterations: Number of moves of a swarm; every other method except "certified" may evaluate
            the model as often as a swarm does.

    Raises:
        InputError: A name is unknown or there twice, nothing is left to do, or a number is too
            small.
    """

    methods: tuple[str, ...]
    joints: dict[str, str]
    trials: int = 30
    seed: int = 0
    swarm_size: int = 50
    iterations: int = 100

    def __post_init__(self) -> None:
        if not self.methods or not self.joints:
            raise InputError("the study has no method or no joint: name at least one of each")
        for method in self.methods:
            if method not in STUDY_METHODS:
                raise unknown_name("method", method, STUDY_METHODS)
            if self.methods.count(method) > 1:
                raise InputError(f"method {method!r} is there twice: name each method once")
        at_least("trials", self.trials, 1)
        check_seed(self.seed)
        at_least("swarm_size", self.swarm_size, 2)
        at_least("iterations", self.iterations, 1)

    @property
    def evaluations(self) -> int:
        """How many models a swarm evaluates in one trial."""
        return self.swarm_size * (self.iterations + 1)

    @property
    def keys(self) -> list[TrialKey]:
        """All trials, in the order of every table."""
        return [
            TrialKey(joint, method, number)
            for joint in self.joints
            for method in self.methods
            for number in range(self.trials)
        ]

    def seed_of(self, key: TrialKey) -> np.random.SeedSequence:
        """Returns the seed of a trial, which no other method, joint or trial changes."""
        spawn_key = (*(zlib.crc32(name.encode()) for name in key[:2]), key.number)
        return np.random.SeedSequence(self.seed, spawn_key=spawn_key)

    def options_of(self, method: str) -> dict[str, int]:
        """Returns the options of an optimizer, with which it evaluates as often as a swarm."""
        return {"swarm_size": self.swarm_size, "max_iterations": self.iterations}

    def to_dict(self) -> dict[str, Any]:
        """Returns plain values for JSON."""
        return {**asdict(self), "methods": list(self.methods)}


class Prediction(NamedTuple):
    """How far a model is from a curve kept out of the fit; infinite where it meets its pole."""

    largest: float  # largest |Tc - Tm| [N·m]
    nrmse: float  # root mean square over the largest torque of the fitted curves


@dataclass(frozen=True, kw_only=True)
class StudyTrial:
    """Result of one trial.

    Attributes:
        key: Key of the trial.
        parameters: Ms, a, alpha, c, k in degrees.
        safe_range: Range [rad] outside which a certified fit needs a constant torque, if any.
        fitness: Eq. (7) of Li et al. 2022 on the fitted curves.
        nrmse: Error sqrt(mean((Tc - Tm)^2)) / max|Tm| on the fitted curves.
        evaluations: How often the model was evaluated on all curves.
        improvements: (evaluations, best fitness) whenever the best one improved.
        predictions: The error on each curve with role "predict".
    """

    key: TrialKey
    parameters: tuple[float, ...]
    safe_range: tuple[float, float] | None
    fitness: float
    nrmse: float
    evaluations: int
    improvements: tuple[tuple[int, float], ...]
    predictions: dict[str, Prediction]

    def convergence_iteration(self, swarm_size: int) -> int:
        """Returns the iteration from which the best fitness is within 1 % of the final one.

        An iteration is `swarm_size` evaluations; the first is that of the scattered swarm.
        """
        final = self.improvements[-1][1]
        spent = next(spent for spent, best in self.improvements if best <= CONVERGED * final)
        return -(-spent // swarm_size)

    def best_after(self, evaluations: NDArray[np.int64]) -> NDArray[np.float64]:
        """Returns the best fitness, (n,), after each of these numbers of evaluations, (n,)."""
        spent, best = np.array(self.improvements).T
        place = np.searchsorted(spent, evaluations, side="right") - 1
        return np.where(place >= 0, best[place], np.inf)

    def evaluations_to(self, fitness: float) -> float:
        """Returns after how many evaluations the best fitness was at most `fitness`, or inf."""
        return next((float(spent) for spent, best in self.improvements if best <= fitness), np.inf)

    def to_json(self) -> str:
        """Returns strict JSON that gives every number back to the last bit."""
        content = asdict(self)
        for name, errors in self.predictions.items():
            content["predictions"][name] = [e if np.isfinite(e) else None for e in errors]
        return json.dumps(content, allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Returns the trial that `to_json` wrote.

        Raises:
            InputError: The text is not what `to_json` wrote.
        """
        return cls.from_dict(parse_json(text, "not a finished trial: it", fix="delete it"))

    @classmethod
    def from_dict(cls, content: Any) -> Self:
        """Returns the trial whose JSON has that content.

        Raises:
            InputError: The content is not that of a finished trial.
        """
        try:
            found = _Saved.model_validate_json(json.dumps(content), strict=True)
        except ValidationError as error:
            problem: Any = error.errors()[0]
            place = ".".join(map(str, problem["loc"])) or "the whole"
            reason = shortened(f"{place}: {problem['msg']}", 120)
            raise InputError(f"not a finished trial ({reason}): delete it") from None
        return cls(
            **{
                **dict(found),
                "key": TrialKey(*found.key),
                "predictions": {
                    name: Prediction(*(np.inf if e is None else e for e in errors))
                    for name, errors in found.predictions.items()
                },
            }
        )


class _Saved(BaseModel):
    """The file of a finished trial."""

    model_config = ConfigDict(extra="forbid")

    key: tuple[str, str, Count]
    parameters: tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat]
    # Version 0.2 wrote `held`.
    safe_range: tuple[FiniteFloat, FiniteFloat] | None = Field(
        validation_alias=AliasChoices("safe_range", "held")
    )
    fitness: Error
    nrmse: Error
    evaluations: Count
    improvements: Annotated[tuple[tuple[Count, Error], ...], Field(min_length=1)]
    predictions: dict[str, tuple[Error | None, Error | None]]


def fingerprint(curves: Sequence[Curve]) -> str:
    """Returns a hash of names, roles, weights and samples, the same wherever the file lies."""
    total = hashlib.sha256()
    for curve in curves:
        total.update(f"{curve.name}\n{curve.role}\n{curve.weight}\n{curve.angle.size}\n".encode())
        total.update(curve.angle.tobytes() + curve.torque.tobytes())
    return total.hexdigest()[:16]


def is_multi_order(curve: Curve) -> bool:
    """Returns whether a curve turns more than once, which no first-order one does."""
    return reversals(curve.angle).size > 1


def run_trial(config: StudyConfig, key: TrialKey, curves: Sequence[Curve]) -> StudyTrial:
    """Runs one trial on all curves of its joint, those with role "predict" kept out of the fit.

    Raises:
        InputError: The curves are unusable, or the method's package is not installed.
    """
    family = Curves(curves)
    measured, rng = family.fitted(), np.random.default_rng(config.seed_of(key))
    final = CurveObjective(measured, loss="paper")
    safe_range = None
    if key.method == "certified":
        fit = certified_fit(measured, rng=rng)
        parameters, evaluations, safe_range = fit.parameters, fit.evaluations, fit.safe_range
        fitness = float(final(parameters)[0])
        improvements = [(spent, best / fit.nrmse * fitness) for spent, best in fit.history]
    else:
        objective = CurveObjective(measured, loss="paper")
        run = run_optimizer(objective, key.method, rng, config.options_of(key.method))
        parameters, improvements = run.row, run.improvements
        fitness, evaluations = float(final(parameters)[0]), objective.evaluations
    return StudyTrial(
        key=key,
        parameters=tuple(map(float, parameters)),
        safe_range=safe_range,
        fitness=fitness,
        nrmse=float(final.nrmse(parameters)[0]),
        evaluations=evaluations,
        improvements=tuple(improvements),
        predictions={c.name: _prediction(c, parameters, final.peak) for c in family.held_out()},
    )


def check(config: StudyConfig, families: Mapping[str, Sequence[Curve]]) -> None:
    """Raises what would stop the trials before any of them has run.

    Raises:
        InputError: Curves are unusable, or a method's package is not installed.
    """
    for joint, curves in families.items():
        samples = CurveObjective(Curves(curves).fitted()).torque.size
        if samples < FEWEST_SAMPLES:
            raise InputError(
                f"the fitted curves of {joint} have {samples} samples in all: give at least "
                f"{FEWEST_SAMPLES}"
            )


def _prediction(curve: Curve, parameters: NDArray[np.float64], peak: float) -> Prediction:
    error = CurveObjective([curve]).responses(parameters)[0] - curve.torque
    if not np.isfinite(error).all():
        return Prediction(np.inf, np.inf)
    return Prediction(float(np.abs(error).max()), float(np.sqrt(np.mean(error**2))) / peak)
