"""Readable references of the models, and motions with which tests and benchmarks examine them."""

from . import around, bouc_wen, dahl, hinged_stops, jiles_atherton, prandtl_ishlinskii, preisach
from .reference import Example, Reference, integrate, reference_of, turn_indices

EXAMPLES: dict[str, tuple[Example, ...]] = {
    "jiles-atherton": jiles_atherton.EXAMPLES,
    "bouc-wen": bouc_wen.EXAMPLES,
    "preisach": preisach.EXAMPLES,
    "prandtl-ishlinskii": prandtl_ishlinskii.EXAMPLES,
    "hinged-stops": hinged_stops.EXAMPLES,
    "dahl": dahl.DAHL_EXAMPLES,
    "duhem": dahl.DUHEM_EXAMPLES,
    "asymmetric": around.ASYMMETRIC_EXAMPLES,
    "clipped": around.CLIPPED_EXAMPLES,
    "backlash": around.BACKLASH_EXAMPLES,
    "viscoelastic": around.VISCOELASTIC_EXAMPLES,
}
"""Models and motions by the name of the model's class."""

__all__ = ["EXAMPLES", "Example", "Reference", "integrate", "reference_of", "turn_indices"]
