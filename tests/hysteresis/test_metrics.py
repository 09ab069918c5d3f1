import math
from dataclasses import asdict

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis.metrics import LoopMetrics, loop_metrics
from helpers import sweep
from hypothesis import given, settings
from hypothesis import strategies as st

# Elastic-perfectly plastic: stiffness 5 N·m/rad, yields at 1 N·m, driven between -1 and 1 rad.
CORNERS_ANGLE = np.array([-1, -0.6, 1, 0.6, -1])
CORNERS_TORQUE = np.array([-1.0, 1, 1, -1, -1])


def ellipse(samples, stiffness=4.0, damping=1.5, amplitude=0.5, phase=0.0, offset=(0.0, 0.0)):
    """A linear spring and a hysteretic damper: area, remanence and coercive angle are known."""
    t = phase + np.linspace(0, 2 * np.pi, samples)
    angle = amplitude * np.sin(t)
    return angle + offset[0], stiffness * angle + damping * np.cos(t) + offset[1]


@pytest.mark.parametrize("phase", [-np.pi / 2, 0, 1, np.pi])
@pytest.mark.parametrize("offset", [(0, 0), (0.8, 3)])
def test_ellipse(phase, offset):
    angle, torque = ellipse(4001, phase=phase, offset=offset)
    found = loop_metrics(angle, torque)
    assert found.area == pytest.approx(math.pi * 0.5 * 1.5, rel=1e-5)
    assert found.center == pytest.approx(offset[0], abs=1e-6)
    assert found.mid_torque == pytest.approx(offset[1], abs=1e-5)
    assert found.remanence == pytest.approx(1.5, rel=1e-5)
    assert found.coercive_angle == pytest.approx(1.5 * 0.5 / math.hypot(2, 1.5), rel=1e-5)
    assert found.peak_torque == pytest.approx(offset[1] + math.hypot(2, 1.5), rel=1e-5)
    assert found.closure_error == pytest.approx(0, abs=1e-12)
    assert found.secant_stiffness == pytest.approx(4, abs=0.01)
    assert found.asymmetry == pytest.approx(0, abs=1e-3)


def expected_parallelogram(torque=1.0):
    return LoopMetrics(
        area=3.2 * torque,
        center=0.0,
        mid_torque=0.0,
        remanence=torque,
        coercive_angle=0.8,
        peak_torque=torque,
        closure_error=0.0,
        secant_stiffness=torque,
        stiffness_into_low=0.0,
        stiffness_out_of_low=5.0 * torque,
        stiffness_into_high=0.0,
        stiffness_out_of_high=5.0 * torque,
        asymmetry=0.0,
    )


@settings(max_examples=100, deadline=None)
@given(
    scale=st.floats(0.01, 100),
    cut=st.integers(0, 3),
    seed=st.integers(0, 2**32),
    extra=st.integers(0, 60),
)
def test_parallelogram_is_exact_however_it_is_sampled(scale, cut, seed, extra):
    # More samples on its sides, repeated samples and another beginning change nothing.
    length = np.arange(5.0)
    where = np.sort(
        np.concatenate([length, np.random.default_rng(seed).uniform(0, 4, extra), length])
    )
    angle, torque = (
        np.interp(where, length, CORNERS_ANGLE),
        np.interp(where, length, CORNERS_TORQUE),
    )
    cut = int(np.flatnonzero(where == cut)[0])
    angle, torque = np.roll(angle[:-1], -cut), np.roll(torque[:-1], -cut)
    angle, torque = np.append(angle, angle[0]), np.append(torque, torque[0])
    found = loop_metrics(angle, scale * torque)
    assert asdict(found) == pytest.approx(
        asdict(expected_parallelogram(scale)), rel=1e-9, abs=1e-9 * scale
    )


def test_corners_alone_are_enough():
    found = loop_metrics(CORNERS_ANGLE, CORNERS_TORQUE)
    assert asdict(found) == pytest.approx(asdict(expected_parallelogram()), abs=1e-12)


