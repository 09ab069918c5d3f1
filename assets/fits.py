"""Protocols of a fit, as a suit reads it: its model, and the measured curves behind it."""

from typing import Protocol, runtime_checkable

from ..hysteresis import HysteresisModel


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


class FittedSoftening(Protocol):
    """How the torque changes over cycles, relative to that of the model."""

    @property
    def first(self) -> float:
        """Torque of the first cycle."""
        ...

    @property
    def steady(self) -> float:
        """Torque after many cycles."""
        ...

    @property
    def cycles(self) -> float:
        """Number of cycles in which the difference falls to 1/e."""
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

    @property
    def softening(self) -> FittedSoftening | None:
        """How the torque changes over cycles; None if that was not fitted."""
        ...
