"""Kernel = readable twin = SciPy = engine: every model along one motion that the engine recorded."""

import math
from dataclasses import dataclass
from itertools import pairwise

import mujoco
import numpy as np
from scipy.integrate import solve_ivp

from ...hysteresis import (
    TABLE_2,
    Asymmetric,
    BoucWen,
    HysteresisModel,
    PrandtlIshlinskii,
    Preisach,
)
from ...hysteresis.engine import attach
from ...hysteresis.model import Array
from ..output import table, to_json
from .twins import Twin, turning_points, twin_of

TOLERANCE = 1e-6  # N·m, of the kernel against its twin and against SciPy
SUM_TOLERANCE = 1e-12  # N·m, of the engine's sum with a polynomial; without one it is exact
RTOL = ATOL = 1e-10  # of DOP853
COLUMNS = ("twin", "dop853", "engine")
SEED, TURNS = 1, 40
SPEED = (0.5, 4.0)  # rad/s

HINGE = """<mujoco><compiler angle="radian"/>
  <option timestep="0.005" integrator="implicitfast" gravity="0 0 0"/>
  <worldbody><body><geom size="0.1"/><joint name="hinge" ref="{start!r}" armature="1"/></body>
  </worldbody>
  <actuator><position joint="hinge" kp="4000" dampratio="1"/></actuator></mujoco>"""


@dataclass(frozen=True, kw_only=True)
class Case:
    """A model, the range of its motion [rad], which starts at the low end, and the torque there."""

    name: str
    model: HysteresisModel
    low: float
    high: float
    start_torque: float = 0.0


def cases() -> list[Case]:
    """Returns all models, with motions in the range of each."""
    ranges = {"shoulder": (0.35, 1.22), "elbow": (0.52, 1.57)}
    published = [
        Case(name=f"jiles-atherton {name}", model=model, low=low, high=high)
        for name, model in TABLE_2.items()
        for low, high in [ranges[name.split("-")[0]]]
    ]
    rng = np.random.default_rng(SEED)
    density = [rng.uniform(0, 0.3, i + 1).tolist() for i in range(8)]
    relays = Preisach(levels=np.linspace(0, 2, 9), density=density, elastic=rng.uniform(1, 6, 8))
    stops = {"stiffness": 1.5, "thresholds": [0.05, 0.2, 0.7], "rest_angle": 0.2}
    springs = PrandtlIshlinskii(**stops, weights=[6, 4, 2])
    plays = PrandtlIshlinskii(
        **stops | {"stiffness": 12}, weights=[-5, -3, -2], operator="play"
    )
    bent = Asymmetric(model=TABLE_2["elbow-sa-pso"], polynomial=[0.3, -0.5, 0.8])
    yields = {"elastic": 3, "hysteretic": 9, "beta": 4, "rest_angle": 0.1}
    around_zero = {"low": -1.0, "high": 1.0}
    at_rest = -1.0 - springs.rest_angle
    return [
        *published,
        Case(name="bouc-wen n = 1", model=BoucWen(**yields, gamma=1, n=1), **around_zero),
        Case(name="bouc-wen n = 1.7", model=BoucWen(**yields, gamma=-1, n=1.7), **around_zero),
        Case(name="preisach", model=relays, low=-0.2, high=2.2, start_torque=0.3),
        Case(
            name="prandtl-ishlinskii stops",
            model=springs,
            **around_zero,
            start_torque=springs.stiffness * at_rest,
        ),
        Case(
            name="prandtl-ishlinskii plays",
            model=plays,
            **around_zero,
            start_torque=(plays.stiffness + sum(plays.weights)) * at_rest,
        ),
        Case(name="asymmetric elbow-sa-pso", model=bent, low=0.52, high=1.57),
    ]


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """The largest differences [N·m] of one model's kernel from its twin, SciPy and the engine."""

    name: str
    low: float
    high: float
    samples: int
    turns: int
    largest_torque: float
    twin: float
    dop853: float
    engine: float
    engine_tolerance: float

    @property
    def within(self) -> dict[str, bool]:
        """Which differences are within their tolerances."""
        limits = {"twin": TOLERANCE, "dop853": TOLERANCE, "engine": self.engine_tolerance}
        return {column: getattr(self, column) <= limit for column, limit in limits.items()}

    def to_dict(self) -> dict[str, object]:
        """Returns the numbers for JSON."""
        return {
            "model": self.name,
            "range_rad": (self.low, self.high),
            "samples": self.samples,
            "turns": self.turns,
            "largest_torque": self.largest_torque,
            "difference": {column: getattr(self, column) for column in COLUMNS},
            "engine_tolerance": self.engine_tolerance,
            "within": self.within,
            "all_within": all(self.within.values()),
        }


