"""Mistakes of a recording, and fits that deserve doubt: what is said about each."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.assets import curves_path
from activesuit.benchmarks.honesty.faults import FAULTS, is_named, named
from activesuit.identification import Curve, Remark, fit_curves, load_curves, save_curves
from activesuit.identification.fit import diagnostics
from activesuit.identification.judging.recording import recording_faults
from activesuit.published import LI_BOUNDS
from helpers import along, assert_refused, sweep

UNCERTAIN = ("play 0.3 degrees", "sensor lag 0.1 s")
SLOW = {  # to fit
    *("a copy 5 % larger", "rows shuffled", "exchanged columns, degrees", "tare and play"),
    *("rate and drift", "turns missing", "rate 1 N·m·s/rad", "play 1 degree"),
    *("drift 2 % a curve", "a curve twice, one 5 % larger", "tare 0.8 N·m"),
}
DIFFICULT = [
    ("play 0.3 degrees", 0),  # surer at its size than by its column
    ("gap 4 degrees", 1),  # the motion begins at a face, not between both
    ("a curve twice, one 5 % larger", 4),  # its own repeat says little of slow noise
    ("one curve negated", 4),  # the other curves hide the sign of the whole
    ("negated torque", 6),  # so thin that the loops take energy by either sign
    ("turns missing", 1),  # the torque does not jump
    ("mN·m", 36),  # a fit of the fault ends far beyond all angles
    ("single outliers", 10),  # their neighbors are no sign of heavy tails
]
FAST = [(name, 0) for name in FAULTS if name not in {*UNCERTAIN, *SLOW}]
SLOWER = [(name, 0) for name in FAULTS if name in SLOW] + DIFFICULT
CASES = [*FAST, *(pytest.param(one, marks=pytest.mark.slow) for one in SLOWER)]


@pytest.mark.parametrize("case", CASES)
def test_a_fault_is_named(case):
    """`python -m activesuit.benchmarks honesty` has the rates of all of them."""
    fault, seed = case
    assert is_named(fault, named(fault, seed))


def test_lines_of_the_file_are_named(elbow, tmp_path):
    whole = along(elbow, 0.52, 1.5, 0.52, samples=60, noise=0.01)
    clipped = replace(whole, torque=np.minimum(whole.torque, 3.0))
    save_curves(tmp_path / "elbow.csv", [clipped], ["a comment"])
    (remark,) = recording_faults(load_curves(tmp_path / "elbow.csv"))
    first = int(np.argmax(clipped.torque == 3.0)) + 3  # after comment and header
    assert (remark.code, remark.values["place"]) == ("clipped", f"line {first}")
    (remark,) = recording_faults([clipped])
    assert remark.values["place"] == f"sample {first - 3} of curve 'A'"


def test_a_plateau_is_no_fault_and_a_rest_is_asked_about():
    angle = sweep(0.0, 1.0, 0.0, samples=60)
    time = np.arange(angle.size, dtype=np.float64)
    time[60:] += 40.0  # a rest at the turn, in which the torque stays
    flat = Curve(angle, np.minimum(20 * angle, 3.0), "A", time=time)
    (asked,) = recording_faults([flat])  # nothing tells it from a turn that was cut off
    assert asked.kind == "turn rest"
    time[60:] -= 38.0  # a few samples, in which it could not go far
    assert recording_faults([replace(flat, time=time)]) == []


def said(curves):
    return {one.kind: one.values for one in fit_curves(curves).remarks}


def test_what_a_fit_says(elbow, table_2):
    assert said(load_curves(curves_path("elbow"))) == {}
    shoulder = said(load_curves(curves_path("shoulder")))
    assert shoulder["range"] == pytest.approx({"low": 0.35, "high": 1.22}, abs=0.01)
    outside = replace(table_2["shoulder-sa-pso"], alpha=6.5)  # just outside the certificate
    assert "certificate" in said([along(outside, 0.35, 1.22, 0.9, 1.22)])
    tiny = along(elbow, *np.radians([0.52, 1.5, 0.52]))
    assert said([tiny])["unit angle"]["span"] == pytest.approx(0.0171, rel=0.01)
    whole = along(elbow, 0.52, 1.5, 0.52)
    order = np.random.default_rng(0).permutation(whole.angle.size)
    shuffled = Curve(whole.angle[order], whole.torque[order], "A")
    assert "disorder rows" in said([shuffled])


def test_what_shows_no_loop_is_refused(elbow):
    up = along(elbow, 0.52, 1.5, samples=50)
    jitter = up.angle + np.random.default_rng(0).normal(0, 0.005, up.angle.size)
    rows = [
        (up, "no curve turns back"),
        (replace(up, angle=jitter), "no curve turns back"),
        (Curve([0, 1, 0], [0, 1, -1], "A"), "have 3 samples in all: give at least 10"),
    ]
    assert_refused(lambda curve: fit_curves([curve]), rows)


def test_limits_of_a_swarm(small_family, elbow):
    (found,) = diagnostics(replace(elbow, Ms=100.0), 0.01, small_family, LI_BOUNDS)
    assert found == Remark("limit", {"name": "Ms", "value": 100.0, "limit": 100.0})
    assert [*diagnostics(elbow, 0.01, small_family, LI_BOUNDS)] == []
