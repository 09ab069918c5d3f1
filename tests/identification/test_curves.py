import hashlib
import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from activesuit.assets import curves_path
from activesuit.errors import InputError
from activesuit.identification import Curve, Curves, load_curves, save_curves
from helpers import assert_refused

HEADER = "curve,angle_rad,torque_nm\n"
TIMED = "curve,time_s,angle_rad,torque_nm\n"


def write(folder, text):
    path = folder / "curves.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_round_trip(tmp_path, small_family):
    path = tmp_path / "family.csv"
    save_curves(path, small_family, comments=["made by a test"])
    assert path.read_text().startswith("# made by a test\n")
    for before, after in zip(small_family, load_curves(path), strict=True):
        assert (before.name, before.role) == (after.name, after.role)
        np.testing.assert_allclose(after.angle, before.angle, atol=1e-6)
        np.testing.assert_allclose(after.torque, before.torque, atol=1e-6)


def test_weights_round_trip(tmp_path, small_family):
    path = tmp_path / "family.csv"
    save_curves(path, small_family)
    assert "weight" not in path.read_text()
    weights = (1.0, 0.1 + 0.2, 1e-9, 12345678.9)
    weighted = [replace(one, weight=w) for one, w in zip(small_family, weights, strict=True)]
    save_curves(path, weighted)
    assert path.read_text().startswith("curve,role,weight,angle_rad,torque_nm\n")
    assert tuple(curve.weight for curve in load_curves(path)) == weights
    assert [curve.role for curve in load_curves(path)] == [curve.role for curve in small_family]


def test_times_round_trip(tmp_path, small_family):
    path = tmp_path / "family.csv"
    save_curves(path, small_family)
    assert "time_s" not in path.read_text()
    size = small_family[0].angle.size
    times = (np.arange(size) / 25, None, np.cumsum(np.full(size, 1 / 3)) + 3000, None)
    timed = [replace(one, time=time) for one, time in zip(small_family, times, strict=True)]
    save_curves(path, timed)
    assert path.read_text().startswith("curve,role,time_s,angle_rad,torque_nm\n")
    for curve, time in zip(load_curves(path), times, strict=True):
        if time is None:
            assert curve.time is None
        else:
            np.testing.assert_allclose(curve.time, time, rtol=1e-11)


def test_bad_times():
    rows = [
        ([0, 2, 1], "curve 'A': the time runs back from 2 to 1 s at sample 2: put the samples"),
        ([0, 1, 1], "curve 'A': the time stands still at 1 s at sample 2"),
        ([0, 1], r"times of shape \(2,\) and 3 samples"),
        ([0, 1, np.inf], "a time that is not finite"),
    ]
    assert_refused(lambda time: Curve([0, 1, 0], [0, 1, 2], "A", time=time), rows)


def test_degrees_order_and_interleaved_curves(tmp_path):
    text = "curve,torque_nm,angle_deg\nA,1,10\nB,5,0\n\n# a remark\nA,2,20\nB,6,90\nA,3,15\n"
    first, second = load_curves(write(tmp_path, text))
    np.testing.assert_allclose(first.angle, np.radians([10, 20, 15]))
    np.testing.assert_array_equal(first.torque, [1, 2, 3])
    assert second.angle[1] == pytest.approx(math.pi / 2)
    assert first.role == "fit"


def test_bad_files(tmp_path):
    rows = [
        ("", "is empty"),
        (HEADER, "header but no samples"),
        ("curve,angle,torque_nm\nA,0,0\n", "the column 'angle' names no unit: give it, as angle"),
        ("angle_rad,torque_nm\n0,0\n", "curve 'curves' has 1 sample"),
        (HEADER + "A,0,0\nA,nan,1\n", "line 3: angle_rad is 'nan': give a finite number"),
        (HEADER + "A,0,0\nA,1,heavy\n", "line 3: torque_nm is 'heavy'"),
        (HEADER + "A,0,0\nA,1,\n", "line 3: torque_nm is ''"),
        (HEADER + "A,0,0\n", "curve 'A' has 1 sample: a curve needs at least 2"),
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
        ("curve,torque_nm,angle_rad,torque_nm\nA,0,0,0\n", "the column 'torque_nm' twice"),
        (
            TIMED + "A,0,0,0\nB,5,0,0\nA,1,1,1\nB,4,1,1\n",
            "line 5: the time runs back from 5 to 4 s",
        ),
        (TIMED + "A,0,0,0\nA,0,1,1\n", "line 3: the time stands still at 0 s"),
        (TIMED + "A,x,0,0\nA,0,1,1\n", "line 2: time_s is 'x'"),
        (TIMED + "A,0,0,0\nA,,1,1\n", "line 3: curve 'A' has a time at some samples only"),
        (TIMED + "A,,0,0\nA,1,1,1\n", "line 3: curve 'A' has a time at some samples only"),
        (
            "curve,angle_rad,angle_deg,torque_nm\nA,0,0,0\n",
            "2 columns for the angle, 'angle_rad' and 'angle_deg'",
        ),
    ]
    assert_refused(lambda text: load_curves(write(tmp_path, text)), rows)
    with pytest.raises(InputError, match=r"curves\.csv"):
        load_curves(write(tmp_path, ""))


