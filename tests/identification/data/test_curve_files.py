"""Layouts of files in which rigs, oscilloscopes and dynamometers write curves."""

import hashlib

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.identification import load_curves
from helpers import assert_refused

ANGLE = np.radians([0.0, 10.5, 20.25, 12.5])
TORQUE = np.array([0.0, 1.25, 2.5, 0.75])
TIME = np.array([0.0, 0.01, 0.02, 0.03])
ROWS = list(zip(TIME, np.degrees(ANGLE), TORQUE, strict=True))


def table(row, separator="", rows=ROWS):
    """Returns lines of numbers: time [s], angle [deg] and torque [N·m] in a form."""
    return "\n".join(row.format(t, a, m) for t, a, m in rows) + "\n"


def commas(text):
    return text.replace(".", ",")


GERMAN = commas(table("{:.2f};{:.2f};{:.3f}"))
TABS = table("{:.2f}\t{:.2f}\t{:.3f}")


def volts(factor):
    return table("{},{},{}", rows=[(factor * t, a / 36, m / 0.5) for t, a, m in ROWS])


def scaled(row, angle=1.0, torque=1.0, time=1.0):
    return table(row, rows=[(time * t, angle * a, torque * m) for t, a, m in ROWS])


QUOTED = "".join('"' + commas(f'{t:.2f}"|"{a:.2f}"|"{m:.3f}"\n') for t, a, m in ROWS)
POINTS = "".join(
    f"{commas(str(t))};{commas(str(a))};"
    + f"{1000 * m:,.2f}\n".replace(",", "'").replace(".", ",").replace("'", ".")
    for t, a, m in ROWS
)
RADIAN = np.pi / 180
# What is written; the numbers are invented.
PLAIN = {
    "German spreadsheet": "Zeit [s];Winkel [Grad];Drehmoment [Nm]\n" + GERMAN,
    "in newton millimeters": "Zeit [s];Winkel [Grad];Drehmoment [Nmm]\n"
    + commas(scaled("{:.2f};{:.2f};{:.1f}", torque=1000)),
    "quoted, with decimal commas": '"Time (s)","Angle (deg)","Torque (N·m)"\n'
    + QUOTED.replace("|", ","),
    "units in a row below": "Time,Angle,Torque\n(s),(deg),(N-m)\n" + table("{},{},{}"),
    "foot-pounds": "time_s\tposition [deg]\ttorque [ft-lbs]\n"
    + scaled("{:.2f}\t{:.2f}\t{:.9f}", torque=1 / 1.3558179483314004),
    "inch-pounds": "t [s] | angle [deg] | torque [lbf·in]\n"
    + scaled("{} | {} | {}", torque=1 / 0.1129848290276167),
    "measurement program with a header of its own": "Measurement\nWriter_Version\t2\n"
    "Decimal_Separator\t.\n***End_of_Header***\n\nTime\tAngle (deg)\tTorque (N·m)\n" + TABS,
    "amplifier with a row of units and decimal commas": "Kanalliste\nSchreiber\t3\n"
    "Zeit\tWinkel\tDrehmoment\ns\t°\tNm\n" + commas(TABS),
    "testing machine": '"Test Run 1"\n\n"Time"\t"Angular Position"\t"Torque"\n'
    "Sec\tdeg\tN-m\n" + TABS,
    "columns of spaces": "Time (s)   Angle (deg)   Torque (Nm)\n" + table("{:9} {:9} {:9}"),
    "NumPy with a commented header": "# time angle_deg torque_nm\n" + table("{} {} {}"),
    "pandas with its index": ",time,angle_deg,torque_nm\n" + table("7,{},{},{}"),
    "marks of thousands": "time;angle [deg];torque [Nmm]\n" + scaled("{};{};{:,.2f}", torque=1000),
    "thousands with points": "time;angle [deg];torque [Nmm]\n" + POINTS,
    "ours": "curve,time_s,angle_deg,torque_nm\n" + table("rig,{},{},{}"),
}
# What is written, and the columns and units that it needs.
NAMED = {
    "oscilloscope in volts": (
        "Model,TDS2014\nSample Interval,0.01\n\nTIME,CH1,CH2\n" + volts(1),
        {"angle": "CH1", "torque": "CH2"},
        {"angle": "36 deg/V", "torque": "0.5 Nm/V"},
    ),
    "USB oscilloscope in milliseconds": (
        "Time,Channel A,Channel B\n(ms),(V),(V)\n\n" + volts(1000),
        {"angle": "Channel A", "torque": "Channel B"},
        {"angle": "36deg/V", "torque": "0.5 Nm/V"},
    ),
    "isokinetic dynamometer": (
        "Biodex data export\nSubject: 12\n\n   MSEC   TORQUE (N-M)   POSITION (DEG)   POS (ANAT)\n"
        + table("  {0:.3f}  {2:.3f}  {1:.2f}  {1:.2f}"),
        {"time": "MSEC"},
        {"time": "s"},
    ),
    "numbers without a header": (
        table("{:e},{:e},{:e}"),
        {"time": "1", "angle": "2", "torque": "3"},
        {"angle": "deg", "torque": "Nm"},
    ),
    "robot bag with nanoseconds": (
        "%time,field.header.seq,field.position0,field.effort0\n"
        + table("{:.0f},1,{},{}", rows=[(1e9 * t + 1.7e18, RADIAN * a, m) for t, a, m in ROWS]),
        {"angle": "field.position0", "torque": "field.effort0"},
        {"time": "ns", "angle": "rad", "torque": "Nm"},
    ),
    "microcontroller": (
        "millis;angle [mrad];torque [mNm];\n"
        + scaled("{:.0f};{:.9f};{:.3f};", 1000 * RADIAN, 1000, 1000),
        {"time": "millis"},
        {"time": "ms"},
    ),
    "opposite sign": (
        "time,angle_deg,M\n" + scaled("{},{},{}", torque=-1),
        {"torque": "M"},
        {"torque": "-1 Nm"},
    ),
    "typographic minus": (
        "time,angle_deg,torque_nm\n" + table("{},{},−{}").replace("−-", "-"),
        {},
        {"torque": "-1 Nm"},
    ),
}
LAYOUTS = {name: (text, {}, {}) for name, text in PLAIN.items()} | NAMED


