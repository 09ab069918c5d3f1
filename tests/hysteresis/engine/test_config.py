"""Hysteresis in plain MJCF: what works, and one sentence for each mistake."""

import re

import mujoco
import numpy as np
import pytest
from activesuit.hysteresis import Asymmetric, model_from_dict
from activesuit.hysteresis.engine import attach

ARM = """<mujoco><worldbody>
  <body><joint name="one" axis="0 1 0"/><geom size=".1"/></body>
  <body><joint name="ball" type="ball"/><geom size=".1"/></body>
  <body><joint name="free" type="free"/><geom size=".1"/></body>
  </worldbody></mujoco>"""

JILES_ATHERTON = {"joint": "one", "Ms": 11.4, "a": 129, "alpha": -0.05, "c": 6.4, "k": 23}
JILES_ATHERTON["angle_unit"] = "deg"
BOUC_WEN = {"joint": "one", "elastic": 1, "hysteretic": 5, "A": 1, "beta": 3, "gamma": 1, "n": 1.5}
PRANDTL_ISHLINSKII = {"joint": "one", "stiffness": 1}
PRANDTL_ISHLINSKII |= {"thresholds": "0.1 0.2 0.5", "weights": "3 2 1"}
HINGED_STOPS = {**PRANDTL_ISHLINSKII, "knots": "-1 1", "slopes": "0.5 1 2"}
PREISACH = {"joint": "one", "levels": "-1 0 1", "density": "0.5 0.25 0.5", "elastic": "3 4"}
DAHL = {"joint": "one", "spring": "0.2 3 -1", "stiffness": 9, "friction": 1.5}
DUHEM = {"joint": "one", "spring": "0.2 3 -1", "stiffness": 9}
DUHEM |= {"friction_up": 1.5, "friction_down": 0.8}
ONE_NUMBER = "give one number, 0 or 1e-100 to 1e100 in size"
NUMBERS = "give numbers, 0 or 1e-100 to 1e100 in size, with blanks between them"
GOOD = {
    "jiles_atherton": JILES_ATHERTON,
    "bouc_wen": BOUC_WEN,
    "prandtl_ishlinskii": PRANDTL_ISHLINSKII,
    "hinged_stops": HINGED_STOPS,
    "preisach": PREISACH,
    "dahl": DAHL,
    "duhem": DUHEM,
}


def mjcf(name, config, *sensors):
    keys = "".join(f'<config key="{k}" value="{v}"/>' for k, v in config.items())
    instance = f'<instance name="i">{keys}</instance>'
    extension = f'<extension><plugin plugin="activesuit.{name}">{instance}</plugin></extension>'
    rows = "".join(f'<plugin name="{sensor}" instance="i"/>' for sensor in sensors)
    sensors = f"<sensor>{rows}</sensor></mujoco>"
    return ARM.replace("<mujoco>", "<mujoco>" + extension).replace("</mujoco>", sensors)


def twin(name):
    """The same model from Python."""
    content = {
        key: [float(word) for word in value.split()] if " " in str(value) else value
        for key, value in GOOD[name].items()
        if key != "joint"
    }
    if name == "preisach":
        content["density"] = [[0.5], [0.25, 0.5]]
    return model_from_dict({"model": name.replace("_", "-"), **content})


def torque_at(angle, name, config, *sensors):
    model = mujoco.MjModel.from_xml_string(mjcf(name, config, "a_torque", *sensors))
    data = mujoco.MjData(model)
    data.qpos[0] = angle
    mujoco.mj_forward(model, data)
    return data.sensor("a_torque").data[0]


def test_plain_mjcf_works():
    for name, config in GOOD.items():
        assert -0.5 > torque_at(0.4, name, config, "a_energy") == -twin(name).response([0, 0.4])[-1]


def test_a_polynomial_adds_to_any_model():
    for name, config in GOOD.items():
        asymmetric = Asymmetric(model=twin(name), polynomial=[0.5, -1, 2])
        expected = asymmetric.response([0.0, 0.4], initial_torque=0.6)[-1]
        more = {**config, "polynomial": " 0.5\t-1 2\n", "start_torque": "0.6"}
        assert torque_at(0.4, name, more) == pytest.approx(-expected, rel=1e-14)


