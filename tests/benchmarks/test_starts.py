"""The benchmark's random starts: our own fit keeps its limits, others spend their budget."""

import pytest
from activesuit.benchmarks import starts
from helpers import in_this_process, set_all

pytestmark = pytest.mark.slow


def test_certified_fits_keep_their_limits(monkeypatch):
    few = {"STARTS_PER_REPEAT": 2, "SWARM_SIZE": 20, "ITERATIONS": 9}
    set_all(monkeypatch, starts, run_all=in_this_process, **few)
    found = starts.random_starts(repeats=1)
    assert [(one.joint, one.method) for one in found] == [
        (joint, method) for joint in ("shoulder", "elbow") for method in starts.STARTED_METHODS
    ]
    for one in found:
        assert one.starts == 2
        assert one.milliseconds > 0
        if one.method == "certified":
            assert one.success_rate == 1
            assert one.over_floor < 1.05
            assert one.to_target <= one.evaluations <= one.most_evaluations <= 200
        else:
            assert one.met is None
            assert one.evaluations == one.most_evaluations == 20 * (9 + 1)
    header, rows = starts.starts_table(found)
    assert {len(row) for row in rows} == {len(header)}