@pytest.mark.parametrize("name", LAYOUTS)
def test_layouts(tmp_path, name):
    written, columns, units = LAYOUTS[name]
    path = tmp_path / "rig.csv"
    for encoding in ("utf-8", "utf-8-sig", "utf-16", "cp1252"):
        text = written.replace("−", "-") if encoding == "cp1252" else written
        path.write_bytes(text.replace("\n", "\r\n").encode(encoding))
        (curve,) = curves = load_curves(path, columns=columns, units=units)
        assert curve.name == "rig"
        np.testing.assert_allclose(curve.angle, ANGLE, atol=1e-6)
        np.testing.assert_allclose(curve.torque, TORQUE, atol=1e-6)
        tolerance = 1e-6 if curve.time[0] < 1e6 else 1e-5 + 256e-9
        np.testing.assert_allclose(curve.time - curve.time[0], TIME, atol=tolerance)
        assert curves.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
        assert bool(curves.reading) == (name != "ours" or encoding == "utf-16")


def test_what_was_done_is_in_words(tmp_path):
    path = tmp_path / "roh.csv"
    text = "Prüfstand 7\nZeit [s];Winkel [Grad];Drehmoment [Nm];Temp [°C]\n"
    path.write_text(text + GERMAN.replace("\n", ";21,5\n"), encoding="cp1252")
    (sentence,) = load_curves(path).reading
    assert sentence == (
        "roh.csv: Windows-1252; text before the header left out (1 lines); semicolons between "
        "cells; decimal commas; angle from 'Winkel [Grad]' in deg; torque from 'Drehmoment [Nm]' "
        "in N·m; time from 'Zeit [s]' in s; 'Temp [°C]' left out; one curve, 4 samples, 0 to "
        "0.353 rad, at most 2.5 N·m"
    )


