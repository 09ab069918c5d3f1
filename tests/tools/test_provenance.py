"""Each number of the composed model has a source, and the page that lists them is up to date."""

import math
from typing import get_args

import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs.model import ASSISTED, ArmConfig, arm_spec
from activesuit.envs.model.fitting import FARTHEST
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


# What a model must be, by the rules of docs/model.md, from the quantities alone.


def masses(config):
    person, ring = segments(config.wearer), VALUE["exo.ring"]
    found = {limb: person[limb].mass for limb in LIMBS}
    found["shoulder"] = VALUE["arm.shoulder_link.mass"]
    if config.suit != "none":
        found |= {f"suit_{limb}": VALUE[f"suit.{limb}.mass"] for limb in LIMBS}
    if config.coupling != "none":
        cuff, motors = VALUE["exo.cuff"], [VALUE[f"exo.{joint}.mass"] for joint in ASSISTED]
        found["exo_shoulder_support"] = motors[0]
        found["exo_upper_arm"] = VALUE["exo.upper_arm_link"] + motors[1] + cuff
        found["exo_forearm"] = VALUE["exo.forearm_link"] + cuff
        found["exo_hand"] = ring
    return found


def moments(config):
    """Of bodies whose moments are given; those of the links follow from shapes and masses."""
    person = segments(config.wearer)
    found = {limb: person[limb].inertia for limb in LIMBS}
    found["shoulder"] = (VALUE["arm.shoulder_link.inertia"],) * 3
    given = {f"suit_{limb}": f"suit.{limb}" for limb in LIMBS} | {"exo_hand": "exo.ring"}
    for body, name in given.items():
        found[body] = tuple(VALUE[f"{name}.inertia.{axis}"] for axis in AXES)
    return found


def centers(config):
    person = segments(config.wearer)
    found = {limb: (0, 0, -person[limb].center) for limb in LIMBS} | {"shoulder": (0, 0, 0)}
    found |= {f"suit_{limb}": (0, 0, -VALUE[f"suit.{limb}.center"]) for limb in LIMBS}
    found["exo_hand"] = (VALUE["exo.ring.center.forward"], 0, -VALUE["exo.ring.center"])
    return found


def joints(config):
    """(range, stiffness, rest, damping, armature, Coulomb friction, torque limits) by joint."""
    cuffed, found = config.coupling == "cuffs", {}
    for joint in JOINTS:
        span = [VALUE[f"suit.range.{joint}.{end}"] for end in ENDS]
        if config.suit == "none":
            span = [math.radians(VALUE[f"range_of_motion.{joint}.{end}"]) for end in ENDS]
        passive = [VALUE.get(f"passive.{joint}.{what}", 0.0) for what in ("stiffness", "rest")]
        viscosity = VALUE[f"passive.{joint}.viscosity"]
        armature = VALUE[f"arm.{joint}.armature"]
        plant = joint in ASSISTED and config.coupling != "none"
        coulomb = VALUE[f"exo.{joint}.coulomb"] if plant else 0.0
        peak = VALUE[f"exo.{joint}.peak_torque"] if plant else 0.0
        muscle, motor = np.array(strength(joint)), np.array([-peak, peak])
        limits, friction = (muscle, 0.0) if cuffed else (muscle + motor, coulomb)
        found[joint] = (span, *passive, viscosity, armature, friction, limits)
        if cuffed:
            found[f"exo_{joint}"] = (span, 0.0, 0.0, 0.0, 0.0, coulomb, motor)
    return found


def strength(joint):
    ways = [VALUE[f"strength.{joint}.{way}.peak"] for way in ("negative", "positive")]
    return -ways[0], ways[1]


def wearer(joint, span):
    """(gain, bias, dynamics, force limits, control limits, armature, damping)."""
    stiffness, damping = (VALUE[f"wearer.{joint}.{what}"] for what in ("stiffness", "damping"))
    fastest, force = VALUE[f"wearer.{joint}.fastest"], strength(joint)
    most = stiffness * FARTHEST + damping * fastest
    inputs = [*span, -fastest, fastest, force[0] - most, force[1] + most]
    return [0], [0, -stiffness, -damping], [0], force, inputs, 0, 0


