"""Motions from CSV files: as they were recorded, or refused in one sentence."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import ArmEnv
from activesuit.envs.tasks import ARM_TRACKING, RecordedMotion
from helpers import assert_refused

HEADER = ["time", *JOINTS]
STEP = 0.02  # s between recorded samples
TIME = STEP * np.arange(50)
SWING = np.column_stack(
    [TIME, 0.1 * np.sin(TIME), 0.8 + 0.2 * np.sin(TIME), 1 + 0.2 * np.cos(TIME), 0 * TIME]
)


def write(path, rows, header=HEADER):
    lines = [",".join(header), *(",".join(str(cell) for cell in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return str(path)


def test_a_recorded_plan_is_the_same_motion(tmp_path):
    """The step is 0.02 s, and the jerk of a move jumps by at most 60 rad / (1.2 s)^3.

    So a cubic spline is off by less than 35 rad/s³ (0.02 s)³ / 40 = 7e-6 rad, its slope by
    35 rad/s³ (0.02 s)² / 4 = 4e-3 rad/s. The end, where the spline is at rest and the motion is
    not, is half a second after what is compared.
    """
    dt, duration = 0.01, 2.0
    samples = round(duration / dt) + 1
    motion = ARM_TRACKING.motion(np.random.default_rng(5), samples + 50, dt)
    rows = np.column_stack([3.0 + dt * np.arange(samples + 50), motion[0]])[::2]
    order = [2, 0, 4, 1, 3]  # of columns, which have names
    path = write(tmp_path / "plan.csv", rows[:, order], [HEADER[i] for i in order])
    task = RecordedMotion(name="Recorded", path=path, duration=duration)
    found = task.motion(np.random.default_rng(0), samples, dt)
    for now, before, error in zip(found, motion, (7e-6, 4e-3, 1.0), strict=True):
        np.testing.assert_allclose(now, before[:samples], atol=error)
    assert np.ptp(found[0], axis=0)[1] > 0.3
    np.testing.assert_allclose(found[0][::2], motion[0][:samples:2], atol=1e-12)


def test_the_arm_follows_it_until_its_end(tmp_path):
    path = write(tmp_path / "swing.csv", SWING)
    task = RecordedMotion(name="Swing", path=path)
    assert task.duration == pytest.approx(TIME[-1])
    env = ArmEnv(task, coupling="none")
    env.reset(seed=0)
    truncated, steps = False, 0
    while not truncated:
        *_, terminated, truncated, info = env.step(np.zeros(0))
        assert not terminated
        steps += 1
    assert steps == round(TIME[-1] / 0.01)
    np.testing.assert_allclose(info["target_angle"], SWING[-1, 1:], atol=1e-12)
    longer = replace(task, duration=2.0).motion(np.random.default_rng(0), 201, 0.01)
    np.testing.assert_allclose(longer[0][120:], np.tile(SWING[-1, 1:], (81, 1)), atol=1e-12)
    assert not longer[1][120:].any() and not longer[2][120:].any()


def test_the_mark_of_spreadsheets_and_empty_lines_do_no_harm(tmp_path):
    path = tmp_path / "sheet.csv"
    plain = RecordedMotion(name="A", path=write(path, SWING)).motion(None, 50, 0.01)
    path.write_text("\ufeff" + path.read_text().replace("\n", "\r\n\r\n"), encoding="utf-8")
    sheet = RecordedMotion(name="B", path=str(path)).motion(None, 50, 0.01)
    np.testing.assert_array_equal(plain, sheet)


def test_files_that_are_no_motion_are_refused(tmp_path):
    def changed(row, column, value):
        rows = SWING.astype(object)
        rows[row, column] = value
        return rows

    def recorded(cells, header):
        path = write(tmp_path / "motion.csv", cells, header)
        return ArmEnv(RecordedMotion(name="Recorded", path=path), coupling="none")

    rows = [
        (np.delete(SWING, range(10, 15), axis=0), HEADER, "a gap from 0.18 to 0.3 s, .*: fill it"),
        (SWING * [20, 1, 1, 1, 1], HEADER, "samples may be 0.2 s apart at most"),
        (
            SWING * [1, *[180 / np.pi] * 4],
            HEADER,
            "if these are degrees, give radians",
        ),
        (SWING, ["time", "a", "b", "c", "d"], "has the columns time, a, b, c, d: use time, should"),
        ([], [], "is empty: give a header 'time,"),
        (SWING[:2], HEADER, "has 2 samples: a motion needs at least 3"),
        (changed(7, 0, SWING[6, 0]), HEADER, "line 9: the time stands still at 0.12 s"),
        (changed(7, 2, "bent"), HEADER, "shoulder_flexion is 'bent': give a finite number"),
        (changed(7, 2, "nan"), HEADER, "shoulder_flexion is .*: give a finite number"),
        ([*SWING[:9].tolist(), [1, 2]], HEADER, "line 11: 2 cells where the header has 5"),
        (SWING * [1e-4, 1, 1, 1, 1], HEADER, "lasts 9.8e-05 s: use 0.02 to 3600 s"),
        (
            SWING + np.eye(5)[3] * 2.5,
            HEADER,
            r"elbow_flexion from .* to .* rad: stay between",
        ),
    ]
    assert_refused(recorded, rows)
    rows = [(path, "cannot read the motion ") for path in ("nowhere.csv", ".", None, 3, "a\0b")]
    assert_refused(lambda path: RecordedMotion(name="Recorded", path=path), rows)
