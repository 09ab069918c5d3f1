"""The tasks: each says which joints move, and between which angles."""

from typing import ClassVar

from ..published import LI_RANGES
from .arm_env import ArmEnv

SHOULDER_RANGE, ELBOW_RANGE = LI_RANGES["shoulder"], LI_RANGES["elbow"]  # rad

Spans = dict[str, tuple[float, float]]


class ShoulderFlexionEnv(ArmEnv):
    """The shoulder flexes and extends between random angles; the elbow is held."""

    span: ClassVar[Spans] = {"shoulder_flexion": SHOULDER_RANGE}
    hold: ClassVar[Spans] = {"elbow_flexion": (0.6, 1.2)}


class ElbowFlexionEnv(ArmEnv):
    """The elbow flexes and extends between random angles; the shoulder is held."""

    span: ClassVar[Spans] = {"elbow_flexion": ELBOW_RANGE}
    hold: ClassVar[Spans] = {"shoulder_flexion": (0.4, 1.0)}


class ArmTrackingEnv(ArmEnv):
    """Shoulder and elbow move independently between random angles."""

    span: ClassVar[Spans] = {"shoulder_flexion": SHOULDER_RANGE, "elbow_flexion": ELBOW_RANGE}
    hold: ClassVar[Spans] = {}