def test_saving_keeps_every_bit(elbow):
    spec = mujoco.MjSpec.from_string(ARM)
    attach(spec, "one", elbow, start_angle=0.1)
    again = mujoco.MjModel.from_xml_string(spec.to_xml())
    begun = [mujoco.MjData(one).plugin_state for one in (again, spec.compile())]
    np.testing.assert_array_equal(*begun)


def test_numbers_are_read_as_python_reads_them():
    for text in ["1e-99", "3.14159265358979323846", "  12.5 ", "+7.e-1", "1e99"]:
        config = {**JILES_ATHERTON, "start_angle": text, "allow_uncertified": "true"}
        model = mujoco.MjModel.from_xml_string(mjcf("jiles_atherton", config))
        assert mujoco.MjData(model).plugin_state[1] == float(text)


# The published shoulder.
RISKY = {"Ms": "22.2316", "a": "319.55", "alpha": "6.3223", "c": "4.7447", "k": "168.582"}
RISKY["allow_uncertified"] = "true"


def say(key, value, what):
    return f"'one': {key} is '{re.escape(value)}': {what}"


BAD = [
    ("jiles_atherton", {"joint": "nope"}, "of joint 'nope': the model has no such joint"),
    ("jiles_atherton", {"joint": "ball"}, "of joint 'ball': the joint is not a hinge or a slide"),
    ("bouc_wen", {"joint": "free"}, "bouc_wen of joint 'free': the joint is not a hinge"),
    ("jiles_atherton", {"Ms": "many"}, say("Ms", "many", ONE_NUMBER)),
    ("jiles_atherton", {"a": "-3"}, r"'one': a is -3\.0 deg: give a number above 0"),
    ("jiles_atherton", {"angle_unit": "turn"}, say("angle_unit", "turn", "use 'rad' or 'deg'")),
    ("jiles_atherton", {"form": "wiki"}, say("form", "wiki", "use 'bulk' or 'original'")),
    ("jiles_atherton", {"clamp": "on"}, say("clamp", "on", "use 'none' or 'jiles' or 'irr")),
    ("jiles_atherton", {"alpha": "5"}, "certificate margin is -0.738 .* or allow_uncertified"),
    ("jiles_atherton", {"form": "original"}, "certificate margin is -|dissipative is False"),
    ("jiles_atherton", {"form": "original", "c": "-1"}, r"'one': c is -1\.0: give a number of at"),
    ("jiles_atherton", {"start_angle": "1 rad"}, say("start_angle", "1 rad", "give one")),
    ("jiles_atherton", {"start_path": "1 inf"}, say("start_path", "1 inf", NUMBERS)),
    ("jiles_atherton", {**RISKY, "start_path": "2.5 -1"}, "the torque becomes infinite between"),
    ("jiles_atherton", {"start_angle": "3"}, "outside the certificate, within"),
    ("jiles_atherton", {"allow_uncertified": "1"}, say("allow_uncertified", "1", "use true")),
    ("jiles_atherton", {"polynomial": "1 x"}, say("polynomial", "1 x", NUMBERS)),
    (
        "jiles_atherton",
        {"polynomial": "1 1 1 1 1 1 1"},
        "has 7 coefficients: give at most 6",
    ),
    ("jiles_atherton", {"angle_range": "1 0"}, r"angle_range is \[1\.0, 0\.0\]: give two asc"),
    ("bouc_wen", {"angle_range": "1"}, r"angle_range is \[1\.0\]: give two asc"),
    ("jiles_atherton", {"colour": "red"}, "unrecognized attribute 'plugin:colour'"),
    ("bouc_wen", {"Ms": "1"}, "unrecognized attribute 'plugin:Ms'"),
    ("bouc_wen", {"hysteretic": "0"}, r"hysteretic is 0\.0 N·m/rad: give a number other"),
    ("bouc_wen", {"gamma": "-4"}, "certificate margin is -|dissipative is False"),
    ("bouc_wen", {"start_torque": "40"}, "outside the certificate, within"),
    ("prandtl_ishlinskii", {"thresholds": "0.1 x"}, say("thresholds", "0.1 x", NUMBERS)),
    ("prandtl_ishlinskii", {"thresholds": "0.1 0.5 0.2"}, "give increasing numbers"),
    ("prandtl_ishlinskii", {"weights": "1 2"}, r"weights is \(1\.0, 2\.0\) .*: give as many"),
    ("prandtl_ishlinskii", {"weights": "3 -2 1"}, "certificate margin is -|dissipative is False"),
    ("prandtl_ishlinskii", {"start_torque": "40"}, "40 N·m .* this prandtl-ishlinskii model can"),
    ("hinged_stops", {"knots": "1 -1"}, r"knots is \(1\.0, -1\.0\) N·m: give 1 to 16 incr"),
    ("dahl", {"spring": ""}, "spring is ''"),
    ("dahl", {"spring": " 1" * 7}, "give 1 to 6 coefficients"),
    ("duhem", {"friction_up": "-1"}, r"friction_up is -1\.0 N·m: give a number above"),
    ("duhem", {"start_torque": "9"}, "outside the certificate, within"),
    ("preisach", {"levels": "0"}, r"levels is \[0\.0\]: give at least 2 angles"),
    ("preisach", {"density": "1 2"}, r"density\[1\] has 1 numbers: give 2"),
    ("preisach", {"density": "1"}, "give 2 rows, one for each segment of levels"),
    ("preisach", {"elastic": "1"}, r"elastic is \(1\.0,\) N·m/rad: give as many numbers"),
    ("preisach", {"density": "1 -2 1"}, "certificate margin is -|dissipative is False"),
]
NO_NUMBERS = ("1e999", "1e-320", "1e101", "0x10", "1e", ".", "1 2", "")
BAD += [("jiles_atherton", {"c": one}, say("c", one, ONE_NUMBER)) for one in NO_NUMBERS]
NOT_ABOVE_0 = "gap is .* rad: give an angle above 0"
BAD += [("jiles_atherton", {"gap": one}, NOT_ABOVE_0) for one in ("0", "-0.1")]
NO_GAPS = ("x", "0.1 0.2", "inf", "nan", "1_000", "\u0661")
BAD += [("jiles_atherton", {"gap": one}, say("gap", one, ONE_NUMBER)) for one in NO_GAPS]
BAD += [
    ("jiles_atherton", {"viscoelastic": given}, message)
    for given, message in {
        "0.1": "give damping, relaxation stiffness and relaxation time, three numbers",
        "0.1 -1 2": "relaxation_stiffness is -1 N·m/rad: give at least 0",
        "0.1 1 0": "relaxation_time is 0 s: give a time above 0",
        "0.1 x 2": say("viscoelastic", "0.1 x 2", NUMBERS),
    }.items()
]


