"""The effort that a suit costs a wearer without exoskeleton, beside the same motions unsuited."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from ..assets import suit_names
from ..envs.evaluation import Score, evaluate
from ..envs.model import ASSISTED
from ..envs.model.config import NO_SUIT

TASK, EPISODES = "ActiveSuit/ArmTracking-v0", 5
SIMULATED = (
    "another simulation, no measurement: shoulder work of handling masses in an EMU is ten times "
    "that without a suit in a bad posture, and 23 % of that in a good one (SAE 2000-01-2257)"
)
CONDITIONS = (("earth", 0.0), ("microgravity", 0.0), ("microgravity", 5.0))  # kg in the hand


@dataclass(frozen=True, kw_only=True)
class SuitCost:
    """Effort at one joint in a suit, divided by the effort without one.

    Attributes:
        suit: Name of the suit.
        gravity: Name of the place.
        payload: Mass in the hand [kg].
        joint: Joint of the wearer.
        unsuited_torque: RMS torque without the suit [N·m].
        torque: Ratio of the RMS torques.
        work: Ratio of the positive work.
        work_cost: Ratio of the metabolic energy of working.
        torque_cost: Ratio of the metabolic energy of holding.
    """

    suit: str
    gravity: str
    payload: float
    joint: str
    unsuited_torque: float
    torque: float
    work: float
    work_cost: float
    torque_cost: float

    def to_dict(self) -> dict[str, Any]:
        """Returns the numbers for JSON."""
        return asdict(self)


def suit_costs() -> list[SuitCost]:
    """Compares every shipped suit with no suit on the same motions, without an exoskeleton."""
    found = []
    for condition in CONDITIONS:
        unsuited = _score(NO_SUIT, *condition)
        for suit in suit_names():
            suited = _score(suit, *condition)
            found += [_ratios(suit, condition, joint, suited, unsuited) for joint in ASSISTED]
    return found


def cost_table(costs: Sequence[SuitCost]) -> tuple[list[str], list[list[str]]]:
    """Returns the table of the costs: header and rows."""
    header = ["suit", "gravity", "load\n[kg]", "joint", "unsuited\n[N·m]", "torque", "work"]
    header += ["cost of\nworking", "cost of\nholding"]
    rows = []
    for cost in costs:
        ratios = (cost.torque, cost.work, cost.work_cost, cost.torque_cost)
        joint = cost.joint.removesuffix("_flexion")
        where = [cost.suit, cost.gravity, f"{cost.payload:g}", joint]
        rows.append([*where, f"{cost.unsuited_torque:.2g}", *(f"{ratio:.1f}" for ratio in ratios)])
    return header, rows


def _score(suit: str, gravity: str, payload: float) -> Score:
    options = {"suit": suit, "gravity": gravity, "payload": {"mass": payload}, "coupling": "none"}
    found = evaluate(
        TASK,
        ["none"],
        motions=EPISODES,
        references=False,
        allow_uncertified=True,
        **options,
    )
    return found.scores["none"]


def _ratios(
    suit: str, condition: tuple[str, float], joint: str, suited: Score, unsuited: Score
) -> SuitCost:
    above, below = suited.load[joint], unsuited.load[joint]
    gravity, payload = condition
    return SuitCost(
        suit=suit,
        gravity=gravity,
        payload=payload,
        joint=joint,
        unsuited_torque=unsuited.human_rms[joint],
        torque=suited.human_rms[joint] / unsuited.human_rms[joint],
        work=above["positive_work"] / below["positive_work"],
        work_cost=above["work_cost"] / below["work_cost"],
        torque_cost=above["torque_cost"] / below["torque_cost"],
    )
