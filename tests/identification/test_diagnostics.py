"""A fit that deserves doubt says so."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.assets import curves_path
from activesuit.errors import InputError
from activesuit.identification import Curve, Remark, identify, load_curves
from activesuit.identification.diagnostics import diagnostics
from activesuit.published import LI_BOUNDS
from helpers import sweep


def said(curves, **options):
    return " ".join(map(str, identify(curves, **options).remarks))


def test_a_good_fit_is_silent():
    assert identify(load_curves(curves_path("elbow"))).remarks == ()


def test_a_fit_that_is_safe_in_its_range_only_says_so():
    text = said(load_curves(curves_path("shoulder")))
    assert "safe between 0.35 and 1.22 rad only; its torque is kept constant outside" in text


def test_a_fit_at_the_limit_of_the_certificate_says_so(table_2):
    # A truth just outside the certificate.
    truth = replace(table_2["shoulder-sa-pso"], alpha=6.5)
    angle = sweep(0.35, 1.22, 0.9, 1.22)
    assert "limit of the certificate" in said([Curve(angle, truth.response(angle), "A")])


def test_one_way_and_tiny_motions(elbow):
    angle = np.linspace(0.52, 1.5, 50)
    jitter = angle + np.random.default_rng(0).normal(0, 0.005, angle.size)
    for one_way in (angle, jitter):
        with pytest.raises(InputError, match="no curve turns back"):
            identify([Curve(one_way, elbow.response(angle), "A")])
    angle = np.radians(sweep(0.52, 1.5, 0.52))
    assert "span only 0.0171 rad" in said([Curve(angle, elbow.response(angle), "A")])


def test_limits_of_a_swarm(small_family, elbow):
    at_limit = replace(elbow, Ms=100.0)
    found = diagnostics(at_limit, 0.01, small_family, LI_BOUNDS)
    assert found == (Remark("limit", "Ms = 100 is at the limit of the search (100)"),)
    assert diagnostics(elbow, 0.01, small_family, LI_BOUNDS) == ()


def test_shuffled_samples(elbow):
    angle = sweep(0.52, 1.5, 0.52)
    order = np.random.default_rng(0).permutation(angle.size)
    text = said([Curve(angle[order], elbow.response(angle)[order], "A")])
    assert "order of measurement" in text


def test_too_few_samples():
    with pytest.raises(ValueError, match="have 3 samples in all: give at least 10"):
        identify([Curve([0, 1, 0], [0, 1, -1], "A")])
