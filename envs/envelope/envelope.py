"""The work envelope of a wearer, a suit and an exoskeleton.

Schmidt 2001 (thesis, MIT, hdl.handle.net/1721.1/8105; SAE 2001-01-2162) calls work envelope the
hand positions that need less than 15 % of the greatest isometric strength at every joint, by
inverse kinematics and a hysteresis model of the suit's torque.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...checks import at_least, flag, within
from ...errors import unknown_name
from ..model import ArmConfig
from ..provenance import Quantity
from .holding import Branch, Condition, Holding

CONDITIONS: tuple[Condition, ...] = get_args(Condition)
BRANCHES: tuple[Branch, ...] = get_args(Branch)
_SUSTAINED = Quantity(
    "envelope.share_of_strength",
    0.15,
    "1",
    "Schmidt 2001, SAE 2001-01-2162, as mvl.mit.edu tells it",
    "transcribed",
)
PROVENANCE: tuple[Quantity, ...] = (_SUSTAINED,)
SUSTAINED = _SUSTAINED.value
SPACING = 0.02  # m
SPACINGS = (0.004, 0.1)  # m
WRIST_ANGLES = 65
PART = 4096  # positions between two reports of progress


@dataclass(frozen=True, eq=False, kw_only=True)
class Envelope:
    """Where a hand can be, and what the easiest posture takes there.

    Attributes:
        config: Wearer, suit, exoskeleton, load and place.
        condition: One of `CONDITIONS`.
        branch: One of `BRANCHES`.
        spacing: Distance of neighbors in the lattice of positions [m].
        position: Positions that the hand can reach, forward, left and up from the shoulder in the
            axes of the torso [m], shape (n, 3).
        effort: Share of isometric strength that the easiest posture takes, that of the joint with
            the largest share [1], shape (n,).
        posture: Easiest posture, in the order of `JOINTS` [rad], shape (n, 4).
        postures: How many postures were examined.
    """

    config: ArmConfig
    condition: Condition
    branch: Branch
    spacing: float
    position: Array
    effort: Array
    posture: Array
    postures: int

    @property
    def reachable(self) -> float:
        """Volume that the hand can reach at any effort [l]."""
        return len(self.effort) * 1e3 * self.spacing**3

    def volume(self, share: float = SUSTAINED) -> float:
        """Returns the volume that takes at most a share of strength [l].

        Args:
            share: Share of isometric strength, above 0.
        """
        return int(np.count_nonzero(self.effort <= share)) * 1e3 * self.spacing**3

    def volume_error(self, share: float = SUSTAINED) -> float:
        """Returns the standard error of `volume` by the choice of the lattice [l].

        The lattice is eight lattices of twice the spacing. Each of them gives a volume, and their
        standard deviation over the root of eight is the error.

        Args:
            share: Share of isometric strength, above 0.
        """
        odd = self.cells[self.effort <= share] % 2
        counts = np.bincount(odd @ [1, 2, 4], minlength=8)
        return float(np.std(counts * 8e3 * self.spacing**3, ddof=1) / np.sqrt(8))

    @cached_property
    def cells(self) -> NDArray[np.int64]:
        """Numbers of the positions in the lattice, whole ones, shape (n, 3)."""
        return np.rint(self.position / self.spacing - 0.5).astype(np.int64)


def work_envelope(
    config: ArmConfig,
    condition: Condition = "suited",
    branch: Branch = "loading",
    *,
    measured: bool = False,
    spacing: float = SPACING,
    wrist_angles: int = WRIST_ANGLES,
    on_progress: Callable[[float], None] = lambda done: None,
) -> Envelope:
    """Finds the hand positions that a wearer can reach, and the least share of strength there.

    Positions are the centers of cubes around the shoulder. For each of them inverse kinematics
    gives all postures with a number of angles of the wrist: two planes of the arm, two ways to
    bend the elbow. The best of them counts.

    Conditions:

    - "unsuited": no suit, no exoskeleton; the joints move as far as those of a healthy adult.
    - "suited": the suit without exoskeleton; the joints move as far as it lets them.
    - "assisted": with the exoskeleton. Each motor takes the torque that holds its joint, of the
      weight of arm, suit, exoskeleton and load, and of suit and relaxed joint, up to its continuous
      torque. The wearer gives the rest, and all of it at abduction and wrist. The friction of the
      motors, which would help, is left out.
    - "unlimited": the same with motors of any torque, which bounds what better ones would give.

    Branches: the suit goes through the steady cycle over the range in which each joint moves. On
    "loading" every joint comes from the lower end of its range, on "unloading" from the upper one.

    Args:
        config: Wearer, suit, exoskeleton, load and place.
        condition: Whether there is a suit, an exoskeleton and its torque.
        branch: Where the joints of the suit come from.
        measured: Whether the joints of a suit only take angles in the ranges of its file, for which
            its models were identified. Without, they move as far as the suited arm does, and the
            models extrapolate.
        spacing: Distance of neighboring positions, 0.004 to 0.1 [m].
        wrist_angles: Number of angles of the wrist, at least 2, over its range.
        on_progress: Function that gets the share that is done, 0 to 1.

    Returns:
        The reachable positions with their effort.

    Raises:
        InputError: A value is unknown or outside its range, the coupling is not rigid, or the
            suit has no steady cycle over a joint's range.
        UncertifiedModelError: The suit is not certified and `allow_uncertified` is not set.
        PoleError: A steady cycle meets the pole of an uncertified model.
    """
    for kind, name, known in (("condition", condition, CONDITIONS), ("branch", branch, BRANCHES)):
        if name not in known:
            raise unknown_name(kind, name, known)
    flag("measured", measured)
    within("spacing", spacing, *SPACINGS, " m")
    at_least("wrist_angles", wrist_angles, 2)
    holding = Holding.of(config, condition, branch, measured=measured)
    low, high = holding.range[-1]
    wrist = np.linspace(low, high, wrist_angles)
    points = _lattice(holding.reach, spacing)
    found = []
    for begin in range(0, len(points), PART):
        found.append(holding.easiest(points[begin : begin + PART], wrist))
        on_progress(min(begin + PART, len(points)) / len(points))
    effort, posture = (np.concatenate([part[i] for part in found]) for i in range(2))
    there = np.isfinite(effort)
    return Envelope(
        config=config,
        condition=condition,
        branch=branch,
        spacing=spacing,
        position=points[there],
        effort=effort[there],
        posture=posture[there],
        postures=sum(part[2] for part in found),
    )


def _lattice(reach: float, spacing: float) -> Array:
    """Returns the centers of cubes within a ball around the shoulder [m], shape (n, 3)."""
    count = int(np.ceil(reach / spacing))
    line = (np.arange(-count, count) + 0.5) * spacing
    points = np.array(np.meshgrid(line, line, line, indexing="ij"), dtype=np.float64)
    points = points.reshape(3, -1).T
    return np.ascontiguousarray(points[np.linalg.norm(points, axis=1) <= reach])
