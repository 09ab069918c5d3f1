"""Readable references of the models, and motions with which tests and benchmarks examine them."""

import copy
import math
from itertools import pairwise

import numpy as np

from ...arrays import Array
from ...hysteresis import (
    TABLE_2,
    Asymmetric,
    Backlash,
    BoucWen,
    Clipped,
    Dahl,
    Duhem,
    HingedStops,
    JilesAtherton,
    PrandtlIshlinskii,
    Preisach,
    Viscoelastic,
)
from ...published import LI_RANGES
from .reference import Example, Reference, reference_of, refers_to, runge_kutta, turn_indices

FIELD_STEP = 0.05  # degrees, longest Runge-Kutta step of Jiles-Atherton
ANGLE_STEP = 1e-3  # rad, longest Runge-Kutta step of the other models


@refers_to(JilesAtherton)
class JilesAthertonReference(Reference):
    """Eq. (4) of Li et al. 2022 as printed, by classical Runge-Kutta steps in H."""

    def __init__(self, model: JilesAtherton, angles: Array, torque: float) -> None:
        super().__init__(angles[0], torque)
        self.model = model
        self.unit = 180 / math.pi if model.angle_unit == "deg" else 1.0

    def equation(self, H: float, M: float, delta: float) -> float:
        """Returns dM/dH in the unit of the parameters."""
        Ms, a, alpha, c, k = (getattr(self.model, name) for name in ("Ms", "a", "alpha", "c", "k"))
        L, dL = langevin((H + alpha * M) / a)
        numerator = Ms * L - M + c * delta * k * Ms / a * dL
        return numerator / (delta * k - alpha * numerator)

    def _torque_after(self, angle: float) -> float:
        H, end = self.angle * self.unit, angle * self.unit
        steps = math.ceil(abs(angle - self.angle) * 180 / math.pi / FIELD_STEP)
        h, M = (end - H) / steps, self.torque
        for i in range(steps):
            M = runge_kutta(self.equation, H + i * h, M, h)
        return M

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] on the present branch; see `Reference.slope`."""
        return self.equation(angle * self.unit, torque, delta) * self.unit


def langevin(x: float) -> tuple[float, float]:
    """Returns L(x) = coth x - 1/x and L'(x), also of complex x; near 0 the closed forms cancel."""
    if abs(x) < 0.05:
        L = x / 3 - x**3 / 45 + 2 * x**5 / 945 - x**7 / 4725
        return L, 1 / 3 - x**2 / 15 + 2 * x**4 / 189 - x**6 / 675
    return 1 / np.tanh(x) - 1 / x, 1 / x**2 - 1 / np.sinh(x) ** 2


_JILES_ATHERTON = tuple(
    Example(name=f"J-A {name}", model=model, low=low, high=high)
    for name, model in TABLE_2.items()
    for low, high in [LI_RANGES[name.partition("-")[0]]]
)


