"""Fixed and bounded parameters: they hold, and the others are fitted as well as they can be."""

import math

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis import Viscoelastic
from activesuit.identification import (
    Certified,
    Corrections,
    Curve,
    Magnetic,
    Search,
    fit_curves,
    identify,
    select,
)
from activesuit.identification.fits.objective import nrmse, torque_errors
from activesuit.identification.fits.parameters import Constraints, parameters_of, with_values
from activesuit.identification.report import uncertainty_table
from helpers import assert_refused, family, is_safe, sweep
from scipy.optimize import least_squares

REACHED = 1.005  # error over that of plain least squares
CASES = [
    ("jiles-atherton", {"c": 6.0}, {}),
    ("jiles-atherton", {"k": 30.0, "c": 6.0}, {}),
    ("jiles-atherton", {"alpha": 0.0}, {"k": (1, 20)}),
    ("jiles-atherton", {}, {"Ms": (13, 14)}),
    ("jiles-atherton", {}, {"alpha": (0.1, math.inf), "a": (0, 150)}),
    ("asymmetric", {"c": 3.0}, {}),
    ("asymmetric", {"polynomial": 0.0}, {"k": (1, 20)}),
    ("bouc-wen", {"n": 1.0}, {}),
    ("bouc-wen", {"gamma": 0.0}, {"elastic": (1, 2)}),
    ("bouc-wen", {}, {"rest_angle": (0.6, 0.7)}),
    ("dahl", {"friction": 1.0}, {}),
    ("dahl", {"spring[3]": 0.0}, {"stiffness": (1, 8)}),
    ("duhem", {"friction_up": 1.0}, {}),
    ("duhem", {}, {"friction_down": (0.1, 0.5)}),
    ("prandtl-ishlinskii", {"stiffness": 0.0}, {"weights": (0, 1)}),
    ("prandtl-ishlinskii", {"rest_angle": 0.5}, {}),
    ("preisach", {"density[2][1]": 0.1}, {"elastic": (1, 6)}),
    ("hinged-stops", {"offset": 0.1}, {"weights": (0, 4)}),
]
SMALL = {"prandtl-ishlinskii": {"thresholds": 4}, "preisach": {"levels": 4}}
SMALL |= {"hinged-stops": {"thresholds": 3}, "dahl": {"degree": 3}}
MANY = ("preisach", "hinged-stops")  # their fits even out what the curves leave open


@pytest.fixture(scope="module")
def curves(elbow):
    return family(elbow, noise=0.03, samples=40)


def plain(found, free, curves, constraints, fitted_start):
    """The error of SciPy's bounded least squares from the fit without constraints."""
    every = parameters_of(free.model, constraints)
    values = np.array([min(max(one.value, one.low), one.high) for one in every])
    low = np.array([max(one.low, one.least) for one in every])
    high = np.array([one.high for one in every])
    moves = low < high
    size = np.maximum(np.abs(values), 0.1)

    def errors(x):
        moved = values.copy()
        moved[moves] = x[: moves.sum()] * size[moves]
        numbers = dict(zip([one.path for one in every], moved.tolist(), strict=True))
        start = float(x[-1]) if fitted_start else free.initial_torque
        try:
            return torque_errors(with_values(found.model.to_dict(), numbers), start, curves)
        except InputError:
            return np.full(sum(one.torque.size for one in curves), 10.0)

    x, ends = values[moves] / size[moves], (low[moves] / size[moves], high[moves] / size[moves])
    if fitted_start:
        x, ends = np.append(x, free.initial_torque), (np.append(ends[0], -9), np.append(ends[1], 9))
    span = ends[1] - ends[0]
    inside = np.where(np.isfinite(span), 1e-3 * span, 1e-9)
    x = np.clip(x, ends[0] + inside, ends[1] - inside)
    return nrmse(least_squares(errors, x, bounds=ends, x_scale="jac").fun, curves)


@pytest.mark.parametrize(("name", "fixed", "bounds"), CASES)
def test_constraints_hold_and_the_rest_is_fitted(curves, name, fixed, bounds):
    method, constraints = Certified(**SMALL.get(name, {})), Constraints(fixed, bounds)
    fit = fit_curves(curves, model=name, method=method, fixed=fixed, bounds=bounds)
    assert fit.constraints == constraints
    assert is_safe(fit.model)
    for one in fit.parameters:
        assert one.low <= one.value <= one.high
        assert (one.state == "fixed") == (constraints.ends(one.name)[0] == one.value == one.high)
    free = fit_curves(curves, model=name, method=method)
    least = plain(fit, free, curves, constraints, name != "jiles-atherton")
    assert fit.nrmse <= (1.05 if name in MANY else REACHED) * least


def test_a_bound_that_does_not_bind_changes_nothing(curves):
    free = fit_curves(curves, model="bouc-wen")
    assert fit_curves(curves, model="bouc-wen", bounds={"n": (1, 9)}).model == free.model


@pytest.mark.parametrize("name", ["pso", "sa-pso", "mpso", "rank-distance-mpso"])
def test_swarms_search_the_box(curves, name):
    search = Search(name, trials=2, swarm_size=10, max_iterations=10)
    fit = fit_curves(curves, method=search, fixed={"c": 6.0}, bounds={"k": (20, 60)})
    for trial in fit.trials:
        assert trial.model.c == 6.0
        assert 20 <= trial.model.k <= 60
    assert fit.parameters[3].state == "fixed"


