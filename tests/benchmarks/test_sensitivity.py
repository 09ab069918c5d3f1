"""Assumed numbers that are halved and doubled."""

import pytest
from activesuit.benchmarks import sensitivity
from activesuit.benchmarks.sensitivity import NOMINAL, POLICIES, changes, sensitivity_table
from helpers import short_benchmark

pytestmark = pytest.mark.slow


def test_every_assumed_gain_is_halved_and_doubled():
    listed = dict(changes())
    assert next(iter(listed)) == NOMINAL
    for name in ("stiffness", "damping", "contraction", "reflex", "delay", "correction"):
        assert sum(f"control.{name} " in change for change in listed) == 2
    assert sum("coulomb" in change for change in listed) == 2


def test_a_conclusion_that_flips_is_named(monkeypatch):
    monkeypatch.setattr(sensitivity, "SETTINGS", (("ArmTracking", "microgravity"),))
    strong = {"exo": {"shoulder": {"coulomb": 12.0}, "elbow": {"coulomb": 8.0}}}
    monkeypatch.setattr(sensitivity, "changes", lambda: iter({NOMINAL: {}, "x 4": strong}.items()))
    with short_benchmark(3.0):
        usual, changed = sensitivity.sensitivity(8)
    assert (usual.change, usual.flipped, usual.kendall) == (NOMINAL, (), pytest.approx(1))
    assert "feedforward is better than no exoskeleton" in changed.flipped
    assert changed.relief["none"] < usual.relief["none"] < 0
    header, rows = sensitivity_table([usual, changed])
    assert len(rows) == 2
    assert all(len(row) == len(header) for row in rows)
    assert len([name for name in header if name.startswith("relief")]) == len(POLICIES)
