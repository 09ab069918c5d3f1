"""Strength, passive torque and body segments of the wearer against published tables."""

import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs.domain.randomization import Randomization
from activesuit.envs.model import ArmConfig
from activesuit.envs.person import (
    Person,
    isometric_strength,
    passive_torque,
    range_of_motion,
    segments,
    strength_limits,
)
from activesuit.envs.person.strength import DIRECTIONS, PROVENANCE
from helpers import assert_refused

VALUE = {quantity.name: quantity.value for quantity in PROVENANCE}
GROUPS = [(i, j) for i in range(2) for j in range(4)]  # directions and joints
RANGES = np.array([range_of_motion(joint) for joint in JOINTS])


def tabled(direction, joint, column):
    return VALUE[f"strength.{JOINTS[joint]}.{DIRECTIONS[direction]}.{column}"]


def torque_of(direction, joint, angle, speed=0.0, person=None):
    """Torque of one muscle group [N·m] at an angle and a speed of shortening."""
    angles, rates = np.zeros(4), np.zeros(4)
    angles[joint], rates[joint] = angle, speed * (-1, 1)[direction]
    limits = strength_limits(isometric_strength(person or Person()), angles, rates)
    return abs(limits[direction][joint])


def strengths(n, seed=0):
    rng = np.random.default_rng(seed)
    sizes = rng.uniform([1.4, 40, 1], [2.1, 140, 99], (n, 3))
    named = (dict(zip(("stature", "mass", "strength"), row, strict=True)) for row in sizes)
    people = (Person(sex=rng.choice(["male", "female"]), **size) for size in named)
    return np.stack([isometric_strength(person) for person in people])


def test_the_reference_man_and_an_average_woman():
    expected = [[70, 85, 52, 10], [55, 99.2, 70, 18]]
    np.testing.assert_array_equal(isometric_strength(Person()), expected)
    woman, man = Person.percentile("female", 50), Person.percentile("male", 50)
    np.testing.assert_allclose(isometric_strength(woman) / isometric_strength(man), 0.55)
    alike = Person(sex="female", stature=1.78, mass=80)
    assert (isometric_strength(alike) < isometric_strength(Person())).all()


def test_tabled_points_are_met():
    for direction, joint in GROUPS:
        peak, fastest, best, width, eccentric, half_speed = (
            tabled(direction, joint, column)
            for column in ("peak", "fastest", "best_angle", "width", "eccentric", "half_speed")
        )
        points = [(best + way * width, 0) for way in (0, 1, -1)]
        points += [(best, share * fastest) for share in (0.5, 1, -1)]
        torque = [torque_of(direction, joint, angle, speed) for angle, speed in points]
        drop = np.exp(-0.5)
        expected = [peak, drop * peak, drop * peak, half_speed * peak, 0, eccentric * peak]
        np.testing.assert_allclose(torque, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    ("degrees", "speed", "published", "tolerance"),
    [(0, 0, 89.9, 0.03), (45, 0, 68.6, 0.03), (45, 50, 46.9, 0.005), (45, -50, 75.3, 0.005)],
)
def test_shoulder_flexors_are_those_of_the_26_men(degrees, speed, published, tolerance):
    # McGill et al. 1994. The standard error of their means is 3.7 % at the spread of the model.
    torque = torque_of(1, 1, np.deg2rad(degrees), np.deg2rad(speed))
    assert torque == pytest.approx(published, rel=tolerance)


def test_the_bare_arm_takes_22_to_25_percent_of_a_mans_strength():
    assert 0.22 < 11.82 / torque_of(1, 1, np.pi / 2) < 0.25  # N·m, see model/test_compose.py


def test_elbow_flexors_are_strongest_at_a_right_angle_and_half_as_strong_straight():
    angles = np.linspace(0, 2.4, 25)
    torque = [torque_of(1, 2, angle) for angle in angles]
    assert abs(angles[np.argmax(torque)] - np.pi / 2) < 0.1
    # Moment arms of brachialis and brachioradialis at full extension over those at 90 degrees.
    assert 0.37 < torque[0] / torque_of(1, 2, np.pi / 2) < 0.56