def examine(case: Case) -> Comparison:
    """Runs one model in the engine and computes the same motion in the three other ways."""
    angle, engine = recorded(case)
    kernel = case.model.response(angle, case.start_torque)
    twin = twin_of(case.model, angle, case.start_torque)
    stepped = np.array([twin.move(a) for a in angle])
    solved = integrated(twin_of(case.model, angle, case.start_torque), angle)
    return Comparison(
        name=case.name,
        low=float(angle.min()),
        high=float(angle.max()),
        samples=angle.size,
        turns=turning_points(angle).size - 1,
        largest_torque=float(np.abs(kernel).max()),
        twin=float(np.abs(kernel - stepped).max()),
        dop853=float(np.abs(kernel - solved).max()),
        engine=float(np.abs(kernel - engine).max()),
        engine_tolerance=SUM_TOLERANCE if isinstance(case.model, Asymmetric) else 0.0,
    )


def recorded(case: Case) -> tuple[Array, Array]:
    """Returns positions [rad] of a driven hinge and the resistance [N·m] by its torque sensor.

    A servo follows a setpoint that turns at random angles; without gravity, so that the suit's
    torque and the servo's are all there is.
    """
    spec = mujoco.MjSpec.from_string(HINGE.format(start=case.low))
    # The published shoulder sets are not certified, but have no pole in this range.
    attach(spec, "hinge", case.model, start_torque=case.start_torque, allow_uncertified=True)
    model = spec.compile()
    data = mujoco.MjData(model)
    angle, torque = [case.low], [case.start_torque]
    for setpoint in setpoints(case, model.opt.timestep):
        data.ctrl[0] = setpoint
        mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        angle.append(float(data.qpos[0]))
        torque.append(-float(data.sensor("hinge_suit_torque").data[0]))
    return np.array(angle), np.array(torque)


def setpoints(case: Case, timestep: float) -> Array:
    """Returns angles [rad] that run up and down between random turns at random speeds."""
    rng = np.random.default_rng(SEED)
    width = case.high - case.low
    low, middle, high = case.low + np.array([0.05, 0.5, 0.95]) * width
    turns = [case.low]
    for i in range(TURNS):
        turns.append(rng.uniform(middle, high) if i % 2 == 0 else rng.uniform(low, middle))
    ramps = []
    for start, end in pairwise(turns):
        steps = math.ceil(abs(end - start) / (rng.uniform(*SPEED) * timestep))
        ramps.append(np.linspace(start, end, steps + 1)[1:])
    return np.concatenate(ramps)


def integrated(twin: Twin, angle: Array) -> Array:
    """Returns the torque [N·m] by DOP853 from dT/dtheta, branch by branch and knot by knot."""
    torque = np.full(angle.size, twin.torque)
    now = twin.torque
    begin = 0
    for turn in turning_points(angle):
        start, delta = twin.angle, math.copysign(1.0, turn - twin.angle)
        inside = [x for x in twin.knots(turn) if 0 < delta * (x - start) < delta * (turn - start)]
        for a, b in pairwise(sorted({start, *inside, turn}, key=lambda x: delta * x)):
            margin = delta * min(1e-13, abs(b - a) / 4)  # the slope jumps at the knots themselves
            solved = solve_ivp(
                lambda x, T, ends=sorted((a + margin, b - margin)), delta=delta: [
                    twin.slope(min(max(x, ends[0]), ends[1]), T[0], delta)
                ],
                (a, b),
                [now],
                "DOP853",
                dense_output=True,
                rtol=RTOL,
                atol=ATOL,
            )
            now = float(solved.y[0, -1])
            here = begin + np.flatnonzero(
                (delta * (angle[begin:] - a) > 0) & (delta * (angle[begin:] - b) <= 0)
            )
            torque[here] = solved.sol(angle[here])[0]
        begin = int(np.flatnonzero(angle[begin:] == turn)[0]) + begin
        twin.move(turn)
    return torque


def report(json: bool) -> None:
    """Compares all models and prints the result as a table or as JSON."""
    found = [examine(case) for case in cases()]
    largest = {column: max(getattr(row, column) for row in found) for column in COLUMNS}
    passed = all(all(row.within.values()) for row in found)
    if json:
        content = {
            "tolerance": TOLERANCE,
            "unit": "N·m",
            "rows": [row.to_dict() for row in found],
            "largest": {**largest, "overall": max(largest.values())},
            "all_within": passed,
        }
        print(to_json(content))
        return
    rows = [
        (
            row.name,
            f"{row.low:.2f} to {row.high:.2f}",
            f"{row.samples}, {row.turns}",
            *(f"{getattr(row, column):.1e}" for column in COLUMNS),
            "yes" if all(row.within.values()) else "NO",
        )
        for row in found
    ]
    print(rows)
