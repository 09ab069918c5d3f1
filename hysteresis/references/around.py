"""Readable references of models around another, and examples of all of them."""

import copy
import math

import numpy as np

from ...arrays import Array
from ..around.asymmetric import Asymmetric
from ..around.backlash import Backlash
from ..around.clipped import Clipped
from ..around.viscoelastic import Viscoelastic
from ..jiles_atherton import TABLE_2
from .reference import Example, Reference, reference_of, refers_to


@refers_to(Asymmetric)
class AsymmetricReference(Reference):
    """The reference of the inner model, plus the polynomial."""

    def __init__(self, model: Asymmetric, angles: Array, torque: float) -> None:
        super().__init__(angles[0], torque)
        self.coefficients = [float(p) for p in model.polynomial]
        self.inner = reference_of(model.model, angles, torque - self.polynomial(self.angle))

    def polynomial(self, angle: float) -> float:
        """Returns the elastic torque [N·m]."""
        return sum(p * angle**i for i, p in enumerate(self.coefficients))

    def _torque_after(self, angle: float) -> float:
        return self.inner.move(angle) + self.polynomial(angle)

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] on the present branch; see `Reference.slope`."""
        bend = sum(i * p * angle ** (i - 1) for i, p in enumerate(self.coefficients) if i)
        return self.inner.slope(angle, torque - self.polynomial(angle), delta) + bend

    def knots(self, end: float) -> list[float]:
        """Returns the knots of the inner reference [rad]; the polynomial is smooth."""
        return self.inner.knots(end)


@refers_to(Clipped)
class HeldReference(Reference):
    """The reference of the inner model, moved to angles inside the range only."""

    def __init__(self, model: Clipped, angles: Array, torque: float) -> None:
        super().__init__(angles[0], torque)
        self.range = model.angle_range
        self.inner = reference_of(model.model, np.clip(angles, *self.range), torque)

    def _torque_after(self, angle: float) -> float:
        return self.inner.move(float(np.clip(angle, *self.range)))

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] on the present branch; see `Reference.slope`."""
        inside = self.range[0] < angle < self.range[1]
        return self.inner.slope(angle, torque, delta) if inside else 0.0

    def knots(self, end: float) -> list[float]:
        """Returns the ends of the range and the knots of the inner reference [rad]."""
        return [*self.range, *self.inner.knots(end)]


@refers_to(Backlash)
class BacklashReference(Reference):
    """The reference of the inner model at the angle of the suit's side, by the law of contact."""

    def __init__(self, model: Backlash, angles: Array, torque: float) -> None:
        super().__init__(angles[0], torque)
        self.half = model.gap / 2
        self.end = self.angle - (math.copysign(self.half, torque) if torque else 0.0)
        # The suit's side may turn on either face of the gap, and where contact opens.
        reached = np.concatenate([[self.end], angles - self.half, angles + self.half])
        self.range = float(reached.min()), float(reached.max())
        self.ways: dict[float, tuple[float, float]] = {}  # the present branch's ends by direction
        self.inner = reference_of(model.model, reached, torque)

    def _ahead(self, end: float) -> float:
        return copy.deepcopy(self.inner).move(end)

    def _rest(self, farthest: float) -> float:
        """Returns where the suit's side rests [rad] if the joint lets it move up to `farthest`."""
        if abs(self.torque) <= 1e-9:
            return self.end
        if self._ahead(farthest) * self.torque >= 0:
            return farthest
        from scipy.optimize import brentq  # SciPy takes long to import

        return float(brentq(self._ahead, self.end, farthest, xtol=1e-14))  # type: ignore[arg-type]

    def _torque_after(self, angle: float) -> float:
        self.ways.clear()
        push = math.copysign(1.0, self.torque)
        face = angle - push * self.half
        away = push * (self.end - face) > 0
        rest = self._rest(face) if away else self.end
        if abs(self.torque) > 1e-9 and not away:
            rest = face
        self.end = min(max(rest, angle - self.half), angle + self.half)
        return self.inner.move(self.end)

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] on the present branch; see `Reference.slope`."""
        opens, closes = self._way(delta)
        if opens < delta * angle < closes:
            return 0.0
        face = delta if delta * angle >= closes else -delta
        return self.inner.slope(angle - face * self.half, torque, delta)

    def knots(self, end: float) -> list[float]:
        """Returns where contact opens and closes [rad], and the knots of the inner reference."""
        delta = math.copysign(1.0, end - self.angle)
        inner = self.inner.knots(end - delta * self.half)
        faces = [knot + side * self.half for knot in inner for side in (1, -1)]
        return [*(delta * knot for knot in self._way(delta)), *faces]

    def _way(self, delta: float) -> tuple[float, float]:
        if delta not in self.ways:
            self.ways[delta] = self._free(delta)
        return self.ways[delta]

    def _free(self, delta: float) -> tuple[float, float]:
        """Returns the ends of the free way, as angles times `delta`; the first may be behind."""
        loaded = abs(self.torque) > 1e-9
        if loaded and self.torque * delta > 0:
            return -math.inf, -math.inf
        rest = self._rest(self.range[int(delta > 0)]) if loaded else self.end
        opens = delta * rest - self.half if loaded else -math.inf
        return opens, delta * rest + self.half


@refers_to(Viscoelastic)
def slow(model: Viscoelastic, angles: Array, torque: float) -> Reference:
    """Returns the reference of the inner model, which is that of slow motions."""
    return reference_of(model.model, angles, torque)


_ELBOW = TABLE_2["elbow-sa-pso"]
CLIPPED_EXAMPLES = (
    Example(
        name="elbow-sa-pso in a range",
        model=Clipped(model=_ELBOW, angle_range=(0.7, 1.3)),
        low=0.52,
        high=1.57,
    ),
)
ASYMMETRIC_EXAMPLES = (
    Example(
        name="asymmetric, elbow-sa-pso",
        model=Asymmetric(model=_ELBOW, polynomial=[0.3, -0.5, 0.8]),
        low=0.52,
        high=1.57,
    ),
)
VISCOELASTIC_EXAMPLES = (
    Example(
        name="viscoelastic, elbow-sa-pso",
        model=Viscoelastic(model=_ELBOW, damping=0.2),
        low=0.52,
        high=1.57,
    ),
)
BACKLASH_EXAMPLES = (
    Example(
        name="backlash, elbow-sa-pso",
        model=Backlash(model=_ELBOW, gap=0.05),
        low=0.52,
        high=1.57,
    ),
    Example(
        name="backlash, asymmetric, elbow-sa-pso",
        model=Backlash(model=Asymmetric(model=_ELBOW, polynomial=[0.3, -0.5, 0.8]), gap=0.05),
        low=0.52,
        high=1.57,
    ),
)
