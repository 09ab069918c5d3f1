import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs.domain.randomization import Randomization
from activesuit.envs.model import ArmConfig
from activesuit.envs.person import Person, range_of_motion, segments
from helpers import assert_refused


def test_default_man_has_the_segments_worked_out_from_de_leva():
    arm = segments(Person())
    expected = {
        "upper_arm": (0.2880, 2.168, 0.1662, (0.01461, 0.01301, 0.00449)),
        "forearm": (0.2749, 1.296, 0.1258, (0.00746, 0.00688, 0.00143)),
        "hand": (0.0881, 0.488, 0.0696, (0.00149, 0.00100, 0.00061)),
    }
    assert list(arm) == list(expected)
    for name, (length, mass, center, inertia) in expected.items():
        assert arm[name].length == pytest.approx(length, abs=6e-5)
        assert arm[name].mass == pytest.approx(mass, abs=6e-4)
        assert arm[name].center == pytest.approx(center, abs=6e-5)
        assert arm[name].inertia == pytest.approx(inertia, abs=6e-6)


def test_a_woman_has_the_female_table():
    arm = segments(Person(sex="female", stature=1.735, mass=61.9))
    lengths = [segment.length for segment in arm.values()]
    assert lengths == pytest.approx([0.2751, 0.2643, 0.0780])
    masses = [segment.mass / 61.9 for segment in arm.values()]
    assert masses == pytest.approx([0.0255, 0.0138, 0.0056])
    centers = [segment.center / segment.length for segment in arm.values()]
    assert centers == pytest.approx([0.5754, 0.4559, 0.7474])
    hand = arm["hand"]
    radii = np.sqrt(np.array(hand.inertia) / hand.mass) / hand.length
    assert radii == pytest.approx([0.531, 0.454, 0.335])


def test_segments_scale_with_stature_and_mass():
    small = segments(Person(sex="female", stature=1.5, mass=50))
    large = segments(Person(sex="female", stature=1.8, mass=100))
    for name in small:
        assert large[name].length == pytest.approx(1.2 * small[name].length)
        assert large[name].mass == pytest.approx(2 * small[name].mass)
        assert large[name].inertia == pytest.approx(2 * 1.44 * np.array(small[name].inertia))
        sagittal, transverse, longitudinal = large[name].inertia
        assert sagittal < transverse + longitudinal  # true of every rigid body


def test_percentiles_are_those_of_the_survey():
    middle = Person.percentile("male", 50)
    assert (middle.stature, middle.mass) == pytest.approx((1.756, 85.5))
    small, large = Person.percentile("female", 5), Person.percentile("male", 95)
    assert small.stature == pytest.approx(1.629 - 1.645 * 0.0642, abs=1e-3)
    assert small.mass == pytest.approx(67.8 - 1.645 * 11.0, abs=0.1)
    assert large.stature == pytest.approx(1.756 + 1.645 * 0.0686, abs=1e-3)
    assert large.mass == pytest.approx(85.5 + 1.645 * 14.2, abs=0.1)
    assert small.strength == large.strength == 50


def test_a_person_that_cannot_be_is_refused():
    rows = [
        ({"stature": 178}, r"^stature is 178: .*; 178 cm is 1.78 m$"),
        ({"stature": 5.8}, r"^stature is 5.8: .*; 5.8 ft is 1.77 m$"),
        ({"stature": float("nan")}, "^stature is nan: "),
        ({"mass": 180}, "^mass is 180: use a number from 40 to 140 kg$"),
        ({"strength": 0}, "^strength is 0: use a number from 1 to 99 .percentile.$"),
        ({"sex": "man"}, "^unknown sex 'man': use one of female, male"),
    ]
    assert_refused(lambda fields: Person(**fields), rows)
    assert_refused(
        Person.percentile, [("male", 0.5, "^percentile is 0.5: use a number from 1 to 99")]
    )


def test_ranges_of_motion_are_the_published_ones():
    ranges = np.rad2deg([range_of_motion(joint) for joint in JOINTS])
    np.testing.assert_allclose(ranges[1:], [(-62, 167), (0, 143), (-75, 76)])
    assert ranges[0, 1] == pytest.approx(184)
    assert_refused(range_of_motion, [("elbow", "unknown joint 'elbow': use one of")])


def test_the_usual_size_is_that_of_the_sex():
    woman = Person.percentile("female", 50)
    assert (Person(), Person(sex="male")) == (Person(stature=1.78, mass=80.0),) * 2
    assert Person(sex="female") == woman
    assert ArmConfig(wearer={"sex": "female"}).wearer == woman
    light = Person(sex="female", stature=woman.stature, mass=60)
    assert ArmConfig.from_dict({"wearer": {"sex": "female", "mass": 60}}).wearer == light
    assert Randomization(wearers=[{"sex": "female"}]).wearers == (woman,)
