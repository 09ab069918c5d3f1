"""The other ways to write a Bouc-Wen model, its dictionary, and what it refuses."""

import math

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis.bouc_wen.model import BoucWen
from helpers import assert_refused, sweep
from scipy.integrate import solve_ivp

PARAMETERS = {"elastic": 0.7, "hysteretic": 2.0, "beta": 3.0, "gamma": 1.0, "n": 1.5}


def model(**changes) -> BoucWen:
    return BoucWen(**{**PARAMETERS, **changes})


def kao_fung_by_time(time, k, d_e, slope, beta, gamma, n):
    """Kao and Fung (2009), eq. (1), in time, under 24 - 24 cos(16 pi t) volts; k (d_e V - h)."""

    def rate(t, h):
        V = 24 * 16 * math.pi * math.sin(16 * math.pi * t)
        h = h[0]
        return [slope * V - beta * abs(V) * abs(h) ** (n - 1) * h - gamma * V * abs(h) ** n]

    turns = np.arange(0, time[-1] - 1e-9, 1 / 16)  # of the voltage: eq. (1) is not smooth there
    h, start = np.empty_like(time), 0.0
    for t in turns:
        inside = (time >= t) & (time < t + 1 / 16)
        ends = np.append(time[inside], t + 1 / 16)
        options = {"rtol": 1e-10, "atol": 1e-13 * abs(slope), "max_step": 1e-3}
        solved = solve_ivp(rate, (t, t + 1 / 16), [start], t_eval=ends, **options)
        h[inside], start = solved.y[0, :-1], solved.y[0, -1]
    return k * (d_e * (24 - 24 * np.cos(16 * math.pi * time)) - h)


@pytest.mark.parametrize("sign", (1, -1))
@pytest.mark.parametrize(("n", "literal"), ((1.0, False), (1.0, True), (1.6, False)))
def test_kao_fung(n, literal, sign):
    # The MPSO row for n = 1 of their table 2 (N/m, m/V, 1/V).
    published = {"k": 4180.5, "d_e": sign * 2.1672e-7, "alpha": 0.2161}
    shape = {"beta": 0.00504, "gamma": 0.0239, "n": n}
    if n > 1:  # the table does not print n, nor its unit for beta and gamma
        shape |= {"beta": 0.0050 * 4e-7 ** (1 - n), "gamma": 0.0237 * 4e-7 ** (1 - n)}
    m = BoucWen.from_kao_fung(**published, **shape, literal=literal)
    time = np.linspace(0.001, 0.249, 80)
    k, d_e, alpha = published.values()
    expected = kao_fung_by_time(time, k, d_e, alpha * (1 if literal else d_e), **shape)
    path = np.union1d(time, np.arange(4) / 16)  # eq. (1) sees the turns too
    torque = m.response(24 - 24 * np.cos(16 * math.pi * path))[np.searchsorted(path, time)]
    np.testing.assert_allclose(torque, expected, atol=1e-7 * np.ptp(expected))


def test_kao_fung_has_the_published_size():
    arguments = {"k": 4180.5, "d_e": 2.1672e-7, "alpha": 0.2161, "beta": 0.00504, "gamma": 0.0239}
    m = BoucWen.from_kao_fung(**arguments, n=1)
    assert m.z_bound / arguments["d_e"] == pytest.approx(7.47, abs=0.005)
    cycle = m.response(sweep(0, *(48, 0) * 20, samples=3))
    assert np.ptp(cycle[-4:]) / arguments["k"] == pytest.approx(8.7e-6, abs=0.05e-6)


def test_A_is_a_scale_and_the_textbook_has_a_ratio():
    angle = sweep(0.1, 0.8, -0.4, 0.3, samples=9)
    m = model(A=1.7, gamma=-2.0, n=2.3, rest_angle=0.1)
    torque = m.response(angle)
    np.testing.assert_allclose(m.normalized().response(angle), torque, atol=1e-12)
    assert m.normalized().A == 1
    textbook = BoucWen.from_stiffness_ratio(k=4.0, alpha=0.25, beta=3, gamma=1, n=1.5)
    assert textbook == model(elastic=1.0, hysteretic=3.0)


def test_bad_parameters():
    rows = [
        ({"hysteretic": 0}, "hysteretic is 0: .* give another number"),
        ({"A": -1}, "A is -1.0: it must be above 0; .* signs"),
        ({"n": 0.5}, r"n is 0\.5: use 1 .* to 1e\+06"),
        ({"n": 1e7}, "n is 10000000"),
        ({"beta": math.nan}, "beta is nan: give a finite number"),
        ({"gamma": "x"}, "gamma is 'x': give a number"),
        ({"elastic": True}, "elastic is True: give a number"),
    ]
    assert_refused(lambda changes: model(**changes), rows)


def test_bad_conversions():
    kao_fung = {"k": 1.0, "d_e": 1.0, "alpha": 0.0, "beta": 1.0, "gamma": 0.0}
    with pytest.raises(InputError, match=r"alpha is 0\.0 and d_e is 1\.0: h would never move"):
        BoucWen.from_kao_fung(**kao_fung)
    with pytest.raises(InputError, match="hysteretic is 0"):
        BoucWen.from_stiffness_ratio(k=1.0, alpha=1.0, beta=1, gamma=0, n=1)
