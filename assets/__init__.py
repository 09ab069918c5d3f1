"""Files that ship with the package (MJCF, suits, curves), and the suits as Python objects."""

from pathlib import Path

from ..errors import unknown_name
from .suit_joints import JOINTS, Softening, SuitJoint
from .suits import AnySuit, Suit, load_suit, suit_names

FOLDER = Path(__file__).parent
SCENE = FOLDER / "mjcf" / "scene.xml"

# Joint of each shipped file of curves, by the name of the file.
CURVES = {"shoulder": "shoulder_flexion", "elbow": "elbow_flexion"}


def curves_path(name: str) -> Path:
    """Returns the path of a curve file that ships with the package: "shoulder" or "elbow"."""
    if name not in CURVES:
        raise unknown_name("shipped curves", name, CURVES)
    return FOLDER / "curves" / f"{name}.csv"


__all__ = [
    "CURVES",
    "FOLDER",
    "JOINTS",
    "SCENE",
    "AnySuit",
    "Softening",
    "Suit",
    "SuitJoint",
    "curves_path",
    "load_suit",
    "suit_names",
]