def test_coulomb_friction_has_vertical_sides():
    angle = np.array([-1.0, 1, 1, -1, -1])
    torque = np.array([2.0, 2, -2, -2, 2])
    found = loop_metrics(angle, torque)
    assert (found.area, found.remanence, found.coercive_angle) == (8, 2, 1)
    assert (found.stiffness_out_of_low, found.stiffness_into_high) == (0, 0)
    assert (found.secant_stiffness, found.asymmetry) == (2, 0)


def test_another_center():
    found = loop_metrics(CORNERS_ANGLE, CORNERS_TORQUE + 3, center=0.8)
    # At 0.8 rad the rising branch has 4 N·m and the falling one is half way down, at 3 N·m.
    assert found.mid_torque == pytest.approx(3.5)
    assert found.remanence == pytest.approx(0.5)
    assert found.coercive_angle == pytest.approx((0.9 + 0.7) / 2)
    assert found.area == pytest.approx(3.2)


def test_driving_loop_of_magnetics():
    # M lags behind H: negative area, and Mr and Hc as they are named there.
    field = sweep(-2, 2, -2, samples=401)
    shift = np.where(np.arange(field.size) <= 400, 0.3, -0.3)
    shift[[0, 400, -1]] = 0
    found = loop_metrics(field, np.tanh(field - shift), center=0)
    assert found.remanence == pytest.approx(math.tanh(0.3), rel=1e-4)
    assert found.coercive_angle == pytest.approx(0.3, rel=1e-4)
    assert found.area < 0


def test_closure_is_explicit():
    angle, torque = CORNERS_ANGLE.copy(), CORNERS_TORQUE.copy()
    torque[-1] = -0.7
    assert loop_metrics(angle, torque).closure_error == pytest.approx(0.3)
    # A cycle that stops short is closed by a straight line, here along its own side.
    short = np.append(angle[:-1], -0.9)
    found = loop_metrics(short, CORNERS_TORQUE)
    assert found.area == pytest.approx(3.2)
    assert found.closure_error == 0


@pytest.mark.parametrize("gap", [-1e-4, 0, 1e-4])
def test_an_open_first_order_curve_has_the_slopes_of_its_samples(gap):
    # From zero torque up at 3 N·m/rad and back at 9 N·m/rad: it ends at -6 N·m.
    angle = sweep(0, 1, gap, samples=100)
    torque = np.where(np.arange(199) < 100, 3 * angle, 3 - 9 * (1 - angle))
    mirrored = -angle, -torque
    found = loop_metrics(angle, torque)
    assert (found.stiffness_out_of_low, found.stiffness_into_low) == pytest.approx((3, 9))
    assert (found.stiffness_into_high, found.stiffness_out_of_high) == pytest.approx((3, 9))
    assert found.secant_stiffness == pytest.approx(9, abs=0.01)
    assert found.closure_error == pytest.approx(-6, abs=0.01)
    assert found.remanence == pytest.approx(1.5, abs=0.01)
    assert loop_metrics(*mirrored).stiffness_into_high == pytest.approx(9)
    assert loop_metrics(*mirrored).secant_stiffness == found.secant_stiffness


def test_asymmetry_is_the_rms_of_the_difference():
    # The rising branch is straight, the falling one hangs below it as a triangle of depth 1.
    found = loop_metrics([-1, 1, 0, -1], [-1.0, 1, -1, -1], center=0)
    # Mirrored at (0, -0.5) the falling branch is -2, 0, 0 at -1, 0, 1 rad: differences 1, 0, 1.
    assert found.mid_torque == -0.5
    assert found.asymmetry == pytest.approx(math.sqrt(1 / 3) / 2)
    assert loop_metrics([0, 1, 0], [0, 1, 0]).asymmetry == 0


@pytest.mark.parametrize("seed", range(5))
def test_noise_and_jitter(seed):
    rng = np.random.default_rng(seed)
    angle, torque = ellipse(4001, phase=-np.pi / 2)
    found = loop_metrics(
        angle + 0.001 * rng.standard_normal(angle.size),
        torque + 0.02 * rng.standard_normal(angle.size),
    )
    assert found.remanence == pytest.approx(1.5, abs=0.05)
    assert found.coercive_angle == pytest.approx(0.3, abs=0.01)
    assert found.area == pytest.approx(math.pi * 0.75, rel=0.01)
    assert found.asymmetry < 0.02


