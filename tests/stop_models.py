"""Random models of stops, with and without a hinge, and motions for them."""

import numpy as np
from activesuit.hysteresis import HingedStops, PrandtlIshlinskii
from hypothesis import given, settings
from hypothesis import strategies as st

angles = st.floats(-2.0, 2.0, allow_subnormal=False)
paths = st.lists(angles, min_size=2, max_size=30)


@st.composite
def stops(draw, idle=True):
    """Stops or plays; with `idle` also with weights that give energy, rising everywhere."""
    operator = draw(st.sampled_from(["stop", "play"]))
    signs = st.sampled_from((1, -1) if idle else (1,))
    elements = st.tuples(st.floats(0.01, 0.5), st.floats(0.1, 5.0), signs)
    steps, sizes, sign = np.transpose(draw(st.lists(elements, min_size=1, max_size=6)))
    weights = sizes * sign * (1 if operator == "stop" else -1)
    return PrandtlIshlinskii(
        stiffness=draw(st.floats(0.3, 3.0)) + np.maximum(-weights, 0).sum(),
        thresholds=np.cumsum(steps),
        weights=weights,
        operator=operator,
        rest_angle=draw(st.floats(-0.5, 0.5)),
    )


@st.composite
def hinged(draw, idle=True):
    """Hinged stops; with `idle` also without a spring, with idle stops and flat hinges."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    size, hinges = rng.integers(1, 7, 2)
    some = (lambda size: rng.integers(0, 2, size)) if idle else np.ones
    return HingedStops(
        stiffness=float(some(1)[0] * rng.uniform(0.3, 3)),
        thresholds=np.cumsum(rng.uniform(0.01, 0.5, size)),
        weights=some(size) * rng.uniform(0.1, 5, size),
        knots=np.cumsum(rng.uniform(0.05, 2, hinges)) - rng.uniform(0, 5),
        slopes=some(hinges + 1) * rng.uniform(0.1, 3, hinges + 1),
        offset=rng.normal(),
        rest_angle=rng.uniform(-0.5, 0.5),
    )


def for_any(*strategies):
    """`given`, with time for the kernels to compile."""
    return lambda test: settings(deadline=None, max_examples=200)(given(*strategies)(test))
