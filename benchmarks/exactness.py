"""How exact each model is: its kernels, its readable reference, SciPy and the engine compared."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import mujoco
import numpy as np

from ..arrays import Array
from ..hysteresis import MODELS, Asymmetric, Backlash, Viscoelastic
from ..hysteresis.engine import attach
from ..scripts.folders import to_json
from ..scripts.output import table
from .references import EXAMPLES, Example, integrate, reference_of, turn_indices

TOLERANCE = 1e-6  # [N·m], kernel against reference and against SciPy
SUM_TOLERANCE = 1e-12  # [N·m], the engine's sum with a polynomial; without one it is exact
COLUMNS, LABELS = ("reference", "dop853", "engine"), ("reference", "DOP853", "engine")
SEED, TURNS = 1, 40
MARGIN = 0.05  # share of the range: least distance of a turn from an end and from another turn
SPEEDS = (0.5, 4.0)  # rad/s

HINGE = """<mujoco><compiler angle="radian"/>
  <option timestep="0.005" integrator="implicitfast" gravity="0 0 0"/>
  <worldbody><body><geom size="0.1"/><joint name="hinge" ref="{start!r}" armature="1"/></body>
  </worldbody>
  <actuator><position joint="hinge" kp="4000" dampratio="1"/></actuator></mujoco>"""


def examples() -> list[Example]:
    """Returns the examples of all models, but those that depend on the rate.

    The engine knows the time and `response` without times does not, so their torques differ.
    """
    slow = [name for name in MODELS if name != Viscoelastic.name]
    return [example for name in slow for example in EXAMPLES[name]]


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """The largest differences [N·m] of a model's kernel from reference, SciPy and engine."""

    name: str
    low: float
    high: float
    samples: int
    turns: int
    largest_torque: float
    reference: float
    dop853: float
    engine: float
    engine_tolerance: float

    @property
    def tolerance(self) -> dict[str, float]:
        """What each difference may be [N·m]."""
        return {"reference": TOLERANCE, "dop853": TOLERANCE, "engine": self.engine_tolerance}

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


def examine(case: Example) -> Comparison:
    """Runs one model in the engine and computes the same motion in the three other ways."""
    angle, engine = recorded(case)
    kernel = case.model.response(angle, case.start_torque)
    reference = reference_of(case.model, angle, case.start_torque)
    stepped = np.array([reference.move(a) for a in angle])
    solved = integrate(reference_of(case.model, angle, case.start_torque), angle)
    return Comparison(
        name=case.name,
        low=float(angle.min()),
        high=float(angle.max()),
        samples=angle.size,
        turns=turn_indices(angle).size - 1,
        largest_torque=float(np.abs(kernel).max()),
        reference=float(np.abs(kernel - stepped).max()),
        dop853=float(np.abs(kernel - solved).max()),
        engine=float(np.abs(kernel - engine).max()),
        engine_tolerance=SUM_TOLERANCE if isinstance(case.model, Asymmetric | Backlash) else 0.0,
    )


def recorded(case: Example) -> tuple[Array, Array]:
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


def setpoints(case: Example, timestep: float) -> Array:
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


def report(json: bool) -> None:
    """Compares all models and prints the result as a table or as JSON."""
    found = [examine(case) for case in examples()]
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
        "largest difference [N·m] of each model's kernel from its reference, SciPy and the engine",
        ["model", "range\n[rad]", "samples", "turns", *LABELS, "within"],
        [*rows, ("all", "", "", "", *maxima, _verdict(passed))],
    )
    print(
        f"largest of all: {overall:.1e} N·m; within means at most {TOLERANCE:g} N·m from "
        f"reference and DOP853,\nand 0 from the engine, bit by bit (asymmetric: {SUM_TOLERANCE:g})"
    )


def _number(difference: float) -> str:
    return f"{difference:.1e}" if difference else "0"


def _verdict(passed: bool) -> str:
    return "yes" if passed else "NO"
