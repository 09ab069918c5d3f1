"""Fits of B-H loops: the form comes back, with the parameters that were published."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.assets import curves_path
from activesuit.errors import InputError
from activesuit.hysteresis import JilesAtherton
from activesuit.identification import (
    Corrections,
    Curve,
    Magnetic,
    bare,
    fit_curves,
    load_curves,
    save_curves,
)
from activesuit.identification.methods import method_of
from helpers import assert_refused, fails, run, sweep

# Ms [A/m], a [A/m], alpha, c, k [A/m], and the largest field [A/m]; see docs/numbers/golden.md.
MATERIALS = {
    "iron": (1.6e6, 1100, 1.6e-3, 0.2, 400, 6e3),
    "soft": (1.48e6, 470, 9.38e-4, 0.0889, 483, 2.5e3),
    "comsol": (1.6e6, 560, 7e-4, 0.1, 1200, 20e3),
}
FIELD, MAGNETIZATION = 4e3, 1e6  # A/m that count as 1 rad, and as 1 N·m


def truth(material, form):
    Ms, a, alpha, c, k, _ = MATERIALS[material]
    numbers = {"Ms": Ms / MAGNETIZATION, "a": a / FIELD, "c": c, "k": k / FIELD}
    numbers["alpha"] = alpha * MAGNETIZATION / FIELD
    return JilesAtherton(**numbers, form=form, clamp="jiles", allow_active=True)


def loops(material, form, noise=2e-3, start=0.0, **options):
    """The initial curve, the major loop and loops inside it."""
    turns = np.array([0, 1, -1, 1, -0.3, 0.5, -0.25, 0.2]) * MATERIALS[material][-1] / FIELD
    field = sweep(*turns, samples=60)
    M = truth(material, form).response(field, start)
    M += noise * np.random.default_rng(0).standard_normal(M.size)
    return Curve(field, M, material, **options)


@pytest.mark.slow
@pytest.mark.parametrize("form", ["bulk", "original", "derivative"])
@pytest.mark.parametrize("material", MATERIALS)
def test_the_form_and_its_parameters_come_back(material, form):
    fit = fit_curves([loops(material, form)], method="magnetic")
    model, known = bare(fit.model), truth(material, form)
    assert model.form == form
    assert model.clamp == "jiles"
    assert fit.verdict == "describes the curves"
    for name, tolerance in {"Ms": 0.01, "a": 0.03, "alpha": 0.03, "c": 0.1, "k": 0.02}.items():
        assert getattr(model, name) == pytest.approx(getattr(known, name), rel=tolerance), name
    others = [one.loss for one in fit.trials if bare(one.model).form != form]
    assert len(others) == 2
    assert fit.nrmse < min(others)
    assert not fit.remarks


def test_jiles_1992_is_the_original_with_other_numbers():
    known = truth("iron", "jiles-1992")
    same = replace(known, form="original", c=known.c / (1 - known.c), k=known.k * (1 - known.c))
    curve = loops("iron", "jiles-1992", noise=0.0)
    np.testing.assert_allclose(same.response(curve.angle), curve.torque, atol=1e-5)
    model = bare(fit_curves([curve], method="magnetic").model)
    assert model.form == "original"
    assert model.c == pytest.approx(same.c, rel=1e-2)
    assert model.k == pytest.approx(same.k, rel=1e-2)


@pytest.mark.parametrize("start", ["identified", "measured"])
def test_a_record_may_begin_magnetized(start):
    curve = loops("iron", "original", noise=1e-4, start=0.4)
    fit = fit_curves([curve], method=Magnetic(budget=1_000), initial_torque=start)
    assert bare(fit.model).form == "original"
    assert bare(fit.model).c == pytest.approx(0.2, rel=0.05)
    if start == "identified":
        assert fit.initial_torque == pytest.approx(0.4, abs=0.01)


def test_noise_hides_the_form_and_a_remark_says_so():
    fit = fit_curves([loops("iron", "original", noise=2e-2)], method="magnetic")
    (remark,) = (one.sentence for one in fit.remarks if one.code == "form")
    assert "do not distinguish the form" in remark
    assert "name the form with every parameter" in remark


def test_the_uncertainty_has_all_five_parameters_and_no_samples():
    fit = fit_curves([loops("iron", "original")], method="magnetic")
    found = fit.uncertainty()
    assert found.names == ("Ms", "a", "alpha", "c", "k")
    known = truth("iron", "original")
    errors = [getattr(fit.model, name) - getattr(known, name) for name in found.names]
    assert np.all(np.abs(errors) < 4 * found.standard_errors)
    with pytest.raises(InputError, match=r"one of magnetics, whose fit is not repeated: samples=0"):
        fit.uncertainty(samples=1)


def test_the_certified_fit_names_the_method():
    fit = fit_curves([loops("iron", "original")])
    assert fit.verdict == "does not describe the curves"
    (remark,) = (one for one in fit.remarks if one.code == "work")
    assert "magnetization over its field" in remark.sentence
    assert remark.option == ("method", "magnetic")


def test_what_is_no_magnet_is_refused():
    one = [loops("iron", "original")]
    weighted = [*one, replace(one[0], name="2", weight=2.0)]
    joint, offset = load_curves(curves_path("elbow")), Corrections(tare="fit")
    rows = [
        (joint, {}, r"the loops take work .* as those of a joint do"),
        (one, {"method": Magnetic(budget=64)}, "budget is 64: use at least 65"),
        (one, {"model": "dahl"}, "model 'dahl' has the method 'certified' only"),
        (one, {"corrections": offset}, "tare is 'fit', which the method 'magnetic' does not fit"),
        (weighted, {}, "weights from 1 to 2"),
    ]
    usual = {"method": "magnetic"}
    assert_refused(lambda curves, options: fit_curves(curves, **usual | options), rows)
    rows = [({"trials": 2}, "has one per form; leave it out"), ({"objective": "sse"}, "is 'sse'")]
    assert_refused(lambda options: method_of("magnetic", **options), rows)


def test_the_command_line_has_it(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    save_curves("bh.csv", [loops("iron", "original")])
    command = ("identify", "bh.csv", "--method", "magnetic")
    assert "original" in run(capsys, *command)
    assert "a suit file has joints" in fails(capsys, *command, "--out", "found")
    assert not (tmp_path / "found").exists()