@refers_to(BoucWen)
class BoucWenReference(Reference):
    """The differential equation of z as printed in `BoucWen`, by classical Runge-Kutta steps."""

    def __init__(self, model: BoucWen, angles: Array, torque: float) -> None:
        super().__init__(angles[0], torque)
        self.model = model
        self.z = self.z_of(self.angle, self.torque)

    def z_of(self, angle: float, torque: float) -> float:
        """Returns z [rad], computed from the torque."""
        elastic = self.model.elastic * (angle - self.model.rest_angle)
        return (torque - elastic) / self.model.hysteretic

    def equation(self, _: float, z: float, delta: float) -> float:
        """Returns dz/dtheta of a motion with the sign `delta`."""
        m = self.model
        return m.A - delta * m.beta * abs(z) ** (m.n - 1) * z - m.gamma * abs(z) ** m.n

    def step(self, z: float, h: float) -> float:
        """Returns z after a small motion h; steps across the kink at z = 0 are halved."""
        after = runge_kutta(self.equation, 0.0, z, h)
        if z * after < 0 and abs(h) > 1e-9:
            return self.step(self.step(z, h / 2), h / 2)
        return after

    def _torque_after(self, angle: float) -> float:
        steps = math.ceil(abs(angle - self.angle) / ANGLE_STEP)
        for _ in range(steps):
            self.z = self.step(self.z, (angle - self.angle) / steps)
        return self.model.elastic * (angle - self.model.rest_angle) + self.model.hysteretic * self.z

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] on the present branch; see `Reference.slope`."""
        dz = self.equation(angle, self.z_of(angle, torque), delta)
        return self.model.elastic + self.model.hysteretic * dz

    def knots(self, end: float) -> list[float]:
        """Returns the angle [rad] at which z is zero."""
        angle, z, h = self.angle, self.z, math.copysign(ANGLE_STEP, end - self.angle)
        while z * h < 0 < (end - angle) * h and abs(h) > 1e-12:
            after = runge_kutta(self.equation, 0.0, z, h)
            if z * after < 0:
                h /= 2
            else:
                angle, z = angle + h, after
        return [angle]


_YIELDS = {"elastic": 3.0, "hysteretic": 9.0, "beta": 4.0, "rest_angle": 0.1}
_BOUC_WEN = (
    Example(name="bouc-wen, n = 1", model=BoucWen(**_YIELDS, gamma=1, n=1), low=-1, high=1),
    Example(name="bouc-wen, n = 1.7", model=BoucWen(**_YIELDS, gamma=-1, n=1.7), low=-1, high=1),
)


@refers_to(Preisach)
class PreisachReference(Reference):
    """The half plane of relays cut into patches, and the share of each patch that is up.

    The cuts are the levels and all turning points of the motion, so that at each turn a patch is
    either all up or all down. Between turns the shares are exact areas, of a rectangle or, for a
    patch on the diagonal, of a triangle.
    """

    def __init__(self, model: Preisach, angles: Array, torque: float) -> None:
        levels = self.levels = np.array(model.levels)
        self.elastic_slopes = np.array(model.elastic)
        cuts = np.clip(angles[[0, *turn_indices(angles)]], levels[0], levels[-1])
        self.grid = np.unique([*levels, *cuts])
        width = np.diff(self.grid)
        cell = np.searchsorted(levels, self.grid[:-1], side="right") - 1
        part = width / np.diff(levels)[cell]
        row, column = np.tril_indices(width.size)  # levels of switching up and down
        weight = [model.density[i][j] for i, j in zip(cell[row], cell[column], strict=True)]
        # A cell on the diagonal is a triangle: patches in it have twice the share, or are halves.
        whole = np.where(cell[row] == cell[column], 2.0, 1.0) * np.where(row == column, 0.5, 1.0)
        self.weight = np.array(weight) * part[row] * part[column] * whole
        self.power = np.where(row == column, 2, 1)
        self.up_from, self.down_from = self.grid[row], self.grid[column + 1]
        self.up_width, self.down_width = width[row], width[column]
        self.up = self.risen(angles[0])
        self.offset = torque - self.elastic(angles[0]) + self.weight @ self.up
        super().__init__(angles[0], torque)

    def risen(self, angle: float) -> Array:
        """Returns the share of each patch that a rise to `angle` from far below switches up."""
        return np.clip((angle - self.up_from) / self.up_width, 0, 1) ** self.power

    def fallen(self, angle: float) -> Array:
        """Returns the share of each patch that a fall to `angle` from far above switches down."""
        return np.clip((self.down_from - angle) / self.down_width, 0, 1) ** self.power

    def elastic(self, angle: float) -> float:
        """Returns the torque [N·m] of the elastic part, from 0 at the lowest level."""
        ends = [-math.inf, *self.levels[1:-1], math.inf]
        pieces = zip(self.elastic_slopes, pairwise(ends), strict=True)
        start = self.levels[0]
        return sum(k * (min(max(angle, a), b) - max(a, start)) for k, (a, b) in pieces)

    def _torque_after(self, angle: float) -> float:
        if angle > self.angle:
            self.up = np.maximum(self.up, self.risen(angle))
        else:
            self.up = np.minimum(self.up, 1 - self.fallen(angle))
        return float(self.offset + self.elastic(angle) - self.weight @ self.up)

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] on the present branch; see `Reference.slope`."""
        if delta > 0:
            way, width, able = angle - self.up_from, self.up_width, 1 - self.up
        else:
            way, width, able = self.down_from - angle, self.down_width, self.up
        switching = (0 < way) & (way < width)
        share = self.power * (way / width) ** (self.power - 1) / width
        i = np.clip(np.searchsorted(self.levels, angle) - 1, 0, self.levels.size - 2)
        return float(self.elastic_slopes[i] - self.weight @ (switching * share * able))

    def knots(self, end: float) -> list[float]:
        """Returns the angles [rad] at which patches end."""
        return self.grid.tolist()