def test_torque_falls_smoothly_with_the_speed_of_shortening():
    for direction, joint in GROUPS:
        fastest = tabled(direction, joint, "fastest")
        speed = np.linspace(-1.2 * fastest, 1.2 * fastest, 24_001)
        angles, rates = np.zeros((speed.size, 4)), np.zeros((speed.size, 4))
        rates[:, joint] = speed * (-1, 1)[direction]
        limits = strength_limits(isometric_strength(Person()), angles, rates)[direction][:, joint]
        torque = np.abs(limits) / torque_of(direction, joint, 0)
        slope = np.diff(torque) / np.diff(speed / fastest)
        moving = np.abs(speed[:-1]) < 0.999 * fastest
        assert (slope[moving] < 0).all() and (slope[~moving] <= 0).all()
        assert torque.max() <= tabled(direction, joint, "eccentric") * (1 + 1e-12)
        assert torque.min() == 0
        here = speed.size // 2  # the two hyperbolas join there
        assert slope[here - 1] == pytest.approx(slope[here], rel=0.03)


def test_limits_keep_their_signs_and_bounds_everywhere():
    rng, strength = np.random.default_rng(0), strengths(500)
    angle, rate = rng.uniform(-4, 4, (500, 4)), rng.uniform(-60, 60, (500, 4))
    low, high = strength_limits(strength, angle, rate)
    assert (low <= 0).all() and (high >= 0).all()
    greatest = strength * [[[tabled(i, j, "eccentric") for j in range(4)] for i in range(2)]]
    assert (-low <= greatest[:, 0] * (1 + 1e-12)).all()
    assert (high <= greatest[:, 1] * (1 + 1e-12)).all()


def test_strength_grows_with_mass_and_percentile():
    masses = [isometric_strength(Person(mass=mass)) for mass in (40, 80, 120)]
    np.testing.assert_allclose(masses[1] / masses[0], 2)
    np.testing.assert_allclose(masses[2] / masses[0], 3)
    ranks = np.array([isometric_strength(Person(strength=rank)) for rank in range(1, 100)])
    assert (np.diff(ranks, axis=0) > 0).all()
    np.testing.assert_allclose(ranks[49], isometric_strength(Person()))
    # The spread between people of one sex and mass is the published coefficient of variation.
    rng = np.random.default_rng(0)
    drawn = [isometric_strength(Person(strength=p))[1, 2] for p in rng.uniform(1, 99, 4000)]
    assert np.std(drawn) / np.mean(drawn) == pytest.approx(0.187, rel=0.1)


def test_many_wearers_at_once_are_those_one_by_one_bit_for_bit():
    rng, strength = np.random.default_rng(1), strengths(37)
    angle, rate = rng.uniform(-3, 3, (37, 4)), rng.uniform(-20, 20, (37, 4))
    low, high = strength_limits(strength, angle, rate)
    passive = passive_torque(strength, angle, rate)
    for i in range(37):
        one = strength_limits(strength[i], angle[i], rate[i])
        np.testing.assert_array_equal(one, (low[i], high[i]))
        np.testing.assert_array_equal(passive_torque(strength[i], angle[i], rate[i]), passive[i])
    alone = strength_limits(strength[0], angle, rate)[1]
    assert alone.shape == (37, 4)


def test_passive_torque_pulls_back_from_the_end_of_the_range():
    for direction, joint in GROUPS:
        strength = isometric_strength(Person())
        begin, full = (tabled(direction, joint, c) for c in ("passive_from", "passive_peak"))
        angles = np.zeros((3, 4))
        angles[:, joint] = begin, (begin + full) / 2, full
        torque = passive_torque(strength, angles, np.zeros(4))[:, joint]
        spring = 1.1 * (1.274 - angles[:, joint]) * (joint == 2)
        pull = (torque - spring) * (-1, 1)[direction]
        peak = tabled(direction, joint, "peak")
        np.testing.assert_allclose(pull, [0, peak / 4, peak], rtol=1e-12, atol=1e-12)


def test_passive_torque_never_feeds_energy_into_a_cycle():
    phase = np.linspace(0, 2 * np.pi, 20_001)
    middle, amplitude = RANGES.mean(axis=1), np.ptp(RANGES, axis=1) / 2
    angle = middle + amplitude * np.sin(phase)[:, None]
    rate = amplitude * np.cos(phase)[:, None]
    torque = passive_torque(isometric_strength(Person()), angle, rate)
    work = np.trapezoid(torque * rate, phase, axis=0)
    viscosity = np.array([VALUE[f"passive.{joint}.viscosity"] for joint in JOINTS])
    np.testing.assert_allclose(work, -viscosity * np.pi * amplitude**2, rtol=1e-6)


def test_a_relaxed_arm_meets_no_end_stop_inside_its_working_range():
    strength = isometric_strength(Person())
    for angle in np.linspace(-0.5, 2.0, 11):
        torque = passive_torque(strength, [angle, angle, max(angle, 0.0), angle / 3], np.zeros(4))
        assert torque[[0, 1, 3]].tolist() == [0, 0, 0]
        assert abs(torque[2]) <= 1.1 * 1.274


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
