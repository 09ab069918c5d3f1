"""Each number of the composed model has a source, and the page that lists them is up to date."""

import math
from typing import get_args

import numpy as np
import pytest
from activesuit.envs.model import ASSISTED, ArmConfig, arm_spec
from activesuit.envs.person import segments
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


def sourced(config):
    """Magnitudes that a model may have: listed ones, a person's segments, and their sums."""
    person = segments(config.wearer)
    found = [abs(value) for value in VALUE.values()]
    degrees = [value for name, value in VALUE.items() if name.startswith("range_of_motion.")]
    found += [abs(math.radians(value)) for value in degrees]
    for one in person.values():
        found += [one.mass, one.center, one.length, *one.inertia]
    shoulder, elbow = ASSISTED
    cuff, links = (
        VALUE["exo.cuff"],
        [VALUE[f"exo.{part}_link"] for part in ("upper_arm", "forearm")],
    )
    found += [links[0] + VALUE[f"exo.{elbow}.mass"] + cuff, links[1] + cuff]
    for joint in (shoulder, elbow):  # muscle and motor together
        ways = [VALUE[f"strength.{joint}.{way}.peak"] for way in ("negative", "positive")]
        found += [way + VALUE[f"exo.{joint}.peak_torque"] for way in ways]
    return np.array([0.0, *found])


CONFIGS = [
    {},
    {"coupling": "cuffs"},
    {"coupling": "none"},
    {"suit": "none", "coupling": "none"},
]
FIELDS = (
    *("body_mass", "jnt_range", "jnt_stiffness", "qpos_spring", "jnt_actfrcrange"),
    *("dof_damping", "dof_armature", "dof_frictionloss"),
    *("actuator_biasprm", "actuator_forcerange", "actuator_armature", "actuator_damping"),
)


@pytest.mark.parametrize("fields", CONFIGS, ids=["rigid", "cuffs", "no exo", "bare"])
def test_every_number_of_the_model_has_a_source(fields):
    """That each number is in its place is what the tests of tests/envs/model ask."""
    config = ArmConfig(**fields)
    spec, numbers = arm_spec(config), sourced(config)
    model = spec.compile()
    assert model.opt.gravity[2] == -VALUE["gravity.earth"]
    found = {name: getattr(model, name) for name in FIELDS}
    given = [i for i in range(model.nbody) if spec.body(model.body(i).name).explicitinertial]
    found |= {"inertia": model.body_inertia[given], "center": model.body_ipos[given]}
    for name, values in found.items():
        for value in np.abs(values).ravel():
            assert np.isclose(value, numbers, rtol=1e-9, atol=1e-12).any(), (name, value)


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
