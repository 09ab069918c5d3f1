"""What `bench muscles` says about the fit of MyoArm, its strength and the bare arm."""

import pytest
from activesuit.assets import JOINTS

pytest.importorskip("myo_sim")

from activesuit.benchmarks.muscles import EFFICIENCY, bare_arms, bare_table, strengths

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def found():
    return strengths()


def test_strengths_have_both_ways_and_speeds(found):
    assert {one.joint for one in found} == set(JOINTS)
    assert {one.speed for one in found} == {0.0, 60.0, 180.0}
    for one in found:
        assert 0 < one.balanced <= one.muscles + 1.1  # 1 N·m may be about another axis
        assert one.apart == (abs(one.muscles / one.ours - 1) > 0.3) and one.source


def test_muscles_are_weaker_when_they_shorten(found):
    for joint in JOINTS:
        for way in {one.way for one in found if one.joint == joint}:
            same = [one for one in found if (one.joint, one.way) == (joint, way)]
            at_speed = {one.speed: one for one in same if one.speed}
            still = next(one for one in same if one.degrees == at_speed[60.0].degrees)
            assert still.muscles > at_speed[60.0].muscles > at_speed[180.0].muscles


def test_the_bare_arm_takes_more_the_more_it_does():
    hanging, bent, straight, elbow, shoulder, crank = bare_arms()
    for model in hanging.power:
        assert hanging.power[model] == pytest.approx(0, abs=0.5)
        assert 0 < bent.power[model] < straight.power[model]
        assert elbow.power[model] < shoulder.power[model] < crank.power[model]
        assert crank.work < crank.power[model]
    assert crank.published == pytest.approx(crank.work / EFFICIENCY) and crank.work > 20
    header, rows = bare_table([hanging, crank])
    assert len(header) == len(rows[0]) and rows[0][1] == "0" and " x " in rows[1][1]
