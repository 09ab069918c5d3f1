"""C99 header of a suit: the models of its joints, with comments about each model."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .. import __version__
from ..hysteresis import HysteresisModel, Viscoelastic
from ..hysteresis.c_code import BYTES, Header, comment, parameters, stepped
from ..hysteresis.safety import require_certificate
from .suit_joints import SuitJoint

GOLDEN_STEP = 0.1  # s, between two golden values of a viscoelastic model
GOLDEN = (1.0, 0.2, 0.7, 0.5, 0.9, 0.0, 0.4)  # places of the golden values in the joint's range
INTRODUCTION = (
    f"Made by ActiveSuit {__version__}: C99, without allocation and without global variables. "
    "Numbers are double, or float where ACTIVESUIT_FLOAT is defined before the header is included. "
    "Angles are in rad, torques in N m, times in s. Do not compile with -ffast-math."
)
"""Paragraph at the beginning of every header."""
STEP = (
    "A step returns the resistance to the motion: the suit's torque on the joint is its negative. "
    "A step to an angle that is not finite returns NaN and changes nothing."
)


@dataclass(frozen=True)
class Part:
    """A part of a header, and the memory that the part needs.

    Attributes:
        name: Name of the joint, or of the policy.
        what: Names of the models that the part computes.
        state: Count of the numbers in the state, which is in RAM.
        constants: Count of the numbers in constant tables, which may be in flash.
    """

    name: str
    what: str
    state: int
    constants: int

    def bytes(self, kind: str) -> tuple[int, int]:
        """Returns the bytes of state and tables for numbers of the type "float" or "double"."""
        return self.state * BYTES[kind], self.constants * BYTES[kind]


def suit_header(
    joints: Mapping[str, SuitJoint],
    prefix: str,
    about: Sequence[str],
    *,
    allow_uncertified: bool = False,
) -> tuple[str, list[Part]]:
    """Returns a C99 header with the resistance of joints, and the memory of each joint.

    Args:
        joints: Joints by name.
        prefix: Name with which all names of the header begin.
        about: Paragraphs about the suit for the comment at the beginning.
        allow_uncertified: Whether to accept a model whose torque could become infinite.

    Raises:
        UncertifiedModelError: A model has no certificate, and `allow_uncertified` is False.
    """
    header, parts = Header(prefix), []
    for name, joint in joints.items():
        if not allow_uncertified:
            start = joint.model.start(joint.start_angle, joint.start_torque)
            require_certificate(joint.model, start, name)
        before = header.constants
        header.add(comment([*joint_comment(name, joint), "", *_golden(joint)]))
        state = header.model(f"as_{name}", joint.model, joint.begun())
        parts.append(Part(name, kind_of(joint.model), state, header.constants - before))
    first = next(iter(joints))
    dt = ", dt" if isinstance(joints[first].model, Viscoelastic) else ""
    calls = ("state state", "init(&state)", f"step(&state, angle{dt})")
    usage = "\n".join(
        f"  {'torque = ' * ('step' in call)}{prefix}_{first}_{call};" for call in calls
    )
    return header.text([*about, INTRODUCTION, STEP, "", usage]), parts


def kind_of(model: HysteresisModel) -> str:
    """Returns the name of a model and of the models inside it, as in "clipped bouc-wen"."""
    inner = getattr(model, "model", None)
    return f"{model.name} {kind_of(inner)}" if inner is not None else model.name


def joint_comment(name: str, joint: SuitJoint) -> list[str]:
    """Returns the paragraphs about a joint: source, certificate, parameters."""
    low, high = joint.range
    path = ", ".join(f"{angle:g}" for angle in joint.start_path)
    begins = f"{joint.start_torque:g} N m at {joint.start_angle:g} rad"
    return [
        f"{name}: {joint.grade}, for {low:g} to {high:g} rad. {joint.source}",
        _guarantees(joint),
        f"It begins with {begins}" + (f", and then goes to {path} rad." if path else "."),
        "",
        "\n".join(parameters(joint.model)),
    ]


def _guarantees(joint: SuitJoint) -> str:
    certificate, in_range = joint.model.certificate(), joint.model.certificate(joint.range)
    if not certificate.certified:
        return (
            f"NOT CERTIFIED (margin {certificate.margin:.3g}): in some motion the torque would "
            "become infinite; a step there returns NaN and changes nothing."
        )
    energy = "no cycle of motion extracts energy" if in_range.dissipative else "it may drive"
    return (
        f"Certificate: the stiffness stays finite in every motion (margin {certificate.margin:.3g})"
        f", {energy}, and in its range the torque is at most {in_range.torque_bound:.4g} N m."
    )


def _golden(joint: SuitJoint) -> list[str]:
    low, high = joint.range
    angle = np.array([float(f"{low + (high - low) * place:.3f}") for place in GOLDEN])
    torque = stepped(joint.model, joint.begun(), angle, GOLDEN_STEP)
    time = f", dt = {GOLDEN_STEP:g} s" if isinstance(joint.model, Viscoelastic) else ""
    rows = (f"  {a:9.3f}  {T:18.12f}" for a, T in zip(angle, torque, strict=True))
    return [f"Golden values of the first steps (double{time}):", "", "\n".join(rows)]
