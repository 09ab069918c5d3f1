"""Mistakes of a recording, and what is said about each."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.benchmarks.honesty.faults import FAULTS, is_named, named
from activesuit.identification import Curve, load_curves, save_curves
from activesuit.identification.recording import recording_faults
from helpers import sweep

UNCERTAIN = ("play 0.3 degrees", "sensor lag 0.1 s")


SLOW = {  # to fit
    *("a copy 5 % larger", "rows shuffled", "exchanged columns, degrees", "tare and play"),
    *("rate and drift", "turns missing", "rate 1 N·m·s/rad", "play 1 degree"),
    *("drift 2 % a curve", "a curve twice, one 5 % larger", "tare 0.8 N·m"),
}
FAULT = [
    pytest.param(name, marks=pytest.mark.slow if name in SLOW else ())
    for name in FAULTS
    if name not in UNCERTAIN
]


@pytest.mark.parametrize("fault", FAULT)
def test_a_fault_is_named(fault):
    """`python -m activesuit.benchmarks honesty` has the rates of all of them."""
    assert is_named(fault, named(fault, 0))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "seed"),
    [
        ("play 0.3 degrees", 0),  # surer at its size than by its column
        ("gap 4 degrees", 1),  # the motion begins at a face, not between both
        ("a curve twice, one 5 % larger", 4),  # its own repeat says little of slow noise
        ("one curve negated", 4),  # the other curves hide the sign of the whole
        ("negated torque", 6),  # so thin that the loops take energy by either sign
        ("negated angle", 14),
        ("exchanged columns, degrees", 6),
        ("turns missing", 1),  # the torque does not jump
        ("clock runs back", 4),
        ("mN·m", 36),  # a fit of the fault ends far beyond all angles
        ("single outliers", 10),  # their neighbors are no sign of heavy tails
    ],
)
def test_a_fault_is_named_in_a_difficult_draw(fault, seed):
    assert is_named(fault, named(fault, seed))


def test_torques_in_another_unit(elbow):
    for factor in [1e3, 1e5, 1e-3]:
        angle = sweep(0.52, 1.5, 0.52)
        curve = Curve(angle, factor * elbow.response(angle), "A")
        found = recording_faults([curve])
        assert found[0].sentence.startswith("the torque peaks at ")
        assert found[0].sentence.endswith(
            " N·m, and that of a joint between 0.01 and 500 N·m: check its unit"
        )
        usual = Curve(angle, elbow.response(angle), "A")
        assert recording_faults([usual]) == []


def test_copies_milliseconds_and_coarse_samples(elbow):
    angle = sweep(0.52, 1.5, 0.52, samples=60)
    time = np.linspace(0, 10, angle.size)
    curve = Curve(angle, elbow.response(angle), "A", time=time)
    assert recording_faults([curve]) == []
    late = replace(curve, time=1000 * time)
    assert "check that time_s is in seconds" in recording_faults([late])[0].sentence
    coarse = replace(curve, angle=np.round(angle / 0.05) * 0.05)
    (remark,) = recording_faults([coarse])
    assert "angles of curve 'A' come in steps of 0.05 rad, 20" in remark.sentence
    fine = replace(curve, angle=np.round(angle / 0.001) * 0.001)
    assert recording_faults([fine]) == []
    copies = [curve, replace(curve, name="B"), replace(curve, name="C", torque=1.1 * curve.torque)]
    assert "curve 'B' is a copy of 'A' to the last digits" in recording_faults(copies)[0].sentence
    coarse = replace(curve, angle=angle[::13], torque=curve.torque[::13], time=time[::13])
    assert "samples of curve 'A' are up to" in recording_faults([coarse])[0].sentence


def test_lines_of_the_file_are_named(elbow, tmp_path):
    angle = sweep(0.52, 1.5, 0.52, samples=60)
    noise = 0.01 * np.random.default_rng(0).standard_normal(angle.size)
    clipped = np.minimum(elbow.response(angle) + noise, 3.0)
    save_curves(tmp_path / "elbow.csv", [Curve(angle, clipped, "A")], ["a comment"])
    (remark,) = recording_faults(load_curves(tmp_path / "elbow.csv"))
    first = int(np.argmax(clipped == 3.0)) + 3  # after comment and header
    assert remark.code == "clipped"
    assert f"from line {first} on" in remark.sentence
    (remark,) = recording_faults([Curve(angle, clipped, "A")])
    assert f"from sample {first - 3} of curve 'A' on" in remark.sentence


def test_a_plateau_is_no_fault_and_a_rest_is_asked_about():
    angle = sweep(0.0, 1.0, 0.0, samples=60)
    time = np.arange(angle.size, dtype=np.float64)
    time[60:] += 40.0  # a rest at the turn, in which the torque stays
    flat = Curve(angle, np.minimum(20 * angle, 3.0), "A", time=time)
    (asked,) = recording_faults([flat])  # nothing tells it from a turn that was cut off
    assert "if it did not rest there, record the turn too" in asked.sentence
    time[60:] -= 38.0  # a few samples, in which it could not go far
    assert recording_faults([replace(flat, time=time)]) == []