def motor(joint):
    """The same of a motor: docs/model.md has the rule for resistance and greatest voltage."""
    value = {
        what: VALUE[f"exo.{joint}.{what}"]
        for what in ("peak_torque", "no_load_speed", "viscous", "bandwidth", "armature")
    }
    peak, drag = value["peak_torque"], value["viscous"] * value["no_load_speed"]
    resistance = value["no_load_speed"] / (peak - drag)
    gain = [resistance, 1, 0, 0, 0, 0, 0, resistance * peak]
    lag, limits = [1 / (2 * np.pi * value["bandwidth"])], [-peak, peak]
    return gain, [0], lag, limits, limits, value["armature"], value["viscous"]


CONFIGS = [
    {},
    {"coupling": "cuffs"},
    {"coupling": "none"},
    {"suit": "none", "coupling": "none"},
]
MODELS = pytest.mark.parametrize("fields", CONFIGS, ids=["rigid", "cuffs", "no exo", "bare"])


@MODELS
def test_masses_and_moments_are_explained(fields):
    config = ArmConfig(**fields)
    spec = arm_spec(config)
    model, expected = spec.compile(), masses(config)
    for i in range(model.nbody):
        name = model.body(i).name
        assert model.body_mass[i] == pytest.approx(expected.get(name, 0.0)), name
        if name not in expected:
            assert not model.body_inertia[i].any()
        elif spec.body(name).explicitinertial:
            assert model.body_inertia[i] == pytest.approx(moments(config)[name])
            assert model.body_ipos[i] == pytest.approx(centers(config)[name], abs=1e-12)
        else:
            assert name in {"exo_shoulder_support", "exo_upper_arm", "exo_forearm"}


@MODELS
def test_sizes_are_explained(fields):
    model, arm = arm_spec(ArmConfig(**fields)).compile(), segments(Person())
    assert model.body("torso").pos[2] == VALUE["torso.shoulder_height"]
    assert model.body("shoulder").pos[1] == -VALUE["torso.shoulder_half_width"]
    assert model.body("forearm").pos == pytest.approx([0, 0, -arm["upper_arm"].length])
    assert model.body("hand").pos == pytest.approx([0, 0, -arm["forearm"].length])
    assert model.opt.gravity[2] == -VALUE["gravity.earth"]


@MODELS
def test_joints_are_explained(fields):
    config = ArmConfig(**fields)
    model, expected = arm_spec(config).compile(), joints(config)
    assert {model.joint(i).name for i in range(model.njnt)} == set(expected)
    for name, (span, stiffness, rest, damping, armature, friction, limits) in expected.items():
        i = model.joint(name).id
        assert model.jnt_range[i] == pytest.approx(span)
        assert (model.jnt_stiffness[i], model.qpos_spring[i]) == (stiffness, rest)
        assert (model.dof_damping[i], model.dof_armature[i]) == (damping, armature)
        assert model.dof_frictionloss[i] == friction
        assert model.jnt_actfrcrange[i] == pytest.approx(limits)
    for polynomial in (model.jnt_stiffnesspoly, model.dof_dampingpoly):
        assert not polynomial.any()


@MODELS
def test_actuators_are_explained(fields):
    config = ArmConfig(**fields)
    model = arm_spec(config).compile()
    expected = {f"human_{joint}": wearer(joint, joints(config)[joint][0]) for joint in JOINTS}
    if config.coupling != "none":
        expected |= {f"assist_{joint}": motor(joint) for joint in ASSISTED}
    assert {model.actuator(i).name for i in range(model.nactuator)} == set(expected)
    for name, (gain, bias, dynamics, force, control, armature, damping) in expected.items():
        i = model.actuator(name).id
        first = model.actuator_ctrladr[i]
        inputs = model.actuator_ctrlrange[first : first + model.actuator_ctrlnum[i]]
        for actual, wanted in (
            (model.actuator_gainprm[i], gain),
            (model.actuator_biasprm[i], bias),
            (model.actuator_dynprm[i], dynamics),
            (inputs.ravel(), control),
        ):
            assert actual == pytest.approx(np.pad(wanted, (0, actual.size - len(wanted))))
        assert model.actuator_forcerange[i] == pytest.approx(force)
        assert (model.actuator_armature[i], model.actuator_damping[i]) == (armature, damping)


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
