"""What models around models refuse: numbers, times, and an order in which they cannot be."""

import numpy as np
from activesuit.hysteresis import Asymmetric, Backlash, Clipped, Viscoelastic, model_from_dict
from helpers import assert_refused


def test_wrong_numbers_are_refused(elbow):
    ranges, gaps = ((1, 0), (0, np.inf), (0, np.nan), 3, (0.5, 0.5)), (0.0, -0.1, np.inf, "x")
    for make, rows in (
        (Clipped, [({"angle_range": one}, "angle_range is") for one in ranges]),
        (Backlash, [({"gap": one}, "gap is") for one in gaps]),
        (
            Viscoelastic,
            [
                ({"damping": -0.1}, "damping is -0.1 N.m.s/rad: give at least 0"),
                ({"relaxation_stiffness": 1.0}, "relaxation_time is 0 s"),
                ({"relaxation_time": np.nan}, "relaxation_time"),
            ],
        ),
    ):
        assert_refused(lambda change, make=make: make(model=elbow, **change), rows)
    timed = Viscoelastic(model=elbow, damping=0.1).response
    assert_refused(
        lambda *time: timed([0.5, 0.6], time=time),
        [(0.0, "give as many"), (1.0, 0.0, r"time\[1\] is 0 s after 1 s")],
    )


def test_wrong_orders_are_refused(elbow):
    bent = Asymmetric(model=elbow, polynomial=[0.1])
    play, rate = Backlash(model=elbow, gap=0.1), Viscoelastic(model=elbow, damping=0.1)
    kept = Clipped(model=elbow, angle_range=(0, 1))
    for make, refused, words in (
        (lambda one: Viscoelastic(model=one), (rate,), "not viscoelastic itself"),
        (
            lambda one: Backlash(model=one, gap=0.1),
            (play, rate, "elbow"),
            "bare, `Clipped` or `Asymmetric`; put a dashpot around",
        ),
        (
            lambda one: Asymmetric(model=one, polynomial=[0.1]),
            (play, bent),
            "give one hysteresis model, bare or `Clipped`",
        ),
        (
            lambda one: Clipped(model=one, angle_range=(0, 1)),
            (play, bent, kept, "shoulder"),
            "give one hysteresis model without another",
        ),
    ):
        assert_refused(make, [(one, words) for one in refused])
    content = {"model": "viscoelastic", "damping": 0.1}
    words = "'viscoelastic' has no 'hysteresis': give the model"
    assert_refused(model_from_dict, [(content, words)])
