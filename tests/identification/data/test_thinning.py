"""Long records: what is kept of them, and that fits and figures stay small."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.identification import Curves, fit_curves, fit_preisach
from activesuit.identification.data.parts import drawn_note, drawn_samples, kept_samples, thinned
from activesuit.identification.figures import compared, loops_plot
from helpers import along


def long_family(model, samples, timed=False):
    rng, curves = np.random.default_rng(0), []
    for turn, role in (("0.87", "fit"), ("1.22", "fit"), ("1.40", "predict"), ("1.57", "fit")):
        options = {"noise": 0.05, "rng": rng, "samples": samples // 2, "name": turn, "role": role}
        one = along(model, 0.52, float(turn), 0.52, **options)
        curves.append(replace(one, time=np.arange(one.angle.size)) if timed else one)
    return Curves(curves, source="elbow.csv", sha256="5e5f")


def test_ordinary_curves_stay_as_they_are(small_family):
    short = thinned(small_family)
    assert all(one is other for one, other in zip(short, small_family, strict=True))
    assert drawn_note(small_family) == ""
    drawn = drawn_samples(small_family)
    for curve, indices in zip(small_family, drawn, strict=True):
        np.testing.assert_array_equal(indices, np.arange(curve.angle.size))


def test_ends_and_turning_points_stay_with_their_times(elbow):
    family = long_family(elbow, 10_000, timed=True)
    short = thinned(family, 2000)
    assert (short.source, short.sha256, short.names) == ("elbow.csv", "5e5f", family.names)
    assert 2000 <= sum(curve.angle.size for curve in short) <= 2020
    for curve, whole in zip(short, family, strict=True):
        assert {0, whole.angle.argmax(), whole.angle.size - 1} <= set(curve.time)
        at = curve.time.astype(int)
        np.testing.assert_array_equal(curve.angle, whole.angle[at])
        np.testing.assert_array_equal(curve.torque, whole.torque[at])


def test_there_are_never_too_many_turning_points():
    for jitter in [0.0, 0.01, 0.3]:
        rng = np.random.default_rng(0)
        angle = np.sin(np.arange(20_000) * 2.5) + jitter * rng.standard_normal(20_000)
        kept = kept_samples(angle, 20)
        assert kept.size <= 2002
        assert {0, 19_999} <= set(kept.tolist())


def test_a_long_record_is_fitted_thinned_and_says_so(elbow):
    family = long_family(elbow, 40_000)
    fit = fit_curves(family)
    (remark,) = fit.remarks
    assert (remark.code, remark.values["every"]) == ("thinned", 3)
    assert (remark.values["used"], remark.values["samples"]) == (40_005, 119_997)
    assert sum(one.angle.size for one in fit.fitted_curves) == 40_005
    assert fit.curves is not family
    assert fit.curves.fitted()[0].angle.size == 39_999
    errors = np.concatenate([fit.predict(c) - c.torque for c in family.fitted()])
    assert fit.nrmse == pytest.approx(np.sqrt(np.mean(errors**2)) / family.fitted().peak)
    assert fit.nrmse == pytest.approx(0.05 / family.peak, rel=0.05)
    for panel in loops_plot("elbow", {"certified": compared(family, fit)}).panels[:2]:
        assert sum(len(line.x) for line in panel.marks) < 2 * 4100
        assert "samples drawn" in panel.x


def test_a_direct_fit_refuses_what_memory_does_not_hold(elbow):
    family = long_family(elbow, 40_000)
    with pytest.raises(InputError, match=r"119,997 samples and 210 weights are .* thin the curves"):
        fit_preisach(family)
    assert fit_preisach(thinned(family, 1000)).certificate().certified