def test_missing_and_binary_files(tmp_path):
    with pytest.raises(InputError, match="No such file"):
        load_curves(tmp_path / "none.csv")
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00\x00\x81")
    with pytest.raises(InputError, match="not a text file"):
        load_curves(tmp_path / "binary.csv")
    with pytest.raises(InputError, match="cannot read"):
        load_curves(tmp_path)


def test_names_survive_and_lists_are_welcome(tmp_path):
    curves = [Curve([0, 1], [0.0, 2], "run 1, left"), Curve([0, 1], [0, 1], 'a "b"')]
    save_curves(tmp_path / "odd.csv", curves)
    assert [curve.name for curve in load_curves(tmp_path / "odd.csv")] == ["run 1, left", 'a "b"']
    for name in ("#3", "", "two\nlines", "one\x0bmore", " padded", "padded "):
        with pytest.raises(InputError, match="curve name"):
            Curve([0, 1], [0, 1], name)


def test_what_load_curves_would_read_otherwise_is_not_saved(tmp_path):
    same = [Curve([0, 1], [0, 1], "A"), Curve([0, 2], [0, 1], "A")]
    with pytest.raises(InputError, match="two curves are named 'A'"):
        save_curves(tmp_path / "same.csv", same)
    assert not list(tmp_path.iterdir())
    save_curves(tmp_path / "one.csv", same[:1], comments=["two\nlines"])
    assert load_curves(tmp_path / "one.csv")[0].name == "A"


def test_degrees_are_not_radians():
    with pytest.raises(InputError, match="reaches 90 rad, more than a full turn"):
        Curve([0, 90], [0, 1], "A")


def test_bad_arrays():
    with pytest.raises(InputError, match="equal length"):
        Curve(np.zeros(3), np.zeros(2), "A")
    with pytest.raises(InputError, match="not finite"):
        Curve(np.array([0.0, 1.0]), np.array([0.0, np.inf]), "A")
    for weight, message in (
        (0, "weight 0: give a number above 0"),
        (math.inf, "is inf"),
        ("1", ""),
    ):
        with pytest.raises(InputError, match=f"curve 'A'.*{message}"):
            Curve([0, 1], [0, 1], "A", weight=weight)


def test_saving_fails_without_leftovers(tmp_path, small_family):
    with pytest.raises(InputError, match="cannot write"):
        save_curves(tmp_path / "no" / "where.csv", small_family)
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
    for question in ("angle_range", "start_angle", "start_torque"):
        with pytest.raises(InputError, match="there is no curve"):
            getattr(Curves(), question)


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(InputError, match=r"cannot read the curves .*: embedded null byte"):
        load_curves("a\0b.csv")
    with pytest.raises(InputError, match=r"cannot read the curves .* is longer than 256 MiB"):
        load_curves("/dev/zero")


def test_small_torques_and_clock_times_survive_the_file(tmp_path):
    time = 1.7e9 + np.linspace(0, 2, 50)
    angle, torque = np.linspace(0.5, 1.5, 50), 1e-6 * np.sin(np.linspace(0, 3, 50))
    save_curves(tmp_path / "a.csv", [Curve(angle, torque, "A", time=time)])
    (back,) = load_curves(tmp_path / "a.csv")
    np.testing.assert_allclose(back.torque, torque, rtol=1e-8)
    np.testing.assert_allclose(back.time - time[0], time - time[0], atol=1e-5)
