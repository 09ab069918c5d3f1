"""The baselines: one call, a budget that holds, and results that depend on the seed alone."""

import sys

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.identification.optimizers.libraries import cma_es
from activesuit.identification.optimizers.registry import LIBRARIES

PACKAGES = {"ga": "pymoo", "cma-es": "cma"}
BOUNDS = [(-5.0, 10.0), (-2.0, 2.0), (0.0, 3.0)]


@pytest.fixture(params=LIBRARIES)
def minimize(request):
    if request.param in PACKAGES:
        pytest.importorskip(PACKAGES[request.param])
    return LIBRARIES[request.param]


def sphere(x):
    return np.sum((x - [1.0, -0.5, 2.0]) ** 2, axis=1)


def rosenbrock(x):
    return np.sum(100 * (x[:, 1:] - x[:, :-1] ** 2) ** 2 + (1 - x[:, :-1]) ** 2, axis=1)


@pytest.mark.parametrize("budget", [1, 7, 60, 1234])
def test_budget_history_and_bounds(minimize, budget):
    positions = []

    def recorded(x):
        positions.append(x.copy())
        return rosenbrock(x)

    result = minimize(recorded, BOUNDS, budget, rng=1)
    everywhere = np.concatenate(positions)
    low, high = np.array(BOUNDS).T
    assert result.nfev == len(everywhere) == len(result.history) == budget
    assert ((everywhere >= low) & (everywhere <= high)).all()
    np.testing.assert_array_equal(
        result.history, np.minimum.accumulate(np.concatenate([rosenbrock(x) for x in positions]))
    )
    assert result.fun == result.history[-1] == rosenbrock(result.x[None])[0]
    assert result.success
    assert result.message == "spent all evaluations"


def test_finds_the_sphere(minimize):
    result = minimize(sphere, BOUNDS, 4000, rng=3)
    assert result.fun < 1e-3
    np.testing.assert_allclose(result.x, [1.0, -0.5, 2.0], atol=0.05)


def test_depends_on_the_seed_alone(minimize):
    np.random.seed(1)  # noqa: NPY002  (the libraries must leave the global generator alone)
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    first = minimize(rosenbrock, BOUNDS, 500, rng=4)
    np.testing.assert_array_equal(np.random.get_state()[1], before)  # noqa: NPY002
    np.random.seed(2)  # noqa: NPY002
    again = minimize(rosenbrock, BOUNDS, 500, rng=np.random.default_rng(4))
    np.testing.assert_array_equal(first.history, again.history)
    np.testing.assert_array_equal(first.x, again.x)
    other = minimize(rosenbrock, BOUNDS, 500, rng=5)
    assert (other.history != first.history).any()


def test_discards_what_is_not_finite(minimize):
    def hurdles(x):
        return np.where(x[:, 0] < 0, np.nan, sphere(x))

    result = minimize(hurdles, BOUNDS, 1500, rng=0)
    assert result.discarded > 0
    assert result.fun < 0.1
    with pytest.raises(InputError, match="no finite value at any of 40 points"):
        minimize(lambda x: np.full(len(x), np.nan), BOUNDS, 40, rng=0)


def test_the_objectives_own_errors_come_through(minimize):
    def broken(x):
        raise ValueError("broken here")

    with pytest.raises(ValueError, match="broken here"):
        minimize(broken, BOUNDS, 100, rng=0)
    with pytest.raises(InputError, match="the objective returned shape"):
        minimize(lambda x: x, BOUNDS, 100, rng=0)


def test_bad_input(minimize):
    with pytest.raises(InputError, match=r"bounds\[0\] are \(1, -1\)"):
        minimize(sphere, [(1.0, -1.0)] * 3, 100)
    with pytest.raises(InputError, match="max_evaluations is 0: use at least 1"):
        minimize(sphere, BOUNDS, 0)


@pytest.mark.parametrize(("name", "package"), PACKAGES.items())
def test_a_missing_library_is_one_sentence(monkeypatch, name, package):
    for module in [key for key in sys.modules if key.split(".")[0] == package]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(InputError, match=rf"package {package}, .*pip install -e '.\[compare\]'"):
        LIBRARIES[name](sphere, BOUNDS, 100)


def test_cma_es_needs_two_parameters():
    pytest.importorskip("cma")
    with pytest.raises(InputError, match="CMA-ES has 1 parameter"):
        cma_es(lambda x: x[:, 0] ** 2, [(-1.0, 1.0)], 100)
