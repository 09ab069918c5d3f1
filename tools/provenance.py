"""Remakes docs/provenance.md: `python -m activesuit.tools.provenance`."""

import pkgutil
from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path

from ..assets import Suit, load_suit, suit_names
from ..envs import belief, model, muscles, person, policies, rig, simulation
from ..envs.model.drawing import drawn_quantities
from ..envs.provenance import Quantity
from ..files import write_text
from ..hysteresis.parameter_table import parameter_table
from ..tables import markdown_table

PAGE = Path(__file__).parent.parent / "docs" / "provenance.md"
PACKAGES = (belief, person, model, rig, simulation, policies, muscles)
HEADER = ["quantity", "value", "unit", "source", "grade"]

BEGINNING = """\
# Numbers and sources

![The person, the person in the suit, and both with the exoskeleton](figures/model.png)

Each number of the simulated person, suit, exoskeleton and rig, as the code uses it, with its source
and a grade:

- **published**: read in the source;
- **transcribed**: printed in the source, but read in somebody's copy of it (a data file, another's
  code or table): look it up before you rely on it;
- **derived**: computed from published or transcribed values;
- **identified**: fitted to curves (suits only);
- **assumed**: ours, or known at second hand only. Replace it by what you know of your own hardware.

**How to read this.** Each table is a module, each row a number with its name in the code, value,
unit, source and grade. [The model](model.md) and the module say what the numbers mean.
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
    """Returns the text of docs/provenance.md."""
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


if __name__ == "__main__":
    write_text(PAGE, page())
    print(f"wrote {PAGE}")
