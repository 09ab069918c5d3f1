"""Files of the motion of one joint."""

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.identification import Motion, load_motion, nested_motion, save_motion
from helpers import assert_refused


def write(folder, text):
    path = folder / "motion.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_round_trip(tmp_path):
    for timed in [True, False]:
        design = nested_motion(0.52, 1.57)
        save_motion(tmp_path / "a.csv", Motion(design.time if timed else None, design.angle))
        time, angle = load_motion(tmp_path / "a.csv")
        np.testing.assert_allclose(angle, design.angle, atol=1e-9)
        if timed:
            np.testing.assert_allclose(time, design.time, rtol=1e-11)
        else:
            assert time is None


def test_columns_of_tasks_of_curves_and_of_degrees(tmp_path):
    text = "time,elbow_flexion,shoulder_flexion\n0,0.5,1\n1,0.7,2\n"
    found = load_motion(write(tmp_path, text), "elbow_flexion")
    np.testing.assert_array_equal(found.angle, [0.5, 0.7])
    np.testing.assert_array_equal(found.time, [0, 1])
    text = "# measured\ncurve,time_s,angle_deg,torque_nm\nA,0,0,1\n\nA,0.5,90,2\n"
    np.testing.assert_allclose(load_motion(write(tmp_path, text)).angle, [0, np.pi / 2])


def test_bad_files(tmp_path):
    rows = [
        ("", "is empty: give a header 'time_s,angle_rad'"),
        ("time_s,angle\n0,1\n", "none of the columns angle_rad, angle_deg: give exactly one"),
        ("angle_rad,angle_deg\n0,1\n", "has angle_rad and angle_deg: give exactly one"),
        ("time,elbow_flexion\n0,1\n", "none of the columns angle_rad"),
        ("angle_rad\n0\n", "has 1 samples: a motion needs at least 2"),
        ("angle_rad\n1\n1\n", "stays at the angle 1 rad"),
        ("time_s,angle_rad\n0,1\n1\n", "line 3: 1 cells where the header has 2"),
        ("time_s,angle_rad\n0,1\n1,nan\n", "line 3: angle_rad is 'nan'"),
        ("time_s,angle_rad\n0,1\n1,90\n", "line 3: angle_rad is 90 rad, more than a full turn"),
        ("time_s,angle_rad\n0,1\n,2\n", "line 3: time_s is ''"),
        ("time_s,angle_rad\n0.5,1\n0.4,2\n", "line 3: the time runs back from 0.5 to 0.4 s: put"),
        ("time_s,angle_rad\n0.5,1\n0.5,2\n", "line 3: the time stands still at 0.5 s"),
    ]
    assert_refused(lambda text: load_motion(write(tmp_path, text)), rows)


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(InputError, match="cannot read the motion"):
        load_motion(tmp_path / "none.csv")
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"cannot read the motion.*not a text file"):
        load_motion(tmp_path / "binary.csv")