def test_several_files_are_one_family(tmp_path):
    (tmp_path / "slow.csv").write_text("angle_deg,torque_nm\n" + table("{1},{2}"))
    (tmp_path / "fast.csv").write_text("angle_deg;torque [Nmm]\n" + table("{1};{2}"))
    curves = load_curves(tmp_path / "slow.csv", tmp_path / "fast.csv")
    assert curves.names == ["slow", "fast"]
    assert curves.source == "slow.csv, fast.csv"
    np.testing.assert_allclose(curves[1].torque, TORQUE / 1000)
    assert curves.place("fast", 2) == "line 4 of fast.csv"
    other = tmp_path / "b" / "slow.csv"
    other.parent.mkdir()
    other.write_text("curve,angle_deg,torque_nm\n" + table("A,{1},{2}") + table("slow,{1},{2}"))
    with pytest.raises(InputError, match=r"two files are named 'slow.csv': rename one"):
        load_curves(tmp_path / "slow.csv", tmp_path / "slow.csv")
    other = other.rename(other.with_name("again.csv"))
    names = load_curves(tmp_path / "slow.csv", other).names
    assert names == ["slow slow", "again A", "again slow"]


def test_bad_files(tmp_path):
    plain, odd = "angle_deg,torque_nm\n0,0\n", "angle [furlong],torque_nm\n0,0\n"
    rows = [
        ("t,x,y\n0,1,2\n1,2,3\n", {}, "has the columns 't', 'x', 'y': use the header 'curve,angle"),
        ("0,1,2\n1,2,3\n", {}, "has no header: use the header .*, or angle=2 for the second one"),
        ("nothing\n", {}, "no line with two numbers, and begins with 'nothing'"),
        ("angle,torque_nm\n0,0\n", {}, "'angle' names no unit: give it, as angle=deg among"),
        (odd, {}, "columns 'angle .furlong.', 'torque_nm': use"),
        (odd, {"columns": {"angle": "angle [furlong]"}}, "names no unit: give it"),
        (plain, {"units": {"angle": "Nm"}}, "a unit of torque, not of angle"),
        (plain, {"units": {"torque": "stone"}}, "no unit of torque: use N·m"),
        (plain, {"units": {"force": "N"}}, "unknown quantity with a unit"),
        (plain, {"columns": {"tork": "a"}}, "did you mean 'torque'"),
        (plain, {"columns": {"time": "Zeit"}}, "has the columns 'angle_deg'"),
        ("angle [deg],torque [Nm]\nrad,Nm\n0,0\n", {}, "in deg by its name and in rad by the row"),
        ("angle_deg,angle_rad,torque_nm\n0,0,0\n", {}, "2 columns for the angle, 'angle_deg' and "),
        ("angle_deg,torque_nm,torque_nm\n0,0,0\n", {}, "the column 'torque_nm' twice: keep one"),
        ("angle_deg,torque_nm\n0,5,1,2\n", {}, "a comma cannot be both separator and decimal mark"),
        ("angle [deg];torque [Nmm]\n1,250;2,500\n", {}, "line 2: '1,250' has either thousands or"),
        ("angle [deg];torque [Nmm]\n1,25;2.5\n", {}, "line 2: '2.5' is no number with the decimal"),
        (plain, {"decimal": "'"}, "decimal is \"'\": give '.' or ','"),
        (plain, {"units": {"torque": "0 Nm/V"}}, "'0 Nm/V' is no unit"),
    ]
    path = tmp_path / "rig.csv"

    def read(text, options):
        path.write_text(text, encoding="utf-8")
        load_curves(path, **options)

    assert_refused(read, rows)


def test_the_decimal_mark_can_be_given(tmp_path):
    path = tmp_path / "rig.csv"
    path.write_text("angle [deg];torque [Nmm]\n0;0\n1;1,250\n2;2,500\n")
    assert load_curves(path, decimal=",").peak == pytest.approx(2.5e-3)
    assert load_curves(path, decimal=".").peak == pytest.approx(2.5)
