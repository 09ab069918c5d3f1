"""One joint of a suit: its hysteresis model, and the source of the numbers."""

import math
from collections.abc import Sequence
from typing import Annotated, Any, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    FiniteFloat,
    InstanceOf,
    PlainSerializer,
    ValidationError,
    model_validator,
)

from ..arrays import Array
from ..checks import number
from ..errors import LONGEST_VALUE, InputError, shortened, shown
from ..hysteresis import HysteresisModel, State, SteadyCycle, model_from_dict, steady_cycle
from ..hysteresis.around import Backlash, Viscoelastic, sprung, without_rate
from ..hysteresis.certificate import ALL_ANGLES
from ..hysteresis.protocol import finite_series, follow

JOINTS = ("shoulder_abduction", "shoulder_flexion", "elbow_flexion", "wrist_flexion")
MOST_SOFTENING = 10.0  # largest ratio of two torques: far beyond any suit
MOST_DAMPING = 1e3  # [N·m·s/rad], more resistance at usual rates than any motor's torque
Grade = Literal["published", "identified", "assumed"]


def _model(given: Any) -> HysteresisModel:
    return given if isinstance(given, HysteresisModel) else model_from_dict(given)


def _number(given: Any) -> Any:
    if isinstance(given, str | bool):
        raise ValueError(f"give a number, without quotes, not {shown(given)}")
    return given


Number = Annotated[FiniteFloat, BeforeValidator(_number)]
Model = Annotated[
    InstanceOf[HysteresisModel],
    BeforeValidator(_model),
    PlainSerializer(lambda model: model.to_dict()),
]


@runtime_checkable
class FittedModel(Protocol):
    """A model that was identified from curves, such as a fit of `activesuit.identification`.

    Attributes:
        model: The identified model.
        method: Name of the method of identification.
        initial_torque: Torque with which all curves begin [N·m]; "measured" means that each curve
            begins with its own first torque.
        nrmse: Error on the fitted curves over their largest torque.
        curves: The measured `Curves`, with the curves that were kept out of the fit.
        softening: Change of the torque over cycles, with `first`, `steady` and `cycles`; None if
            the change was not fitted.
    """

    @property
    def model(self) -> HysteresisModel: ...  # noqa: D102
    @property
    def method(self) -> str: ...  # noqa: D102
    @property
    def initial_torque(self) -> float | str: ...  # noqa: D102
    @property
    def nrmse(self) -> float: ...  # noqa: D102
    @property
    def curves(self) -> Any: ...  # noqa: D102
    @property
    def softening(self) -> Any: ...  # noqa: D102


