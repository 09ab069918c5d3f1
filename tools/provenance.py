"""Remakes docs/numbers/provenance.md: `python -m activesuit.tools.provenance`."""

import pkgutil
from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path

import mujoco

from ..assets import JOINTS, SCENE, Suit, load_suit, suit_names
from ..envs import belief, model, muscles, person, policies, rig, simulation
from ..envs.provenance import Quantity
from ..files import write_text
from ..hysteresis.parameter_table import parameter_table
from ..tables import markdown_table

PAGE = Path(__file__).parent.parent / "docs" / "numbers" / "provenance.md"
PACKAGES = (belief, person, model, rig, simulation, policies, muscles)
HEADER = ["quantity", "value", "unit", "source", "grade"]

BEGINNING = """\
# Sources of the numbers

Each table is a module, and each row a number of the simulated person, suit, exoskeleton or rig,
with its name in the code. [The model](../model.md) says what the numbers mean.

| grade | means |
|---|---|
| published | read in the source |
| transcribed | printed in the source, but read in a copy of others: look it up before use |
| derived | computed from published or transcribed values |
| identified | fitted to curves (suits only) |
| assumed | our choice, or known at second hand: replace it by what you know of your hardware |
"""


def quantities() -> dict[str, tuple[Quantity, ...]]:
    """Returns the quantities by the name of the module, or of arm.xml, that holds them."""
    found: dict[str, tuple[Quantity, ...]] = {}
    for package in PACKAGES:
        for module in pkgutil.iter_modules(package.__path__, f"{package.__name__}."):
            numbers = getattr(import_module(module.name), "PROVENANCE", ())
            if numbers:
                found[module.name] = numbers
    return found | {"assets/mjcf/arm.xml": drawn_quantities()}


def page() -> str:
    """Returns the text of docs/numbers/provenance.md."""
    parts = [BEGINNING]
    for place, numbers in quantities().items():
        parts += [f"## `{place}`\n", markdown_table(HEADER, map(_cells, numbers)) + "\n"]
    for name in suit_names():
        parts += list(_suit(load_suit(name)))
    return "\n".join(parts).rstrip() + "\n"


def _cells(quantity: Quantity) -> Sequence[str]:
    value = f"{quantity.value:.10g}"
    return f"`{quantity.name}`", value, quantity.unit, quantity.source, quantity.grade


def _suit(suit: Suit) -> Iterator[str]:
    yield f"## Suit `{suit.name}`\n"
    yield f"{suit.description}\n"
    header, rows = parameter_table({name: entry.model for name, entry in suit.joints.items()})
    rows = [[cell.replace("-\n", "-") for cell in row] for row in rows]
    yield markdown_table(header, rows) + "\n"
    rows = (
        (name, " to ".join(f"{angle:g}" for angle in entry.range), entry.source, entry.grade)
        for name, entry in suit.joints.items()
    )
    yield markdown_table(["joint", "range [rad]", "source", "grade"], rows) + "\n"


_HEIGHT = (
    "0.803 of stature; below the acromion, 0.818 by Drillis and Contini 1966, as cited by others"
)
_ROOM = "0.14 of stature; room for the suit beside the torso"
_SUIT_MASS = "a round number; arms of an EMU are said to weigh 5 kg each, without primary source"
_SOLIDS = {
    "upper_arm": "the mass, as a thin cylinder of radius 0.080 m and length 0.288 m",
    "forearm": "the mass, as a thin cylinder of radius 0.066 m and length 0.26 m",
    "hand": "the mass, as a solid ellipsoid of half axes 0.03, 0.045 and 0.07 m",
}
_RING = "the mass, as three rods, of the size drawn"
_LINK = "nearly zero; MuJoCo requires some of every body that moves"
_AXES = ("sagittal", "transverse", "longitudinal")
_SUITED = "inside the range of healthy adults (Boone and Azen 1979; AAOS), reduced by the suit"
_ARMATURE = "MyoSuite's arm, 0.01 kg·m²; less for the wrist; keeps the integration stable"
_GAIN = "a round number: keeps the suited arm and exoskeleton within some degrees"
_FASTEST = "a round number, beyond the intentions of all tasks"


def drawn_quantities() -> tuple[Quantity, ...]:
    """Returns the quantities in the plain MJCF: sizes, masses, ranges in the suit, gains.

    Moments of inertia are about the center of mass; sagittal, transverse and longitudinal are the
    axes x, y and z of the hanging arm. Centers are below the joint that the part moves with.
    """
    spec = mujoco.MjSpec.from_file(str(SCENE))
    link = spec.body("shoulder")
    height, half_width = float(spec.body("torso").pos[2]), abs(float(link.pos[1]))
    return (
        Quantity("torso.shoulder_height", height, "m", _HEIGHT, "assumed"),
        Quantity("torso.shoulder_half_width", half_width, "m", _ROOM, "assumed"),
        Quantity("arm.shoulder_link.mass", link.mass, "kg", _LINK, "assumed"),
        Quantity("arm.shoulder_link.inertia", float(link.inertia[0]), "kg·m²", _LINK, "assumed"),
        *_of_bodies(spec),
        *(quantity for name in JOINTS for quantity in _of_joint(spec, name)),
    )


def _of_bodies(spec: mujoco.MjSpec) -> Iterator[Quantity]:
    """Yields masses, centers and moments of the suit's parts and of the ring at the hand."""
    ring = spec.body("exo_hand")
    forward, _, up = ring.ipos.tolist()
    yield Quantity("exo.ring.center.forward", forward, "m", _RING, "assumed")
    yield from _below("exo.ring", -up, ring.inertia.tolist(), _RING)
    for part, solid in _SOLIDS.items():
        body = spec.body(f"suit_{part}")
        yield Quantity(f"suit.{part}.mass", body.mass, "kg", _SUIT_MASS, "assumed")
        yield from _below(f"suit.{part}", -float(body.ipos[2]), body.inertia.tolist(), solid)


def _below(name: str, center: float, inertia: list[float], source: str) -> Iterator[Quantity]:
    yield Quantity(f"{name}.center", center, "m", source, "assumed")
    for axis, moment in zip(_AXES, inertia, strict=True):
        yield Quantity(f"{name}.inertia.{axis}", moment, "kg·m²", source, "assumed")


def _of_joint(spec: mujoco.MjSpec, name: str) -> Iterator[Quantity]:
    """Yields range and armature of a joint, and the wearer's gains and fastest intention."""
    joint, wearer = spec.joint(name), spec.actuator(f"human_{name}")
    for end, value in zip(("low", "high"), joint.range.tolist(), strict=True):
        yield Quantity(f"suit.range.{name}.{end}", value, "rad", _SUITED, "assumed")
    yield Quantity(f"arm.{name}.armature", joint.armature, "kg·m²", _ARMATURE, "assumed")
    _, stiffness, damping = (-wearer.biasprm[:3]).tolist()
    fastest = float(wearer.velrange[1])
    yield Quantity(f"wearer.{name}.stiffness", stiffness, "N·m/rad", _GAIN, "assumed")
    yield Quantity(f"wearer.{name}.damping", damping, "N·m·s/rad", _GAIN, "assumed")
    yield Quantity(f"wearer.{name}.fastest", fastest, "rad/s", _FASTEST, "assumed")


if __name__ == "__main__":
    write_text(PAGE, page())
    print(f"wrote {PAGE}")