def test_bad_mjcf_is_one_sentence():
    long = {"Ms": "9" * 5000 + "x"}  # is cut off
    for name, change, message in [*BAD, ("jiles_atherton", long, "'one': Ms is '999")]:
        with pytest.raises(ValueError, match=message):
            mujoco.MjModel.from_xml_string(mjcf(name, {**GOOD[name], **change}, "a_torque"))
    good = {"gap": "0.05", "viscoelastic": "0.1 0 0"}
    mujoco.MjModel.from_xml_string(mjcf("jiles_atherton", {**JILES_ATHERTON, **good}))


def test_bad_sensors():
    for name, config in GOOD.items():
        with pytest.raises(ValueError, match="must end in torque, stiffness or energy"):
            mujoco.MjModel.from_xml_string(mjcf(name, config, "elbow"))
        with pytest.raises(ValueError, match="two of its sensors measure the same"):
            mujoco.MjModel.from_xml_string(mjcf(name, config, "a_torque", "b_torque"))


def test_a_joint_has_one_model():
    text = mjcf("jiles_atherton", JILES_ATHERTON)
    second = mjcf("preisach", PREISACH).partition("<extension>")[2].partition("</extension>")[0]
    twice = text.replace("</extension>", second.replace('name="i"', 'name="k"') + "</extension>")
    with pytest.raises(ValueError, match="'one': another instance resists the joint already"):
        mujoco.MjModel.from_xml_string(twice)