class Strict(BaseModel):
    """A part of a suit file; unknown fields raise an error."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Softening(Strict):
    """Change of the torque of a joint over cycles of motion, relative to the torque of its model.

    After n cycles the torque is steady + (first - steady) exp(-n / cycles) times the torque of the
    model. Fabric and bladders that wear in soften (first > steady); creep is a drift.

    Attributes:
        first: Torque of the first cycle over the model's torque, above 0 and at most 10.
        steady: Torque after many cycles over the model's torque, above 0 and at most 10.
        cycles: Number of cycles in which the difference falls to 1/e, > 0.
    """

    first: Annotated[Number, Field(gt=0, le=MOST_SOFTENING)]
    steady: Annotated[Number, Field(gt=0, le=MOST_SOFTENING)] = 1.0
    cycles: Annotated[Number, Field(gt=0)]

    @model_validator(mode="after")
    def _changes_little(self) -> "Softening":
        if not 1 / MOST_SOFTENING <= self.first / self.steady <= MOST_SOFTENING:
            raise ValueError(
                f"first is {self.first:g} and steady {self.steady:g}: both are factors of the "
                f"model's torque, of which one is at most {MOST_SOFTENING:g} times the other"
            )
        return self

    def factor(self, cycles: float) -> float:
        """Returns the torque after a number of cycles (also `inf`) over the torque of the model."""
        return self.steady + (self.first - self.steady) * math.exp(-cycles / self.cycles)


class SuitJoint(Strict):
    """The resistance of one joint and its provenance.

    Attributes:
        model: Any hysteresis model; the file holds its `to_dict`.
        samples: Other models that the data allow too, for randomization.
        left_open: Phrases about effects that the data do not determine and the samples lack.
        range: Lowest and highest angle [rad] at which the model was identified or may be used.
        start_angle: Angle at which the memory of the joint begins [rad].
        start_torque: Resistance at that angle [N·m].
        start_path: Turning angles of the motion before the start [rad]; the memory is then at the
            last angle. Without a path, the joint begins on the virgin curve.
        volume_share: Share of the joint's elastic torque that the displaced gas causes, 0 to 1;
            this share alone changes with the pressure, and `source` gives its evidence. None means
            unknown: the whole torque is then assumed, without a measurement, to be proportional to
            the pressure.
        softening: Change of the torque over the cycles of motion; None if the torque does not
            change, or if the change is not known. A suit begins with its first cycle, a
            preconditioned suit after many cycles.
        grade: Grade of the numbers: published (printed in a paper), identified (fitted to curves)
            or assumed.
        source: Source of the numbers, in words.
        data_sha256: Hash of the curve file; None if the model was not identified.
        fit_nrmse: NRMSE on the fitted curves; None if the model was not identified.
        certificate_margin: Margin of the model's certificate when the file was made.
    """

    model: Model
    samples: tuple[Model, ...] = ()
    left_open: tuple[str, ...] = ()
    range: tuple[Number, Number]
    start_angle: Number
    start_torque: Number = 0.0
    start_path: tuple[Number, ...] = ()
    volume_share: Number | None = None
    softening: Softening | None = None
    grade: Grade
    source: str
    data_sha256: str | None = None
    fit_nrmse: Number | None = None
    certificate_margin: Number | None = None

    @classmethod
    def from_model(cls, model: HysteresisModel, **provenance: Any) -> "SuitJoint":
        """Returns the joint of a model; `provenance` holds the other fields, except the margin."""
        margin = model.certificate().margin
        try:
            return cls(model=model, certificate_margin=margin, **provenance)
        except ValidationError as error:
            raise InputError(first_problem(error)) from error

    @classmethod
    def from_fit(
        cls,
        fit: FittedModel,
        *,
        samples: Sequence[HysteresisModel] = (),
        left_open: Sequence[str] = (),
    ) -> "SuitJoint":
        """Returns the joint of a fit, with the start, the range and the source of the curves.

        Args:
            fit: Result of `activesuit.identification.identify`.
            samples: Other models that the curves allow too, as `uncertainty` draws them.
            left_open: Phrases about effects that the curves do not determine and the samples lack.
        """
        if not isinstance(fit, FittedModel):
            raise InputError(f"fit is {shown(fit)}: give the fit of identify")
        curves, fitted = fit.curves, fit.curves.fitted()
        start = fit.initial_torque
        file = f" of {curves.source}" if curves.source else ""
        change = fit.softening
        terms = {name: getattr(change, name, None) for name in Softening.model_fields}
        return cls.from_model(
            fit.model,
            samples=tuple(samples),
            left_open=tuple(left_open),
            range=curves.angle_range,
            start_angle=curves.start_angle,
            start_torque=fitted.start_torque if isinstance(start, str) else start,
            grade="identified",
            source=f"{fit.method} fit{file}, curves {', '.join(fitted.names)}.",
            data_sha256=curves.sha256,
            fit_nrmse=fit.nrmse,
            softening=None if change is None else Softening.model_validate(terms),
        )

    @model_validator(mode="after")
    def _numbers_are_possible(self) -> "SuitJoint":
        if not self.range[0] < self.range[1]:
            raise ValueError(
                f"range is {list(self.range)}: the first angle must be the smaller one"
            )
        if max(map(abs, (*self.range, self.start_angle))) > 2 * math.pi:
            raise ValueError(
                f"range is {list(self.range)} and start_angle {self.start_angle}: more than a full "
                "turn; both are radians"
            )
        for i, angle in enumerate(self.start_path):
            if abs(angle) > 2 * math.pi:
                raise ValueError(
                    f"start_path[{i}] is {angle}: more than a full turn; angles are radians"
                )
        if self.volume_share is not None and not 0 <= self.volume_share <= 1:
            raise ValueError(
                f"volume_share is {self.volume_share:g}: give the share of the elastic torque that "
                "the gas makes, 0 to 1, or leave it out if it is not known"
            )
        return self

    @model_validator(mode="after")
    def _models_are_possible(self) -> "SuitJoint":
        for i, sample in enumerate(self.samples):
            if is_safe(self.model) and not is_safe(sample):
                raise ValueError(
                    f"samples[{i}] has certificate margin {sample.certificate().margin:.3g}, but "
                    "the model itself is certified: remove that sample"
                )
        low, high = self.range
        for model in (self.model, *self.samples):
            if isinstance(model, Viscoelastic) and model.damping > MOST_DAMPING:
                raise ValueError(
                    f"damping is {model.damping:g} N·m·s/rad: give at most {MOST_DAMPING:g}"
                )
            inner = without_rate(model)
            if isinstance(inner, Backlash) and inner.gap >= high - low:
                raise ValueError(
                    f"gap is {inner.gap:g} rad: give less than the range, {high - low:.3g} rad"
                )
        return self

    def begun(self) -> State:
        """Returns the memory with which the joint begins, after its path."""
        start = self.model.start(self.start_angle, self.start_torque)
        return follow(self.model, start, self.start_path)

    def response(
        self, angle: ArrayLike, model: HysteresisModel | None = None, time: ArrayLike | None = None
    ) -> Array:
        """Computes the resistance along a motion that continues from the start of the memory.

        Args:
            angle: Joint angles [rad], shape (n,).
            model: One of `samples`; by default the joint's own model.
            time: Time of each angle [s], shape (n,), for a viscoelastic model. Without times the
                motion is infinitely slow; the motion up to the start is always infinitely slow.

        Returns:
            Resistance [N·m], shape (n,).

        Raises:
            PoleError: The motion meets the pole of an uncertified model.
        """
        before = (self.start_angle, *self.start_path)
        model = model or self.model
        motion = np.concatenate([before, finite_series("angle", angle, "rad")])
        torque = model.response(motion, self.start_torque)[len(before) :]
        if time is None or not isinstance(model, Viscoelastic):
            return torque
        return torque + model.rate_torque(angle, time)

    def steady_cycle(self, model: HysteresisModel | None = None) -> SteadyCycle:
        """Returns the steady cycle over the joint's range, which repeats itself.

        Args:
            model: One of `samples`; by default the joint's own model.

        Raises:
            InputError: The cycles do not become steady.
            PoleError: The motion meets the pole of an uncertified model.
        """
        start = {"start_angle": self.start_angle, "start_torque": self.start_torque}
        return steady_cycle(model or self.model, self.range, **start)

    def preconditioned(self) -> "SuitJoint":
        """Returns the joint whose memory begins in the steady cycle over its range.

        From the start the motion makes as many cycles as the model and all samples need to become
        steady, and then goes from the lower end up to the start angle. Errors are as in
        `steady_cycle`.
        """
        models = (self.model, *self.samples)
        cycles = max(self.steady_cycle(model).cycles for model in models)
        path = (*self.range * cycles, self.range[0], self.start_angle)
        return self.model_copy(update={"start_path": path})

    def after(self, cycles: float) -> "SuitJoint":
        """Returns the joint as after a number of cycles of motion, with its certificate unchanged.

        Cycles count from the new joint, so that `after(10).after(20)` is the same as `after(20)`.

        Args:
            cycles: Number of cycles since the joint was new, 0 or more, also infinite.
        """
        if not isinstance(cycles, int | float) or not cycles >= 0:
            raise InputError(f"cycles is {cycles}: give a number of cycles, 0 or more")
        if self.softening is None:
            return self
        factor = self.softening.factor(cycles)
        if factor == 1:
            return self
        first, steady = self.softening.first / factor, self.softening.steady / factor
        changes = {
            "model": self.model.scaled(torque=factor),
            "samples": tuple(sample.scaled(torque=factor) for sample in self.samples),
            "start_torque": factor * self.start_torque,
            "softening": Softening(first=first, steady=steady, cycles=self.softening.cycles),
            "source": f"{self.source}; after {cycles:g} cycles, {factor:.3g} times that torque",
        }
        return self.model_copy(update=changes)

    def at_pressure_ratio(self, ratio: float) -> "SuitJoint":
        """Returns the joint at `ratio` times the pressure at which its torque was measured.

        Without a volume share the whole torque is proportional to the pressure, friction included,
        and the ratio must be above 0. With a volume share the torque of the gas is added: (ratio -
        1) times that share of the straight line through the middle of the steady cycle. The added
        torque is conservative, so the loop keeps its width, certificate and dissipated energy.
        Samples get the line of the model. Errors are as in `steady_cycle`.
        """
        if self.volume_share is None:
            return self.scaled(torque=ratio)
        if number("ratio", ratio) < 0:
            raise InputError(f"ratio is {ratio:g}: give a ratio of pressures, 0 or more")
        factor = (ratio - 1) * self.volume_share
        offset, stiffness = self.steady_cycle().spring()
        changes = self._with_line(factor * offset, factor * stiffness) | {
            "volume_share": ratio * self.volume_share / (1 + factor) if ratio else 0.0,
            "source": f"{self.source}; then {ratio:.3g} times the pressure, which changes "
            f"{self.volume_share:.3g} of the elastic torque",
        }
        return SuitJoint(**(dict(self) | changes))

    def apart(
        self, spring: float, loop: float, line: tuple[float, float] | None = None
    ) -> "SuitJoint":
        """Returns the joint with `spring` times its elastic torque and `loop` times all else.

        The elastic torque is the straight line through the middle of the steady cycle over the
        joint's range, and the line goes on outside. All else is the loop about the line, with its
        bends, memory and friction. A line dissipates nothing, so that the certificate stays.
        Samples get the line of the model.

        Args:
            spring: Factor of the elastic torque.
            loop: Factor of the loop, above 0.
            line: Torque at angle 0 [N·m] and stiffness [N·m/rad] of the elastic torque, where they
                are known; by default those of `steady_cycle().spring()`, whose errors are possible.
        """
        offset, stiffness = self.steady_cycle().spring() if line is None else line
        more = spring - loop
        return self.model_copy(update=self._with_line(more * offset, more * stiffness, loop))

    def _with_line(self, offset: float, stiffness: float, loop: float = 1.0) -> dict[str, Any]:
        """Returns the fields of a joint with `loop` times the torque of this one, and a line."""
        models = (self.model, *self.samples)
        if loop != 1:
            models = tuple(model.scaled(torque=loop) for model in models)
        model, *samples = (sprung(one, offset, stiffness) for one in models)
        begins = loop * self.start_torque + offset + stiffness * self.start_angle
        return {"model": model, "samples": tuple(samples), "start_torque": begins}

    def scaled(self, *, torque: float) -> "SuitJoint":
        """Returns a joint with `torque` times the resistance and a note in its source."""
        model = self.model.scaled(torque=torque)
        changes = {
            "model": model,
            "samples": tuple(sample.scaled(torque=torque) for sample in self.samples),
            "start_torque": torque * self.start_torque,
            "certificate_margin": self.certificate_margin and model.certificate().margin,
            "source": f"{self.source}; then {torque:.3g} times that torque",
        }
        return SuitJoint(**(dict(self) | changes))


def first_problem(error: ValidationError) -> str:
    """Returns the first error in the fields of a suit, and its fix, as a sentence."""
    problem: Any = error.errors()[0]
    place = ".".join(
        shortened(str(part), LONGEST_VALUE) for part in problem["loc"] if part != "[key]"
    )
    place = place or "the file"
    if problem["type"] == "extra_forbidden":
        return f"{place} is not a known field: remove it"
    if problem["type"] == "literal_error":
        return f"{place} is {shown(problem['input'])}: use {problem['ctx']['expected']}"
    if problem["type"] == "missing":
        return f"{place} is missing: add it"
    if problem["type"] == "value_error":  # ours, which names the value
        return f"{place}: {problem['ctx']['error']}"
    value = problem["input"]
    return f"{place}: {problem['msg']}" + (
        "" if isinstance(value, (dict, list)) else f" (it is {shown(value)})"
    )


def is_safe(model: HysteresisModel, angle_range: tuple[float, float] = ALL_ANGLES) -> bool:
    """Returns whether a model is certified and dissipative at the angles of a range [rad]."""
    certificate = model.certificate(angle_range)
    return certificate.certified and certificate.dissipative