def _random_preisach() -> Preisach:
    rng = np.random.default_rng(1)
    density = [rng.uniform(0, 0.3, i + 1).tolist() for i in range(8)]
    return Preisach(levels=np.linspace(0, 2, 9), density=density, elastic=rng.uniform(1, 6, 8))


_PREISACH = (
    Example(name="preisach", model=_random_preisach(), low=-0.2, high=2.2, start_torque=0.3),
)


@refers_to(PrandtlIshlinskii)
class PrandtlIshlinskiiReference(Reference):
    """A list of stops, all zero at the start; a play is u = angle - rest_angle less its stop."""

    def __init__(self, model: PrandtlIshlinskii, angles: Array, _: float) -> None:
        self.model = model
        self.stops = [0.0 for _ in model.thresholds]
        super().__init__(angles[0], self.sum(angles[0]))

    def sum(self, angle: float) -> float:
        """Returns the torque [N·m] at `angle` with the stops as they are."""
        u = angle - self.model.rest_angle
        parts = [stop if self.model.operator == "stop" else u - stop for stop in self.stops]
        pairs = zip(self.model.weights, parts, strict=True)
        return self.model.stiffness * u + sum(weight * part for weight, part in pairs)

    def _torque_after(self, angle: float) -> float:
        pairs = zip(self.stops, self.model.thresholds, strict=True)
        self.stops = [min(max(stop + angle - self.angle, -r), r) for stop, r in pairs]
        return self.sum(angle)

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] on the present branch; see `Reference.slope`."""
        moved, total = abs(angle - self.angle), self.model.stiffness
        parts = zip(self.model.weights, self.model.thresholds, self.stops, strict=True)
        for weight, r, stop in parts:
            slips = delta * stop + moved >= r
            total += weight if slips == (self.model.operator == "play") else 0.0
        return total

    def knots(self, end: float) -> list[float]:
        """Returns the angles [rad] at which a stop begins to slip."""
        delta = math.copysign(1.0, end - self.angle)
        pairs = zip(self.stops, self.model.thresholds, strict=True)
        return [self.angle + delta * r - stop for stop, r in pairs]


_THRESHOLDS = (0.05, 0.2, 0.7)
_STOPS = PrandtlIshlinskii(stiffness=1.5, thresholds=_THRESHOLDS, weights=(6, 4, 2), rest_angle=0.2)
_PLAYS = PrandtlIshlinskii(
    stiffness=12, thresholds=_THRESHOLDS, weights=(-5, -3, -2), operator="play", rest_angle=0.2
)
_FROM_REST = -1.0 - 0.2  # rad: all stops are at zero at the start
_PRANDTL_ISHLINSKII = (
    Example(
        name="prandtl-ishlinskii stops",
        model=_STOPS,
        low=-1,
        high=1,
        start_torque=_STOPS.stiffness * _FROM_REST,
    ),
    Example(
        name="prandtl-ishlinskii plays",
        model=_PLAYS,
        low=-1,
        high=1,
        start_torque=(_PLAYS.stiffness + sum(_PLAYS.weights)) * _FROM_REST,
    ),
)


@refers_to(HingedStops)
class HingedStopsReference(Reference):
    """The readable Prandtl-Ishlinskii model, and a sum of hinges over its torque P."""

    def __init__(self, model: HingedStops, angles: Array, _: float) -> None:
        self.model = model
        self.stops = PrandtlIshlinskiiReference(model.stops, angles, 0.0)
        super().__init__(angles[0], self.hinge(self.stops.torque))

    def hinge(self, P: float) -> float:
        """Returns the torque offset + h(P): a line, and a change of slope at each knot."""
        total = self.model.offset + self.model.slopes[0] * P
        for knot, change in zip(self.model.knots, np.diff(self.model.slopes), strict=True):
            total += change * (max(P - knot, 0.0) - max(-knot, 0.0))
        return total

    def ahead(self, angle: float) -> float:
        """Returns P [N·m] at a later angle of the present branch."""
        return copy.copy(self.stops).move(angle)

    def _torque_after(self, angle: float) -> float:
        return self.hinge(self.stops.move(angle))

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] on the present branch; see `Reference.slope`."""
        piece = int(np.searchsorted(self.model.knots, self.ahead(angle)))
        return self.stops.slope(angle, torque, delta) * self.model.slopes[piece]

    def knots(self, end: float) -> list[float]:
        """Returns the angles [rad] at which a stop begins to slip, or P passes a knot."""
        low, high = sorted((self.angle, end))
        slips = [x for x in self.stops.knots(end) if low < x < high]
        angles = np.array(sorted({low, *slips, high}))
        P = np.array([self.ahead(x) for x in angles])  # linear in between
        inside = [knot for knot in self.model.knots if P[0] < knot < P[-1]]
        return [*slips, *np.interp(inside, P, angles).tolist()]


