"""One joint of a suit: its hysteresis model, and where the numbers come from."""

import math
from collections.abc import Sequence
from typing import Annotated, Any, Literal, Protocol, get_args, runtime_checkable

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    FiniteFloat,
    InstanceOf,
    PlainSerializer,
    ValidationError,
    model_validator,
)

from ..errors import LONGEST_VALUE, InputError, shortened, shown
from ..hysteresis import HysteresisModel, model_from_dict

JOINTS = ("shoulder_abduction", "shoulder_flexion", "elbow_flexion", "wrist_flexion")
Grade = Literal["published", "identified", "assumed"]
GRADES: tuple[str, ...] = get_args(Grade)


def _model(given: Any) -> HysteresisModel:
    return given if isinstance(given, HysteresisModel) else model_from_dict(given)


Model = Annotated[
    InstanceOf[HysteresisModel],
    BeforeValidator(_model),
    PlainSerializer(lambda model: model.to_dict()),
]


class Strict(BaseModel):
    """A part of a suit file; unknown fields raise an error."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class FittedCurves(Protocol):
    """The measured curves of one joint, and the file they come from."""

    source: str
    sha256: str | None

    @property
    def names(self) -> list[str]:
        """The names of the curves."""
        ...

    @property
    def angle_range(self) -> tuple[float, float]:
        """The smallest and the largest angle of all curves [rad]."""
        ...

    @property
    def start_angle(self) -> float:
        """The angle at which the first curve begins [rad]."""
        ...

    @property
    def start_torque(self) -> float:
        """The mean torque with which the curves begin [N·m]."""
        ...

    def fitted(self) -> "FittedCurves":
        """Returns the curves that the model was fitted to."""
        ...


@runtime_checkable
class FittedModel(Protocol):
    """A model that was identified from curves, such as a fit of `activesuit.identification`."""

    @property
    def model(self) -> HysteresisModel:
        """The identified model."""
        ...

    @property
    def method(self) -> str:
        """The name of the method that found it."""
        ...

    @property
    def initial_torque(self) -> float | str:
        """The torque with which all curves begin [N·m]; or "measured", each with its own."""
        ...

    @property
    def nrmse(self) -> float:
        """The error on the fitted curves over their largest torque."""
        ...

    @property
    def curves(self) -> FittedCurves:
        """The measured curves, also those that were kept out of the fit."""
        ...


class SuitJoint(Strict):
    """The resistance of one joint and its provenance.

    Attributes:
        model: Any hysteresis model; the file holds its `to_dict`.
        samples: Other models that the data allow too, to randomize with.
        range: Lowest and highest angle [rad] at which the model was identified or may be used.
        start_angle: Angle at which the memory of the joint begins [rad].
        start_torque: Resistance at that angle [N·m].
        grade: Grade of the numbers: published (printed in a paper), identified (fitted to curves)
            or assumed.
        source: Source of the numbers, in words.
        data_sha256: Hash of the curve file; None if the model was not identified.
        fit_nrmse: NRMSE on the fitted curves; None if the model was not identified.
        certificate_margin: Margin of the model's certificate when the file was made.
    """

    model: Model
    samples: tuple[Model, ...] = ()
    range: tuple[FiniteFloat, FiniteFloat]
    start_angle: FiniteFloat
    start_torque: FiniteFloat = 0.0
    grade: Grade
    source: str
    data_sha256: str | None = None
    fit_nrmse: FiniteFloat | None = None
    certificate_margin: FiniteFloat | None = None

    @classmethod
    def from_model(cls, model: HysteresisModel, **provenance: Any) -> "SuitJoint":
        """Returns the joint of a model; `provenance` holds the other fields, except the margin.

        Raises:
            InputError: A field is missing, unknown or wrong.
        """
        margin = model.certificate().margin
        try:
            return cls(model=model, certificate_margin=margin, **provenance)
        except ValidationError as error:
            raise InputError(first_problem(error)) from error

    @classmethod
    def from_fit(
        cls, fit: FittedModel, *, note: str = "", samples: Sequence[HysteresisModel] = ()
    ) -> "SuitJoint":
        """Returns the joint of a fit, whose source is the curves of the fit.

        The memory of the joint begins where the curves begin, and its range is theirs.

        Args:
            fit: Result of `activesuit.identification.identify`.
            note: Sentence that is added to the source.
            samples: Other models that the curves allow too, as `uncertainty` draws them.

        Raises:
            InputError: `fit` is no fit, or a sample is less safe than the model.
        """
        if not isinstance(fit, FittedModel):
            raise InputError(f"fit is {shown(fit)}: give what identify returned")
        curves, fitted = fit.curves, fit.curves.fitted()
        start = fit.initial_torque
        file = f" of {curves.source}" if curves.source else ""
        source = f"{fit.method} fit{file}, curves {', '.join(fitted.names)}."
        return cls.from_model(
            fit.model,
            samples=tuple(samples),
            range=curves.angle_range,
            start_angle=curves.start_angle,
            start_torque=fitted.start_torque if isinstance(start, str) else start,
            grade="identified",
            source=f"{source} {note}" if note else source,
            data_sha256=curves.sha256,
            fit_nrmse=fit.nrmse,
        )

    @model_validator(mode="after")
    def _angles_are_radians(self) -> "SuitJoint":
        if not self.range[0] < self.range[1]:
            raise ValueError(
                f"range is {list(self.range)}: the first angle must be the smaller one"
            )
        if max(map(abs, (*self.range, self.start_angle))) > 2 * math.pi:
            raise ValueError(
                f"range is {list(self.range)} and start_angle {self.start_angle}: more than a full "
                "turn; both are radians"
            )
        return self

    @model_validator(mode="after")
    def _samples_are_as_safe(self) -> "SuitJoint":
        for i, sample in enumerate(self.samples):
            if _is_safe(self.model) and not _is_safe(sample):
                raise ValueError(
                    f"samples[{i}] has certificate margin {sample.certificate().margin:.3g}, but "
                    "the model itself is certified: remove that sample"
                )
        return self

    def scaled(self, *, torque: float) -> "SuitJoint":
        """Returns the joint with `torque` times the resistance; its source then says so.

        Raises:
            InputError: `torque` is not finite or not above 0.
        """
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


def _is_safe(model: HysteresisModel) -> bool:
    certificate = model.certificate()
    return certificate.certified and certificate.dissipative