def test_a_branch_that_never_passes_the_mid_torque():
    # The falling branch dips below the rising one, which stays above the mid torque throughout.
    found = loop_metrics([-1, 1, 0, -1], [0.0, 0, -1, 0])
    assert found.mid_torque == -0.5
    assert math.isnan(found.coercive_angle)


def test_elastic_loop_has_no_width():
    angle = sweep(0, 1, 0, samples=30)
    found = loop_metrics(angle, 2 * angle)
    assert found.area == pytest.approx(0, abs=1e-12)
    assert found.remanence == pytest.approx(0, abs=1e-12)
    assert found.coercive_angle == pytest.approx(0, abs=1e-12)
    assert found.stiffness_out_of_high == pytest.approx(2)


def test_tangent_span_averages_over_its_angle():
    angle = sweep(-1, 1, -1, samples=2001)
    torque = angle**2
    assert loop_metrics(angle, torque).stiffness_out_of_high == pytest.approx(1.9, abs=1e-3)
    fine = loop_metrics(angle, torque, tangent_span=0.002)
    assert fine.stiffness_into_high == pytest.approx(2, abs=0.003)
    assert fine.stiffness_into_low == pytest.approx(-2, abs=0.003)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("angle_scale", [1e-99, 1, 1e99])
@pytest.mark.parametrize("torque_scale", [1e-99, 1, 1e99])
def test_the_numbers_scale_with_their_units(angle_scale, torque_scale):
    angle, torque = ellipse(401)
    one = loop_metrics(angle, torque)
    other = loop_metrics(angle_scale * angle, torque_scale * torque)
    assert other.area == pytest.approx(one.area * angle_scale * torque_scale)
    assert other.remanence == pytest.approx(one.remanence * torque_scale)
    assert other.coercive_angle == pytest.approx(one.coercive_angle * angle_scale)
    stiffness = one.stiffness_into_high * torque_scale / angle_scale
    assert other.stiffness_into_high == pytest.approx(stiffness)
    assert other.asymmetry == pytest.approx(one.asymmetry)


loop = [0.0, 1, 0]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: loop_metrics([0, np.nan, 0], loop), r"angle\[1\] is nan: give finite numbers"),
        (lambda: loop_metrics(loop, [0, np.inf, 0]), r"torque\[1\] is inf"),
        (lambda: loop_metrics(loop, [0, -1e300, 0]), r"torque\[1\] is -1e\+300: give"),
        (lambda: loop_metrics([0, 1e300, 0], loop), r"at most 1e\+100 \(rad\)"),
        (lambda: loop_metrics([0, 1e-200, 0], loop), "covers 1e-200 rad"),
        (lambda: loop_metrics(loop, [0, 1]), "angle has 3 samples and torque has 2"),
        (lambda: loop_metrics([0, 1], [0, 1]), "the record has 2 samples"),
        (lambda: loop_metrics([0, 1, 2], loop), "covers 2 rad and ends 2 rad from its start"),
        (lambda: loop_metrics([1, 1, 1], loop), "covers 0 rad"),
        (lambda: loop_metrics(sweep(0, 1, 0, 2, 0), sweep(0, 1, 0, 2, 0)), "give a single cycle"),
        (lambda: loop_metrics(sweep(0, 1, 0, 1, 0), sweep(0, 1, 0, 1, 0)), "give a single cycle"),
        (lambda: loop_metrics(loop, loop, center=1), "center is 1 rad: choose it inside the loop"),
        (lambda: loop_metrics(loop, loop, center=np.nan), "center is nan"),
        (lambda: loop_metrics(loop, loop, tangent_span=0), "tangent_span is 0 rad"),
        (lambda: loop_metrics(loop, loop, tangent_span=0.3), "at most 0.25 rad in this loop"),
        (lambda: loop_metrics(loop, loop, tangent_span=np.nan), "tangent_span is nan"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(InputError, match=message):
        call()