_HINGED_STOPS = (
    Example(
        name="hinged stops",
        model=HingedStops(
            stiffness=1.5,
            thresholds=(0.05, 0.2, 0.7),
            weights=(6, 4, 2),
            knots=(-1.5, 0.5, 2),
            slopes=(0.4, 1, 0.3, 1.6),
            offset=0.2,
            rest_angle=0.2,
        ),
        low=-1,
        high=1,
        start_torque=0.2 - 0.4 * 0.3 - 1.5,
    ),
)


@refers_to(Dahl)
@refers_to(Duhem)
class DuhemReference(Reference):
    """The differential equation of z as printed in `Duhem`, by classical Runge-Kutta steps."""

    def __init__(self, model: Dahl | Duhem, angles: Array, torque: float) -> None:
        super().__init__(angles[0], torque)
        self.model = model
        equal = isinstance(model, Dahl)
        self.up = model.friction if equal else model.friction_up
        self.down = model.friction if equal else model.friction_down
        self.z = self.torque - self.elastic(self.angle)

    def elastic(self, angle: float) -> float:
        """Returns the torque of the spring [N·m]."""
        return sum(p * angle**i for i, p in enumerate(self.model.spring))

    def equation(self, _: float, z: float, delta: float) -> float:
        """Returns dz/dtheta [N·m/rad] of a motion with the sign `delta`."""
        return self.model.stiffness * (1 - z / self.up if delta > 0 else 1 + z / self.down)

    def _torque_after(self, angle: float) -> float:
        steps = math.ceil(abs(angle - self.angle) / ANGLE_STEP)
        for _ in range(steps):
            self.z = runge_kutta(self.equation, 0.0, self.z, (angle - self.angle) / steps)
        return self.elastic(angle) + self.z

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] on the present branch; see `Reference.slope`."""
        bend = sum(i * p * angle ** (i - 1) for i, p in enumerate(self.model.spring) if i)
        return bend + self.equation(angle, torque - self.elastic(angle), delta)


_SPRING = (0.5, 3.0, -1.0, 0.8)
_DAHL = (
    Example(
        name="dahl",
        model=Dahl(spring=_SPRING, stiffness=9.0, friction=1.5),
        low=-1,
        high=1,
        start_torque=-4.0,
    ),
)
_DUHEM = (
    Example(
        name="duhem",
        model=Duhem(spring=_SPRING, stiffness=9.0, friction_up=1.5, friction_down=0.6),
        low=-1,
        high=1,
        start_torque=-4.5,
    ),
)


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
_CLIPPED = (
    Example(
        name="elbow-sa-pso in a range",
        model=Clipped(model=_ELBOW, angle_range=(0.7, 1.3)),
        low=0.52,
        high=1.57,
    ),
)
_ASYMMETRIC = (
    Example(
        name="asymmetric, elbow-sa-pso",
        model=Asymmetric(model=_ELBOW, polynomial=[0.3, -0.5, 0.8]),
        low=0.52,
        high=1.57,
    ),
)
_VISCOELASTIC = (
    Example(
        name="viscoelastic, elbow-sa-pso",
        model=Viscoelastic(model=_ELBOW, damping=0.2),
        low=0.52,
        high=1.57,
    ),
)
_BACKLASH = (
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


EXAMPLES: dict[str, tuple[Example, ...]] = {
    "jiles-atherton": _JILES_ATHERTON,
    "bouc-wen": _BOUC_WEN,
    "preisach": _PREISACH,
    "prandtl-ishlinskii": _PRANDTL_ISHLINSKII,
    "hinged-stops": _HINGED_STOPS,
    "dahl": _DAHL,
    "duhem": _DUHEM,
    "asymmetric": _ASYMMETRIC,
    "clipped": _CLIPPED,
    "backlash": _BACKLASH,
    "viscoelastic": _VISCOELASTIC,
}
"""Models and motions by the name of the model's class."""
