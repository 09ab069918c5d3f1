"""Kernel = readable twin = SciPy = engine: each model along a motion that the engine recorded."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import mujoco
import numpy as np
from scipy.integrate import solve_ivp

from ...arrays import Array
from ...hysteresis import (
    TABLE_2,
    Asymmetric,
    BoucWen,
    Held,
    HysteresisModel,
    PrandtlIshlinskii,
    Preisach,
)
from ...hysteresis.engine import attach
from ..output import table, to_json
from .twins import Twin, turn_indices, twin_of

TOLERANCE = 1e-6  # N·m, of the kernel against its twin and against SciPy
SUM_TOLERANCE = 1e-12  # N·m, of the engine's sum with a polynomial; without one it is exact
RTOL = ATOL = 1e-10  # of DOP853
COLUMNS, LABELS = ("twin", "dop853", "engine"), ("twin", "DOP853", "engine")
SEED, TURNS = 1, 40
MARGIN = 0.05  # of the range, from its ends to a turn and at least between two turns
SPEEDS = (0.5, 4.0)  # rad/s

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
        Case(name=f"J-A {name}", model=model, low=low, high=high)
        for name, model in TABLE_2.items()
        for low, high in [ranges[name.partition("-")[0]]]
    ]
    rng = np.random.default_rng(SEED)
    density = [rng.uniform(0, 0.3, i + 1).tolist() for i in range(8)]
    relays = Preisach(levels=np.linspace(0, 2, 9), density=density, elastic=rng.uniform(1, 6, 8))
    thresholds = [0.05, 0.2, 0.7]
    springs = PrandtlIshlinskii(
        stiffness=1.5, thresholds=thresholds, weights=[6, 4, 2], rest_angle=0.2
    )
    plays = PrandtlIshlinskii(
        stiffness=12, thresholds=thresholds, weights=[-5, -3, -2], operator="play", rest_angle=0.2
    )
    held = Held(model=TABLE_2["elbow-sa-pso"], angle_range=(0.7, 1.3))
    bent = Asymmetric(model=TABLE_2["elbow-sa-pso"], polynomial=[0.3, -0.5, 0.8])
    yields = {"elastic": 3, "hysteretic": 9, "beta": 4, "rest_angle": 0.1}
    around_zero = {"low": -1.0, "high": 1.0}
    at_rest = -1.0 - springs.rest_angle
    return [
        *published,
        Case(name="bouc-wen, n = 1", model=BoucWen(**yields, gamma=1, n=1), **around_zero),
        Case(name="bouc-wen, n = 1.7", model=BoucWen(**yields, gamma=-1, n=1.7), **around_zero),
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
        Case(name="held, elbow-sa-pso", model=held, low=0.52, high=1.57),
        Case(name="asymmetric, elbow-sa-pso", model=bent, low=0.52, high=1.57),
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
    def tolerance(self) -> dict[str, float]:
        """What each difference may be [N·m]."""
        return {"twin": TOLERANCE, "dop853": TOLERANCE, "engine": self.engine_tolerance}

    @property
    def within(self) -> dict[str, bool]:
        """Which differences are within their tolerances."""
        return {name: getattr(self, name) <= limit for name, limit in self.tolerance.items()}

    @property
    def passed(self) -> bool:
        """Whether all are."""
        return all(self.within.values())

    def to_dict(self) -> dict[str, Any]:
        """Returns the numbers for JSON."""
        return {
            "model": self.name,
            "range": (self.low, self.high),
            "samples": self.samples,
            "turns": self.turns,
            "largest_torque": self.largest_torque,
            "difference": {name: getattr(self, name) for name in COLUMNS},
            "tolerance": self.tolerance,
            "within": self.within,
            "passed": self.passed,
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
        turns=turn_indices(angle).size - 1,
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
    low, high = case.low + MARGIN * width, case.high - MARGIN * width
    turns = [case.low, high]
    for i in range(TURNS):
        down, up = (low, turns[-1] - MARGIN * width), (turns[-1] + MARGIN * width, high)
        turns.append(rng.uniform(*(up if i % 2 else down)))
    ramps = []
    for start, end in pairwise(turns):
        steps = math.ceil(abs(end - start) / (rng.uniform(*SPEEDS) * timestep))
        ramps.append(np.linspace(start, end, steps + 1)[1:])
    return np.concatenate(ramps)


def integrated(twin: Twin, angle: Array) -> Array:
    """Returns the torque [N·m] by DOP853 from dT/dtheta, from turn to turn and knot to knot."""
    torque = np.empty_like(angle)
    now, first = twin.torque, 0
    for last in turn_indices(angle):
        branch = angle[first : last + 1]
        start, end = float(branch[0]), float(branch[-1])
        inside = [x for x in twin.knots(end) if min(start, end) < x < max(start, end)]
        for a, b in pairwise(sorted({start, *inside, end}, reverse=end < start)):
            solved = solve(twin, a, b, now)
            here = np.flatnonzero((branch >= min(a, b)) & (branch <= max(a, b)))
            if here.size > 0:
                torque[first + here] = solved.sol(branch[here])[0]
            now = float(solved.y[0, -1])
        twin.move(end)
        first = last
    return torque


def solve(twin: Twin, a: float, b: float, torque: float) -> Any:
    """Integrates dT/dtheta between two angles [rad]; at both it may jump, so it is taken inside."""
    delta = math.copysign(1.0, b - a)
    inset = delta * min(1e-13, abs(b - a) / 4)
    low, high = sorted((a + inset, b - inset))
    return solve_ivp(
        lambda x, T: [twin.slope(min(max(x, low), high), T[0], delta)],
        (a, b),
        [torque],
        "DOP853",
        dense_output=True,
        rtol=RTOL,
        atol=ATOL,
    )


def report(json: bool) -> None:
    """Compares all models and prints the result as a table or as JSON."""
    found = [examine(case) for case in cases()]
    largest = {column: max(getattr(row, column) for row in found) for column in COLUMNS}
    overall, passed = max(largest.values()), all(row.passed for row in found)
    if json:
        content = {
            "unit": "N·m",
            "rows": [row.to_dict() for row in found],
            "largest": {**largest, "overall": overall},
            "within": passed,
        }
        print(to_json(content))
        return
    rows = [
        (
            row.name,
            f"{row.low:.2f} to {row.high:.2f}",
            f"{row.samples}",
            f"{row.turns}",
            *(_number(getattr(row, column)) for column in COLUMNS),
            _verdict(row.passed),
        )
        for row in found
    ]
    maxima = map(_number, largest.values())
    table(
        "largest difference [N·m] of each model's kernel from its twin, SciPy and the engine",
        ["model", "range\n[rad]", "samples", "turns", *LABELS, "within"],
        [*rows, ("all", "", "", "", *maxima, _verdict(passed))],
        left=1,
    )
    print(
        f"largest of all: {overall:.1e} N·m; within means at most {TOLERANCE:g} N·m from twin and "
        f"DOP853,\nand 0 from the engine, bit by bit (asymmetric: {SUM_TOLERANCE:g})"
    )


def _number(difference: float) -> str:
    return f"{difference:.1e}" if difference else "0"


def _verdict(passed: bool) -> str:
    return "yes" if passed else "NO"
