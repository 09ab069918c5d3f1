"""The search that all certified fits share, on a problem whose optimum is known."""

import numpy as np
import pytest
from activesuit.identification.fits.search import BudgetSpent, Evaluation, Search, sobol_points

CENTER = np.array([0.3, -0.2])


class Bowl:
    """Errors that vanish at `CENTER`; what lies left of `wall` lacks margin."""

    low, high = np.full(2, -1.0), np.full(2, 1.0)

    def __init__(self, wall=-np.inf):
        self.wall = wall

    def evaluate(self, point):
        x, y = point - CENTER
        return Evaluation(np.array([x, 2 * y, x * y]), self.missing(point[None])[0], point.copy())

    def missing(self, points):
        return np.maximum(self.wall - points[:, 0], 0.0)

    def derivatives(self, point):
        x, y = point - CENTER
        return np.array([[1, 0], [0, 2], [y, x]], dtype=float)


@pytest.mark.parametrize("exact", [True, False])
def test_it_finds_the_optimum_and_keeps_the_margin(exact):
    problem = Bowl()
    search = Search(problem, 200, exact=exact)
    search.run(search.screened(sobol_points(problem.low, problem.high, 8, 0)), floor=1e-9)
    np.testing.assert_allclose(search.best, CENTER, atol=1e-4)
    assert search.history[-1][1] == search.score
    assert (np.diff([score for _, score in search.history]) < 0).all()
    search = Search(Bowl(wall=0.5), 300, exact=exact)  # a wall beyond the optimum
    search.run([np.array([0.9, 0.9]), np.array([-0.5, 0.0])])
    assert search.best is not None
    assert 0.5 - 0.005 <= search.best[0] <= 0.52


def test_the_budget_is_kept():
    problem = Bowl()
    for budget in (9, 10, 20):
        search = Search(problem, budget)
        search.run(search.screened(sobol_points(problem.low, problem.high, 8, 0)))
        assert search.evaluations == budget
    with pytest.raises(BudgetSpent):
        search.spend(1)


def test_two_runs_that_agree_end_the_search():
    starts = [np.array([0.9, 0.9]), np.array([-0.5, 0.5]), np.array([0.8, -0.9])]
    tried = []

    class Counted(Bowl):
        def evaluate(self, point):
            tried.append(any(np.array_equal(point, start) for start in starts))
            x, y = point - CENTER
            return Evaluation(np.array([x, y, 1.0]), 0.0, point.copy())  # never better than 1

    for agreeing, expected in ((1, 1), (2, 2), (0, 3)):
        tried.clear()
        search = Search(Counted(), 500)
        search.keep(np.zeros(2), 0.7, 0.0)
        search.run(starts, agreeing=agreeing)
        assert sum(tried) == expected == search.agreed
