"""Each number of the composed model has a source, and the page that lists them is up to date."""

import math
import re
from typing import get_args

import numpy as np
import pytest
from activesuit.envs.model import ASSISTED, ArmConfig, arm_spec
from activesuit.envs.person import Person, segments
from activesuit.envs.provenance import Grade
from activesuit.tools.provenance import PAGE, page, quantities

ALL = [quantity for numbers in quantities().values() for quantity in numbers]
VALUE = {quantity.name: quantity.value for quantity in ALL}
LIMBS = ("upper_arm", "forearm", "hand")
AXES = ("sagittal", "transverse", "longitudinal")
ENDS = ("low", "high")
NO = (0.0, 0.0)


def test_the_page_is_what_the_code_says():
    assert PAGE.read_text(encoding="utf-8") == page(), "python -m activesuit.tools.provenance"


def test_quantities_are_complete():
    assert len(VALUE) == len(ALL)
    for quantity in ALL:
        assert math.isfinite(quantity.value)
        assert quantity.unit
        assert quantity.source
        assert quantity.grade in get_args(Grade)


CONFIGS = [
    {},
    {"coupling": "cuffs"},
    {"coupling": "none"},
    {"suit": "none", "coupling": "none"},
]
FIELDS = {  # of a model, and the names of the quantities that its numbers are
    "body_mass": r"\.mass|\.ring$|exo\..*_link",
    "body_inertia": r"\.inertia",
    "body_ipos": r"\.center",
    "jnt_range": r"suit\.range|range_of_motion",
    "jnt_stiffness": r"passive.*\.stiffness",
    "qpos_spring": r"passive.*\.rest",
    "jnt_actfrcrange": r"strength.*\.peak|peak_torque",
    "dof_damping": r"passive.*\.viscosity",
    "dof_armature": r"arm\..*\.armature",
    "dof_frictionloss": r"coulomb",
    "actuator_biasprm": r"wearer.*\.(stiffness|damping)",
    "actuator_forcerange": r"strength.*\.peak|peak_torque",
    "actuator_armature": r"exo.*\.armature",
    "actuator_damping": r"exo.*\.viscous",
}


def sourced(field):
    """Magnitudes that a field of a model may have: quantities, a person's segments, and sums."""
    named = {name: value for name, value in VALUE.items() if re.search(FIELDS[field], name)}
    found = [*named.values()]
    if field == "jnt_range":
        found += [math.radians(one) for name, one in named.items() if "of_motion" in name]
    if field == "jnt_actfrcrange":  # muscle and motor together
        found += [VALUE[f"exo.{joint}.peak_torque"] + one for joint in ASSISTED for one in found]
    if field == "body_mass":
        upper, forearm = (VALUE[f"exo.{part}_link"] + VALUE["exo.cuff"] for part in LIMBS[:2])
        found += [forearm, upper + VALUE[f"exo.{ASSISTED[1]}.mass"]]
    part = {"body_mass": "mass", "body_inertia": "inertia", "body_ipos": "center"}.get(field, "")
    person = segments(Person()).values() if part else ()
    return np.abs(np.hstack([0.0, *found, *(getattr(one, part) for one in person)]))


@pytest.mark.parametrize("fields", CONFIGS, ids=["rigid", "cuffs", "no exo", "bare"])
def test_every_number_of_the_model_has_a_source(fields):
    """That each number is in its place is what the tests of tests/envs/model ask."""
    spec = arm_spec(ArmConfig(**fields))
    model = spec.compile()
    given = [spec.body(model.body(i).name).explicitinertial for i in range(model.nbody)]
    assert model.opt.gravity[2] == -VALUE["gravity.earth"]
    for field in FIELDS:
        values, known = getattr(model, field), sourced(field)
        rows = given if field in ("body_inertia", "body_ipos") else slice(None)
        for value in np.abs(values[rows]).ravel():
            assert np.isclose(value, known, rtol=1e-9, atol=1e-12).any(), (field, value)


@pytest.mark.parametrize(
    ("part", "radius", "length"), [("upper_arm", 0.080, 0.288), ("forearm", 0.066, 0.26)]
)
def test_moments_of_sleeves_are_those_of_thin_cylinders(part, radius, length):
    across, _, along = (VALUE[f"suit.{part}.inertia.{axis}"] for axis in AXES)
    mass = VALUE[f"suit.{part}.mass"]
    assert along == pytest.approx(mass * radius**2, rel=0.005)
    assert across == pytest.approx(mass * (radius**2 / 2 + length**2 / 12), rel=0.005)


def test_moments_of_the_glove_are_those_of_an_ellipsoid():
    x, y, z = 0.03**2, 0.045**2, 0.07**2
    exact = VALUE["suit.hand.mass"] / 5 * np.array([y + z, x + z, x + y])
    rounded = [VALUE[f"suit.hand.inertia.{axis}"] for axis in AXES]
    np.testing.assert_allclose(rounded, exact, atol=5e-6)
