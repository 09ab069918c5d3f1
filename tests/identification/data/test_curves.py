"""Files of curves, and of the motion of one joint."""

import hashlib
import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from activesuit.assets import curves_path
from activesuit.identification import (
    Curve,
    Curves,
    Motion,
    load_curves,
    load_motion,
    nested_motion,
    save_curves,
    save_motion,
)
from helpers import assert_refused

HEADER = "curve,angle_rad,torque_nm\n"
TIMED = "curve,time_s,angle_rad,torque_nm\n"


def write(folder, text):
    path = folder / "curves.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_round_trip(tmp_path, small_family):
    save_curves(tmp_path / "plain.csv", small_family, comments=["made by a test", "two\nlines"])
    text = (tmp_path / "plain.csv").read_text()
    assert text.startswith("# made by a test\n")
    assert "weight" not in text and "time_s" not in text
    steps = np.arange(small_family[0].angle.size)
    weights = (1.0, 0.1 + 0.2, 1e-9, 12345678.9)
    times = (steps / 25, None, steps / 3 + 3000, 1.7e9 + steps / 25)  # the last is a clock's
    full = [
        replace(one, weight=weight, time=time, torque=1e-6 * one.torque)
        for one, weight, time in zip(small_family, weights, times, strict=True)
    ]
    save_curves(tmp_path / "full.csv", full)
    text = (tmp_path / "full.csv").read_text()
    assert text.startswith("curve,role,weight,time_s,angle_rad,torque_nm\n")
    for curves, name in ((small_family, "plain"), (full, "full")):
        for before, after in zip(curves, load_curves(tmp_path / f"{name}.csv"), strict=True):
            same = [(one.name, one.role, one.weight) for one in (before, after)]
            assert same[0] == same[1]
            np.testing.assert_allclose(after.angle, before.angle, atol=1e-6)
            scale = np.abs(before.torque).max()
            np.testing.assert_allclose(after.torque, before.torque, atol=1e-6 * scale)
            if before.time is None:
                assert after.time is None
            else:
                start = before.time[0]
                np.testing.assert_allclose(after.time - start, before.time - start, atol=1e-5)


def test_bad_curves():
    rows = [
        ([0, 1, 0], [0, 1], {}, "equal length"),
        ([0, 1], [0.0, np.inf], {}, "not finite"),
        ([0, 90], [0, 1], {}, "reaches 90 rad, more than a full turn"),
        ([0, 1], [0, 1], {"weight": 0}, "curve 'A'.*weight 0: give a number above 0"),
        ([0, 1], [0, 1], {"weight": math.inf}, "curve 'A'.*is inf"),
        ([0, 1], [0, 1], {"weight": "1"}, "curve 'A'"),
        ([0, 1, 0], [0, 1, 2], {"time": [0, 2, 1]}, "back from 2 to 1 s at sample 2: put the samp"),
        ([0, 1, 0], [0, 1, 2], {"time": [0, 1, 1]}, "curve 'A': the time stands still at 1 s at s"),
        ([0, 1, 0], [0, 1, 2], {"time": [0, 1]}, r"times of shape \(2,\) and 3 samples"),
        ([0, 1, 0], [0, 1, 2], {"time": [0, 1, np.inf]}, "a time that is not finite"),
    ]
    names = ("#3", "", "two\nlines", "one\x0bmore", " padded", "padded ")
    rows += [([0, 1], [0, 1], {"name": name}, "curve name") for name in names]

    def made(angle, torque, options):
        Curve(np.array(angle), np.array(torque), **{"name": "A"} | options)

    assert_refused(made, rows)


def test_degrees_order_and_interleaved_curves(tmp_path):
    text = "curve,torque_nm,angle_deg\nA,1,10\nB,5,0\n\n# a remark\nA,2,20\nB,6,90\nA,3,15\n"
    first, second = load_curves(write(tmp_path, text))
    np.testing.assert_allclose(first.angle, np.radians([10, 20, 15]))
    np.testing.assert_array_equal(first.torque, [1, 2, 3])
    assert second.angle[1] == pytest.approx(math.pi / 2)
    assert first.role == "fit"


def test_bad_files(tmp_path):
    rows = [
        ("", r"curves\.csv.* is empty"),
        (HEADER, "header but no samples"),
        ("angle_rad,torque_nm\n0,0\n", "curve 'curves' has 1 sample: a curve needs at least 2"),
        (HEADER + "A,0,0\nA,nan,1\n", "line 3: angle_rad is 'nan': give a finite number"),
        (HEADER + "A,0,0\nA,1,heavy\n", "line 3: torque_nm is 'heavy'"),
        (HEADER + "A,0,0\nA,90,5\n", "angle_rad is 90 rad, more than a full turn.*angle_deg"),
        (HEADER + "A,0,0\nA,1\n", "line 3: 2 cells where the header has 3"),
        (HEADER + ",0,0\n,1,1\n", "line 2: the cell 'curve' is empty"),
        (HEADER + "A,0.5,0\nA,0.5,1\n", "stays at the angle 0.5 rad"),
        ("curve,role,angle_rad,torque_nm\nA,fit,0,0\nA,predict,1,1\n", "changes its role"),
        ("curve,role,angle_rad,torque_nm\nA,test,0,0\nA,test,1,1\n", "role 'test'"),
        ("curve,weight,angle_rad,torque_nm\nA,1,0,0\nA,2,1,1\n", "changes its weight to 2.0"),
        ("curve,weight,angle_rad,torque_nm\nA,0,0,0\nA,0,1,1\n", "weight 0: give a number above 0"),
        ("curve,weight,angle_rad,torque_nm\nA,x,0,0\n", "line 2: weight is 'x': give a finite"),
        (HEADER + 'A,"0,0\n', "not a CSV file"),
        (TIMED + "A,0,0,0\nB,5,0,0\nA,1,1,1\nB,4,1,1\n", "line 5: the time runs back from 5 to 4"),
        (TIMED + "A,0,0,0\nA,0,1,1\n", "line 3: the time stands still at 0 s"),
        (TIMED + "A,0,0,0\nA,,1,1\n", "line 3: curve 'A' has a time at some samples only"),
        (TIMED + "A,,0,0\nA,1,1,1\n", "line 3: curve 'A' has a time at some samples only"),
    ]
    assert_refused(lambda text: load_curves(write(tmp_path, text)), rows)


