"""The tasks: which joints move, and between which angles."""

from typing import ClassVar

from .arm_env import ArmEnv

# rad: the ranges in which the paper measured (sections 3.1 and 5.1).
SHOULDER_RANGE = (0.35, 1.22)
ELBOW_RANGE = (0.52, 1.57)

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
