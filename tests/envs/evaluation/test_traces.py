"""The trace of a motion as CSV: effort, strength, fatigue and heat where they exist."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation import rollout
from activesuit.envs.evaluation.figures import strain_plot
from activesuit.envs.evaluation.report import trace_columns
from activesuit.envs.model import ASSISTED
from activesuit.envs.policies import make_policy
from activesuit.envs.tasks import TASKS
from activesuit.scripts.folders import RunFolder

MUSCLES = [f"{joint}_{way}" for way in ("extensor", "flexor") for joint in JOINTS]


def played(**options):
    arms = ArmEnv(replace(TASKS["OverheadHold"], duration=1.0), **options).rows(1, threads=1)
    (trace,) = rollout(arms, make_policy("none", arms), [0])
    return trace


def columns(folder):
    with open(folder / "trace.csv") as file:
        (_, *header), *rows = csv.reader(file)
    return dict(zip(header, np.array([row[1:] for row in rows], float).T, strict=True))


def test_fatigue_strength_and_heat_are_in_the_trace(tmp_path):
    trace = played()
    assert trace.fatigue is not None and trace.motor_load is not None
    RunFolder(tmp_path).csv("trace.csv", *trace_columns({"none": trace}))
    found = columns(tmp_path)
    wanted = {f"{one}_fatigue": trace.fatigue.reshape(-1, 8)[:, i] for i, one in enumerate(MUSCLES)}
    left = trace.strength.reshape(-1, 8)
    wanted |= {f"{one}_strength_nm": left[:, i] for i, one in enumerate(MUSCLES)}
    wanted |= {f"{one}_motor_load": trace.motor_load[:, i] for i, one in enumerate(ASSISTED)}
    wanted |= {f"{one}_effort": trace.effort[:, i] for i, one in enumerate(JOINTS)}
    for name, values in wanted.items():
        np.testing.assert_allclose(found[name], values, rtol=1e-5, err_msg=name)
    assert found["shoulder_flexion_flexor_fatigue"][-1] > 0
    assert found["time_s"][-1] == pytest.approx(1.0)


@pytest.mark.parametrize(("options", "rows"), [({}, 4), ({"fatigue": False}, 3)])
def test_what_is_not_there_is_left_out(tmp_path, options, rows):
    bare = played(coupling="none", **options)
    RunFolder(tmp_path).csv("trace.csv", *trace_columns({"none": bare}))
    names = columns(tmp_path)
    assert not any("motor_load" in name for name in names)
    assert any("fatigue" in name for name in names) == (rows == 4)
    for trace, count in ((bare, rows - 1), (played(**options), rows)):
        assert len(strain_plot({"none": trace}).panels) == 2 * count