def test_magnetics_too():
    field = sweep(-2.0, 2.0, -2.0, samples=60)
    lag = np.where(np.arange(field.size) < 60, -0.3, 0.3)
    loop = Curve(field, np.tanh((field + lag) / 0.5), "loop")
    given = {"fixed": {"c": 0.1, "alpha": 0.0}, "bounds": {"Ms": (1.1, 1.2)}}
    fit = fit_curves([loop], method=Magnetic(budget=300), initial_torque="measured", **given)
    assert (fit.model.c, fit.model.alpha) == (0.1, 0.0)
    assert 1.1 <= fit.model.Ms <= 1.2


@pytest.mark.parametrize("name", ["jiles-atherton", "dahl"])
def test_what_is_around_the_model_is_constrained_too(elbow, name):
    truth = Viscoelastic(model=elbow, damping=0.3)
    angle = sweep(0.52, 1.57, 0.52, 1.2, samples=60)
    time = 0.05 * np.arange(angle.size)
    record = [Curve(angle, truth.response(angle, time=time), "record", time=time)]
    viscous, play = Corrections(rate="viscous"), Corrections(play="fit")
    fit = fit_curves(record, model=name, corrections=viscous, fixed={"damping": 0.2})
    assert fit.model.damping == 0.2
    fit = fit_curves(record, model=name, corrections=viscous, bounds={"damping": (0, 0.1)})
    assert 0 <= fit.model.damping <= 0.1
    fit = fit_curves(record, model=name, corrections=play, fixed={"gap": 0.02})
    assert fit.model.gap == 0.02
    fit = fit_curves(record, model=name, corrections=play, bounds={"gap": (0.01, 0.03)})
    assert 0.01 <= fit.model.gap <= 0.03


def test_tables_say_what_is_fixed_and_samples_keep_it(curves):
    found = identify(curves, fixed={"c": 6.0}, bounds={"k": (1, 20)}, samples=2)
    rows = {row[0]: row for row in uncertainty_table(found.fit, found.uncertainty)[1]}
    assert rows["c"] == ["c", "6", "", "fixed"]
    assert rows["k [deg]"][2:] == ["", "at its bound"]
    assert found.uncertainty.names == ("Ms", "a", "alpha")
    assert all(one.c == 6.0 and one.k <= 20 for one in found.uncertainty.samples)
    table = found.tables()[found.fit.curves.source][1]
    assert ["fixed", "c"] in table
    assert ["at its bound", "k"] in table
    assert any("k = 20: at the bound that was given" in one for one in found.sentences())
    assert found.to_dict()["constraints"] == {"fixed": {"c": 6.0}, "bounds": {"k": (1, 20)}}


def test_auto_leaves_out_models_without_the_parameter(curves):
    found = select(curves, fixed={"stiffness": 8.0})
    reasons = {one.name: one.reason for one in found.candidates}
    assert "unknown parameter of 'bouc-wen' 'stiffness'" in reasons["bouc-wen"]
    assert not reasons["dahl"]
    assert found.fit.model.stiffness == 8.0
    rows = [({"stiff": 1.0}, "unknown parameter 'stiff': use one of .*'stiffness'")]
    assert_refused(lambda fixed: select(curves, fixed=fixed), rows)


def test_bad_constraints(curves):
    whole = dict.fromkeys(("Ms", "a", "alpha", "c", "k"), 2.0)
    rows = [
        ({"fixed": {"d": 1.0}}, "unknown parameter of 'jiles-atherton' 'd': use one of Ms, a, al"),
        ({"fixed": {"c[0]": 2.0}}, r"unknown parameter of 'jiles-atherton' 'c\[0\]'"),
        ({"fixed": {"gap": 0.1}}, "unknown parameter of 'jiles-atherton' 'gap'"),
        ({"fixed": {"c": 1.0}}, "c is 1: a fit of 'jiles-atherton' allows numbers above 1; its pa"),
        ({"bounds": {"k": (-3, 2)}}, "k is -3 to 2: a fit of 'jiles-atherton' allows numbers abo"),
        ({"bounds": {"k": (3, 2)}}, r"bounds of k are \(3, 2\): give two numbers"),
        ({"bounds": {"k": (1, math.nan)}}, "give two numbers"),
        ({"bounds": {"k": 3}}, "bounds of k are 3: give two numbers"),
        ({"fixed": {"k": 2}, "bounds": {"k": (1, 3)}}, "k is fixed at 2 and bounded by"),
        ({"fixed": whole}, "every parameter of 'jiles-atherton' is fixed, .* leave one of Ms"),
        ({"fixed": {"c": "x"}}, "fixed c is 'x': give a number"),
        ({"fixed": {"c": math.inf}}, "fixed c is inf: give a finite number"),
        ({"fixed": 3}, "fixed is 3: give a dictionary"),
        ({"model": "bouc-wen", "fixed": {"n": 0.5}}, "allows numbers from 1 to"),
        ({"model": "bouc-wen", "fixed": {"gamma": 50.0, "beta": 1.0}}, "no certified model 'bouc"),
        ({"model": "dahl", "fixed": {"spring[9]": 1.0}}, r"no spring\[9\]: the model has spring"),
        ({"model": "dahl", "fixed": {"friction": 0.0}}, "allows numbers above 0"),
        ({"method": "magnetic", "fixed": {"c": 2.0}}, "numbers above 0 to 0.999"),
    ]
    assert_refused(lambda options: fit_curves(curves, **options), rows)