def test_names_survive_and_lists_are_welcome(tmp_path):
    curves = [Curve([0, 1], [0.0, 2], "run 1, left"), Curve([0, 1], [0, 1], 'a "b"')]
    save_curves(tmp_path / "odd.csv", curves)
    assert [curve.name for curve in load_curves(tmp_path / "odd.csv")] == ["run 1, left", 'a "b"']


def test_saving_fails_without_leftovers(tmp_path, small_family):
    same = [Curve([0, 1], [0, 1], "A"), Curve([0, 2], [0, 1], "A")]
    rows = [("same.csv", same, "are named 'A'"), ("no/where.csv", small_family, "cannot write")]
    assert_refused(lambda name, curves: save_curves(tmp_path / name, curves), rows)
    assert list(tmp_path.iterdir()) == []


def test_curves_know_their_roles_and_their_file(tmp_path):
    path = curves_path("elbow")
    curves = load_curves(path)
    assert isinstance(curves, Curves)
    assert curves.held_out().names == ["1.05", "1.40"]
    assert sorted([*curves.fitted().names, *curves.held_out().names]) == sorted(curves.names)
    assert curves.peak == max(np.abs(curve.torque).max() for curve in curves)
    assert curves.angle_range == pytest.approx((0.52, 1.57), abs=1e-6)
    assert curves.start_angle == 0.52
    assert curves.start_torque == pytest.approx(0, abs=0.1)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    for part in (curves, curves.fitted(), Curves(curves), pickle.loads(pickle.dumps(curves))):
        assert (part.source, part.sha256) == ("elbow.csv", digest)
    made = Curves(list(curves))
    assert (made.source, made.sha256) == ("", None)
    assert made == curves


def test_without_curves_there_is_nothing_to_ask():
    assert Curves().peak == 0
    questions = ("angle_range", "start_angle", "start_torque")
    rows = [(one, "there is no curve") for one in questions]
    assert_refused(lambda question: getattr(Curves(), question), rows)


def test_files_that_cannot_be_read(tmp_path):
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00\x00\x81")
    rows = [
        (load_curves, tmp_path / "none.csv", "No such file"),
        (load_curves, tmp_path / "binary.csv", "not a text file"),
        (load_curves, tmp_path, "cannot read"),
        (load_curves, "a\0b.csv", r"cannot read the curves .*: embedded null byte"),
        (load_curves, "/dev/zero", r"cannot read the curves .* is longer than 256 MiB"),
        (load_motion, tmp_path / "none.csv", "cannot read the motion"),
        (load_motion, tmp_path / "binary.csv", "cannot read the motion.*not a text file"),
    ]
    assert_refused(lambda load, path: load(path), rows)
    assert_refused(load_curves, [("no file of curves: give at least one",)])


def test_motions_round_trip(tmp_path):
    design = nested_motion(0.52, 1.57)
    for written in (design.time, None):
        save_motion(tmp_path / "a.csv", Motion(written, design.angle))
        time, angle = load_motion(tmp_path / "a.csv")
        np.testing.assert_allclose(angle, design.angle, atol=1e-9)
        assert (time is None) == (written is None)
        if time is not None:
            np.testing.assert_allclose(time, design.time, rtol=1e-11)


def test_motions_of_tasks_of_curves_and_of_degrees(tmp_path):
    text = "time,elbow_flexion,shoulder_flexion\n0,0.5,1\n1,0.7,2\n"
    found = load_motion(write(tmp_path, text), "elbow_flexion")
    np.testing.assert_array_equal(found.angle, [0.5, 0.7])
    np.testing.assert_array_equal(found.time, [0, 1])
    text = "# measured\ncurve,time_s,angle_deg,torque_nm\nA,0,0,1\n\nA,0.5,90,2\n"
    np.testing.assert_allclose(load_motion(write(tmp_path, text)).angle, [0, np.pi / 2])


def test_bad_files_of_motions(tmp_path):
    rows = [
        ("", "is empty: give a header 'time_s,angle_rad'"),
        ("time_s,angle\n0,1\n", "none of the columns angle_rad, angle_deg: give exactly one"),
        ("angle_rad,angle_deg\n0,1\n", "has angle_rad and angle_deg: give exactly one"),
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
